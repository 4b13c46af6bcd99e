"""What the commands that draw do: files written, their names on stderr."""

from pathlib import Path

import typer

from hhrl_agents.files import OutputError, require_writable, write_atomically
from hhrl_bench import leaderboard
from hhrl_bench.errors import RecordError
from hhrl_bench.loading import load_agent
from hhrl_bench.players import OPTIONS, option_name
from hhrl_bench.store import Store
from hhrl_bench.tasks import get_task
from hhrl_bench.terminal import console
from hhrl_envs.extras import require


def analyse(agent: str, task: str, episodes: int, episode: int, out: Path | None, *, as_json: bool) -> None:
    """Return nothing; analyse an agent, print what was found, and write it with figures into a folder, if any."""
    from hhrl_bench import analysis_command  # noqa: PLC0415

    analysis_command.run(console(), agent, task, episodes, episode, out, as_json=as_json)


def figures(path: Path, out: Path | None) -> None:
    """Return nothing; draw the figures of a leaderboard file into a folder, beside it by default."""
    require("matplotlib", "report")
    from hhrl_bench.leaderboard_figures import save_leaderboard_figures  # noqa: PLC0415

    board, folder = leaderboard.read(path), out or path.with_suffix("")
    written = save_leaderboard_figures(board, Store(path.parent), folder)
    if not written:
        raise RecordError(f"the leaderboard of {board.suite} has one agent a task and no curves: nothing to draw")
    for file in written:
        typer.echo(f"wrote {file}", err=True)


def report(path: Path, out: Path | None) -> None:
    """Return nothing; write the page of a leaderboard file, beside it by default."""
    require("jinja2", "report")
    require("matplotlib", "report")
    from hhrl_bench.report import html  # noqa: PLC0415

    board, page = leaderboard.read(path), out or path.with_suffix(".html")
    if page.resolve() == path.resolve():
        raise OutputError(f"cannot write {page}: it is the leaderboard; name another --out")
    require_writable(page)
    write_atomically(page, html(board, Store(path.parent)))
    typer.echo(f"wrote {page}", err=True)


def watch(agent: str, task: str, out: Path, episode: int, option: str | None, opponent: str | None) -> None:
    """Return nothing; draw a test episode into a file."""
    from hhrl_bench.watch import watch as draw  # noqa: PLC0415

    chosen, held = get_task(task).against(opponent), option_name(option)
    outcome = draw(load_agent(agent, chosen), chosen, out, episode, OPTIONS[held] if held else None)
    typer.echo(f"wrote {out}: {outcome.name.lower().replace('_', '-')}", err=True)


def watch_failures(agent: str, task: str, out: Path, count: int, entry: Path) -> None:
    """Return nothing; draw the first failures that a published entry has of an agent on a task."""
    from hhrl_bench.failures import film_failures  # noqa: PLC0415

    drawn = 0
    for path, outcome in film_failures(leaderboard.read(entry), Store(entry.parent), agent, task, count, out):
        typer.echo(f"wrote {path}: {outcome.name.lower().replace('_', '-')}", err=True)
        drawn += 1
    if not drawn:
        typer.echo(f"{entry} has no failure of {agent} on {task}", err=True)
