"""Studies: units to do and the leaderboard to make of them, for a suite or for the transfer of one source."""

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.records import TimedResult
from hhrl_bench.evaluation.results import silent, task_record
from hhrl_bench.evaluation.store import Store
from hhrl_bench.execution.progress_folder import ProgressFolder, StudyStatus
from hhrl_bench.execution.run import IN_THIS_PROCESS, Execution, Show, run_stages
from hhrl_bench.execution.unit import Done, Stages, Unit
from hhrl_bench.leaderboard.entry import build_entry
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.suites.suites import Curves, Suite
from hhrl_bench.suites.units import arm_trainings, seed_trainings
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.tasks.tasks import Task, get_task
from hhrl_bench.training.learning_curves import read_outcomes
from hhrl_bench.training.reuse import load_source
from hhrl_bench.transfer.summary import transfer_record
from hhrl_bench.transfer.transfer import Transfer, sensible_arms
from hhrl_envs import get_scenario
from hhrl_envs.errors import one_line


@dataclass(frozen=True)
class Study:
    """What to do and what to make of it.

    Attributes:
        name: of the leaderboard.
        command: that does the same again.
        tasks: that results are on, with this many test ``episodes`` each.
        stages: the units.
        curves: whose learning curves the leaderboard holds.
        store: where the units leave their evidence.
    """

    name: str
    command: str
    tasks: Sequence[Task]
    episodes: int
    stages: Stages
    curves: Curves
    store: Store

    def __post_init__(self) -> None:
        """Reject a number of episodes that a task does not have."""
        for task in self.tasks:
            task.test.take(self.episodes)

    @property
    def units(self) -> tuple[Unit, ...]:
        """The units of all stages."""
        return tuple(unit for stage in self.stages for unit in stage)

    def status(self, execution: Execution) -> StudyStatus:
        """Return what is to be done if it begins now."""
        return StudyStatus(
            study=self.name,
            executor=execution.executor,
            started=datetime.now(UTC).isoformat(timespec="seconds"),
            units=tuple(one_line(unit.name) for unit in self.units),
        )

    def run(
        self, execution: Execution = IN_THIS_PROCESS, progress: ProgressFolder | None = None, show: Show = silent
    ) -> Iterator[Done]:
        """Yield every unit as it is done; see :func:`hhrl_bench.execution.run.run_stages`."""
        return run_stages(self.stages, execution, progress, show)

    def leaderboard(self, done: Sequence[Done], executor: str = "local") -> LeaderboardRecord:
        """Return the leaderboard of all units, in their own order whatever the order they were done in."""
        outcomes = {one.unit.name: one.outcome for one in done}
        results = [found for unit in self.units if isinstance(found := outcomes[unit.name], TimedResult)]
        tasks = [task_record(task, self.episodes) for task in self.tasks]
        trainings = [read_outcomes(training.folder, training.seeds) for training in self.curves.trainings]
        transfer = transfer_record(self.curves.transfers)
        return build_entry(self.name, tasks, results, self.command, self.store, transfer, trainings, executor)


def suite_study(suite: Suite, folder: Path) -> Study:
    """Return the study of a suite, whose trainings lie in ``folder``."""
    tasks = list(map(get_task, suite.tasks))
    command = f"hhrl-bench run --suite {suite.id}"
    return Study(suite.id, command, tasks, suite.episodes, suite.stages(folder), suite.curves(folder), Store(folder))


def transfer_study(
    source: str, targets: Sequence[str], seeds: Sequence[int], env_steps: int, episodes: int, folder: Path
) -> Study:
    """Return the study of one source reused in the targets with these training seeds, or with all that it has.

    Raises:
        InputError: if there is no such source, target or seed, a target sees or acts otherwise than the source, or
            nothing of the source can be reused in it.
    """
    tasks = list(map(get_task, targets))
    twice = next((target for target in targets if targets.count(target) > 1), None)
    if twice is not None:
        raise AgentError(f"target {twice!r} is named twice; name each target once")
    loaded, *_ = [load_source(source, get_scenario(task.scenario)) for task in tasks]
    chosen = tuple(seeds or sorted(loaded.policies))
    loaded.require_seeds(chosen)
    transfers = [Transfer(source, task, chosen, env_steps, folder / loaded.method.id / task.id) for task in tasks]
    for task in tasks:
        if not sensible_arms(loaded.method, task):
            raise AgentError(
                f"nothing of {loaded.method.id} can be reused in a training on {task.id}; name another target"
            )
    store = Store(folder)
    arms = [arm for one in transfers for arm in arm_trainings(one, loaded.method, episodes, store)]
    words = ["hhrl-bench", "transfer", "--source", source, *(word for one in targets for word in ("--target", one))]
    words += ["--seeds", format_seeds(chosen), "--env-steps", str(env_steps), "--episodes", str(episodes)]
    stages: Stages = [seed_trainings(arms), arms]
    return Study("transfer", shlex.join(words), tasks, episodes, stages, Curves(transfers=transfers), store)
