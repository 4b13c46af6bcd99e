"""The figures of transfers: what a method's policies are worth in other tasks, as a matrix and as curves."""

from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from hhrl_bench.figures.style import (
    AT_THRESHOLD,
    BAND,
    DIVERGING,
    SEQUENTIAL,
    Line,
    Palette,
    draw_curves,
    draw_threshold,
    legend_below,
    new_figure,
    new_panels,
    number_text,
    outline,
    rate_axes,
)
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.text import NONE
from hhrl_bench.transfer.records import TransferRecord
from hhrl_bench.transfer.transfer import ArmName
from hhrl_envs.arrays import Floats


class Map(NamedTuple):
    """A map of one number of one arm: heading, colours and their range, how the number is written."""

    heading: str
    arm: ArmName
    value: Callable[[TransferRecord], float | None]
    colours: str
    norm: Normalize
    written: Callable[[float], str]


def _forward(row: TransferRecord) -> float | None:
    return row.over_scratch.forward_transfer.mean if row.over_scratch else None


def _signed(value: float) -> str:
    return number_text(value, "+z.2f")


MAPS = (
    Map("zero-shot success", "zero-shot", lambda row: row.start.mean, SEQUENTIAL, Normalize(0, 1), "{:.0%}".format),
    Map("forward transfer, frozen-action", "frozen-action", _forward, DIVERGING, Normalize(-1, 1), _signed),
    Map("forward transfer, fine-tune", "fine-tune", _forward, DIVERGING, Normalize(-1, 1), _signed),
)


def draw_transfer_matrix(rows: Sequence[TransferRecord]) -> Figure:
    """Return the figure of the rows of one method: a map for each arm there is; colours end at a transfer of -1."""
    sources, targets = sorted({row.source for row in rows}), sorted({row.target for row in rows})
    maps = [one for one in MAPS if any(row.arm == one.arm for row in rows)]
    size = (max(2.2 + 0.75 * len(targets), 5.0), 2.2 + len(maps) * (0.45 + 0.4 * len(sources)))
    figure = new_figure(*size, f"Transfer of {rows[0].method}", "mean over the seeds")
    axes = figure.subplots(len(maps), 1, sharex=True, squeeze=False)[:, 0]
    for axis, one in zip(axes, maps, strict=True):
        _draw_map(axis, one, _values(one, rows, sources, targets))
        axis.set_yticks(range(len(sources)), sources)
        axis.set_ylabel("source")
    axes[-1].set_xticks(range(len(targets)), targets, rotation=40, ha="right", rotation_mode="anchor")
    axes[-1].set_xlabel("target")
    return figure


def _values(one: Map, rows: Sequence[TransferRecord], sources: list[str], targets: list[str]) -> Floats:
    """Return the numbers of a map [sources, targets], NaN where there is none."""
    values = np.full((len(sources), len(targets)), np.nan)
    for row in rows:
        value = one.value(row) if row.arm == one.arm else None
        if value is not None:
            values[sources.index(row.source), targets.index(row.target)] = value
    return values


def _draw_map(axes: Axes, one: Map, values: Floats) -> None:
    axes.set_facecolor(Palette.PALE)
    image = axes.imshow(values, cmap=one.colours, norm=one.norm, aspect="auto")
    for (y, x), value in np.ndenumerate(values):
        red, green, blue, _ = image.cmap(one.norm(value)) if np.isfinite(value) else (1.0, 1.0, 1.0, 1.0)
        dark = 0.299 * red + 0.587 * green + 0.114 * blue < 0.5
        text = one.written(value) if np.isfinite(value) else NONE
        axes.text(x, y, text, ha="center", va="center", color="white" if dark else Palette.INK)
    axes.set_title(one.heading)
    axes.tick_params(length=0)
    outline(axes)


ARM_LINES: Mapping[ArmName, Line] = {
    "scratch": Line("scratch", Palette.GREY, "-"),
    "zero-shot": Line("zero-shot", Palette.PURPLE, "--"),
    "frozen-action": Line("frozen-action", Palette.ORANGE, "-."),
    "fine-tune": Line("fine-tune", Palette.BLUE, "-"),
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
    legend_below(figure, [*(line for arm, line in ARM_LINES.items() if arm in present), AT_THRESHOLD])
    return figure


def _target(row: TransferRecord) -> str:
    return row.target


def _draw_target(axes: Axes, arms: Sequence[TransferRecord]) -> None:
    draw_threshold(axes)
    by_arm = {row.arm: row for row in arms}
    for arm in (arm for arm in ARM_LINES if arm in by_arm):
        row = by_arm[arm]
        draw_curves(axes, np.array(row.env_steps, np.float64), np.array(row.success), ARM_LINES[arm])
    rate_axes(axes, arms[0].budget)
