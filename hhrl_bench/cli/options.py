"""Arguments and options that commands of several files have."""

import os
from typing import Annotated

import typer

AGENT_HELP = (
    "A registered name, METHOD:SEEDS, a checkpoint, a run directory, a zip of Stable-Baselines3, an ONNX file, a "
    "folder or a list A,B,C of these, module:factory, or module:factory@SEEDS."
)
AgentArgument = Annotated[str, typer.Argument(metavar="AGENT", help=AGENT_HELP, show_default=False)]
AgentsArgument = Annotated[list[str], typer.Argument(metavar="AGENT", help=AGENT_HELP, show_default=False)]
TASK_HELP = "A task's id, a scenario file, or module:scenario."
TaskOption = Annotated[str, typer.Option("--task", metavar="TASK", help=TASK_HELP)]
TasksOption = Annotated[
    list[str] | None,
    typer.Option(
        "--task",
        metavar="TASK",
        help=f"{TASK_HELP} May be repeated, for a table a task.",
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


def _trust(trusted: bool) -> None:
    """Let the processes of agents run what is in their files, which the variable says to them."""
    if trusted:
        os.environ["HHRL_TRUST"] = "1"


TrustOption = Annotated[
    bool,
    typer.Option(
        "--trust",
        callback=_trust,
        help="Run the code that is in a zip of Stable-Baselines3, where it cannot be read without that.",
    ),
]
