"""The harder tiers leave room: a rule without memory cannot close it, and what they hide would."""

from functools import cache

import numpy as np
import pytest

from hhrl_agents import RULES, Decision
from hhrl_bench.evaluation.metrics import HEADLINE, METRICS
from hhrl_bench.evaluation.paired_evaluation import play_task
from hhrl_bench.tasks.tasks import TASKS, get_task
from hhrl_envs import SCENARIOS, Scenario, Simulator
from hhrl_envs.arrays import Flags, Floats32
from hhrl_envs.observation import A_E, D_D, D_F, V_E, to_si
from hhrl_envs.scenario.registry import SUPERSEDED
from support.headroom import TIERS, Room, room, table

EPISODES = 200
EACH_TIER = pytest.mark.parametrize("tier", TIERS)


@cache
def played(tier: str) -> Room:
    return room(tier, EPISODES)


def share(tier: str, agent: str) -> float:
    """The score of an agent as a share of the oracle's, as the page has them."""
    said = dict(zip(Room._fields, table()[tier], strict=True))
    return said[agent] / said["oracle"]


@EACH_TIER
def test_nearly_every_world_is_feasible(tier: str) -> None:
    simulator = Simulator(SCENARIOS[tier], 1000)
    simulator.reset(TASKS[tier].test.take(1000))
    assert simulator.feasible.mean() >= 0.985


@EACH_TIER
def test_a_tuned_rule_leaves_room(tier: str) -> None:
    assert share(tier, "tuned") <= 0.75
    assert share(tier, "robust") <= 0.65


@EACH_TIER
def test_the_room_is_what_is_hidden(tier: str) -> None:
    assert share(tier, "told") >= 0.9


@EACH_TIER
def test_the_page_says_what_is_scored(tier: str) -> None:
    """Its means over 10,000 episodes lie within four standard errors of those over the first ones."""
    said = table()[tier]
    for mean, scores in zip(said, played(tier), strict=True):
        assert abs(mean - np.mean(scores)) < 4.0 * np.std(scores) / np.sqrt(EPISODES) + 0.0005, HEADLINE


def test_superseded_scenarios_are_known_and_so_are_their_successors() -> None:
    assert SUPERSEDED.keys() == {f"stop-line-{tier}-v0" for tier in ("dense", "erratic", "wet", "noisy")}
    assert {*SUPERSEDED, *SUPERSEDED.values()} <= SCENARIOS.keys()
    assert set(SUPERSEDED.values()) <= TIERS.keys()


class Crawler:
    """A follower that stops in nearly every world of a tier by being slow; gap 5 m, headway 1 s.

    numbers: gain [1/s], margin before the line [m], deceleration [m/s^2], anticipated lag [s].
    """

    def __init__(self, scenario: Scenario, *numbers: float) -> None:
        self._levels = np.array(scenario.vehicle.levels)
        self._gain, self._margin, self._decel, self._lag = numbers

    def reset(self, mask: Flags) -> None:
        """Do nothing: it has no memory."""

    def act(self, observations: Floats32) -> Decision:
        state = to_si(observations)
        speed = np.maximum(state[:, V_E] + self._lag * state[:, A_E], 0.0)
        line = state[:, D_D] - self._margin - self._lag * state[:, V_E]
        gap = state[:, D_F] - 5.0 - (1.0 + self._lag) * state[:, V_E]
        wanted = np.sqrt(2.0 * self._decel * np.maximum(np.minimum(line, gap), 0.0))
        accel = self._gain * (wanted - speed)
        return Decision(np.full(len(accel), -1), np.abs(accel[:, None] - self._levels).argmin(axis=1))


@pytest.mark.parametrize(
    ("tier", "numbers"),
    [
        ("stop-line-erratic-v0", (2.0, 1.2, 0.3, 1.0)),
        ("stop-line-dense-v0", (2.0, 1.2, 1.0, 0.5)),
        ("stop-line-noisy-v0", (2.0, 1.2, 0.3, 1.0)),
    ],
)
def test_a_crawler_stops_nearly_always_and_scores_little(tier: str, numbers: tuple[float, ...]) -> None:
    task = get_task(tier)
    crawler = Crawler(SCENARIOS[tier], *numbers)
    played = play_task(crawler, task, task.test.take(EPISODES)).records
    assert METRICS["success"].values(played).mean() > 0.95
    assert METRICS[HEADLINE].values(played).mean() < 0.6
    rules = (RULES[name](SCENARIOS[tier]) for name in ("rule-plus", "rule-tuned"))
    others = [play_task(rule, task, task.test.take(EPISODES)).records for rule in rules]
    assert max(METRICS[HEADLINE].values(one).mean() for one in others) > METRICS[HEADLINE].values(played).mean()
