"""How learning curves are drawn: the mean over seeds in its band, over env steps. Needs the ``report`` extra."""

from collections.abc import Collection
from math import ceil
from typing import Literal, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, PercentFormatter

from hhrl_bench.figures import INK
from hhrl_bench.statistics import FloatArray, bootstrap_band
from hhrl_bench.summaries import BOOTSTRAP_SEED
from hhrl_bench.transfer_metrics import THRESHOLD

BAND = "band: 95% interval of the mean over the seeds"

_LETTER, _HANDLE = 0.07, 0.65  # inches in a legend

Dashes = Literal["-", "--", "-.", ":"]


class Line(NamedTuple):
    """What a line stands for, and what it looks like; both colour and dashes tell lines apart."""

    name: str
    colour: str
    dashes: Dashes


AT_THRESHOLD = Line(f"{THRESHOLD:.0%}", INK, ":")


def draw_curves(axes: Axes, env_steps: FloatArray, curves: FloatArray, line: Line) -> None:
    """Return nothing; draw the mean of curves [seeds, reports] over env steps, with its 95% band."""
    band, thousands = bootstrap_band(curves, np.random.default_rng(BOOTSTRAP_SEED)), env_steps / 1000
    axes.plot(thousands, band.mean, color=line.colour, linestyle=line.dashes)
    axes.fill_between(thousands, band.low, band.high, color=line.colour, alpha=0.15, linewidth=0)


def rate_axes(axes: Axes, last: float) -> None:
    """Return nothing; let the axes show rates, from step 0 to ``last``."""
    axes.set_xlim(0.0, last / 1000)
    axes.set_ylim(-0.02, 1.02)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.grid(visible=True)


def draw_threshold(axes: Axes) -> None:
    """Return nothing; draw a line at the success rate that a method has to reach."""
    axes.axhline(THRESHOLD, color=AT_THRESHOLD.colour, linestyle=AT_THRESHOLD.dashes, linewidth=1.0)


def legend_below(figure: Figure, lines: Collection[Line]) -> None:
    """Return nothing; name the lines below all axes."""
    handles = [Line2D([], [], color=line.colour, linestyle=line.dashes, label=line.name) for line in lines]
    name_below(figure, handles)


def name_below(figure: Figure, handles: Collection[Artist]) -> None:
    """Return nothing; put a legend below all axes, in as many rows of about equal length as it takes."""
    inches = _LETTER * max(len(str(handle.get_label())) for handle in handles) + _HANDLE
    rows = ceil(len(handles) * inches / figure.get_figwidth())
    figure.legend(handles=list(handles), loc="outside lower center", ncols=ceil(len(handles) / rows), handlelength=3.0)
