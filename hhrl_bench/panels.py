"""Figures of many panels, in rows filled from the left, their axes labelled at the border alone."""

from collections.abc import Sequence
from math import ceil

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hhrl_bench.figures import new_figure

_WIDTH, _NARROWEST = 3.0, 6.5


def new_panels(
    title: str,
    subtitle: str,
    headings: Sequence[str],
    x: str,
    y: str,
    columns: int = 3,
    height: float = 2.4,
    *,
    one_y: bool = True,
) -> tuple[Figure, list[Axes]]:
    """Return a figure and a panel for each heading, to be made within ``style()``.

    Args:
        title: of the figure.
        subtitle: of the figure.
        headings: of the panels.
        x: what all panels have to the right.
        y: what all panels have upwards.
        columns: how many panels stand in a row at most.
        height: of a panel in inches.
        one_y: whether all panels have one range of y.
    """
    count = len(headings)
    across = min(count, columns)
    rows = ceil(count / across)
    figure = new_figure(max(1.0 + _WIDTH * across, _NARROWEST), 1.6 + height * rows, title, subtitle)
    grid = figure.subplots(rows, across, sharey=one_y, squeeze=False)
    panels = list(grid.flat)
    for place, (axes, heading) in enumerate(zip(panels, headings, strict=False)):
        axes.set_title(heading)
        if place + across >= count:
            axes.set_xlabel(x)
    for axes in grid[:, 0]:
        axes.set_ylabel(y)
    for axes in panels[count:]:
        axes.set_axis_off()
    return figure, panels[:count]
