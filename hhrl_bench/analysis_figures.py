"""The figures of an analysis, by name. Needs the ``report`` extra."""

from collections.abc import Callable, Mapping
from pathlib import Path

from matplotlib.figure import Figure

from hhrl_bench.analysis_episode_figure import draw_episode
from hhrl_bench.analysis_levels_figure import draw_levels
from hhrl_bench.analysis_plane_figure import draw_plane
from hhrl_bench.analysis_records import AnalysisRecord, named
from hhrl_bench.analysis_usage_figure import draw_usage
from hhrl_bench.figures import remove, save, style
from hhrl_envs import get_scenario


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
