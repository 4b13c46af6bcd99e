"""What the commands about agents, methods and the paper do: results on stdout, progress on stderr."""

import json
import shlex
import time
from collections.abc import Collection, Sequence
from pathlib import Path

import typer
from rich.table import Table

from hhrl_bench.listing import LISTS, Rows
from hhrl_bench.loading import require_playable
from hhrl_bench.players import option_name
from hhrl_bench.progress import progress
from hhrl_bench.records import OptionName, TimedResult
from hhrl_bench.results import evaluate_agent, evaluation_record, task_record
from hhrl_bench.run_directory import RunDirectory, failed_seeds
from hhrl_bench.seeds import MAX_TRAINING_SEED, parse_seeds
from hhrl_bench.table import print_results, print_widest
from hhrl_bench.tasks import Task, get_task
from hhrl_bench.terminal import console
from hhrl_envs.extras import require


def list_registered(what: str | None, *, as_json: bool) -> None:
    """Return nothing; print one list of :data:`hhrl_bench.listing.LISTS`, or all of them."""
    if what is not None:
        _print_rows(LISTS[what](), as_json=as_json)
    elif as_json:
        typer.echo(json.dumps({name: rows() for name, rows in LISTS.items()}, indent=2))
    else:
        for name, rows in LISTS.items():
            _print_rows(rows(), title=name)


def train(
    method: str,
    task: str,
    seeds: str,
    env_steps: int | None,
    out: Path | None,
    device: str,
    *,
    resume: bool,
    tensorboard: bool,
) -> bool:
    """Return whether no seed failed; train, validate and save; the run directory's name goes to stdout."""
    require("torch", "torch")
    from hhrl_bench import train as training  # noqa: PLC0415

    chosen = get_task(task)
    folder = out or Path("runs") / method / chosen.id
    plan = training.Plan(
        training.get_method(method), chosen, parse_seeds(seeds), env_steps or chosen.env_steps, folder, device
    )
    finished = resume and RunDirectory(folder).finished(plan.seeds)
    try:
        with progress(f"{method}, seeds {seeds}") as update:
            for report in training.train(plan, resume=resume, tensorboard=tensorboard):
                update(report.env_steps, plan.env_steps, report.note)
    except KeyboardInterrupt:
        typer.echo("hhrl-bench: the same command with --resume goes on from the last saved state", err=True)
        raise
    if finished:
        typer.echo(f"hhrl-bench: {folder} holds seeds {seeds} already, their training is finished", err=True)
    typer.echo(str(folder))
    return not _say_failed(folder, plan.seeds)


def evaluate(
    agents: Sequence[str], task: str, episodes: int, option: str | None, opponent: str | None, *, as_json: bool
) -> None:
    """Return nothing; evaluate agents in the same worlds and print their record or their table."""
    chosen, held = get_task(task).against(opponent), option_name(option)
    record = task_record(chosen, episodes)
    require_playable(agents, chosen)
    timed = [_evaluate_timed(agent, chosen, episodes, held) for agent in agents]
    if not as_json:
        print_results(console(), record, [one.result for one in timed])
        return
    words = ["hhrl-bench", "evaluate", *agents, "--task", task, "--episodes", str(episodes)]
    words += ["--option", held] if held else []
    command = shlex.join([*words, "--opponent", opponent] if opponent else words)
    typer.echo(evaluation_record(record, timed, command).model_dump_json(indent=2))


def calibrate(seed: int, generations: int, episodes: int, out: Path | None, *, check: bool) -> bool:
    """Return whether all bars hold in the world found, with ``check`` in the registered one; print it.

    With ``out`` parameters and residuals are written into that folder.
    """
    from hhrl_bench import calibrate as calibration  # noqa: PLC0415
    from hhrl_bench.residuals import markdown  # noqa: PLC0415

    if check:
        record = calibration.check(episodes, out)
    else:
        with progress(f"calibration, seed {seed}") as update:
            record = calibration.search(seed, generations, episodes, out, update)
    typer.echo(markdown(record))
    if out is not None:
        typer.echo(f"wrote {out}", err=True)
    return record.holds


def sigma(*, as_json: bool) -> None:
    """Return nothing; print the constants of the reward that Table I implies."""
    from hhrl_bench.sigma_report import measure, print_sigma  # noqa: PLC0415

    record = measure()
    if as_json:
        typer.echo(record.model_dump_json(indent=2))
    else:
        print_sigma(console(), record)


def _evaluate_timed(agent: str, task: Task, episodes: int, option: OptionName | None) -> TimedResult:
    started = time.perf_counter()
    with progress(f"{agent} on {task.id}") as update:
        result = evaluate_agent(agent, task, episodes, option, update)
    _say_failed(Path(agent), range(MAX_TRAINING_SEED + 1))
    return TimedResult(result=result, seconds=time.perf_counter() - started)


def _say_failed(folder: Path, seeds: Collection[int]) -> bool:
    """Return whether one of the seeds has failed; say which."""
    failed = [seed for seed in failed_seeds(folder) if seed in seeds]
    if failed:
        names = ", ".join(str(seed) for seed in failed)
        typer.echo(f"hhrl-bench: seeds that failed: {names}; see {folder}/seed-{failed[0]}.failed.json", err=True)
    return bool(failed)


def _print_rows(rows: Rows, *, title: str | None = None, as_json: bool = False) -> None:
    if as_json:
        typer.echo(json.dumps(rows, indent=2))
        return
    screen, names = console(), list(rows[0])
    tables = [_rows_table(rows, names[:count], title) for count in range(len(names), 0, -1)]
    if left_out := print_widest(screen, tables, wrapped=True):
        missing = ", ".join(names[len(names) - left_out :])
        screen.print(f"A wider terminal shows {missing} too; so does --json.", style="dim", highlight=False)


def _rows_table(rows: Rows, names: Sequence[str], title: str | None) -> Table:
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    for name in names:
        table.add_column(name, no_wrap=name == "id", overflow="fold")
    for row in rows:
        table.add_row(*(_said(row[name]) for name in names))
    return table


def _said(value: object) -> str:
    if isinstance(value, list):
        return (" to " if isinstance(value[0], int) else ", ").join(map(_said, value))
    return "" if value is None else f"{value:,}" if isinstance(value, int) else str(value)
