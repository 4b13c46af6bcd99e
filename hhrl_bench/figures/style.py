"""Figures: one style, and files that are equal byte for byte for equal data. Needs the ``report`` extra.

Figures are made without pyplot, so that no window, no backend and no global state is involved.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from enum import StrEnum
from io import BytesIO
from itertools import cycle
from math import ceil
from pathlib import Path
from textwrap import fill
from typing import Any, Literal, NamedTuple
from warnings import catch_warnings, filterwarnings

import matplotlib as mpl
import matplotlib.style
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator, PercentFormatter
from PIL import Image

from hhrl_agents.atomic_files import require_writable, write_atomically
from hhrl_bench.analysis.records import LevelName, TermName
from hhrl_bench.schema import OptionName
from hhrl_bench.statistics.intervals import BOOTSTRAP_SEED, bootstrap_band
from hhrl_bench.text import file_name
from hhrl_bench.training.learning_curves import THRESHOLD
from hhrl_envs import SUB_GOALS
from hhrl_envs.arrays import Floats
from hhrl_envs.observation import SYMBOLS

SEQUENTIAL, DIVERGING = "viridis", "RdBu"


class Palette(StrEnum):
    """Okabe and Ito's palette, distinguishable with every kind of colour vision, and greys."""

    BLUE = "#0072B2"
    SKY = "#56B4E9"
    GREEN = "#009E73"
    YELLOW = "#F0E442"
    ORANGE = "#E69F00"
    VERMILLION = "#D55E00"
    PURPLE = "#CC79A7"
    INK = "#1C222B"
    GREY = "#6B7480"
    PALE = "#D0D5DB"


_STYLE: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": Palette.GREY,
    "axes.grid": False,
    "axes.labelcolor": Palette.INK,
    "axes.labelsize": 9,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10,
    "figure.constrained_layout.use": True,
    "figure.titlesize": 12,
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "grid.color": Palette.PALE,
    "grid.linewidth": 0.6,
    "hatch.linewidth": 0.6,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "savefig.facecolor": "white",
    "svg.hashsalt": "hhrl-bench",
    "text.color": Palette.INK,
    "xtick.color": Palette.GREY,
    "xtick.labelcolor": Palette.INK,
    "ytick.color": Palette.GREY,
    "ytick.labelcolor": Palette.INK,
}
_METADATA = {"svg": {"Date": None, "Creator": None}, "png": {"Software": None}}
_DPI, _LETTERS_PER_INCH, _COLOURS = 144, 9, 256


def style(*, mathematics: bool = False) -> AbstractContextManager[None]:
    """Return the context to draw and save figures in: this style, whatever the user's own settings are.

    Without ``mathematics`` all text is plain, dollar signs too: names of agents and tasks are anybody's.
    """
    return mpl.style.context(["default", _STYLE, {"text.parse_math": mathematics}])


def new_figure(width: float, height: float, title: str, subtitle: str) -> Figure:
    """Return an empty figure of ``width`` x ``height`` inches, to be made within ``style()``.

    The title is plain text, broken where it is too long; the subtitle, a line of its own, may hold mathematics.
    """
    figure = Figure(figsize=(width, height))
    lines = fill(title, round(_LETTERS_PER_INCH * width))
    if mpl.rcParams["text.parse_math"]:
        lines = lines.replace("$", r"\$")
    figure.suptitle(f"{lines}\n{subtitle}", x=0.01, ha="left", weight="bold")
    return figure


def number_text(value: float, digits: str = "g") -> str:
    """Return a number as text, with a true minus sign."""
    return f"{value:{digits}}".replace("-", "\N{MINUS SIGN}")


