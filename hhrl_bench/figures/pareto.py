"""The figure of time and comfort: how long each agent takes on a task, and how smoothly it drives."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from hhrl_bench.evaluation.records import MetricRecord, ResultRecord
from hhrl_bench.figures.style import Look, Palette, looks, name_below, new_panels, save_figure, style
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.training.learning_curves import THRESHOLD
from hhrl_envs import get_scenario
from hhrl_envs.arrays import Floats

_SIZE, _MARGIN, _LETTERS = 7.0, 0.12, 46
_UNDER = f"filled: success of {THRESHOLD:.0%} or more; line: those that no rival beats\nthin lines: 95% intervals"


def save_pareto(board: LeaderboardRecord, folder: Path) -> list[Path]:
    """Draw time and comfort into a folder and return the files, SVG and PNG; none if no task has several agents.

    Raises:
        OutputError: if a file cannot be written.
    """
    if not _fields(board):
        return []
    with style():
        return save_figure(draw_pareto(board), folder, "time-and-comfort")


def draw_pareto(board: LeaderboardRecord) -> Figure:
    """Return the figure: a panel for each task with results of several agents.

    Where some succeed, the panel shows where they are; its heading names the others that lie beyond it.
    """
    fields = {
        task: [_place(result, _dt(board, task)) for result in results] for task, results in _fields(board).items()
    }
    known = looks([place.agent for places in fields.values() for place in places])
    x, y = "mean time of an episode [s]", "unsmooth steps an episode"
    figure, panels = new_panels("Time and comfort", _UNDER, [*fields], x, y, 2, one_y=False)
    for axes, places in zip(panels, fields.values(), strict=True):
        _draw_task(axes, places, known)
    name_below(figure, [_mark(agent, look, filled=True) for agent, look in known.items()])
    return figure


class Place(NamedTuple):
    """Where an agent is: mean, low and high of the time [s] and of the unsmooth steps, and whether it succeeds."""

    agent: str
    time: Floats
    unsmooth: Floats
    succeeds: bool
    is_oracle: bool

    @property
    def point(self) -> Floats:
        """The two means."""
        return np.array([self.time[0], self.unsmooth[0]])


def _fields(board: LeaderboardRecord) -> dict[str, list[ResultRecord]]:
    """Return the results that choose their options themselves, by task; tasks with several of them alone."""
    free = [result for result in board.results if result.option is None]
    by_task = {task.id: [result for result in free if result.task == task.id] for task in board.tasks}
    return {task: results for task, results in by_task.items() if len(results) > 1}


def _dt(board: LeaderboardRecord, task: str) -> float:
    return get_scenario(next(one.scenario for one in board.tasks if one.id == task)).dt


def _place(result: ResultRecord, dt: float) -> Place:
    metrics = result.metrics
    succeeds = (metrics.success.mean or 0.0) >= THRESHOLD
    time, unsmooth = dt * _numbers(metrics.steps), _numbers(metrics.unsmooth)
    return Place(result.agent, time, unsmooth, succeeds, is_oracle=result.kind == "oracle")


def _numbers(metric: MetricRecord) -> Floats:
    return np.array([metric.mean, metric.low, metric.high], np.float64)


def _draw_task(axes: Axes, places: Sequence[Place], known: Mapping[str, Look]) -> None:
    points = np.array([place.point for place in places if place.succeeds]).reshape(-1, 2)
    rivals = np.array([place.point for place in places if place.succeeds and not place.is_oracle]).reshape(-1, 2)
    front = rivals[non_dominated(rivals)]
    axes.plot(*front[np.argsort(front[:, 0])].T, color=Palette.PALE, zorder=1)
    shown = points if len(points) else np.array([place.point for place in places])
    low, high = shown.min(axis=0), shown.max(axis=0)
    margin = _MARGIN * np.where(high > low, high - low, np.maximum(high, 1.0))
    low, high = low - margin, high + margin
    beyond = [place.agent for place in places if ((place.point < low) | (place.point > high)).any()]
    for place in places:
        if place.agent not in beyond:
            _draw_place(axes, place, known[place.agent])
    if beyond:
        missing = fill(f"beyond: {', '.join(beyond)}", _LETTERS, break_on_hyphens=False)
        axes.set_title(f"{axes.get_title(loc='left')}\n{missing}")
    axes.xaxis.set_major_locator(MaxNLocator(5))
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.grid(visible=True)


def _draw_place(axes: Axes, place: Place, look: Look) -> None:
    (time, *times), (unsmooth, *bounds) = place.time, place.unsmooth
    axes.plot(times, [unsmooth] * 2, [time] * 2, bounds, color=look.colour, linewidth=0.8, zorder=2)
    mark = _mark(place.agent, look, filled=place.succeeds)
    mark.set_data([time], [unsmooth])
    axes.add_line(mark)


def _mark(agent: str, look: Look, *, filled: bool) -> Line2D:
    return Line2D(
        [], [], linestyle="none", marker=look.marker, markersize=_SIZE, color=look.colour, label=agent,
        markerfacecolor=look.colour if filled else "white", markeredgewidth=1.2, zorder=3,
    )  # fmt: skip


def non_dominated(points: Floats) -> NDArray[np.bool_]:
    """Return which of the points [n, k] no other one is at most equal to in all coordinates and below in one, [n]."""
    no_worse = (points[:, None] <= points).all(axis=-1)
    better = (points[:, None] < points).any(axis=-1)
    dominated: NDArray[np.bool_] = np.any(no_worse & better, axis=0)
    return ~dominated
