"""The figure of per-level rewards: terms by outcome, the episodes' returns, and mean rewards over time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hhrl_bench.analysis.records import (
    AnalysisRecord,
    LevelName,
    LevelRewardsRecord,
    LevelsRecord,
    grouped,
    named,
    shown,
)
from hhrl_bench.figures import style as fig
from hhrl_bench.figures.style import LEVEL_COLOURS, LEVEL_NAMES, LEVEL_WIDTHS, TERM_COLOURS, TERM_NAMES
from hhrl_envs import get_scenario

_GROUP_GAP = 0.6  # rows


def draw_levels(record: AnalysisRecord) -> Figure:
    """Return the figure; the level ``task`` is drawn for flat agents alone."""
    rewards = record.level_rewards
    groups = grouped(rewards.overall, rewards.by_outcome)
    height = 0.26 * len(groups) * (len(shown(rewards.overall.levels)) + _GROUP_GAP) + 0.5
    figure = fig.new_figure(9.0, height + 4.5, named(record), f"{record.task.episodes:,} test episodes")
    axes = figure.subplot_mosaic([["terms", "terms"], ["returns", "steps"]], height_ratios=[height, 3.0])
    _draw_terms(axes["terms"], groups)
    _draw_returns(axes["returns"], rewards)
    _draw_steps(axes["steps"], rewards, get_scenario(record.task.scenario).dt)
    return figure


def _draw_terms(axes: Axes, groups: dict[str, LevelsRecord]) -> None:
    labels: dict[float, str] = {}
    place = 0.0
    for name, group in groups.items():
        heading = f"{name} ({group.episodes:,})    "
        for level, means in shown(group.levels).items():
            ends = {False: 0.0, True: 0.0}
            for term, value in means.terms.items():
                axes.barh(place, value, left=ends[value < 0.0], color=TERM_COLOURS[term], height=0.85)
                ends[value < 0.0] += value
            axes.plot(means.total, place, marker="D", color=fig.INK, markersize=4)
            labels[place], heading = heading + LEVEL_NAMES[level], ""
            place += 1.0
        place += _GROUP_GAP
    axes.use_sticky_edges = False
    axes.set_yticks([*labels], [*labels.values()])
    axes.invert_yaxis()
    axes.axvline(0.0, color=fig.GREY, linewidth=0.8)
    axes.grid(visible=True, axis="x")
    axes.set_xlabel("mean reward of an episode; diamond: sum of the terms")
    fig.legend(axes, [(TERM_NAMES[term], colour) for term, colour in TERM_COLOURS.items()])


def _draw_returns(axes: Axes, rewards: LevelRewardsRecord) -> None:
    totals = shown(rewards.by_episode.total)
    for level, values in totals.items():
        axes.ecdf(values, color=LEVEL_COLOURS[level], linewidth=LEVEL_WIDTHS[level])
    _finish(axes, [*totals], "reward of an episode", "share of episodes at or below")


def _draw_steps(axes: Axes, rewards: LevelRewardsRecord, dt: float) -> None:
    running = np.array(rewards.by_step.running)
    times, means = (1 + np.arange(len(running))) * dt, shown(rewards.by_step.reward)
    for level, values in means.items():
        so_far = np.cumsum(running * values) / running[0]
        axes.plot(times, so_far, color=LEVEL_COLOURS[level], linewidth=LEVEL_WIDTHS[level])
    _finish(axes, [*means], "time [s]; episodes that have ended keep theirs", "mean reward so far")


def _finish(axes: Axes, levels: list[LevelName], x: str, y: str) -> None:
    fig.legend(axes, [(LEVEL_NAMES[level], LEVEL_COLOURS[level]) for level in levels])
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(visible=True)
