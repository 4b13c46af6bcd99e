"""Episodes as rows: the world that each was in, how it ended, what it came to and how severe it was."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.decisions import Trace
from hhrl_bench.evaluation.episodes import EpisodeRecords, TrafficRecords
from hhrl_bench.evaluation.metrics import METRICS, Least, Metric
from hhrl_bench.evaluation.paired_evaluation import evaluation_drivers
from hhrl_bench.evaluation.replay import replay
from hhrl_bench.evaluation.results import PlayedRun
from hhrl_bench.evaluation.rollout import Step
from hhrl_bench.tasks.tasks import Task
from hhrl_envs import Outcome, get_scenario
from hhrl_envs.arrays import Codes, Flags, Floats, Keys
from hhrl_envs.scenario.scenario import GRAVITY, Scenario

Columns = dict[str, list[Any]]
"""Values by the names of columns, as many in each; None: there is none."""

TEXTS = ("agent", "task", "profile", "style", "profiles", "outcome", "cause")
"""The columns of text; the others are numbers and truth values."""

NO_FRONT, AN_AGENT = "none", "agent"
"""The profile where no vehicle is in front, and that of a front vehicle that an agent drives."""


class Run(NamedTuple):
    """One policy's first test episodes of a task.

    Attributes:
        agent: its name.
        seed: its training seed; None without one.
        task: what was played.
        trace: every decision.
        outcome: how each episode ended, int8 [N].
    """

    agent: str
    seed: int | None
    task: Task
    trace: Trace
    outcome: Codes

    @property
    def worlds(self) -> Keys:
        """The seeds of the worlds, uint64 [N]."""
        return self.task.test.take(len(self.outcome))


def run_of(agent: str, task: Task, played: PlayedRun) -> Run:
    """Return the run of an agent's policy that was just played."""
    return Run(agent, played.seed, task, played.scored.trace, played.scored.records.outcome)


class World(NamedTuple):
    """What is known of an episode before its first step.

    Attributes:
        feasible: whether some ego could succeed; None where that shows at the end.
        families, styles: of the drivers in front and how each stops, nearest first.
        friction: of the road.
    """

    feasible: bool | None
    families: tuple[str, ...]
    styles: tuple[str, ...]
    friction: float


def episode_columns(runs: Sequence[Run]) -> Columns:
    """Return a row for every episode of runs: agent, seeds, outcome, cause, drivers in front, metrics and severity.

    The decisions are run through the simulator again, so rows from evidence are those of fresh rollouts.

    Raises:
        RecordError: if a run's outcomes are not those that its decisions come to.
    """
    parts = [_columns(run) for run in runs]
    names = max(parts, key=len)  # where a world has no number of a metric, that column lacks in its part
    blank = [[None] * len(run.outcome) for run in runs]
    return {
        name: [value for part, none in zip(parts, blank, strict=True) for value in part.get(name, none)]
        for name in names
    }


def _columns(run: Run) -> Columns:
    metrics = [metric for metric in METRICS.values() if not metric.is_rate and metric.key != "steps"]
    (played,) = replay([run], run.task, run.worlds, [*metrics, OVERRUN])
    records, count = played.records, len(run.outcome)
    require_same_episodes(run, slice(0, count), records.outcome, records.steps)
    known = list(worlds(run.task, run.worlds))
    outcomes = [Outcome(int(code)) for code in records.outcome]
    failed = [one != Outcome.SUCCESS for one in outcomes]
    return {
        "agent": [run.agent] * count,
        "training_seed": [run.seed] * count,
        "task": [run.task.id] * count,
        "episode": list(range(count)),
        "world_seed": [int(seed) for seed in run.worlds],
        "feasible": _feasible(records, known),
        "fronts": [len(world.families) for world in known],
        "profile": [world.families[0] if world.families else NO_FRONT for world in known],
        "style": [world.styles[0] if world.styles else None for world in known],
        "profiles": [profiles_of(world) for world in known],
        "friction": [world.friction for world in known],
        "outcome": [one.name.lower() for one in outcomes],
        "cause": [one.name.lower() if fails else None for one, fails in zip(outcomes, failed, strict=True)],
        "steps": records.steps.tolist(),
        **{one.key: _values(one, records) for one in [*metrics, OVERRUN] if one.follows_from(records.measured)},
    }


def require_same_episodes(run: Run, part: slice, outcome: Codes, steps: NDArray[Any]) -> None:
    """Raise a ``RecordError`` if part of a run's episodes did not end as its decisions do, given how those end, [N]."""
    differ = (run.outcome[part] != outcome) | (run.trace.steps[part] != steps)
    if differ.any():
        raise RecordError(
            f"{run.agent} on {run.task.id}: episode {part.start + int(differ.argmax())} does not end as its evidence "
            "says; the evidence is damaged, or of another version"
        )


def profiles_of(world: World) -> str:
    """Return the families of the drivers in front, nearest first, in one word."""
    return "+".join(world.families) or NO_FRONT


def worlds(task: Task, seeds: Keys) -> Iterator[World]:
    """Return the worlds of seeds, uint64 [N], as they are before the first step."""
    drivers = evaluation_drivers(task)
    simulator = drivers.simulator(get_scenario(task.scenario), len(seeds))
    simulator.reset(seeds)
    friction = simulator.friction.tolist()
    by_agents, scripted = simulator.num_agents - 1, simulator.num_agents == 1
    for row in range(len(seeds)):
        fronts = simulator.profiles(row)
        families = [AN_AGENT if slot < by_agents else str(front["family"]) for slot, front in enumerate(fronts)]
        styles = [AN_AGENT if slot < by_agents else str(front["style"]) for slot, front in enumerate(fronts)]
        feasible = bool(simulator.feasible[row]) if scripted else None
        yield World(feasible, tuple(families), tuple(styles), friction[row])


def _feasible(records: EpisodeRecords, known: Sequence[World]) -> list[bool | None]:
    if isinstance(records, TrafficRecords):
        feasible: list[bool | None] = records.feasible.tolist()
        return feasible
    return [world.feasible for world in known]


def _values(metric: Metric, records: EpisodeRecords) -> list[int | float | None]:
    values = metric.values(records)
    if not callable(metric.of) and metric.of.whole:
        return [int(value) for value in values]
    return [None if np.isnan(value) else float(value) for value in values]


def _overrun(step: Step) -> Floats:
    """Return how far past its line the ego would come to rest, [B]; NaN but where it has just crossed that."""
    crossed: Flags = step.running & (step.results.outcomes == int(Outcome.NOT_STOP))
    found, friction = np.full(len(crossed), np.nan), step.simulator.friction
    for row in np.flatnonzero(crossed):
        position, speed, _ = step.simulator.vehicles(int(row))[step.slots[0]]
        past = position - step.simulator.lines[row]
        found[row] = max(float(past), 0.0) + speed * speed / (2.0 * full_brake(step.simulator.scenario, friction[row]))
    return found


def full_brake(scenario: Scenario, friction: float) -> float:
    """Return the hardest deceleration that the ego's levels and a road of this friction allow, in m/s^2."""
    return float(min(-scenario.vehicle.levels[0], friction * GRAVITY))


OVERRUN = Metric(
    "overrun", "overrun\nm", Least(_overrun),
    "metres past the line where full braking from there on would end; none where the ego did not cross it",
    unit="m", better="lower", table="worst cases",
)  # fmt: skip
"""How severe a crossed line is. It follows from a replay, and is no metric of results."""
