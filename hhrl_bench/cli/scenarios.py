"""The commands for scenarios of one's own: print one as a file, and say what is wrong with a file."""

from typing import Annotated

import typer

from hhrl_bench.cli.options import TASK_HELP

scenario_app = typer.Typer(help="Write and check scenario files.")

SURVEYED = 1_000
"""Worlds by which the share of feasible ones is told."""

MANY = 0.5
"""The share of feasible worlds below which a scenario is likely not what its author wanted."""

TaskArgument = Annotated[str, typer.Argument(metavar="TASK", help=TASK_HELP, show_default=False)]


@scenario_app.command()
def show(task: TaskArgument) -> None:
    """Print the scenario of a task as JSON, which is a scenario file: change its id and what you like."""
    from hhrl_bench.tasks.tasks import get_task
    from hhrl_envs import get_scenario, scenario_to_json

    typer.echo(scenario_to_json(get_scenario(get_task(task).scenario)))


@scenario_app.command()
def check(task: Annotated[str, typer.Argument(metavar="FILE", help=TASK_HELP, show_default=False)]) -> None:
    """Say what a scenario file comes to as a task; exit code 2, and what is wrong in one line, if it is none."""
    from hhrl_bench.cli.console import announce_compiling
    from hhrl_bench.tasks.tasks import get_task
    from hhrl_envs import SUB_GOALS, Simulator, get_scenario
    from hhrl_envs.simulation.simulator import MAKE_FEASIBLE
    from hhrl_envs.simulation.survey import feasible_share

    chosen = get_task(task)
    scenario = get_scenario(chosen.scenario)
    announce_compiling()
    Simulator(scenario, 1).reset([0])  # where no world is feasible, this says so
    goals = ", ".join(goal.name for goal, there in zip(SUB_GOALS, scenario.option_mask, strict=True) if there)
    ranges = ", ".join(f"{one.name} from {one.start:,}" for one in (chosen.train, chosen.validation, chosen.test))
    typer.echo(f"{scenario.id}: a valid scenario, spec hash {scenario.spec_hash[:12]}")
    typer.echo(f"goal {scenario.goal.name}, options {goals}, {scenario.num_actions} levels, {scenario.horizon} steps")
    share = feasible_share(scenario, SURVEYED)
    solved = f"{share:.1%} of {SURVEYED:,} worlds as they are drawn can be solved"
    typer.echo(f"{solved}; others are {'drawn anew' if scenario.feasible_only else 'kept'}")
    if share < MANY:
        typer.echo(f"few: {MAKE_FEASIBLE}")
    typer.echo(f"training budget {chosen.env_steps:,} env steps a seed; worlds: {ranges}")
