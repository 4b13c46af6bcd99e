"""The figure of the (d_f, d_d) plane: greedy option and action, and the attention for every option."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize
from matplotlib.figure import Figure, SubFigure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from hhrl_bench.analysis.records import AnalysisRecord, PlaneRecord, named
from hhrl_bench.evaluation.guarded_agent import OPTIONS
from hhrl_bench.figures import style as fig
from hhrl_bench.figures.style import SUB_GOAL_COLOURS, SUB_GOAL_NAMES, outline, symbol
from hhrl_envs import SUB_GOALS, get_scenario
from hhrl_envs.arrays import Floats
from hhrl_envs.observation import SIZE

_COLUMNS = 6
_TALL = 3.7  # inches; a row of maps


def draw_plane(record: AnalysisRecord) -> Figure:
    """Return the figure; without options or attention their maps are left out.

    The attention is drawn for the first option, then how much each other option changes it: that is little, and
    would not be seen side by side.
    """
    plane = record.plane
    weights = {name: np.array([*grids.values()]) for name, grids in (plane.attention or {}).items()}
    speeds = f"$v_e$ = {plane.v_e:g} m/s, $v_f$ = {plane.v_f:g} m/s, no accelerations"
    width = 11.0 if plane.option else 6.5
    figure = fig.new_figure(width, 0.5 + _TALL * (1 + len(weights)), named(record), speeds)
    parts = figure.subfigures(1 + len(weights), 1, squeeze=False)[:, 0]
    _draw_policy(parts[0], record)
    base: Floats | None = None
    for part, (name, grids) in zip(parts[1:], weights.items(), strict=True):
        if base is None:
            base = grids
            part.suptitle(f"Attention $I(s, o)$, given the option to {SUB_GOAL_NAMES[name]}", x=0.01, ha="left")
            _draw_attention(part, plane, grids, Normalize(0.0, grids.max()), fig.SEQUENTIAL, "weight")
        else:
            part.suptitle(f"Change of the attention if the option is to {SUB_GOAL_NAMES[name]}", x=0.01, ha="left")
            most = float(np.abs(grids - base).max()) or 1.0
            _draw_attention(part, plane, grids - base, Normalize(-most, most), fig.DIVERGING, "change of weight")
    return figure


def _draw_policy(part: SubFigure, record: AnalysisRecord) -> None:
    plane = record.plane
    axes = part.subplots(1, 2 if plane.option else 1, squeeze=False)[0]
    if plane.option:
        codes = np.array([[OPTIONS[name] for name in row] for row in plane.option])
        edges = (np.arange(len(SUB_GOALS) + 1) - 0.5).tolist()
        norm = BoundaryNorm(edges, len(SUB_GOALS))
        _map(axes[0], plane, codes, ListedColormap([*SUB_GOAL_COLOURS.values()]), norm)
        axes[0].set_title("selected option")
        fig.legend(axes[0], [(goal.spelling, SUB_GOAL_COLOURS[goal.name]) for goal in SUB_GOALS])
    edges = (np.arange(len(record.levels) + 1) - 0.5).tolist()
    image = _map(axes[-1], plane, np.array(plane.action), "RdYlBu", BoundaryNorm(edges, 256))
    axes[-1].set_title("selected action")
    bar = part.colorbar(image, ax=axes[-1], ticks=range(len(record.levels)), label="target acceleration [m/s$^2$]")
    bar.ax.set_yticklabels([fig.number_text(level) for level in record.levels])
    for one in axes:
        line = _mark_line(one, plane, get_scenario(record.task.scenario).vehicle.length)
        one.set_xlabel("$d_f$, to the front vehicle [m]")
        one.set_ylabel("$d_d$, to the stop-line [m]")
    axes[-1].legend(handles=[line], loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)


def _mark_line(axes: Axes, plane: PlaneRecord, length: float) -> Line2D:
    """Return the line drawn where the front vehicle's front bumper is at the stop-line; below, it has passed it."""
    [line] = axes.plot(plane.d_f, np.array(plane.d_f) + length, color=fig.Palette.INK, linewidth=1.0, linestyle="--")
    axes.set_ylim(plane.d_d[0], plane.d_d[-1])
    line.set_label("front vehicle at the line")
    return line


def _draw_attention(
    part: SubFigure, plane: PlaneRecord, grids: Floats, norm: Normalize, colours: str, label: str
) -> None:
    axes = part.subplots(2, _COLUMNS, sharex=True, sharey=True)
    for index, one in enumerate(axes.flat[:SIZE]):
        _map(one, plane, grids[index], colours, norm)
        one.set_title(symbol(index))
    for one in axes.flat[SIZE:]:
        one.set_axis_off()
    part.colorbar(ScalarMappable(norm, colours), ax=axes, label=label, pad=0.01)
    part.supxlabel("$d_f$ [m]", size=9)
    part.supylabel("$d_d$ [m]", size=9)


def _map(
    axes: Axes, plane: PlaneRecord, values: NDArray[Any], colours: str | ListedColormap, norm: Normalize
) -> AxesImage:
    """Return the image of values [d_d, d_f], drawn over axes in metres."""
    x, y = ((axis[1] - axis[0]) / 2 for axis in (plane.d_f, plane.d_d))
    extent = (plane.d_f[0] - x, plane.d_f[-1] + x, plane.d_d[0] - y, plane.d_d[-1] + y)
    outline(axes)
    return axes.imshow(
        values, cmap=colours, norm=norm, origin="lower", aspect="auto", interpolation="nearest", extent=extent
    )
