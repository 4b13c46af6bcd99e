"""The figures of an analysis, by name. Needs the ``report`` extra."""

from collections.abc import Callable, Mapping
from pathlib import Path

from matplotlib.figure import Figure

from hhrl_agents.atomic_files import require_writable, write_atomically
from hhrl_bench.analysis.records import AnalysisRecord, named
from hhrl_bench.figures.episode import draw_episode
from hhrl_bench.figures.levels import draw_levels
from hhrl_bench.figures.option_usage import draw_usage
from hhrl_bench.figures.plane import draw_plane
from hhrl_bench.figures.style import remove, save, style
from hhrl_envs import get_scenario
from hhrl_envs.errors import require


def _draw_episode(record: AnalysisRecord) -> Figure:
    return draw_episode(named(record), get_scenario(record.task.scenario), record.episode)


FIGURES: Mapping[str, Callable[[AnalysisRecord], Figure | None]] = {
    "attention-episode": _draw_episode,
    "attention-plane": draw_plane,
    "option-usage": draw_usage,
    "level-rewards": draw_levels,
}
"""What draws each figure; None where the agent has nothing to show there."""


def save_figures(record: AnalysisRecord, folder: Path) -> list[Path]:
    """Return the files written into the folder: each figure as SVG and PNG; one that is not drawn is taken away.

    Raises:
        OutputError: if one cannot be written.
    """
    written: list[Path] = []
    with style(mathematics=True):
        for name, draw in FIGURES.items():
            figure = draw(record)
            written += remove(folder, name) if figure is None else save(figure, folder, name)
    return written


FILE = "analysis.json"


def require_folder(folder: Path) -> None:
    """Return nothing; raise an ``InputError`` if an analysis could not be drawn or not be written into the folder."""
    require("matplotlib", extra="report")
    require_writable(folder / FILE)


def write(record: AnalysisRecord, folder: Path) -> list[Path]:
    """Return the files written into the folder: the record as JSON, and its figures.

    Equal analyses give equal files, byte for byte.
    """
    path = folder / FILE
    write_atomically(path, record.model_dump_json() + "\n")
    return [path, *save_figures(record, folder)]
