"""The command line: exit code 0 done, 1 a check did not hold, 2 bad usage or input, said in one line."""

import os
import sys
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from hhrl_bench.cli.agents import agents_app
from hhrl_bench.cli.export import export_app
from hhrl_bench.cli.interrupts import INTERRUPTED, advise, say_interrupted, was_interrupted
from hhrl_bench.cli.leaderboard import leaderboard_app
from hhrl_bench.cli.once import GivenOnce, require_once
from hhrl_bench.cli.paper import paper_app
from hhrl_bench.cli.pictures import pictures_app
from hhrl_bench.cli.scenarios import scenario_app
from hhrl_bench.cli.suites import suites_app
from hhrl_bench.cli.tuning import tuning_app
from hhrl_bench.tracebacks import TRACEBACK_VARIABLE, show_traceback


class OneLineErrors(GivenOnce, TyperGroup):
    """A group of commands whose failures are one line on stderr and exit code 2, without a traceback."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run the command line and leave with its exit code."""
        advise("")
        try:
            code = super().main(*args, **{**kwargs, "standalone_mode": False})
            sys.stdout.flush()  # here, where a full disk or a reader that has left can still be answered
        except Exception as error:
            code = INTERRUPTED if was_interrupted() else _explained(error)
            if code is None:
                raise
        if code == INTERRUPTED:
            say_interrupted()
        sys.exit(code if isinstance(code, int) else 0)


def _explained(error: Exception) -> int | None:
    """Say what is wrong with usage or input, and return the exit code; None for a fault of ours."""
    message = _message(error)
    if message is None:
        return None
    show_traceback(error)
    if isinstance(error, OSError):
        _close_stdout()
    typer.echo("hhrl-bench: " + " ".join(message.split()), err=True)
    return 2


def _close_stdout() -> None:
    """Drop what stdout still holds if nobody takes it, so that Python does not try again when it ends."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _message(error: Exception) -> str | None:
    """Return what to say of bad usage or input; None for a fault of ours, which keeps its traceback."""
    if hasattr(error, "format_message"):
        return str(error.format_message()).replace("Value error, ", "")
    if isinstance(error, FileNotFoundError) and error.filename is None:
        return "the current folder has been removed; change to one that is there"
    if isinstance(error, OSError) and error.strerror:
        return f"{error.strerror}: {error.filename}" if error.filename else error.strerror
    if isinstance(error, ValueError):
        from hhrl_envs.errors import InputError

        return str(error) if isinstance(error, InputError) else None
    return None


def _require_threads(number: str) -> None:
    """Refuse a number of threads that an environment hands down and that no library that reads it could use."""
    if not number.isdecimal() or int(number) < 1:
        raise typer.BadParameter(f"NUMBA_NUM_THREADS is {number!r}; write a number of threads from 1, or unset it")


app = typer.Typer(
    cls=OneLineErrors,
    help="Benchmark hierarchical, flat and rule agents on the stop-line tasks.",
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
)
app.add_typer(agents_app)
app.add_typer(export_app)
app.add_typer(paper_app)
app.add_typer(tuning_app)
app.add_typer(suites_app)
app.add_typer(pictures_app)
app.add_typer(leaderboard_app, name="leaderboard")
app.add_typer(scenario_app, name="scenario")
require_once(app)


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and leave.")] = False,
    traceback: Annotated[
        bool, typer.Option("--traceback", help="Show where an error comes from; so does HHRL_TRACEBACK=1.")
    ] = False,
    extension: Annotated[
        list[str] | None,
        typer.Option(
            metavar="MODULE_OR_FILE",
            help="Load a module that registers metrics or scenarios of your own, or a scenario file; may be given "
            "again. HHRL_EXTENSIONS names such modules too.",
            show_default=False,
        ),
    ] = None,
) -> None:
    if traceback:
        os.environ[TRACEBACK_VARIABLE] = "1"  # processes that the command begins show theirs too
    _require_threads(os.environ.get("NUMBA_NUM_THREADS", "1"))
    if extension or "HHRL_EXTENSIONS" in os.environ:
        from hhrl_bench.extensions import load_extensions

        load_extensions(extension or ())
    if version:
        from hhrl_bench import __version__

        typer.echo(f"hhrl-bench {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
