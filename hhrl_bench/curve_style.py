"""How learning curves are drawn: the mean over seeds in its band, over env steps. Needs the ``report`` extra."""

from collections.abc import Iterable
from typing import Literal, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, PercentFormatter

from hhrl_bench.statistics import FloatArray, bootstrap_band
from hhrl_bench.summaries import BOOTSTRAP_SEED

BAND = "band: 95% interval of the mean over the seeds"


class Line(NamedTuple):
    """What a line stands for, and what it looks like; both colour and dashes tell lines apart."""

    name: str
    colour: str
    dashes: Literal["-", "--", "-.", ":"]


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


def legend_below(figure: Figure, lines: Iterable[Line]) -> None:
    """Return nothing; name the lines below all axes."""
    handles = [Line2D([], [], color=line.colour, linestyle=line.dashes, label=line.name) for line in lines]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), handlelength=3.0)
