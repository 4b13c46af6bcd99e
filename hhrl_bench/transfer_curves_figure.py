"""The figure of transfer curves: success over env steps, a target a panel, all arms of one method from one source."""

from collections.abc import Mapping, Sequence
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hhrl_bench import figures as fig
from hhrl_bench.arms import ArmName
from hhrl_bench.curve_style import AT_THRESHOLD, BAND, Line, draw_curves, draw_threshold, legend_below, rate_axes
from hhrl_bench.panels import new_panels
from hhrl_bench.seeds import format_seeds
from hhrl_bench.transfer_records import TransferRecord

LINES: Mapping[ArmName, Line] = {
    "scratch": Line("scratch", fig.GREY, "-"),
    "zero-shot": Line("zero-shot", fig.PURPLE, "--"),
    "frozen-action": Line("frozen-action", fig.ORANGE, "-."),
    "fine-tune": Line("fine-tune", fig.BLUE, "-"),
}


def draw_transfer_curves(rows: Sequence[TransferRecord]) -> Figure:
    """Return the figure of the rows of one method and source."""
    targets = {target: list(arms) for target, arms in groupby(sorted(rows, key=_target), key=_target)}
    headings = [f"{target}, seeds {format_seeds(arms[0].seeds)}" for target, arms in targets.items()]
    title = f"{rows[0].method} trained on {rows[0].source}, then on other tasks"
    figure, panels = new_panels(title, BAND, headings, "env steps (thousands)", "validation success")
    for axes, arms in zip(panels, targets.values(), strict=True):
        _draw_target(axes, arms)
    present = {row.arm for row in rows}
    legend_below(figure, [*(line for arm, line in LINES.items() if arm in present), AT_THRESHOLD])
    return figure


def _target(row: TransferRecord) -> str:
    return row.target


def _draw_target(axes: Axes, arms: Sequence[TransferRecord]) -> None:
    draw_threshold(axes)
    by_arm = {row.arm: row for row in arms}
    for arm in (arm for arm in LINES if arm in by_arm):
        row = by_arm[arm]
        draw_curves(axes, np.array(row.env_steps, np.float64), np.array(row.success), LINES[arm])
    rate_axes(axes, arms[0].budget)
