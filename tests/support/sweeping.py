"""The command line with suites of small units, which are done by the real executors: ``python -m support.sweeping``."""

from dataclasses import dataclass, replace
from pathlib import Path

from hhrl_bench.cli import main
from hhrl_bench.suites import suites
from hhrl_bench.suites.suites import TrainingSuite
from hhrl_bench.suites.units import Training

RULES = ("rule-1", "rule-2", "rule-3", "rule-4", "rule-4-literal", "rule-plus")
TASKS = ("stop-line-v0", "stop-line-wet-v0", "stop-line-dense-v0", "stop-line-noisy-v0", "stop-line-erratic-v0")


@dataclass(frozen=True, slots=True)
class ShortTrainings(TrainingSuite):
    """A suite whose trainings take ``env_steps`` a seed, whatever their tasks' budgets are."""

    env_steps: int = 1500

    def _trainings(self, folder: Path) -> list[Training]:
        trainings = TrainingSuite._trainings(self, folder)
        return [replace(one, task=replace(one.task, env_steps=self.env_steps)) for one in trainings]


def pairs(methods: tuple[str, ...], tasks: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Return every method with every task."""
    return tuple((method, task) for task in tasks for method in methods)


SUITES = {
    one.id: one
    for one in (
        ShortTrainings("forty", pairs(("ddqn", "hybrid-hrl"), TASKS), (0,), 50, RULES),
        ShortTrainings("four", pairs(("ddqn", "hybrid-hrl"), TASKS[:1]), (0,), 20, RULES[:2]),
        ShortTrainings("equal", pairs(("ddqn", "hybrid-hrl"), TASKS[:4]), (0,), 20, (), 20_000),
    )
}


if __name__ == "__main__":
    suites.SUITES = SUITES
    main()
