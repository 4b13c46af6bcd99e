"""The figure of training results: how often each method succeeds on a task as it learns.

Where parts of Hybrid HRL are switched off, as in the paper, a task has a row of two panels: Hybrid HRL beside these
methods, and beside all others.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hhrl_bench.figures.style import (
    AT_THRESHOLD,
    BAND,
    Line,
    Palette,
    draw_curves,
    draw_threshold,
    legend_below,
    lines,
    new_figure,
    new_panels,
    rate_axes,
    save_figure,
    style,
)
from hhrl_bench.training.learning_curves import TrainingOutcomesRecord

Trainings = Sequence[TrainingOutcomesRecord]

_REFERENCE, _ABLATIONS = "hybrid-hrl", ("hrl-0", "hrl-1", "hrl-2", "hrl-3")
_COLUMNS = ("HRL-0 to HRL-3", "other methods")
_ACROSS, _HEIGHT = 2, 1.75


def save_training_curves(trainings: Trainings, folder: Path) -> list[Path]:
    """Draw the training results into a folder and return the files, SVG and PNG; none if no task has several methods.

    Raises:
        OutputError: if a file cannot be written.
    """
    if not rivals(trainings):
        return []
    with style():
        return save_figure(draw_training_curves(trainings), folder, "training-results")


def rivals(trainings: Trainings) -> dict[str, Trainings]:
    """Return the trainings of every task on which there are several, by task."""
    tasks = dict.fromkeys(one.task for one in trainings)
    groups = {task: [one for one in trainings if one.task == task] for task in tasks}
    return {task: group for task, group in groups.items() if len(group) > 1}


def draw_training_curves(trainings: Trainings) -> Figure:
    """Return the figure of the tasks on which there are several trainings."""
    tasks = rivals(trainings)
    shown = [one for group in tasks.values() for one in group]
    columns = [column for column in _COLUMNS if any(one.method != _REFERENCE for one in _of(column, shown))]
    cells = [(task, column) for task in tasks for column in columns]
    [(usual, _)] = Counter(one.runs for one in shown).most_common(1)
    headings = [
        "\n".join([f"{task}: {column}" if len(columns) > 1 else task, *_apart(_of(column, tasks[task]), usual)])
        for task, column in cells
    ]
    x, y, title = "env steps (thousands)", "validation success", f"Training results, {usual}"
    figure, panels = new_panels(title, BAND, headings, x, y, _ACROSS, _HEIGHT)
    for axes, (task, column) in zip(panels, cells, strict=True):
        _draw(axes, _of(column, tasks[task]))
        rate_axes(axes, max(one.env_steps[-1] for one in tasks[task]))
    legend_below(figure, [*lines([one.method for one in shown]).values(), AT_THRESHOLD])
    return figure


def _apart(trainings: Trainings, usual: str) -> list[str]:
    """Return the methods whose runs are not the usual ones, with theirs."""
    return [f"{one.method}: {one.runs}" for one in trainings if one.runs != usual]


def _of(column: str, trainings: Trainings) -> Trainings:
    ablations = column == _COLUMNS[0]
    return [one for one in trainings if one.method == _REFERENCE or (one.method in _ABLATIONS) == ablations]


def _draw(axes: Axes, trainings: Trainings) -> None:
    draw_threshold(axes)
    by_method = {one.method: one for one in trainings}
    for method, line in lines([*by_method]).items():
        training = by_method[method]
        draw_curves(axes, np.array(training.env_steps, np.float64), training.testing.array("success"), line)


_ABREAST = 3

OUTCOME_LINES: Mapping[str, Line] = {
    "success": Line("success", Palette.GREEN, "-"),
    "timeout": Line("timeout", Palette.BLUE, "-."),
    "not_stop": Line("not stop", Palette.ORANGE, "--"),
    "collision": Line("collision", Palette.VERMILLION, ":"),
}


def save_trainings(trainings: Sequence[TrainingOutcomesRecord], folder: Path) -> list[Path]:
    """Draw how the episodes of trainings end, from left to right, into a folder, and return the files, SVG and PNG.

    Where they are too many for one, every method has its own; trainings on several tasks then have none, as the
    figures would be larger than all else that is published of them.

    Raises:
        OutputError: if a file cannot be written.
    """
    written: list[Path] = []
    with style():
        for name, group in _pages(trainings).items():
            written += save_figure(draw_trainings(group), folder, name)
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
    figure = new_figure(width, 5.6, "How episodes end while an agent learns", f"{BAND}, by report")
    grid = figure.subplots(2, len(trainings), sharey=True, squeeze=False)
    for pair, training in zip(grid.T, trainings, strict=True):
        _draw_training(pair, training)
    for axes, label in zip(grid[:, 0], ("training episodes", "validation episodes"), strict=True):
        axes.set_ylabel(label)
    legend_below(figure, OUTCOME_LINES.values())
    return figure


def _draw_training(pair: Iterable[Axes], training: TrainingOutcomesRecord) -> None:
    above, below = pair
    env_steps = np.array(training.env_steps, np.float64)
    for axes, shares in ((above, training.training), (below, training.testing)):
        for outcome, line in OUTCOME_LINES.items():
            draw_curves(axes, env_steps, shares.array(outcome), line)
        rate_axes(axes, env_steps[-1])
    above.set_title(f"{training.method}\n{training.task}, {training.runs}")
    above.tick_params(labelbottom=False)
    below.set_xlabel("env steps (thousands)")
