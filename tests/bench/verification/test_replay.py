"""A trace, played again, comes to the same episodes to the last bit, whoever decided and on whatever task."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_agents import RULES, Decision
from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.episodes import EpisodeRecords
from hhrl_bench.evaluation.evidence import Evidence, pack, unpack
from hhrl_bench.evaluation.loading import load_agent
from hhrl_bench.evaluation.paired_evaluation import ScoredEpisodes, play_task
from hhrl_bench.evaluation.replay import replay
from hhrl_bench.tasks.tasks import TASKS, Task, get_task
from hhrl_envs import Option, get_scenario

EPISODES = 5


def equal(one: EpisodeRecords, other: EpisodeRecords) -> bool:
    """Return whether records are of one kind and hold the same bits."""
    ours, theirs = one.arrays(), other.arrays()
    pairs = [(array, theirs[name]) for name, array in ours.items()]
    return [*ours] == [*theirs] and all(a.tobytes() == b.tobytes() and a.dtype == b.dtype for a, b in pairs)


def played(name: str, task: Task, option: Option | None = None) -> ScoredEpisodes:
    return play_task(load_agent(name, task), task, task.test.take(EPISODES), option)


def evidence(of: ScoredEpisodes) -> Evidence:
    return unpack(pack(of))


@pytest.mark.parametrize("task", TASKS.values(), ids=TASKS)
@pytest.mark.parametrize("rule", ["rule-2", "rule-plus"])
def test_every_task_comes_to_the_same_again(task: Task, rule: str) -> None:
    one = played(rule, task)
    (again,) = replay([evidence(one)], task, task.test.take(EPISODES))
    assert equal(again.records, one.records)


@pytest.mark.parametrize("agent", ["ddqn", "hybrid-hrl-plus", "follow-only"])
def test_learned_agents_come_to_the_same_again(agent: str) -> None:
    pytest.importorskip("torch")
    task = get_task("stop-line-v0")
    one = played(agent, task)
    (again,) = replay([evidence(one)], task, task.test.take(EPISODES))
    assert equal(again.records, one.records)
    assert np.isnan(again.records.return_option).all() == (agent == "ddqn")


def test_a_scripted_opponent_and_a_held_option_too() -> None:
    scripted, task = get_task("adversary-v0").against("scripted"), get_task("stop-line-v0")
    seeds = task.test.take(EPISODES)
    for one, where in ((played("rule-4", scripted), scripted), (played("rule-4", task, Option.FFV), task)):
        (again,) = replay([evidence(one)], where, seeds)
        assert equal(again.records, one.records)


def test_several_policies_are_replayed_side_by_side_as_each_alone() -> None:
    task = get_task("platoon-v0")
    both = [played(rule, task) for rule in ("rule-3", "rule-1")]
    again = replay([evidence(one) for one in both], task, task.test.take(EPISODES))
    assert all(map(equal, [one.records for one in again], [one.records for one in both]))
    assert not equal(again[0].records, again[1].records)


def test_the_worlds_are_those_of_the_trace_and_in_its_order() -> None:
    task = get_task("stop-line-v0")
    one, seeds = played("rule-4", task), task.test.take(EPISODES)
    (again,) = replay([evidence(one)], task, seeds[::-1].copy())
    assert not equal(again.records, one.records)
    np.testing.assert_array_equal(again.records.seed, seeds[::-1])


def changed(of: ScoredEpisodes, **parts: Any) -> Evidence:
    kept = evidence(of)
    return kept._replace(trace=kept.trace._replace(**parts))


def test_an_episode_cut_short_or_prolonged_is_not_what_was_played() -> None:
    task = get_task("stop-line-v0")
    one = played("rule-4", task)
    trace = one.trace
    seeds, first = task.test.take(EPISODES), int(trace.steps[0])
    short = trace.steps.copy()
    short[0] -= 40
    cut = np.r_[0 : first - 40, first : len(trace.actions)]
    (again,) = replay([changed(one, steps=short, options=trace.options[cut], actions=trace.actions[cut])], task, seeds)
    assert not np.array_equal(again.records.steps, short)
    longer = trace.steps.copy()
    longer[0] += 1
    more = np.r_[0:first, first - 1, first : len(trace.actions)]
    (again,) = replay(
        [changed(one, steps=longer, options=trace.options[more], actions=trace.actions[more])], task, seeds
    )
    assert equal(again.records, one.records)
    assert again.records.steps[0] == longer[0] - 1


def test_what_cannot_be_a_trace_of_the_task_is_refused() -> None:
    task = get_task("stop-line-v0")
    one, seeds = played("rule-4", task), task.test.take(EPISODES)
    kept, trace = evidence(one), one.trace
    with pytest.raises(RecordError, match=f"has {EPISODES} episodes, not {EPISODES - 1}"):
        replay([kept], task, seeds[:-1])
    with pytest.raises(RecordError, match="drives 1 vehicles, in this task agents drive"):
        replay([kept], get_task("platoon-v0"), seeds)
    for parts in (
        {"options": np.full_like(trace.options, len(Option))},
        {"options": np.full_like(trace.options, -2)},
        {"actions": np.full_like(trace.actions, get_scenario(task.scenario).num_actions)},
        {"actions": np.full_like(trace.actions, -1)},
    ):
        with pytest.raises(RecordError, match="an option or action that this scenario does not have"):
            replay([changed(one, **parts)], task, seeds)


def test_a_trace_holds_what_was_decided_as_long_as_the_episode_ran() -> None:
    """Episode by episode, against the rule asked again."""
    task = get_task("stop-line-v0")
    scenario, rule = get_scenario(task.scenario), RULES["rule-4"](get_scenario(task.scenario))
    seen: list[Decision] = []

    class Listening:
        def reset(self, mask: NDArray[np.bool_]) -> None:
            rule.reset(mask)

        def act(self, observations: NDArray[np.float32]) -> Decision:
            seen.append(rule.act(observations))
            return seen[-1]

    one = play_task(Listening(), task, task.test.take(EPISODES))
    ends = np.cumsum(one.trace.steps)
    for row, (end, steps) in enumerate(zip(ends, one.trace.steps, strict=True)):
        assert one.trace.options[end - steps : end, 0].tolist() == [step.option[row] for step in seen[:steps]]
        assert one.trace.actions[end - steps : end, 0].tolist() == [step.action[row] for step in seen[:steps]]
    assert one.trace.actions.max() < scenario.num_actions
