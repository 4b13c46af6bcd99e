"""The figure of trainings: how their episodes ended, in training and in testing, report by report."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hhrl_bench import figures as fig
from hhrl_bench.curve_style import BAND, Line, draw_curves, legend_below, rate_axes
from hhrl_bench.training_records import TrainingOutcomesRecord

LINES: Mapping[str, Line] = {
    "success": Line("success", fig.GREEN, "-"),
    "timeout": Line("timeout", fig.BLUE, "-."),
    "not_stop": Line("not stop", fig.ORANGE, "--"),
    "collision": Line("collision", fig.VERMILLION, ":"),
}


def save_trainings(trainings: Sequence[TrainingOutcomesRecord], folder: Path) -> list[Path]:
    """Return the files written into the folder, SVG and PNG: the figure of the trainings, from left to right.

    Raises:
        OutputError: if a file cannot be written.
    """
    with fig.style():
        return fig.save(draw_trainings(trainings), folder, "training-outcomes")


def draw_trainings(trainings: Sequence[TrainingOutcomesRecord]) -> Figure:
    """Return the figure: a column a training, the episodes that it learned from above, validation episodes below."""
    columns = len(trainings)
    figure = fig.new_figure(
        max(1.2 + 3.0 * columns, 6.5), 5.6, "How episodes end while an agent learns", f"{BAND}, by report"
    )
    axes = figure.subplots(2, columns, sharex="col", sharey=True, squeeze=False)
    for column, training in zip(axes.T, trainings, strict=True):
        env_steps = np.array(training.env_steps, np.float64)
        for one, shares in zip(column, (training.training, training.testing), strict=True):
            for outcome, line in LINES.items():
                draw_curves(one, env_steps, shares.array(outcome), line)
            rate_axes(one, env_steps[-1])
        column[0].set_title(f"{training.method}\n{training.task}, {training.runs}")
        column[1].set_xlabel("env steps (thousands)")
    axes[0, 0].set_ylabel("training episodes")
    axes[1, 0].set_ylabel("validation episodes")
    legend_below(figure, LINES.values())
    return figure
