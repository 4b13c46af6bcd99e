"""Every scored episode on a line of its own: its world, how it ended and why, who drove ahead, and its metrics."""

import csv
import io
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hhrl_agents.atomic_files import OutputError, require_writable, write_atomically
from hhrl_bench.evaluation.episodes import TrafficRecords
from hhrl_bench.evaluation.guarded_agent import OPTIONS
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.paired_evaluation import BATCH_ROWS, ScoredEpisodes, batches
from hhrl_bench.schema import finite
from hhrl_bench.tasks.tasks import Task
from hhrl_envs import SUB_GOALS, Outcome, Simulator, get_scenario
from hhrl_envs.arrays import Keys

Row = dict[str, Any]
"""What a line says of an episode, by the names of the columns."""

CAUSES: Mapping[Outcome, str] = {
    Outcome.SUCCESS: "",
    Outcome.TIMEOUT: "time limit",
    Outcome.REAR_ENDED: "hit from behind",
    **{goal.failure: f"failed to {goal.name}" for goal in SUB_GOALS},
}
"""Why an episode ended as it did: nothing if it succeeded, else which sub-goal failed or what else came."""

_NAMES = {int(option): name for name, option in OPTIONS.items()} | {-1: ""}


class EpisodeFile:
    """The lines of episodes for a ``.csv`` or ``.jsonl`` file, which is written when all are there.

    Raises:
        OutputError: at once, for another kind of file, or one that could not be written.
    """

    def __init__(self, path: Path) -> None:
        if path.suffix.lower() not in _TEXTS:
            raise OutputError(f"cannot write episodes to {path.name!r}; write a name that ends in .csv or .jsonl")
        require_writable(path)
        self._path, self._rows = path, list[Row]()

    def add(self, agent: str, task: Task, training_seed: int | None, played: ScoredEpisodes) -> None:
        """Add the episodes that one policy of an agent has played on a task."""
        first = {"task": task.id, "agent": agent, "training_seed": training_seed}
        self._rows += [{**first, **row} for row in episode_rows(task, played)]

    def write(self) -> None:
        """Write the file, whole or not at all."""
        write_atomically(self._path, _TEXTS[self._path.suffix.lower()](self._rows))


def episode_rows(task: Task, played: ScoredEpisodes) -> Iterator[Row]:
    """Yield what there is to say of every episode, in their order.

    ``profile``: the families of the scripted front vehicles, the nearest first; ``last_option``: what a hierarchical
    agent had selected for the first vehicle that it drives when the episode ended; ``feasible``: where front vehicles
    are agents, whether some ego could have succeeded; then every metric that is no rate.
    """
    records, trace = played
    last = trace.options[np.cumsum(trace.steps) - 1, 0]
    metrics = {key: metric.values(records) for key, metric in METRICS.items() if not metric.is_rate and key != "steps"}
    traffic = records if isinstance(records, TrafficRecords) else None
    agents = 1 if traffic is None else traffic.outcomes.shape[1]
    for episode, profile in enumerate(profiles(task, records.seed, agents - 1)):
        outcome = Outcome(int(records.outcome[episode]))
        yield {
            "episode": episode,
            "world_seed": int(records.seed[episode]),
            "outcome": outcome.name.lower(),
            "cause": CAUSES[outcome],
            "profile": profile,
            "last_option": _NAMES[int(last[episode])],
            "steps": int(records.steps[episode]),
            "feasible": None if traffic is None else bool(traffic.feasible[episode]),
            **finite({key: float(values[episode]) for key, values in metrics.items()}),
        }


def profiles(task: Task, seeds: Keys, learned_fronts: int) -> Iterator[str]:
    """Yield the families of the scripted front vehicles of every world uint64 [N], the nearest first."""
    simulator = Simulator(get_scenario(task.scenario), min(BATCH_ROWS, len(seeds)), learned_fronts=learned_fronts)
    left = len(seeds)
    for batch in batches(seeds, simulator.num_rows):
        simulator.reset(batch)
        for row in range(min(left, len(batch))):
            yield " ".join(str(one["family"]) for one in simulator.profiles(row)[learned_fronts:])
        left -= len(batch)


def _csv(rows: list[Row]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(name for row in rows for name in row)), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _jsonl(rows: list[Row]) -> str:
    return "".join(json.dumps(row, allow_nan=False) + "\n" for row in rows)


_TEXTS = {".csv": _csv, ".jsonl": _jsonl}
