"""The figure of trainings: how their episodes ended, in training and in testing, report by report."""

from collections.abc import Iterable, Mapping, Sequence
from math import ceil
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hhrl_bench import figures as fig
from hhrl_bench.curve_style import BAND, Line, draw_curves, legend_below, rate_axes
from hhrl_bench.training_records import TrainingOutcomesRecord

_ABREAST = 3

LINES: Mapping[str, Line] = {
    "success": Line("success", fig.GREEN, "-"),
    "timeout": Line("timeout", fig.BLUE, "-."),
    "not_stop": Line("not stop", fig.ORANGE, "--"),
    "collision": Line("collision", fig.VERMILLION, ":"),
}


def save_trainings(trainings: Sequence[TrainingOutcomesRecord], folder: Path) -> list[Path]:
    """Return the files written into the folder, SVG and PNG: the figure of the trainings, from left to right.

    Where they are too many for one, every method has its own.

    Raises:
        OutputError: if a file cannot be written.
    """
    written: list[Path] = []
    with fig.style():
        for name, group in _pages(trainings).items():
            written += fig.save(draw_trainings(group), folder, name)
    return written


def _pages(trainings: Sequence[TrainingOutcomesRecord]) -> dict[str, Sequence[TrainingOutcomesRecord]]:
    """Return the trainings of every figure, by its name."""
    if len(trainings) <= _ABREAST:
        return {"training-outcomes": trainings}
    methods = dict.fromkeys(one.method for one in trainings)
    return {f"training-outcomes-{method}": [one for one in trainings if one.method == method] for method in methods}


def draw_trainings(trainings: Sequence[TrainingOutcomesRecord]) -> Figure:
    """Return the figure: a column a training, the episodes that it learned from above, validation episodes below.

    More than three trainings stand in several such rows.
    """
    rows, columns = ceil(len(trainings) / _ABREAST), min(len(trainings), _ABREAST)
    size = (max(1.2 + 3.0 * columns, 6.5), 0.8 + 4.8 * rows)
    figure = fig.new_figure(*size, "How episodes end while an agent learns", f"{BAND}, by report")
    grid = figure.subplots(2 * rows, columns, sharey=True, squeeze=False)
    pairs = [pair for row in range(rows) for pair in grid[2 * row : 2 * row + 2].T]
    for pair, training in zip(pairs, trainings, strict=False):
        _draw_training(pair, training)
    for axes in (axes for pair in pairs[len(trainings) :] for axes in pair):
        axes.set_axis_off()
    for place, axes in enumerate(grid[:, 0]):
        axes.set_ylabel(("training episodes", "validation episodes")[place % 2])
    legend_below(figure, LINES.values())
    return figure


def _draw_training(pair: Iterable[Axes], training: TrainingOutcomesRecord) -> None:
    above, below = pair
    env_steps = np.array(training.env_steps, np.float64)
    for axes, shares in ((above, training.training), (below, training.testing)):
        for outcome, line in LINES.items():
            draw_curves(axes, env_steps, shares.array(outcome), line)
        rate_axes(axes, env_steps[-1])
    above.set_title(f"{training.method}\n{training.task}, {training.runs}")
    above.tick_params(labelbottom=False)
    below.set_xlabel("env steps (thousands)")
