"""The room in the harder tiers: what the oracle, tuned rules, and a rule that is told what is hidden score there.

``python -m support.headroom`` prints the table of docs/headroom.md; ``python -m support.headroom search`` searches for
the numbers of the rules that are told, with the budget that ``rule-tuned`` has in a tier.
"""

import json
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from hhrl_agents import ORACLES, RULES
from hhrl_agents.agent import Agent, ClairvoyantAgent
from hhrl_agents.rules.rule_plus import RulePlus
from hhrl_agents.rules.tuning import FIRST_TUNING, Tuning
from hhrl_bench.evaluation.metrics import HEADLINE, METRICS
from hhrl_bench.evaluation.paired_evaluation import play
from hhrl_bench.evaluation.results import silent
from hhrl_bench.tasks.tasks import TASKS, get_task
from hhrl_bench.tuning.search import search
from hhrl_envs import SCENARIOS, Scenario, Sensor, Simulator, Slippery
from hhrl_envs.arrays import Flags, Floats, Keys

EPISODES = 10_000
NUMBERS = Path(__file__).with_suffix(".json")
PAGE = Path(__file__).parents[2] / "docs" / "headroom.md"


class Tier(NamedTuple):
    """What a tier hides, and worlds in which that is no secret, by the names of their sets of numbers.

    Of a world with several sets an agent that is told takes the one that `chosen` says.
    """

    hidden: str
    told: Mapping[str, Scenario]
    chosen: Callable[[Simulator], Flags] | None = None


def _exact(scenario: Scenario) -> Scenario:
    return replace(scenario, sensor=Sensor(front_range=scenario.sensor.front_range))


def _icy(scenario: Scenario, share: float) -> Scenario:
    slippery = scenario.road.slippery
    assert slippery is not None
    return replace(scenario, road=replace(scenario.road, slippery=Slippery(share, slippery.friction)))


def _tiers() -> dict[str, Tier]:
    dense, erratic, wet, noisy = (
        SCENARIOS[f"stop-line-{one}"] for one in ("dense-v1", "erratic-v1", "wet-v1", "noisy-v1")
    )
    return {
        dense.id: Tier("whether somebody is in front", {dense.id: _exact(dense)}),
        erratic.id: Tier("whether what stands ahead is there", {erratic.id: _exact(erratic)}),
        wet.id: Tier(
            "the friction",
            {f"{wet.id}, grip": _icy(wet, 0.0), f"{wet.id}, ice": _icy(wet, 1.0)},
            lambda simulator: simulator.friction < 0.5,
        ),
        noisy.id: Tier("the true distances and speeds, now", {noisy.id: _exact(noisy)}),
    }


TIERS: Mapping[str, Tier] = MappingProxyType(_tiers())


class Room(NamedTuple):
    """The scores of the same episodes of a tier, float64 [N] each."""

    oracle: Floats
    tuned: Floats
    robust: Floats
    told: Floats


def room(tier: str, episodes: int) -> Room:
    """Return what the first episodes of a tier's test set are scored with."""
    scenario, seeds = SCENARIOS[tier], TASKS[tier].test.take(episodes)
    oracle = score(ORACLES["oracle"](scenario), scenario, seeds)
    tuned, robust = (score(RULES[name](scenario), scenario, seeds) for name in ("rule-tuned", "rule-robust"))
    return Room(oracle, tuned, robust, told(tier, seeds))


def told(tier: str, seeds: Keys) -> Floats:
    """Return the scores of the rule that is told what the tier hides."""
    _, worlds, chosen = TIERS[tier]
    scenario, found = SCENARIOS[tier], numbers()
    if chosen is None:
        ((name, exact),) = worlds.items()
        return score(RulePlus(exact, found[name]), exact, seeds)
    each = [score(RulePlus(scenario, found[name]), scenario, seeds) for name in worlds]
    simulator = Simulator(scenario, len(seeds))
    simulator.reset(seeds)
    return np.where(chosen(simulator), each[1], each[0])


def score(agent: Agent | ClairvoyantAgent, scenario: Scenario, seeds: Keys) -> Floats:
    metric = METRICS[HEADLINE]
    return metric.values(play(agent, scenario, seeds, metrics=[METRICS[key] for key in metric.needs]).records)


def numbers() -> dict[str, Tuning]:
    """Return the numbers of the rules that are told, by the names of their worlds."""
    return {name: replace(FIRST_TUNING, **own) for name, own in json.loads(NUMBERS.read_text()).items()}


def search_numbers() -> None:
    """Search for them, world by world, and write them into their file."""
    found = {}
    for tier, (_, worlds, _) in TIERS.items():
        for place, (name, scenario) in enumerate(worlds.items()):
            task = get_task(replace(scenario, id=f"told-{place}-{tier}"))
            found[name] = dict(search([task], TASKS[tier].env_steps, 0, silent).tuning)
            print(name, flush=True)
    NUMBERS.write_text(json.dumps(found, indent=2) + "\n")


def table() -> dict[str, list[float]]:
    """Return the scores that the page has, by the tier, in the order of a `Room`."""
    found = re.findall(r"^\| (stop-line-.* \(\d\.\d\d\)) \|$", PAGE.read_text(), re.MULTILINE)
    rows = [row.split(" | ") for row in found]
    return {tier: [float(cell.split()[0]) for cell in cells] for tier, _, *cells in rows}


def lines(episodes: int) -> list[str]:
    """Return the rows of the table: scores, and their shares of the oracle's in brackets."""
    rows = []
    for tier, (hidden, _, _) in TIERS.items():
        best, *others = (float(np.mean(scores)) for scores in room(tier, episodes))
        cells = " | ".join(f"{one:.3f} ({one / best:.2f})" for one in others)
        rows.append(f"| {tier} | {hidden} | {best:.3f} | {cells} |")
    return rows


if __name__ == "__main__":
    if sys.argv[1:] == ["search"]:
        search_numbers()
    else:
        print("\n".join(lines(EPISODES)))
