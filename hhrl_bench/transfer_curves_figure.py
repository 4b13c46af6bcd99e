"""The figure of transfer curves: success over env steps, a target a panel, all arms of one method from one source."""

from collections.abc import Mapping, Sequence
from itertools import groupby
from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hhrl_bench import figures as fig
from hhrl_bench.arms import ArmName
from hhrl_bench.curve_style import BAND, Line, draw_curves, legend_below, rate_axes
from hhrl_bench.seeds import format_seeds
from hhrl_bench.transfer_metrics import THRESHOLD
from hhrl_bench.transfer_records import TransferRecord

LINES: Mapping[ArmName, Line] = {
    "scratch": Line("scratch", fig.GREY, "-"),
    "zero-shot": Line("zero-shot", fig.PURPLE, "--"),
    "frozen-action": Line("frozen-action", fig.ORANGE, "-."),
    "fine-tune": Line("fine-tune", fig.BLUE, "-"),
}
_THRESHOLD = Line(f"{THRESHOLD:.0%}", fig.INK, ":")
_COLUMNS = 3


def draw_transfer_curves(rows: Sequence[TransferRecord]) -> Figure:
    """Return the figure of the rows of one method and source."""
    targets = {target: list(arms) for target, arms in groupby(sorted(rows, key=_target), key=_target)}
    columns = min(len(targets), _COLUMNS)
    lines = ceil(len(targets) / columns)
    title = f"{rows[0].method} trained on {rows[0].source}, then on other tasks"
    figure = fig.new_figure(max(1.0 + 3.0 * columns, 6.5), 1.6 + 2.4 * lines, title, BAND)
    axes = figure.subplots(lines, columns, sharey=True, squeeze=False)
    for place, (one, (target, arms)) in enumerate(zip(axes.flat, targets.items(), strict=False)):
        _draw_target(one, arms)
        one.set_title(f"{target}, seeds {format_seeds(arms[0].seeds)}")
        if place + columns >= len(targets):
            one.set_xlabel("env steps (thousands)")
    for one in axes[:, 0]:
        one.set_ylabel("validation success")
    for one in axes.flat[len(targets) :]:
        one.set_axis_off()
    legend_below(figure, [*(line for arm, line in LINES.items() if arm in {row.arm for row in rows}), _THRESHOLD])
    return figure


def _target(row: TransferRecord) -> str:
    return row.target


def _draw_target(axes: Axes, arms: Sequence[TransferRecord]) -> None:
    axes.axhline(THRESHOLD, color=_THRESHOLD.colour, linestyle=_THRESHOLD.dashes, linewidth=1.0)
    by_arm = {row.arm: row for row in arms}
    for arm in (arm for arm in LINES if arm in by_arm):
        row = by_arm[arm]
        draw_curves(axes, np.array(row.env_steps, np.float64), np.array(row.success), LINES[arm])
    rate_axes(axes, arms[0].budget)
