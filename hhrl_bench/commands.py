"""What the commands of the command line do: results on stdout, progress on stderr."""

import json
import os
import shlex
import time
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal, cast

import typer
from rich.console import Console
from rich.table import Table

from hhrl_agents.files import OutputError, require_writable, write_atomically
from hhrl_bench import leaderboard
from hhrl_bench.attempts import Done
from hhrl_bench.board import Board
from hhrl_bench.errors import AgentError, ClusterError, RecordError
from hhrl_bench.executors import HERE, Execution
from hhrl_bench.leaderboard_record import LeaderboardRecord
from hhrl_bench.leaderboard_table import print_leaderboard
from hhrl_bench.listing import LISTS, Rows
from hhrl_bench.loading import load_agent, load_agents
from hhrl_bench.players import OPTIONS
from hhrl_bench.progress import progress
from hhrl_bench.records import OptionName, TimedResult
from hhrl_bench.results import evaluate_agent, evaluation_record, task_record
from hhrl_bench.run_directory import RunDirectory, failed_seeds
from hhrl_bench.seeds import MAX_TRAINING_SEED, parse_seeds
from hhrl_bench.status import print_status, study_board, study_status
from hhrl_bench.store import Store
from hhrl_bench.study import Study, suite_study, transfer_study
from hhrl_bench.study_view import study_view
from hhrl_bench.suite import ScoreSuite, get_suite
from hhrl_bench.table import print_results
from hhrl_bench.tasks import Task, get_task
from hhrl_envs import get_scenario
from hhrl_envs.extras import require

PLAIN_WIDTH = 160


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


def _say_failed(folder: Path, seeds: Collection[int]) -> bool:
    """Return whether one of the seeds has failed; say which."""
    failed = [seed for seed in failed_seeds(folder) if seed in seeds]
    if failed:
        names = ", ".join(str(seed) for seed in failed)
        typer.echo(f"hhrl-bench: seeds that failed: {names}; see {folder}/seed-{failed[0]}.failed.json", err=True)
    return bool(failed)


def evaluate(
    agents: Sequence[str], task: str, episodes: int, option: str | None, opponent: str | None, *, as_json: bool
) -> None:
    """Return nothing; evaluate agents in the same worlds and print their record or their table."""
    chosen, held = get_task(task).against(opponent), _option(option)
    record = task_record(chosen, episodes)
    _require_playable(agents, chosen)
    timed = [_evaluate_timed(agent, chosen, episodes, held) for agent in agents]
    if not as_json:
        print_results(_console(), record, [one.result for one in timed])
        return
    words = ["hhrl-bench", "evaluate", *agents, "--task", task, "--episodes", str(episodes)]
    words += ["--option", held] if held else []
    command = shlex.join([*words, "--opponent", opponent] if opponent else words)
    typer.echo(evaluation_record(record, timed, command).model_dump_json(indent=2))


def robustness(agents: Sequence[str], episodes: int, *, as_json: bool) -> bool:
    """Return whether every agent was scored on the robustness suite's tasks; print a leaderboard, or a row an agent."""
    from hhrl_bench.robustness import print_robustness  # noqa: PLC0415

    suite = replace(cast(ScoreSuite, get_suite("robustness")), agents=tuple(agents), episodes=episodes)
    _require_playable(agents, get_task(suite.tasks[0]))
    command = shlex.join(["hhrl-bench", "robustness", *agents, "--episodes", str(episodes)])
    with TemporaryDirectory() as folder:
        board = _do(replace(suite_study(suite, Path(folder)), command=command), HERE)
    if board and as_json:
        typer.echo(board.model_dump_json(indent=2))
    elif board:
        print_robustness(_console(), board)
    return board is not None


def analyse(agent: str, task: str, episodes: int, episode: int, out: Path | None, *, as_json: bool) -> None:
    """Return nothing; analyse an agent, print what was found, and write it with figures into a folder, if any."""
    from hhrl_bench import analysis_command  # noqa: PLC0415

    analysis_command.run(_console(), agent, task, episodes, episode, out, as_json=as_json)


def run(suite_id: str, agents: Sequence[str], out: Path | None, work: Path | None, execution: Execution) -> bool:
    """Return whether every unit of the suite was done; write and print its leaderboard, or that of other agents."""
    folder, suite = work or Path("runs") / suite_id, get_suite(suite_id)
    if not agents:
        return _publish(suite_study(suite, folder), out or Path("leaderboards") / f"{suite_id}.json", folder, execution)
    study = suite_study(ScoreSuite(suite.id, tuple(agents), suite.tasks, suite.episodes), folder)
    _require_playable(agents, get_task(suite.tasks[0]))
    words = ["hhrl-bench", "run", "--suite", suite_id, *(word for agent in agents for word in ("--agent", agent))]
    return _publish(replace(study, command=shlex.join(words)), out or folder / "entry.json", folder, execution)


def execution(
    executor: Literal["local", "ray"], workers: int | None, address: str | None, unit_timeout: float | None
) -> Execution:
    """Return who does the units; ``unit_timeout`` in minutes."""
    if executor != "ray" and address is not None:
        raise ClusterError("an --address is that of a Ray cluster; add --executor ray")
    if executor == "ray" and workers is not None:
        raise ClusterError("a Ray cluster has the workers that its nodes have cores; leave --workers out")
    patience = None if unit_timeout is None else 60.0 * unit_timeout
    return Execution(executor, workers or os.cpu_count() or 1, address, patience)


