"""The figure of trainings: how their episodes ended, in training and in testing, report by report."""

from collections.abc import Iterable, Mapping, Sequence
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

    Where they are too many for one, every method has its own; trainings on several tasks then have none, as the
    figures would be larger than all else that is published of them.

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
    if len({one.task for one in trainings}) > 1:
        return {}
    return {f"training-outcomes-{one.method}": [one] for one in trainings}


def draw_trainings(trainings: Sequence[TrainingOutcomesRecord]) -> Figure:
    """Return the figure: a column a training, the episodes that it learned from above, validation episodes below."""
    width = max(1.2 + 3.0 * len(trainings), 6.5)
    figure = fig.new_figure(width, 5.6, "How episodes end while an agent learns", f"{BAND}, by report")
    grid = figure.subplots(2, len(trainings), sharey=True, squeeze=False)
    for pair, training in zip(grid.T, trainings, strict=True):
        _draw_training(pair, training)
    for axes, label in zip(grid[:, 0], ("training episodes", "validation episodes"), strict=True):
        axes.set_ylabel(label)
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
