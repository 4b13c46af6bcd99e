"""How far a study is, on the screen: live on a terminal, plain lines anywhere else, and what ``--status`` prints."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from hhrl_bench.execution.progress_folder import ProgressFolder, UnitStatus
from hhrl_bench.execution.unit import Done, unit_status

LINE_INTERVAL = 60.0
"""Seconds between plain lines about the units that run."""


@dataclass
class UnitCounts:
    """How many of ``units`` are done and failed, and the seconds that those done have taken."""

    units: int
    done: int = 0
    failed: int = 0
    seconds: float = 0.0

    def add(self, status: UnitStatus) -> None:
        """Count a unit that has ended."""
        self.done += status.state == "done"
        self.failed += status.state == "failed"
        self.seconds += status.seconds if status.state == "done" else 0.0

    def left(self, running: Sequence[UnitStatus]) -> float | None:
        """Return an estimate of the seconds until all is done, as if all units were alike; None if nothing is known."""
        shares = sum(status.share for status in running)
        finished = self.done + shares
        if not finished or not running:
            return None
        each = (self.seconds + sum(status.seconds for status in running)) / finished
        return each * (self.units - self.done - self.failed - shares) / len(running)

    def text(self, running: Sequence[UnitStatus]) -> str:
        """Return the counts in words."""
        left = self.left(running)
        counts = [f"{self.done:,} of {self.units:,} done", f"{len(running):,} running", f"{self.failed:,} failed"]
        return ", ".join(counts if left is None else [*counts, f"about {timedelta(seconds=round(left))} left"])


class StudyView:
    """Shows a study: as lines that ``say`` takes, or as a picture that ``draw`` takes."""

    def __init__(
        self,
        name: str,
        units: int,
        say: Callable[[str], None] | None = None,
        draw: Callable[[RenderableType], None] | None = None,
    ) -> None:
        self._name, self._counts, self._say, self._draw = name, UnitCounts(units), say, draw
        self._running: Sequence[UnitStatus] = ()
        self._due = time.monotonic() + LINE_INTERVAL

    def show(self, running: Sequence[UnitStatus]) -> None:
        """Show how far the running units are."""
        self._running = running
        if self._draw:
            self._draw(self._picture())
        elif self._say and running and time.monotonic() >= self._due:
            self._due = time.monotonic() + LINE_INTERVAL
            self._say(f"suite {self._name}: {self._counts.text(running)}")
            for status in running:
                self._say(f"  {status.unit}: {status.share:.0%} {status.note}".rstrip())

    def ended(self, done: Done) -> None:
        """Show that a unit has ended."""
        status = unit_status(done, 0.0)
        self._counts.add(status)
        self._running = [one for one in self._running if one.unit != done.unit.name]
        if self._draw:
            self._draw(self._picture())
        elif self._say:
            ended = self._counts.done + self._counts.failed
            said = status.note if done.outcome else "failed"
            self._say(f"suite {self._name}: {ended:,} of {self._counts.units:,} {done.unit.name}: {said}")

    def _picture(self) -> Group:
        counts = self._counts
        line = Table.grid(padding=(0, 1))
        share = counts.done + counts.failed + sum(status.share for status in self._running)
        bar = ProgressBar(total=counts.units, completed=share, width=24)
        line.add_row(Text(f"suite {self._name}"), bar, Text(counts.text(self._running)))
        return Group(line, _unit_table(self._running))


@contextmanager
def study_view(name: str, units: int) -> Iterator[StudyView]:
    """Return a context with the view of a study of so many units, on stderr."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield StudyView(
            name, units, say=lambda line: console.print(line, markup=False, highlight=False, soft_wrap=True)
        )
        return
    with Live(console=console, auto_refresh=False, transient=True) as live:
        yield StudyView(name, units, draw=lambda picture: live.update(picture, refresh=True))


def print_status(console: Console, progress: ProgressFolder) -> None:
    """Print how many units are done, and how far each is that runs or why it has failed.

    Raises:
        RecordError: in one line, if the folder holds no study.
    """
    study = progress.study()
    units = [status for name in study.units if (status := progress.unit(name))]
    counts = UnitCounts(len(study.units))
    for status in units:
        counts.add(status)
    at_work = progress.is_open()
    running = [status for status in units if status.state == "running"]
    state = f"at work since {study.started}" if at_work else "no run is at work"
    text = f"suite {study.study}: {counts.text(running if at_work else ())} ({study.executor}, {state})"
    console.print(text, markup=False, highlight=False, soft_wrap=True)
    failed = [status for status in units if status.state == "failed"]
    if running or failed:
        console.print(_unit_table([*(running if at_work else map(_stopped, running)), *failed]))


def _stopped(status: UnitStatus) -> UnitStatus:
    """Return the status of a unit that nobody goes on with."""
    return status.model_copy(update={"note": f"stopped; {status.note}".rstrip("; ")})


def _unit_table(units: Sequence[UnitStatus]) -> Table:
    """Return a row for each unit: what it is called, how far it is, its success rates or why it has failed."""
    table = Table(box=None, show_header=False, pad_edge=True)
    table.add_column(overflow="fold")
    table.add_column(justify="right", no_wrap=True)
    table.add_column(overflow="fold")
    for status in units:
        state = f"{status.share:.0%}" if status.state == "running" else status.state
        table.add_row(
            Text(status.unit), Text(state, style="red" if status.state == "failed" else ""), Text(status.note)
        )
    return table
