"""Units that succeed, fail, hang or die as their script says, and count in a folder how often they were begun."""

import os
import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from hhrl_bench.evaluation.records import TimedResult
from hhrl_bench.evaluation.results import Update, evaluate_agent, silent
from hhrl_bench.tasks.tasks import get_task
from hhrl_envs import InputError

TASK = get_task("stop-line-v0")


@dataclass(frozen=True)
class ScriptedUnit:
    """A unit that succeeds, or does what ``script`` says; with ``once`` in it the first time alone."""

    name: str
    folder: Path
    script: str = ""

    def check(self) -> None:
        """Accept the unit."""

    def run(self, update: Update = silent) -> TimedResult:
        """Return a result, or fail, hang or die."""
        begun = self.begun()
        (self.folder / f"{self.name}-{begun}").write_text(str(os.getpid()))
        update(1, 2, "validation success 50%")
        what, _, when = self.script.partition(" ")
        if when != "once" or not begun:
            getattr(self, f"_{what}", bool)()
        return TimedResult(result=evaluate_agent("rule-2", TASK, 3), seconds=0.5)

    def begun(self) -> int:
        """Return how often it was begun."""
        return len(self._attempts())

    def pids(self) -> list[int]:
        """Return the processes that have begun it."""
        return [int(path.read_text()) for path in self._attempts() if path.read_text()]

    def _attempts(self) -> list[Path]:
        return list(self.folder.glob(f"{self.name}-[0-9]"))

    def is_hanging(self) -> bool:
        """Return whether it hangs now."""
        return any(is_running(int(path.read_text() or 0)) for path in self.folder.glob(f"{self.name}-hangs-*"))

    def _hangs(self) -> None:
        (self.folder / f"{self.name}-hangs-{self.begun()}").write_text(str(os.getpid()))
        time.sleep(300)

    def _dies(self) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    def _leaves(self) -> None:
        sys.exit(3)

    def _refuses(self) -> None:
        raise InputError("cannot; write what can")

    def _breaks(self) -> None:
        raise ZeroDivisionError("of ours")


def is_running(pid: int) -> bool:
    """Return whether there is a process of this id that has not ended."""
    try:
        return "\nState:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
