"""Arguments and options that commands of several files have."""

from typing import Annotated

import typer

AGENT_HELP = "A registered name, a checkpoint, a run directory, or module:factory."
AgentArgument = Annotated[str, typer.Argument(metavar="AGENT", help=AGENT_HELP, show_default=False)]
AgentsArgument = Annotated[list[str], typer.Argument(metavar="AGENT", help=AGENT_HELP, show_default=False)]
TaskOption = Annotated[str, typer.Option("--task", metavar="TASK", help="The task's id.")]
TasksOption = Annotated[
    list[str] | None,
    typer.Option(
        "--task",
        metavar="TASK",
        help="The task's id; may be repeated, for a table a task.",
        show_default="stop-line-v0",
    ),
]
HeldOption = Annotated[
    str | None,
    typer.Option(
        "--option",
        metavar="[stop|follow]",
        help="Hold this option fixed: stop at the stop-line (the paper's SSL), or follow the front vehicle (FFV).",
    ),
]
OpponentOption = Annotated[
    str | None,
    typer.Option(
        "--opponent",
        metavar="AGENT",
        help="Who drives the nearest front vehicle of adversary-v0: an agent, or scripted.",
        show_default="the task's",
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON, and nothing else, on stdout.")]
