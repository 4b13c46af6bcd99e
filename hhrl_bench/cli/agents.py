"""The commands that list what is registered, train methods and evaluate agents."""

import json
import re
import shlex
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from enum import StrEnum
from functools import partial
from inspect import getdoc
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hhrl_bench.cli.console import announce_compiling, console, progress
from hhrl_bench.cli.interrupts import advise
from hhrl_bench.cli.options import (
    AgentsArgument,
    HeldOption,
    JsonOption,
    OpponentOption,
    TaskOption,
    TasksOption,
    TrustOption,
)

if TYPE_CHECKING:
    from rich.table import Table

    from hhrl_bench.errors import FailedAgentError
    from hhrl_bench.evaluation.records import EvaluationRecord, TimedResult
    from hhrl_bench.evaluation.results import PlayedRun
    from hhrl_bench.exports.episodes import Run
    from hhrl_bench.schema import OptionName
    from hhrl_bench.tables.table import Table as Results
    from hhrl_bench.tasks.tasks import Task

agents_app = typer.Typer()

Rows = list[dict[str, Any]]
Keep = Callable[[str, "Task", "PlayedRun"], object]
"""What takes a policy of an agent that has played a task."""


class Listed(StrEnum):
    """What ``list`` can be asked for."""

    AGENTS = "agents"
    TASKS = "tasks"
    SUITES = "suites"


@agents_app.command("list")
def list_registered(
    what: Annotated[Listed | None, typer.Argument(help="What to list.", show_default="all")] = None,
    as_json: JsonOption = False,
) -> None:
    """List what is registered: agents with their number of trained seeds, tasks and suites."""
    if what is not None:
        _print_rows(LISTS[what](), as_json=as_json)
    elif as_json:
        typer.echo(json.dumps({name: rows() for name, rows in LISTS.items()}, indent=2))
    else:
        for name, rows in LISTS.items():
            _print_rows(rows(), title=name)


