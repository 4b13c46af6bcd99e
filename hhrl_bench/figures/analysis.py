"""The figures of an analysis: one episode, the (d_f, d_d) plane, option usage, and per-level rewards.

They need the ``report`` extra.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from hhrl_agents.atomic_files import require_writable, write_atomically
from hhrl_bench.analysis.records import (
    AnalysisRecord,
    LevelName,
    LevelRewardsRecord,
    LevelsRecord,
    OptionUsageRecord,
    UsageBinRecord,
    grouped,
    named,
    shown,
)
from hhrl_bench.figures import style as fig
from hhrl_bench.figures.episode import draw_episode
from hhrl_bench.figures.plane import draw_plane
from hhrl_bench.figures.style import (
    LEVEL_COLOURS,
    LEVEL_NAMES,
    LEVEL_WIDTHS,
    SUB_GOAL_COLOURS,
    SUB_GOAL_NAMES,
    TERM_COLOURS,
    TERM_NAMES,
    remove_figure,
    save_figure,
    style,
)
from hhrl_envs import get_scenario
from hhrl_envs.errors import require

FILE = "analysis.json"
_GROUP_GAP = 0.6  # rows


def require_folder(folder: Path) -> None:
    """Raise an ``InputError`` if an analysis could not be drawn or not be written into the folder."""
    require("matplotlib", extra="report")
    require_writable(folder / FILE)


def write(record: AnalysisRecord, folder: Path) -> list[Path]:
    """Return the files written into the folder: the record as JSON, and its figures.

    Equal analyses give equal files, byte for byte.
    """
    path = folder / FILE
    write_atomically(path, record.model_dump_json() + "\n")
    return [path, *save_figures(record, folder)]


def save_figures(record: AnalysisRecord, folder: Path) -> list[Path]:
    """Return the files written into the folder: each figure as SVG and PNG; one that is not drawn is taken away.

    Raises:
        OutputError: if one cannot be written.
    """
    written: list[Path] = []
    with style(mathematics=True):
        for name, draw in FIGURES.items():
            figure = draw(record)
            written += remove_figure(folder, name) if figure is None else save_figure(figure, folder, name)
    return written


def draw_usage(record: AnalysisRecord) -> Figure | None:
    """Return the figure; None for a flat agent."""
    usage = record.option_usage
    if usage is None:
        return None
    height = 0.32 * (1 + len(usage.by_outcome)) + 0.2
    title = f"{record.task.episodes:,} test episodes, {usage.overall.switches:.1f} switches an episode"
    figure = fig.new_figure(9.0, height + 5.4, named(record), title)
    axes = figure.subplot_mosaic(
        [["many_d", "many_f"], ["share_d", "share_f"], ["outcome", "outcome"]], height_ratios=[0.9, 2.4, height]
    )
    _draw_bins(axes["many_d"], axes["share_d"], usage.by_d_d, "$d_d$, to the stop-line [m]")
    _draw_bins(axes["many_f"], axes["share_f"], usage.by_d_f, "$d_f$, to the front vehicle [m]")
    _draw_outcomes(axes["outcome"], usage)
    fig.legend(axes["many_f"], [(SUB_GOAL_NAMES[name], colour) for name, colour in SUB_GOAL_COLOURS.items()])
    axes["many_d"].set_ylabel("share of steps")
    axes["share_d"].set_ylabel("share of these steps")
    return figure


def _draw_bins(many: Axes, shares: Axes, bins: Sequence[UsageBinRecord], label: str) -> None:
    bins = _trimmed(bins)
    places, total = np.arange(len(bins)), sum(one.steps for one in bins)
    many.bar(places, [one.steps / total for one in bins], color=fig.Palette.GREY, width=0.9)
    bottom = np.zeros(len(bins))
    for name, colour in SUB_GOAL_COLOURS.items():
        heights = np.array([one.share[name] if one.share else 0.0 for one in bins])
        shares.bar(places, heights, bottom=bottom, color=colour, width=0.9)
        bottom += heights
    labels = ["none" if one.high is None else f"{one.low:g}\N{EN DASH}{one.high:g}" for one in bins]
    shares.set_xticks(places, labels, rotation=60)
    shares.set_xlabel(f"{label}; none: out of range" if bins[-1].high is None else label)
    many.set_xticks([])
    shares.set_ylim(0.0, 1.0)
    for axes in (many, shares):
        axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
        axes.grid(visible=True, axis="y")


def _trimmed(bins: Sequence[UsageBinRecord]) -> list[UsageBinRecord]:
    """Return the bins without the empty ones at the far end; what is out of range stays if there is any."""
    filled = [place for place, one in enumerate(bins) if one.steps and one.high is not None]
    return [*bins[: max(filled, default=0) + 1], *(one for one in bins if one.high is None and one.steps)]


def _draw_outcomes(axes: Axes, usage: OptionUsageRecord) -> None:
    rows = grouped(usage.overall, usage.by_outcome)
    left = np.zeros(len(rows))
    for name, colour in SUB_GOAL_COLOURS.items():
        widths = np.array([one.share[name] for one in rows.values()])
        axes.barh(range(len(rows)), widths, left=left, color=colour, height=0.8)
        left += widths
    axes.set_yticks(range(len(rows)), [f"{name} ({one.episodes:,})" for name, one in rows.items()])
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.0)
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_xlabel("share of the steps, by the outcome of the episodes (how many)")


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
            axes.plot(means.total, place, marker="D", color=fig.Palette.INK, markersize=4)
            labels[place], heading = heading + LEVEL_NAMES[level], ""
            place += 1.0
        place += _GROUP_GAP
    axes.use_sticky_edges = False
    axes.set_yticks([*labels], [*labels.values()])
    axes.invert_yaxis()
    axes.axvline(0.0, color=fig.Palette.GREY, linewidth=0.8)
    axes.grid(visible=True, axis="x")
    axes.set_xlabel("mean reward of an episode; diamond: sum of the terms")
    fig.legend(axes, [(TERM_NAMES[term], colour) for term, colour in TERM_COLOURS.items()])


def _draw_returns(axes: Axes, rewards: LevelRewardsRecord) -> None:
    totals = shown(rewards.by_episode.total)
    for level, values in totals.items():
        axes.ecdf(values, color=LEVEL_COLOURS[level], linewidth=LEVEL_WIDTHS[level])
    _label_levels(axes, [*totals], "reward of an episode", "share of episodes at or below")


def _draw_steps(axes: Axes, rewards: LevelRewardsRecord, dt: float) -> None:
    running = np.array(rewards.by_step.running)
    times, means = (1 + np.arange(len(running))) * dt, shown(rewards.by_step.reward)
    for level, values in means.items():
        so_far = np.cumsum(running * values) / running[0]
        axes.plot(times, so_far, color=LEVEL_COLOURS[level], linewidth=LEVEL_WIDTHS[level])
    _label_levels(axes, [*means], "time [s]; episodes that have ended keep theirs", "mean reward so far")


def _label_levels(axes: Axes, levels: list[LevelName], x: str, y: str) -> None:
    fig.legend(axes, [(LEVEL_NAMES[level], LEVEL_COLOURS[level]) for level in levels])
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(visible=True)


def _draw_episode(record: AnalysisRecord) -> Figure:
    return draw_episode(named(record), get_scenario(record.task.scenario), record.episode)


FIGURES: Mapping[str, Callable[[AnalysisRecord], Figure | None]] = {
    "attention-episode": _draw_episode,
    "attention-plane": draw_plane,
    "option-usage": draw_usage,
    "level-rewards": draw_levels,
}
"""What draws each figure; None where the agent has nothing to show there."""
