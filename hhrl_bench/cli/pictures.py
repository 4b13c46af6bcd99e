"""The commands that draw: an episode, an analysis, the figures and the page of a leaderboard."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hhrl_bench.cli.console import announce_compiling, console, progress
from hhrl_bench.cli.options import AgentArgument, HeldOption, JsonOption, OpponentOption, TaskOption, TrustOption

if TYPE_CHECKING:
    from hhrl_envs import Outcome

pictures_app = typer.Typer()


@pictures_app.command()
def watch(
    agent: AgentArgument,
    out: Annotated[Path, typer.Option(help="The picture to write: a .gif in real time, or a .png strip.")],
    task: TaskOption = "stop-line-v0",
    episode: Annotated[int | None, typer.Option(min=0, help="Which test episode.", show_default="0")] = None,
    option: HeldOption = None,
    opponent: OpponentOption = None,
    failed: Annotated[
        int | None,
        typer.Option(
            min=1,
            metavar="N",
            help="Draw the first N failures that --entry has of the agent instead, each beside OUT.",
            show_default="none",
        ),
    ] = None,
    entry: Annotated[Path, typer.Option(help="A published leaderboard, for --failed.")] = Path(
        "leaderboards/quick.json"
    ),
    _trust: TrustOption = False,
) -> None:
    """Draw an agent's test episode: every step as a .gif, or key frames and charts as a .png."""
    if failed is not None:
        for name, given in {"--episode": episode, "--option": option, "--opponent": opponent}.items():
            if given is not None:
                raise typer.BadParameter(
                    "it says nothing to --failed, whose episodes are the entry's; leave one out", param_hint=name
                )
    from hhrl_bench.evaluation.guarded_agent import OPTIONS, option_name
    from hhrl_bench.evaluation.loading import load_agent
    from hhrl_bench.evaluation.store import Store
    from hhrl_bench.figures import watch as films
    from hhrl_bench.leaderboard.entry import read_entry
    from hhrl_bench.tasks.tasks import get_task

    announce_compiling()
    drawn: list[tuple[Path, Outcome]]
    with progress(f"{agent} on {task}") as update:
        if failed is None:
            chosen, held = get_task(task).against(opponent), option_name(option)
            loaded, fixed = load_agent(agent, chosen), OPTIONS[held] if held else None
            drawn = [(out, films.watch(loaded, chosen, out, episode or 0, fixed, update))]
        else:
            drawn = [*films.film_failures(read_entry(entry), Store(entry.parent), agent, task, failed, out, update)]
    for path, outcome in drawn:
        typer.echo(f"wrote {path}: {outcome.name.lower().replace('_', '-')}", err=True)
    if not drawn:
        typer.echo(f"{entry} has no failure of {agent} on {task}", err=True)


@pictures_app.command()
def analyse(
    agent: AgentArgument,
    task: TaskOption = "stop-line-v0",
    episodes: Annotated[int, typer.Option(help="How many test episodes to count options and rewards over.")] = 500,
    episode: Annotated[int, typer.Option(min=0, help="The test episode to show step by step.")] = 0,
    out: Annotated[Path | None, typer.Option(help="Folder to write analysis.json and the figures into.")] = None,
    as_json: JsonOption = False,
    _trust: TrustOption = False,
) -> None:
    """Show an agent's option usage, per-level rewards and attention; of several training seeds, the lowest one's."""
    from hhrl_bench.analysis import analyse as analysis
    from hhrl_bench.tables.analysis import print_analysis
    from hhrl_envs.errors import require

    announce_compiling()
    if out is not None:
        require("matplotlib", "report")
        from hhrl_bench.figures.analysis import require_folder

        require_folder(out)
    written: list[Path] = []
    with progress(f"{agent} on {task}") as update:
        record = analysis.analyse(agent, task, episodes, episode, update)
        if out is not None:
            from hhrl_bench.figures.analysis import write

            written = write(record, out)
    for path in written:
        typer.echo(f"wrote {path}", err=True)
    if as_json:
        typer.echo(record.model_dump_json())
    else:
        print_analysis(console(), record)


@pictures_app.command()
def figures(
    file: Annotated[Path, typer.Argument(help="Leaderboard file.")] = Path("leaderboards/transfer.json"),
    out: Annotated[Path | None, typer.Option(help="Folder.", show_default="FILE without .json")] = None,
) -> None:
    """Draw the figures of a leaderboard file, as SVG and PNG."""
    from hhrl_agents.atomic_files import filled_folder, require_writable
    from hhrl_bench.errors import RecordError
    from hhrl_bench.evaluation.store import Store
    from hhrl_bench.leaderboard.entry import read_entry
    from hhrl_envs.errors import require

    require("matplotlib", "report")
    from hhrl_bench.figures.leaderboard import save_leaderboard_figures

    announce_compiling()
    board, folder = read_entry(file), out or file.with_suffix("")
    require_writable(folder / "figure.svg")
    with filled_folder(folder) as new, progress(f"figures of {file.name}") as update:
        written = save_leaderboard_figures(board, Store(file.parent), new, update)
        if not written:
            raise RecordError(f"the leaderboard of {board.suite} has one agent a task and no curves: nothing to draw")
    for path in written:
        typer.echo(f"wrote {folder / path.name}", err=True)


@pictures_app.command()
def report(
    file: Annotated[Path, typer.Argument(help="Leaderboard file.")] = Path("leaderboards/quick.json"),
    out: Annotated[Path | None, typer.Option(help="The page to write.", show_default="FILE.html")] = None,
) -> None:
    """Write a leaderboard file as one HTML page: tables, figures, settings and provenance."""
    from hhrl_agents.atomic_files import OutputError, require_writable, write_atomically
    from hhrl_bench.evaluation.store import Store
    from hhrl_bench.leaderboard.entry import read_entry
    from hhrl_envs.errors import require

    require("jinja2", "report")
    require("matplotlib", "report")
    from hhrl_bench.publishing.html_page import html

    announce_compiling()
    board, page = read_entry(file), out or file.with_suffix(".html")
    if page.resolve() == file.resolve():
        raise OutputError(f"cannot write {page}: it is the leaderboard; name another --out")
    require_writable(page)
    with progress(f"page of {file.name}") as update:
        write_atomically(page, html(board, Store(file.parent), update))
    typer.echo(f"wrote {page}", err=True)
