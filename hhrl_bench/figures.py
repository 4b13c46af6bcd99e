"""Figures: one style, and files that are equal byte for byte for equal data. Needs the ``report`` extra.

Figures are made without pyplot, so that no window, no backend and no global state is involved.
"""

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from io import BytesIO
from pathlib import Path
from textwrap import fill
from typing import Any
from warnings import catch_warnings, filterwarnings

import matplotlib as mpl
import matplotlib.style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from PIL import Image

from hhrl_agents.files import require_writable, write_atomically
from hhrl_bench.names import file_name

# Okabe and Ito's palette, distinguishable with every kind of colour vision, and greys
BLUE, SKY, GREEN, YELLOW = "#0072B2", "#56B4E9", "#009E73", "#F0E442"
ORANGE, VERMILLION, PURPLE = "#E69F00", "#D55E00", "#CC79A7"
INK, GREY, PALE = "#1C222B", "#6B7480", "#D0D5DB"
SEQUENTIAL, DIVERGING = "viridis", "RdBu"

_STYLE: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": GREY,
    "axes.grid": False,
    "axes.labelcolor": INK,
    "axes.labelsize": 9,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlelocation": "left",
    "axes.titlesize": 10,
    "figure.constrained_layout.use": True,
    "figure.titlesize": 12,
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "grid.color": PALE,
    "grid.linewidth": 0.6,
    "hatch.linewidth": 0.6,
    "legend.fontsize": 9,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "savefig.facecolor": "white",
    "svg.hashsalt": "hhrl-bench",
    "text.color": INK,
    "xtick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.color": GREY,
    "ytick.labelcolor": INK,
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


def number(value: float, digits: str = "g") -> str:
    """Return a number as text, with a true minus sign."""
    return f"{value:{digits}}".replace("-", "\N{MINUS SIGN}")


def save(figure: Figure, folder: Path, name: str) -> list[Path]:
    """Return the files written, whole or not at all: ``name``.svg and ``name``.png in ``folder``, made if need be.

    Raises:
        OutputError: if one cannot be written.
    """
    paths = _paths(folder, name)
    require_writable(paths[0])
    for path, content in zip(paths, _pictures(figure), strict=True):
        write_atomically(path, content)
    return paths


def remove(folder: Path, name: str) -> list[Path]:
    """Return no files, as none are left of the figure ``name`` that an earlier call may have saved in ``folder``."""
    for path in _paths(folder, name):
        path.unlink(missing_ok=True)
    return []


def legend(axes: Axes, entries: Sequence[tuple[str, str]]) -> None:
    """Return nothing; put names in their colours above the axes, at the right."""
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
