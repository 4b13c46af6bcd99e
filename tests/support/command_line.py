"""The command line, called as a script calls it: stdout is no terminal and its width is not set."""

from typer.testing import CliRunner, Result

from hhrl_bench.cli.app import app


def invoke(*arguments: str, columns: int | None = None) -> Result:
    """Run ``hhrl-bench`` with these arguments; with ``columns`` as on a terminal of that width."""
    return CliRunner(env={"COLUMNS": None if columns is None else str(columns)}).invoke(app, list(arguments))
