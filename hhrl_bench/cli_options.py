"""Arguments and options that several commands of the command line have."""

from enum import StrEnum
from typing import Annotated

import typer


class Executor(StrEnum):
    """Who can do the units of a suite."""

    LOCAL = "local"
    RAY = "ray"


AGENT_HELP = "A registered name, a checkpoint, a run directory, or module:factory."
AgentArgument = Annotated[str, typer.Argument(metavar="AGENT", help=AGENT_HELP, show_default=False)]
AgentsArgument = Annotated[list[str], typer.Argument(metavar="AGENT", help=AGENT_HELP, show_default=False)]
TaskOption = Annotated[str, typer.Option("--task", metavar="TASK", help="The task's id.")]
HeldOption = Annotated[
    str | None,
    typer.Option(
        "--option",
        metavar="[stop|follow]",
        help="Hold this option fixed: stop at the stop-line (the paper's SSL), or follow the front vehicle (FFV).",
    ),
]
WorkersOption = Annotated[
    int | None, typer.Option(min=1, help="Processes of this machine, side by side.", show_default="the number of cores")
]
ExecutorOption = Annotated[
    Executor, typer.Option(help="Who does the units: processes of this machine, or a Ray cluster (the ray extra).")
]
AddressOption = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="The Ray cluster's.", show_default="this machine's cluster")
]
UnitTimeoutOption = Annotated[
    float | None,
    typer.Option(
        min=0.01, metavar="MINUTES", help="End a worker that reports nothing for so long.", show_default="never"
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