def save_figure(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Write ``name``.svg and ``name``.png, whole or not at all, into ``folder``, made if need be; return their paths.

    Raises:
        OutputError: if one cannot be written.
    """
    paths = _paths(folder, name)
    require_writable(paths[0])
    for path, content in zip(paths, _pictures(figure), strict=True):
        write_atomically(path, content)
    return paths


def remove_figure(folder: Path, name: str) -> list[Path]:
    """Delete the files of a figure that an earlier call may have saved; return an empty list, as none are left."""
    for path in _paths(folder, name):
        path.unlink(missing_ok=True)
    return []


def legend(axes: Axes, entries: Sequence[tuple[str, str]]) -> None:
    """Put names in their colours above the axes, at the right."""
    patches = [Patch(color=colour, label=name) for name, colour in entries]
    axes.legend(
        handles=patches, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(entries), borderaxespad=0.2,
        handlelength=1.2, columnspacing=1.4,
    )  # fmt: skip


def _pictures(figure: Figure) -> Iterator[bytes]:
    """Yield the content of a file for each of the formats, whatever letters and lengths the names in it have."""
    with catch_warnings():
        filterwarnings("ignore", "Glyph|constrained_layout", UserWarning)
        if (layout := figure.get_layout_engine()) is not None:
            layout.execute(figure)
        figure.set_layout_engine("none")  # what was laid out once need not be laid out for each file
        for suffix, metadata in _METADATA.items():
            out = BytesIO()
            figure.savefig(out, format=suffix, dpi=_DPI, metadata=metadata)
            yield _with_few_colours(out) if suffix == "png" else out.getvalue()


def _with_few_colours(picture: BytesIO) -> bytes:
    """Return a PNG in a third of its bytes: a figure has few colours, and shades of them where lines are smoothed."""
    out = BytesIO()
    with Image.open(picture) as image:
        image.convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE).save(out, "PNG", optimize=True)
    return out.getvalue()


def _paths(folder: Path, name: str) -> list[Path]:
    return [folder / f"{file_name(name)}.{suffix}" for suffix in _METADATA]


Dashes = Literal["-", "--", "-.", ":"]


class Look(NamedTuple):
    """Colour, dashes of the line, and a marker that can be filled."""

    colour: str
    dashes: Dashes
    marker: str


_LOOKS: Mapping[str, Look] = {
    "rule-1": Look(Palette.GREY, "-", "<"),
    "rule-2": Look(Palette.GREY, "--", ">"),
    "rule-3": Look(Palette.GREY, "-.", "v"),
    "rule-4": Look(Palette.GREY, ":", "^"),
    "rule-plus": Look(Palette.INK, ":", "p"),
    "rule-tuned": Look(Palette.INK, "--", "D"),
    "rule-robust": Look(Palette.INK, "-.", "d"),
    "oracle": Look(Palette.YELLOW, ":", "*"),
    "ddqn": Look(Palette.INK, "-", "s"),
    "ddqn-plus": Look(Palette.GREY, "--", "h"),
    "hrl-0": Look(Palette.SKY, ":", "P"),
    "hrl-1": Look(Palette.GREEN, "-.", "8"),
    "hrl-2": Look(Palette.ORANGE, "--", "H"),
    "hrl-3": Look(Palette.PURPLE, "-.", "*"),
    "hybrid-hrl": Look(Palette.BLUE, "-", "o"),
    "hybrid-hrl-plus": Look(Palette.VERMILLION, "-", "D"),
    "pqn": Look(Palette.GREEN, ":", "X"),
    "ppo": Look(Palette.ORANGE, ":", "P"),
}
_UNLIKE: tuple[tuple[Dashes, str], ...] = (("--", "H"), (":", "d"), ("-.", "8"))
_OTHERS = [
    Look(colour, dashes, marker)
    for dashes, marker in _UNLIKE
    for colour in (Palette.BLUE, Palette.VERMILLION, Palette.PURPLE, Palette.SKY)
]


def looks(agents: Sequence[str]) -> dict[str, Look]:
    """Return what each agent looks like; those that are not registered take in turn what is left."""
    others = cycle(_OTHERS)
    return {agent: _LOOKS.get(agent) or next(others) for agent in in_order(agents)}


def in_order(agents: Sequence[str]) -> list[str]:
    """Return the agents, each once: rules, then methods, then the others as they come."""
    known = [agent for agent in _LOOKS if agent in agents]
    return [*known, *(agent for agent in dict.fromkeys(agents) if agent not in _LOOKS)]


class Line(NamedTuple):
    """What a line stands for, and what it looks like; both colour and dashes tell lines apart."""

    name: str
    colour: str
    dashes: Dashes


def lines(agents: Sequence[str]) -> dict[str, Line]:
    """Return the line of each agent."""
    return {agent: Line(agent, look.colour, look.dashes) for agent, look in looks(agents).items()}


SUB_GOAL_NAMES: dict[OptionName, str] = {goal.name: f"{goal.title} ({goal.spelling})" for goal in SUB_GOALS}
"""Of the sub-goals by their words; a legend has room for short ones."""
SUB_GOAL_COLOURS: dict[OptionName, str] = {goal.name: "#{:02X}{:02X}{:02X}".format(*goal.colour) for goal in SUB_GOALS}
LEVEL_NAMES: dict[LevelName, str] = {"option": "$r^{option}$", "action": "$r^{action}$", "task": "$r^{task}$"}
LEVEL_WIDTHS: dict[LevelName, float] = {"option": 3.6, "action": 1.4, "task": 1.6}  # one is seen below the other
LEVEL_COLOURS: dict[LevelName, str] = {"option": Palette.BLUE, "action": Palette.VERMILLION, "task": Palette.GREY}
TERM_NAMES: dict[TermName, str] = {
    "sub_goal": "sub-goal: time, success, timeout",
    "unsafe": "unsafe",
    "failure": "failure",
    "jerk": "jerk",
}
TERM_COLOURS: dict[TermName, str] = {
    "sub_goal": Palette.SKY, "unsafe": Palette.YELLOW, "failure": Palette.VERMILLION, "jerk": Palette.PURPLE
}  # fmt: skip


def label_weights(axes: Axes) -> None:
    """Label the rows of a map of weights with the state elements, the first one on top."""
    axes.set_yticks(range(len(SYMBOLS)), [symbol(i) for i in range(len(SYMBOLS))])
    axes.tick_params(axis="y", length=0)


def symbol(index: int) -> str:
    """Return a state element's symbol as mathematics."""
    parts = [part.split("_") for part in SYMBOLS[index].split("/")]
    return "$" + "/".join(f"{letter}_{{{below}}}" for letter, below in parts) + "$"


def outline(axes: Axes) -> None:
    """Draw all four sides of a map."""
    for side in axes.spines.values():
        side.set_visible(True)


BAND = "band: 95% interval of the mean over the seeds"

_LETTER, _HANDLE = 0.07, 0.65  # inches in a legend


AT_THRESHOLD = Line(f"{THRESHOLD:.0%}", Palette.INK, ":")


def draw_curves(axes: Axes, env_steps: Floats, curves: Floats, line: Line) -> None:
    """Draw the mean of curves [seeds, reports] over env steps, with its 95% band."""
    band, thousands = bootstrap_band(curves, np.random.default_rng(BOOTSTRAP_SEED)), env_steps / 1000
    axes.plot(thousands, band.mean, color=line.colour, linestyle=line.dashes)
    axes.fill_between(thousands, band.low, band.high, color=line.colour, alpha=0.15, linewidth=0)


def rate_axes(axes: Axes, last: float) -> None:
    """Let the axes show rates, from step 0 to ``last``."""
    axes.set_xlim(0.0, last / 1000)
    axes.set_ylim(-0.02, 1.02)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
    axes.grid(visible=True)


def draw_threshold(axes: Axes) -> None:
    """Draw a line at the success rate that a method has to reach."""
    axes.axhline(THRESHOLD, color=AT_THRESHOLD.colour, linestyle=AT_THRESHOLD.dashes, linewidth=1.0)


def legend_below(figure: Figure, lines: Collection[Line]) -> None:
    """Name the lines below all axes."""
    handles = [Line2D([], [], color=line.colour, linestyle=line.dashes, label=line.name) for line in lines]
    name_below(figure, handles)


def name_below(figure: Figure, handles: Collection[Artist]) -> None:
    """Put a legend below all axes, in as many rows of about equal length as it takes."""
    inches = _LETTER * max(len(str(handle.get_label())) for handle in handles) + _HANDLE
    rows = ceil(len(handles) * inches / figure.get_figwidth())
    figure.legend(handles=list(handles), loc="outside lower center", ncols=ceil(len(handles) / rows), handlelength=3.0)


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
