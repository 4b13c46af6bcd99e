"""The figure of one episode: distances, speeds, option and attention, and both levels' rewards over time."""

from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hhrl_bench.analysis.attention import attention_over_episode
from hhrl_bench.analysis.records import EpisodeTraceRecord, shown, spoken
from hhrl_bench.evaluation.loading import LoadedAgent, load_agents
from hhrl_bench.figures import style as fig
from hhrl_bench.figures.style import (
    LEVEL_COLOURS,
    LEVEL_NAMES,
    LEVEL_WIDTHS,
    SUB_GOAL_COLOURS,
    SUB_GOAL_NAMES,
    label_weights,
    outline,
    save_figure,
    style,
)
from hhrl_bench.tasks.tasks import AnyTask, get_task
from hhrl_envs import Outcome, Scenario, get_scenario
from hhrl_envs.arrays import Codes


def draw_episode(who: str, scenario: Scenario, episode: EpisodeTraceRecord) -> Figure:
    """Return the figure of an episode of ``who``; without options or attention their panels are left out."""
    dt, reach = scenario.dt, scenario.sensor.front_range
    end = len(episode.time) * dt
    panels = {"distance": 2.2, "speed": 1.6}
    panels |= {"option": 0.5} if episode.option else {}
    panels |= {"attention": 3.4} if episode.attention else {}
    panels |= {"reward": 2.0}
    title = f"test episode {episode.number}: {spoken(episode.outcome)} after {end:.1f} s"
    figure = fig.new_figure(9.0, 1.15 * sum(panels.values()) + 1.2, who, title)
    axes = dict(zip(panels, figure.subplots(len(panels), sharex=True, height_ratios=[*panels.values()]), strict=True))
    _draw_distances(axes["distance"], episode, reach)
    _draw_speeds(axes["speed"], episode, reach)
    if "option" in axes:
        _draw_options(axes["option"], episode, dt)
    if "attention" in axes:
        _draw_attention(figure, axes["attention"], episode, dt)
    _draw_rewards(axes["reward"], episode)
    axes["reward"].set_xlabel("time [s]")
    axes["reward"].set_xlim(0.0, end)
    figure.align_ylabels()
    return figure


def _draw_distances(axes: Axes, episode: EpisodeTraceRecord, reach: float) -> None:
    front = np.array(episode.state["d_f"])
    axes.plot(episode.time, episode.state["d_d"], color=fig.Palette.ORANGE)
    axes.plot(episode.time, np.where(front < reach, front, np.nan), color=fig.Palette.GREEN)
    fig.legend(
        axes, [("$d_d$, to the stop-line", fig.Palette.ORANGE), ("$d_f$, to the front vehicle", fig.Palette.GREEN)]
    )
    _finish(axes, "distance [m]")


def _draw_speeds(axes: Axes, episode: EpisodeTraceRecord, reach: float) -> None:
    front = np.where(np.array(episode.state["d_f"]) < reach, episode.state["v_f"], np.nan)
    axes.plot(episode.time, episode.state["v_e"], color=fig.Palette.BLUE)
    axes.plot(episode.time, front, color=fig.Palette.GREY)
    fig.legend(axes, [("$v_e$, ego", fig.Palette.BLUE), ("$v_f$, front vehicle", fig.Palette.GREY)])
    _finish(axes, "speed [m/s]")


def _draw_options(axes: Axes, episode: EpisodeTraceRecord, dt: float) -> None:
    start = 0.0
    for name, run in groupby(episode.option or ()):
        length = dt * len([*run])
        axes.barh(0.5, length, 1.0, left=start, color=SUB_GOAL_COLOURS[name])
        start += length
    fig.legend(axes, [(SUB_GOAL_NAMES[name], colour) for name, colour in SUB_GOAL_COLOURS.items()])
    axes.set_yticks([0.5], ["option"])
    axes.tick_params(axis="y", length=0)
    axes.set_ylim(0.0, 1.0)


def _draw_attention(figure: Figure, axes: Axes, episode: EpisodeTraceRecord, dt: float) -> None:
    weights = np.array([*(episode.attention or {}).values()])
    extent = (0.0, weights.shape[1] * dt, len(weights) - 0.5, -0.5)
    image = axes.imshow(weights, cmap=fig.SEQUENTIAL, aspect="auto", vmin=0.0, interpolation="nearest", extent=extent)
    label_weights(axes)
    outline(axes)
    bar = figure.colorbar(image, ax=axes, pad=0.01, label="attention $I(s, o)$")
    bar.ax.axhline(1 / len(weights), color="white", linewidth=1.2)
    axes.set_title("attention on the state elements, given the selected option; white mark: all equal")


def _draw_rewards(axes: Axes, episode: EpisodeTraceRecord) -> None:
    levels = shown(episode.cumulative)
    for level, values in levels.items():
        axes.plot(episode.time, values, color=LEVEL_COLOURS[level], linewidth=LEVEL_WIDTHS[level])
    totals = {level: fig.number_text(values[-1], ".1f") for level, values in levels.items()}
    fig.legend(
        axes, [(f"{LEVEL_NAMES[level]}, {total} in all", LEVEL_COLOURS[level]) for level, total in totals.items()]
    )
    _finish(axes, "reward so far")


def _finish(axes: Axes, label: str) -> None:
    axes.set_ylabel(label)
    axes.grid(visible=True)


def typical_episode(outcome: Codes, steps: NDArray[np.int32]) -> int:
    """Return the number of the success whose length is the median of all successes; of all episodes if none succeeds.

    Args:
        outcome: how test episode 0, 1, ... ended (:class:`hhrl_envs.Outcome`), [N].
        steps: how long it was, [N].
    """
    successes = np.flatnonzero(outcome == Outcome.SUCCESS)
    places = successes if len(successes) else np.arange(len(outcome))
    by_length = places[np.argsort(steps[places], kind="stable")]
    return int(by_length[(len(places) - 1) // 2])


def save_episode(source: str | Path, task: AnyTask, episode: int, folder: Path) -> list[Path]:
    """Return the files written into the folder, SVG and PNG: test episode ``episode`` of an agent on a task.

    Args:
        source: a registered name, a checkpoint file, a run directory, or ``module:factory``; of several training
            seeds, the lowest is shown.
        task: what names a task; see :func:`hhrl_bench.tasks.tasks.get_task`.
        episode: which test episode.
        folder: where the files go.

    Raises:
        InputError: in one line, for anything that cannot be loaded, run or written.
    """
    task = get_task(task)
    scenario = get_scenario(task.scenario)
    with load_agents(source, scenario)[0] as loaded:
        trace = attention_over_episode(loaded.agent, task, episode)
    name, seed = _name(source, loaded)
    with style(mathematics=True):
        figure = draw_episode(f"{name}{seed} on {task.id}", scenario, trace)
        return save_figure(figure, folder, f"episode-{name.replace(':', '-')}-{task.id}")


def _name(source: str | Path, loaded: LoadedAgent) -> tuple[str, str]:
    """Return what the agent is called, and which training seed it is of, if any."""
    if loaded.training is None:
        return str(source), ""
    return loaded.training.method, f", training seed {loaded.training.seed},"