def status(folder: Path) -> None:
    """Return nothing; print how far the suite is whose trainings lie in ``folder``."""
    print_status(_console(), study_board(folder))


def transfer(
    source: str,
    targets: Sequence[str],
    seeds: str | None,
    env_steps: int,
    episodes: int,
    out: Path,
    execution: Execution,
) -> bool:
    """Return whether every arm was done; reuse a source in the targets, write and print what it is worth there."""
    require("torch", "torch")
    study = transfer_study(source, targets, () if seeds is None else parse_seeds(seeds), env_steps, episodes, out)
    return _publish(study, out / "transfer.json", out, execution)


def _publish(study: Study, path: Path, folder: Path, execution: Execution) -> bool:
    """Return whether every unit of the study was done; write and print its leaderboard if so."""
    require_writable(path)
    progress_board = study_board(folder)
    with progress_board.opened(study_status(study, execution)):
        board = _do(study, execution, progress_board)
    if board is None:
        typer.echo("hhrl-bench: no leaderboard was written; the same command goes on with what is left", err=True)
        return False
    written = leaderboard.publish(board, path, study.store)
    print_leaderboard(_console(), board)
    typer.echo(f"wrote {path}" if written else f"{path} holds the same results already", err=True)
    return True


def _do(study: Study, execution: Execution, board: Board | None = None) -> LeaderboardRecord | None:
    """Return the leaderboard of a study; None if a unit has failed, which is said."""
    done: list[Done] = []
    with study_view(study.name, study.units) as view:
        for one in study.run(execution, board, view.show):
            done.append(one)
            view.ended(one)
    failed = [one for one in done if one.outcome is None]
    for one in failed:
        typer.echo(f"hhrl-bench: {one.unit.name} failed: {one.failure}", err=True)
    return None if failed else study.leaderboard(done, execution.executor)


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
        print_sigma(_console(), record)


def show_leaderboard(path: Path, *, details: bool, as_json: bool) -> None:
    """Return nothing; print a leaderboard file as tables, in ``details`` or not, or as the JSON it is."""
    board = leaderboard.read(path)
    if as_json:
        typer.echo(board.model_dump_json(indent=2))
    else:
        print_leaderboard(_console(), board, details=details)


def show_schema() -> None:
    """Return nothing; print the JSON schema of leaderboards."""
    typer.echo(leaderboard.schema(), nl=False)


def watch(agent: str, task: str, out: Path, episode: int, option: str | None, opponent: str | None) -> None:
    """Return nothing; draw a test episode into a file."""
    from hhrl_bench.watch import watch as draw  # noqa: PLC0415

    held = OPTIONS.get(_option(option) or "")
    chosen = get_task(task).against(opponent)
    outcome = draw(load_agent(agent, chosen), chosen, out, episode, held)
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


def _require_playable(agents: Sequence[str], task: Task) -> None:
    """Return nothing; raises before anything is played for an agent that is named twice or does not load."""
    twice = next((agent for agent in agents if agents.count(agent) > 1), None)
    if twice is not None:
        raise AgentError(f"agent {twice!r} is named twice; name each agent once")
    for agent in agents[1:]:  # the first is loaded and played at once
        load_agents(agent, get_scenario(task.scenario))


def _evaluate_timed(agent: str, task: Task, episodes: int, option: OptionName | None) -> TimedResult:
    started = time.perf_counter()
    with progress(f"{agent} on {task.id}") as update:
        result = evaluate_agent(agent, task, episodes, option, update)
    _say_failed(Path(agent), range(MAX_TRAINING_SEED + 1))
    return TimedResult(result=result, seconds=time.perf_counter() - started)


def _option(spelling: str | None) -> OptionName | None:
    """Return the option's name for it or for the paper's name, in any case."""
    names = {word: name for name, option in OPTIONS.items() for word in (name, option.name.lower())}
    if spelling is not None and spelling.lower() not in names:
        known = ", ".join(f"{name} or {option.name}" for name, option in OPTIONS.items())
        raise AgentError(f"unknown option {spelling!r}; write one of: {known}")
    return None if spelling is None else cast(OptionName, names[spelling.lower()])


def _print_rows(rows: Rows, *, title: str | None = None, as_json: bool = False) -> None:
    if as_json:
        typer.echo(json.dumps(rows, indent=2))
        return
    table = Table(*rows[0], title=title, title_justify="left", box=None, pad_edge=False)
    for row in rows:
        table.add_row(*(_said(value) for value in row.values()))
    _console().print(table)


def _said(value: object) -> str:
    if isinstance(value, list):
        return (" to " if isinstance(value[0], int) else ", ").join(map(_said, value))
    return "" if value is None else f"{value:,}" if isinstance(value, int) else str(value)


def _console() -> Console:
    """Return the console of stdout; wide enough for any table where that is no terminal and COLUMNS is not set."""
    console = Console(markup=False, emoji=False)  # names are text, whatever brackets and colons they hold
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = PLAIN_WIDTH
    return console
