"""The figure of option usage: shares of the steps by distance to line and front vehicle, and by outcome."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from hhrl_bench.analysis.records import AnalysisRecord, OptionUsageRecord, UsageBinRecord, grouped, named
from hhrl_bench.figures import style as fig
from hhrl_bench.figures.style import OPTION_COLOURS, OPTION_NAMES


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
    fig.legend(axes["many_f"], [(OPTION_NAMES[name], colour) for name, colour in OPTION_COLOURS.items()])
    axes["many_d"].set_ylabel("share of steps")
    axes["share_d"].set_ylabel("share of these steps")
    return figure


def _draw_bins(many: Axes, shares: Axes, bins: Sequence[UsageBinRecord], label: str) -> None:
    bins = _trimmed(bins)
    places, total = np.arange(len(bins)), sum(one.steps for one in bins)
    many.bar(places, [one.steps / total for one in bins], color=fig.GREY, width=0.9)
    bottom = np.zeros(len(bins))
    for name, colour in OPTION_COLOURS.items():
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
    for name, colour in OPTION_COLOURS.items():
        widths = np.array([one.share[name] for one in rows.values()])
        axes.barh(range(len(rows)), widths, left=left, color=colour, height=0.8)
        left += widths
    axes.set_yticks(range(len(rows)), [f"{name} ({one.episodes:,})" for name, one in rows.items()])
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.0)
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.set_xlabel("share of the steps, by the outcome of the episodes (how many)")
