"""Progress on stderr: a bar on a terminal, plain lines anywhere else."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

Update = Callable[[int, int, str], None]
"""What a loop calls to say how much is done, of how much, and a word about it."""


def silent(*_: object) -> None:
    """Show nothing."""


@contextmanager
def progress(title: str) -> Iterator[Update]:
    """Return a context whose value shows progress when it is called."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda done, total, note: console.print(
            f"{title}: {done:,} of {total:,} {note}".rstrip(), markup=False, highlight=False, soft_wrap=True
        )
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[note]}"), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=None, note="")
        yield lambda done, total, note: bar.update(task, completed=done, total=total, note=note)
