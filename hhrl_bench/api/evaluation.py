"""An evaluation: agents in the same test episodes of a task, printed, framed, watched and exported."""

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from hhrl_agents.atomic_files import require_writable, write_atomically
from hhrl_bench.api.printed import Printed, Shown
from hhrl_bench.errors import AgentError, SeedError
from hhrl_bench.evaluation.decisions import episodes_of
from hhrl_bench.evaluation.episodes import EpisodeRecords
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.records import Kind, ResultRecord, TaskRecord
from hhrl_bench.evaluation.results import PlayedRun, result_of, silent, task_record
from hhrl_bench.exports.episodes import OVERRUN, Columns, Run, episode_columns, run_of
from hhrl_bench.exports.export import export_runs, format_of, require_free
from hhrl_bench.exports.files import to_frame
from hhrl_bench.figures.watch import artist, replayed
from hhrl_bench.schema import OptionName
from hhrl_bench.tables.failures import AgentEpisodes, failures_table
from hhrl_bench.tables.results import results_table, score_table, worst_cases_table
from hhrl_bench.tables.table import Table
from hhrl_bench.tasks.tasks import Task
from hhrl_envs.errors import InputError

if TYPE_CHECKING:
    from PIL.Image import Image


@dataclass(frozen=True)
class Scored:
    """An agent on a task.

    Attributes:
        agent: its name.
        kind: whether it is a rule, learned, or a user's own.
        task: the task.
        option: the option that was held; None: the agent chose.
        runs: its policies: the only one, or one for each training seed.
    """

    agent: str
    kind: Kind
    task: Task
    option: OptionName | None
    runs: tuple[PlayedRun, ...]

    @cached_property
    def result(self) -> ResultRecord:
        """What the runs come to."""
        return result_of(self.agent, self.kind, self.task, self.option, self.runs)

    def exported(self) -> list[Run]:
        """Return the runs as they are exported."""
        return [run_of(self.agent, self.task, run) for run in self.runs]


