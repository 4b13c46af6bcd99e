"""The command ``export``: episodes as rows or as a Minari dataset, and networks as an ONNX file."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hhrl_bench.cli.console import announce_compiling, progress
from hhrl_bench.cli.options import AgentArgument, HeldOption, OpponentOption, TaskOption

if TYPE_CHECKING:
    from hhrl_bench.exports.episodes import Run

export_app = typer.Typer()


@export_app.command()
def export(
    agent: AgentArgument,
    to: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE_OR_FOLDER",
            help="Write the agent's test episodes: into a .csv or a .parquet file, a row each; or into a folder of "
            "Minari datasets, every transition.",
            show_default=False,
        ),
    ] = None,
    kind: Annotated[
        str | None,
        typer.Option("--format", metavar="[csv|parquet|minari]", help="The format.", show_default="by the name"),
    ] = None,
    task: TaskOption = "stop-line-v0",
    episodes: Annotated[
        int | None, typer.Option(help="How many test episodes.", show_default="1000, or all of --entry")
    ] = None,
    option: HeldOption = None,
    opponent: OpponentOption = None,
    entry: Annotated[
        Path | None,
        typer.Option(
            help="A published leaderboard to take the decisions from; nothing is run anew.", show_default=False
        ),
    ] = None,
    onnx: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write a learned agent's networks as an ONNX file instead; of several seeds, the lowest one's.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Write an agent's episodes as CSV, Parquet or a Minari dataset, or its networks as an ONNX file."""
    given = {"--to": to, "--format": kind, "--episodes": episodes, "--option": option, "--opponent": opponent}
    if onnx is not None:
        _refuse({**given, "--entry": entry}, "it says nothing to --onnx; leave one out")
        _export_onnx(agent, onnx, task)
        return
    if to is None:
        raise typer.BadParameter("name what to write: --to FILE_OR_FOLDER, or --onnx FILE", param_hint="--to")
    if entry is not None:
        _refuse({"--option": option, "--opponent": opponent}, "it says nothing to --entry; leave one out")
    from hhrl_bench.exports.export import export_runs, format_of, require_free

    chosen = format_of(to, kind)
    require_free(to, chosen)
    announce_compiling()
    runs = (
        _played(agent, task, 1000 if episodes is None else episodes, option, opponent)
        if entry is None
        else _of_entry(entry, agent, task, episodes)
    )
    for written in export_runs(runs, to, chosen):
        typer.echo(written)
    if chosen == "minari":
        typer.echo(f"hhrl-bench: MINARI_DATASETS_PATH={to} lets Minari load it by its id", err=True)


def _refuse(given: dict[str, object], why: str) -> None:
    for name, value in given.items():
        if value is not None:
            raise typer.BadParameter(why, param_hint=name)


def _played(agent: str, task: str, episodes: int, option: str | None, opponent: str | None) -> "Sequence[Run]":
    from hhrl_bench.api.evaluate import evaluate
    from hhrl_bench.evaluation.guarded_agent import OPTIONS, option_name
    from hhrl_bench.tasks.tasks import get_task

    chosen, held = get_task(task).against(opponent), option_name(option)
    with progress(f"{agent} on {chosen.id}") as update:
        return evaluate(agent, chosen, episodes, OPTIONS[held] if held else None, update).exported()


def _of_entry(entry: Path, agent: str, task: str, episodes: int | None) -> "Sequence[Run]":
    from hhrl_bench.evaluation.store import Store
    from hhrl_bench.exports.export import entry_runs
    from hhrl_bench.leaderboard.entry import read_entry

    return entry_runs(read_entry(entry), Store(entry.parent), agent, task, episodes)


def _export_onnx(agent: str, path: Path, task: str) -> None:
    from hhrl_agents.policies.learned_agent import LearnedAgent
    from hhrl_bench.errors import AgentError
    from hhrl_bench.evaluation.loading import load_agent
    from hhrl_envs.errors import require

    for module in ("torch", "onnx", "onnxscript", "onnxruntime"):
        require(module, "onnx")
    loaded = load_agent(agent, task)
    if not isinstance(loaded, LearnedAgent):
        raise AgentError(f"agent {agent!r} has no networks to write; name a learned one")
    from hhrl_agents.reference.onnx import export_onnx

    parity = export_onnx(loaded, path)
    levels, seed = " and ".join(loaded.method.levels), loaded.metadata["seed"]
    typer.echo(f"{path}: {levels} values of {loaded.method.id}, training seed {seed}")
    typer.echo(
        f"ONNX Runtime decides alike in {parity.equal:,} of {parity.states:,} random states ({parity.ties} ties); "
        f"values differ by at most {parity.difference:.1e} of the larger of their size and 1"
    )
