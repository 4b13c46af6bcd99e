"""Every scored episode on a line of its own: its world, how it ended and why, who drove ahead, and its metrics."""

import csv
import io
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from hhrl_agents.atomic_files import OutputError, require_writable, write_atomically
from hhrl_bench.evaluation.episodes import EpisodeRecords, TrafficRecords
from hhrl_bench.evaluation.guarded_agent import OPTIONS
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.paired_evaluation import BATCH_ROWS, ScoredEpisodes, batches
from hhrl_bench.schema import finite
from hhrl_bench.tasks.tasks import Task
from hhrl_envs import Outcome, Simulator, get_scenario

Row = dict[str, Any]
"""What a line says of an episode, by the names of the columns."""

NO_FRONT, AN_AGENT = "none", "agent"
"""The profile where no vehicle is in front, and that of a front vehicle that an agent drives."""

_NAMES: Mapping[int, str | None] = {-1: None, **{int(option): name for name, option in OPTIONS.items()}}


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
        first = {"agent": agent, "training_seed": training_seed, "task": task.id}
        self._rows += [{**first, **row} for row in episode_rows(task, played)]

    def write(self) -> None:
        """Write the file, whole or not at all."""
        write_atomically(self._path, _TEXTS[self._path.suffix.lower()](self._rows))


def episode_rows(task: Task, played: ScoredEpisodes) -> Iterator[Row]:
    """Yield what there is to say of every episode, in their order.

    ``feasible``: whether some ego could have succeeded; ``profile``: the family of the driver in front of the ego, and
    ``profiles`` those of all in front, nearest first; ``cause``: how the episode failed, None if it did not;
    ``last_option``: what a hierarchical agent had selected at its end; then every metric that is no rate.
    """
    records, trace = played
    last = trace.options[np.cumsum(trace.steps) - 1, 0]
    metrics = {key: metric.values(records) for key, metric in METRICS.items() if not metric.is_rate and key != "steps"}
    for episode, (feasible, families) in enumerate(_worlds(task, records)):
        outcome = Outcome(int(records.outcome[episode]))
        yield {
            "episode": episode,
            "world_seed": int(records.seed[episode]),
            "feasible": feasible,
            "profile": families[0] if families else NO_FRONT,
            "profiles": "+".join(families) or NO_FRONT,
            "outcome": outcome.name.lower(),
            "cause": None if outcome == Outcome.SUCCESS else outcome.name.lower(),
            "last_option": _NAMES[int(last[episode])],
            "steps": int(records.steps[episode]),
            **finite({key: float(values[episode]) for key, values in metrics.items()}),
        }


def _worlds(task: Task, records: EpisodeRecords) -> Iterator[tuple[bool, list[str]]]:
    """Yield of every episode whether it was feasible, and the families of the drivers in front, nearest first."""
    traffic = records if isinstance(records, TrafficRecords) else None
    agents = 0 if traffic is None else traffic.outcomes.shape[1] - 1
    simulator = Simulator(get_scenario(task.scenario), min(BATCH_ROWS, len(records)), learned_fronts=agents)
    for first, batch in zip(range(0, len(records), BATCH_ROWS), batches(records.seed, simulator.num_rows), strict=True):
        simulator.reset(batch)
        feasible = simulator.feasible if traffic is None else traffic.feasible[first:]
        for row in range(min(len(batch), len(records) - first)):
            scripted = [str(one["family"]) for one in simulator.profiles(row)[agents:]]
            yield bool(feasible[row]), [AN_AGENT] * agents + scripted


def _csv(rows: list[Row]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(name for row in rows for name in row)), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _jsonl(rows: list[Row]) -> str:
    return "".join(json.dumps(row, allow_nan=False) + "\n" for row in rows)


_TEXTS = {".csv": _csv, ".jsonl": _jsonl}