@agents_app.command()
def train(
    method: Annotated[str, typer.Argument(metavar="METHOD", help="A learned method; see: list agents.")],
    task: TaskOption = "stop-line-v0",
    seeds: Annotated[str, typer.Option(help="Training seeds, trained side by side, such as 0-4,7.")] = "0",
    env_steps: Annotated[
        int | None, typer.Option(min=1, help="Steps for each seed.", show_default="the task's budget")
    ] = None,
    schedule_steps: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Steps over which exploration and learning rate change; as they are then, they stay.",
            show_default="the steps for each seed",
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Run directory.", show_default="runs/METHOD/TASK")] = None,
    engine: Annotated[str, typer.Option(help="What computes: compiled, or torch, the reference.")] = "compiled",
    device: Annotated[str, typer.Option(help="Where torch computes, cpu or cuda.")] = "cpu",
    resume: Annotated[
        bool,
        typer.Option("--resume", help="Go on with a training that was stopped, or has ended after fewer --env-steps."),
    ] = False,
    track: Annotated[
        list[str] | None,
        typer.Option(
            metavar="TRACKER",
            help="Write the curves for tensorboard, wandb (offline) or mlflow too; may be given again.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Train a method; keep each seed's best policy on validation episodes, and its last; exit code 1 if one fails."""
    from hhrl_bench.tasks.seeds import parse_seeds
    from hhrl_bench.tasks.tasks import get_task
    from hhrl_bench.training import train as training
    from hhrl_bench.training.extension import extends, span_of
    from hhrl_bench.training.run_directory import RunDirectory

    announce_compiling()
    chosen = get_task(task)
    folder, budget = out or Path("runs") / method / chosen.id, env_steps or chosen.env_steps
    trained = training.get_method(method)
    plan = training.Plan(trained, chosen, parse_seeds(seeds), budget, folder, None, engine, device, schedule_steps)
    if resume and schedule_steps is None:
        plan = replace(plan, schedule_steps=span_of(plan, RunDirectory(folder)))
    finished = resume and RunDirectory(folder).finished(plan.seeds) and not extends(plan, RunDirectory(folder))
    advise("the same command with --resume goes on from the last saved state")
    with progress(f"{method}, seeds {seeds}") as update:
        for report in training.train(plan, resume=resume, extendable=True, track=track or ()):
            update(report.env_steps, plan.env_steps, report.note)
    if finished:
        typer.echo(f"hhrl-bench: {folder} holds seeds {seeds} already, their training is finished", err=True)
    typer.echo(str(folder))
    if _say_failed(folder, plan.seeds):
        raise typer.Exit(1)


@agents_app.command()
def evaluate(
    agents: AgentsArgument,
    tasks: TasksOption = None,
    episodes: Annotated[int, typer.Option(help="How many test episodes of each task.")] = 1000,
    option: HeldOption = None,
    opponent: OpponentOption = None,
    per_episode: Annotated[
        Path | None,
        typer.Option(
            "--per-episode", metavar="FILE", help="Write every episode to a .csv or .parquet file, a row each."
        ),
    ] = None,
    as_json: JsonOption = False,
    _trust: TrustOption = False,
) -> None:
    """Score one agent or several on the test episodes of one task or several, the same worlds for every agent."""
    from hhrl_bench.evaluation.guarded_agent import option_name
    from hhrl_bench.evaluation.loading import require_playable
    from hhrl_bench.evaluation.results import evaluation_record, task_record
    from hhrl_bench.exports.export import export_runs, format_of
    from hhrl_bench.tables.results import results_table
    from hhrl_bench.tasks.tasks import distinct_tasks

    if per_episode is not None:
        _require_rows(per_episode)
    _say_what_is_passed_over(agents)
    announce_compiling()
    named, held = tasks or ["stop-line-v0"], option_name(option)
    chosen = [one.against(opponent) for one in distinct_tasks(named)]
    records = [task_record(one, episodes) for one in chosen]
    for one in chosen:
        require_playable(agents, one)
    runs: list[Run] = []
    keep = None if per_episode is None else partial(_keep_run, runs)
    each = [_evaluate_each(agents, one, episodes, held, keep) for one in chosen]
    failures = [failure for _, failed in each for failure in failed]
    if not any(timed for timed, _ in each):
        raise failures[0]
    if per_episode is not None:
        export_runs(runs, per_episode, format_of(per_episode))
    scored = [(name, record, timed) for name, record, (timed, _) in zip(named, records, each, strict=True) if timed]
    if as_json:
        commands = [_evaluate_command(agents, name, episodes, held, opponent) for name, _, _ in scored]
        made = [
            evaluation_record(record, timed, said) for (_, record, timed), said in zip(scored, commands, strict=True)
        ]
        _print_evaluations(made, alone=len(chosen) == 1)
    else:
        _print_results([results_table(record, [one.result for one in timed]) for _, record, timed in scored])
    for failure in failures:
        typer.echo(f"hhrl-bench: {failure}", err=True)
    if failures:
        raise typer.Exit(2)


def _print_evaluations(records: Sequence["EvaluationRecord"], *, alone: bool) -> None:
    """Print the record of the only task, or the list of the records of several."""
    if alone:
        typer.echo(records[0].model_dump_json(indent=2))
    else:
        typer.echo(json.dumps([record.model_dump(mode="json") for record in records], indent=2))


def _print_results(tables: Sequence["Results"]) -> None:
    from hhrl_bench.tables.terminal import print_table

    for place, table in enumerate(tables):
        if place > 0:
            console().print()
        print_table(console(), table)


def _say_what_is_passed_over(agents: Sequence[str]) -> None:
    """Say which registered names are those of files or folders here too: the registered agent is scored."""
    from hhrl_bench.evaluation.sources import is_registered

    for name in agents:
        if is_registered(name) and Path(name).exists():
            typer.echo(f"hhrl-bench: {name} is the registered agent; for what lies here write ./{name}", err=True)


def _require_rows(path: Path) -> None:
    """Refuse a file that cannot be written with a row for each episode, before anything is played."""
    from hhrl_bench.exports.export import format_of, require_free

    if not path.suffix:
        raise typer.BadParameter(f"{str(path)!r} is no file of rows; write a name that ends in .csv or .parquet")
    require_free(path, format_of(path))


def _keep_run(runs: "list[Run]", agent: str, task: "Task", played: "PlayedRun") -> None:
    from hhrl_bench.exports.episodes import run_of

    runs.append(run_of(agent, task, played))


def _evaluate_command(
    agents: Sequence[str], task: str, episodes: int, held: "OptionName | None", opponent: str | None
) -> str:
    words = ["hhrl-bench", "evaluate", *agents, "--task", task, "--episodes", str(episodes)]
    words += ["--option", held] if held else []
    return shlex.join([*words, "--opponent", opponent] if opponent else words)


def _evaluate_each(
    agents: Sequence[str], task: "Task", episodes: int, option: "OptionName | None", keep: "Keep | None"
) -> tuple[list["TimedResult"], list["FailedAgentError"]]:
    """Return the results on a task, and why users' own agents have failed that have none."""
    from hhrl_bench.errors import FailedAgentError

    timed: list[TimedResult] = []
    failures: list[FailedAgentError] = []
    for agent in agents:
        try:
            timed.append(_evaluate_timed(agent, task, episodes, option, keep))
        except FailedAgentError as error:
            failures.append(error)
    return timed, failures


def _evaluate_timed(
    agent: str, task: "Task", episodes: int, option: "OptionName | None", keep: "Keep | None"
) -> "TimedResult":
    from hhrl_bench.evaluation.records import TimedResult
    from hhrl_bench.evaluation.results import evaluate_agent
    from hhrl_bench.tasks.seeds import MAX_TRAINING_SEED

    started = time.perf_counter()
    with progress(f"{agent} on {task.id}") as update:
        result = evaluate_agent(agent, task, episodes, option, update, None, keep and partial(keep, agent, task))
    _say_failed(Path(agent), range(MAX_TRAINING_SEED + 1))
    return TimedResult(result=result, seconds=time.perf_counter() - started)


def _say_failed(folder: Path, seeds: Collection[int]) -> bool:
    """Say which of the seeds have failed in a run directory; return whether one has."""
    from hhrl_bench.training.run_directory import failed_seeds

    failed = [seed for seed in failed_seeds(folder) if seed in seeds]
    if failed:
        names = ", ".join(str(seed) for seed in failed)
        typer.echo(f"hhrl-bench: seeds that failed: {names}; see {folder}/seed-{failed[0]}.failed.json", err=True)
    return bool(failed)


def _agents() -> Rows:
    """Return the rule agents, and the learned methods: how many trained seeds come with the package, what they are."""
    from hhrl_agents import METHODS, ORACLES, RULES
    from hhrl_bench.evaluation.sources import shipped_methods

    shipped = shipped_methods()
    kinds = {"rule": RULES, "oracle": ORACLES}
    rules = [
        {"id": name, "kind": kind, "shipped_seeds": None, "summary": _summary(make)}
        for kind, makers in kinds.items()
        for name, make in makers.items()
    ]
    learned = [
        {"id": name, "kind": "learned", "shipped_seeds": shipped.get(name, 0), "summary": method.summary}
        for name, method in METHODS.items()
    ]
    return [*rules, *learned]


def _summary(make: Callable[..., object]) -> str:
    """Return what the first line of a constructor's docstring says of the agent."""
    said = (getdoc(make) or "").partition("\n")[0].removesuffix(".")
    return re.sub(r"^(Return the|An?) [\w` ]*?[Aa]gent`?( without memory)? that ", "", said)


def _tasks() -> Rows:
    """Return the tasks: scenario, training budget, what a scored agent drives behind whom, first and last seeds."""
    from hhrl_bench.tasks.tasks import TASKS, summary_of

    return [
        {
            "id": task.id,
            "scenario": task.scenario,
            "env_steps": task.env_steps,
            "drives": "all" if task.shared else "ego",
            "opponent": task.opponent,
            "summary": summary_of(task),
            **{
                f"{seeds.name}_seeds": [seeds.start, seeds.start + seeds.size - 1]
                for seeds in (task.train, task.validation, task.test)
            },
        }
        for task in TASKS.values()
    ]


def _suites() -> Rows:
    """Return the suites: their tasks, agents and number of episodes."""
    from hhrl_bench.suites.suites import SUITES

    return [
        {"id": one.id, "tasks": list(one.tasks), "agents": list(one.agents), "episodes": one.episodes}
        for one in SUITES.values()
    ]


LISTS: Mapping[Listed, Callable[[], Rows]] = MappingProxyType(
    {Listed.AGENTS: _agents, Listed.TASKS: _tasks, Listed.SUITES: _suites}
)


def _print_rows(rows: Rows, *, title: str | None = None, as_json: bool = False) -> None:
    from hhrl_bench.tables.terminal import print_widest

    if as_json:
        typer.echo(json.dumps(rows, indent=2))
        return
    screen = console()
    alike = {name: value for name, value in rows[0].items() if all(row[name] == value for row in rows)}
    names = [name for name in rows[0] if name not in alike]
    tables = [_rows_table(rows, names[:count], title) for count in range(len(names), 0, -1)]
    if left_out := print_widest(screen, tables, wrapped=True):
        missing = ", ".join(names[len(names) - left_out :])
        screen.print(f"A wider terminal shows {missing} too; so does --json.", style="dim", highlight=False)
    if alike:
        said = "; ".join(f"{name} {_said(value)}" for name, value in alike.items())
        screen.print(f"The same for all: {said}.", style="dim", highlight=False)


def _rows_table(rows: Rows, names: Sequence[str], title: str | None) -> "Table":
    from rich.table import Table

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