class Evaluation(Printed):
    """Agents in the same test episodes of a task. It prints as the table that ``hhrl-bench evaluate`` prints.

    ``evaluation["rule-4"]`` is the same of one agent alone; iterating gives the names of the agents, ``len`` the number
    of episodes. With a single policy, all that its ``records`` have is an attribute too, and so are the numbers of
    every metric [episodes]: ``evaluation.outcome``, ``evaluation.digest()``, ``evaluation.success``.

    Attributes:
        task: the task.
        episodes: how many test episodes every policy has played.
        agents: the names of the agents, in their order.
    """

    def __init__(self, task: Task, episodes: int, scored: Sequence[Scored]) -> None:
        self.task, self.episodes = task, episodes
        self._scored = {one.agent: one for one in scored}
        self.agents = tuple(self._scored)

    def __getitem__(self, agent: str) -> "Evaluation":
        return Evaluation(self.task, self.episodes, [self._of(agent)])

    def __iter__(self) -> Iterator[str]:
        return iter(self.agents)

    def __len__(self) -> int:
        return self.episodes

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(f"an evaluation has no {name!r}")
        try:
            records = self.records
        except InputError as error:
            raise AttributeError(f"an evaluation has no {name!r}: {error}") from error
        known = hasattr(records, name) or name not in METRICS
        return getattr(records, name) if known else METRICS[name].values(records)

    @property
    def results(self) -> tuple[ResultRecord, ...]:
        """The agents' results: means with intervals, and those of every training seed, as in published files."""
        return tuple(one.result for one in self._scored.values())

    @property
    def result(self) -> ResultRecord:
        """The result of the only agent, such as ``evaluation.result.metrics.success.low``.

        Raises:
            InputError: if there are several agents.
        """
        return self._only().result

    @property
    def runs(self) -> tuple[PlayedRun, ...]:
        """The policies of the only agent: a record, records of the episodes, and every decision.

        Raises:
            InputError: if there are several agents.
        """
        return self._only().runs

    @property
    def records(self) -> EpisodeRecords:
        """What every episode of the only policy came to, as arrays [episodes].

        Raises:
            InputError: if there are several policies.
        """
        if len(self.runs) > 1:
            raise InputError(f"{self.agents[0]} has {len(self.runs)} training seeds; write .runs[0].scored.records")
        return self.runs[0].scored.records

    @cached_property
    def task_record(self) -> TaskRecord:
        """The task as published files describe it: seeds of the worlds, hashes of the scenario."""
        return task_record(self.task, self.episodes)

    def tables(self) -> Sequence[Table]:
        """Return the table of results."""
        return [results_table(self.task_record, self.results)]

    def scores(self) -> Shown:
        """Return what the scores of the agents are made of: it prints as a table."""
        return Shown(score_table(self.task_record, self.results))

    def worst_cases(self) -> Shown:
        """Return the worst training seed of every agent, and how severe its episodes are: it prints as a table."""
        return Shown(worst_cases_table(self.task_record, self.results))

    def failures(self) -> Shown:
        """Return the failures by cause, by the driver in front, and how severe they are: it prints as a table."""
        parts = [
            AgentEpisodes(one.agent, len(one.runs), episode_columns(one.exported())) for one in self._scored.values()
        ]
        title = f"Failures on {self.task.id}, {self.episodes:,} test episodes a policy"
        return Shown(failures_table(parts, [METRICS["impact_speed"], OVERRUN], title))

    def failed(self, agent: str | None = None, run: int = 0) -> list[int]:
        """Return the test episodes that a policy failed in, which ``watch`` can show.

        Args:
            agent: whose; None: the only agent's.
            run: the place of the policy among those of the agent, one for each training seed.
        """
        causes = episode_columns([self._run(agent, run)])["cause"]
        return [episode for episode, cause in enumerate(causes) if cause is not None]

    def columns(self) -> Columns:
        """Return every episode as a row: agent, seeds, profile in front, outcome, cause, metrics, severity.

        Raises:
            RecordError: if an agent's decisions do not come to the same episodes again.
        """
        return episode_columns(self.exported())

    def to_frame(self, of: Literal["episodes", "metrics"] = "episodes") -> Any:
        """Return a pandas ``DataFrame``: a row for every episode, or for every metric of every agent.

        Raises:
            MissingExtraError: without pandas, naming the extra that brings it.
        """
        return to_frame(self.columns() if of == "episodes" else _metric_columns(self.results))

    def watch(self, episode: int, out: str | Path | None = None, agent: str | None = None, run: int = 0) -> "Image":
        """Return a picture of a test episode: key frames, speed and distance; a notebook shows it.

        Args:
            episode: which test episode.
            out: a .png to write it to, or a .gif, which moves in real time.
            agent: whose; None: the only agent's.
            run: the place of the policy among those of the agent, one for each training seed.

        Raises:
            InputError: in one line, for an episode that was not played, a file that cannot be written, or without the
                render extra.
        """
        path = Path("episode.png" if out is None else out)
        draw, chosen = artist(path), self._run(agent, run)
        if not 0 <= episode < self.episodes:
            raise SeedError(f"episode {episode} was not played; write 0 to {self.episodes - 1}")
        if out is not None:
            require_writable(path)
        data = draw(replayed(self.task, episode, episodes_of(chosen.trace, slice(episode, episode + 1))), silent)
        if out is not None:
            write_atomically(path, data)
        from PIL import Image  # noqa: PLC0415

        return Image.open(io.BytesIO(data))

    def export(self, to: str | Path, format: Literal["csv", "parquet", "minari"] | None = None) -> list[str]:  # noqa: A002
        """Write every episode; return the path of the file, or the ids of the Minari datasets, one an agent.

        Args:
            to: a file, or the folder of Minari datasets that ``MINARI_DATASETS_PATH`` names when they are loaded.
            format: None: what the suffix of ``to`` says; without one it is Minari.

        Raises:
            InputError: in one line, if it cannot be written, or an extra is missing.
        """
        path = Path(to)
        kind = format_of(path, format)
        require_free(path, kind)
        return export_runs(self.exported(), path, kind)

    def exported(self) -> list[Run]:
        """Return all policies of all agents, each with its decisions, as ``hhrl_bench.exports`` takes them."""
        return [run for one in self._scored.values() for run in one.exported()]

    def _of(self, agent: str) -> Scored:
        if agent not in self._scored:
            raise AgentError(f"the evaluation has no agent {agent!r}; it has {', '.join(self.agents)}")
        return self._scored[agent]

    def _only(self) -> Scored:
        if len(self.agents) > 1:
            raise InputError(f"several agents were evaluated; choose one: evaluation[{self.agents[0]!r}]")
        return self._scored[self.agents[0]]

    def _run(self, agent: str | None, run: int) -> Run:
        runs = (self._only() if agent is None else self._of(agent)).exported()
        if not 0 <= run < len(runs):
            raise SeedError(f"{runs[0].agent} has no run {run}; write 0 to {len(runs) - 1}")
        return runs[run]


def _metric_columns(results: Sequence[ResultRecord]) -> Columns:
    """Return a row for every metric of every result."""
    rows = [(result, metric, result.metrics.get(metric.key)) for result in results for metric in METRICS.values()]
    known = [(result, metric, found) for result, metric, found in rows if found is not None]
    return {
        "agent": [result.agent for result, *_ in known],
        "task": [result.task for result, *_ in known],
        "metric": [metric.key for _, metric, _ in known],
        **{
            name: [getattr(found, name) for *_, found in known]
            for name in ("mean", "low", "high", "iqm", "n", "interval")
        },
    }
