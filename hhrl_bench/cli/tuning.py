"""The command that searches for the numbers of an agent."""

from pathlib import Path
from typing import Annotated

import typer

from hhrl_bench.cli.console import announce_compiling, console, progress
from hhrl_bench.cli.interrupts import advise
from hhrl_bench.cli.options import TASK_HELP, JsonOption

tuning_app = typer.Typer()


@tuning_app.command()
def tune(
    agent: Annotated[str, typer.Argument(metavar="AGENT", help="rule-tuned or rule-robust.", show_default=False)],
    task: Annotated[
        list[str] | None,
        typer.Option(
            "--task",
            metavar="TASK",
            help=f"{TASK_HELP} May be repeated.",
            show_default="all with scripted traffic that are not superseded, but for held-out drivers",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the search.")] = 0,
    env_steps: Annotated[
        int | None, typer.Option(min=1, help="Steps of each search.", show_default="the budgets of its tasks")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File to write the numbers into; other sets in it stay.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Search for the numbers of a rule with the best score on training worlds, and print and write what is found."""
    from hhrl_bench.tables.terminal import print_table
    from hhrl_bench.tables.tunings import tunings_table
    from hhrl_bench.tasks.tasks import distinct_tasks
    from hhrl_bench.tuning.tune import tune as tune_agent

    announce_compiling()
    tasks = distinct_tasks(task or [])
    if out is not None:
        advise(f"{out} has the searches that have ended; the same command with --task does the rest")
    record = tune_agent(agent, tasks, seed, env_steps, out, lambda name: progress(f"{agent}, {name}"))
    if as_json:
        typer.echo(record.model_dump_json(indent=2))
    else:
        print_table(console(), tunings_table(record))
    if out is not None:
        typer.echo(f"wrote {out}", err=True)
