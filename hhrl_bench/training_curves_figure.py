"""The figure of training results: how often each method succeeds on a task as it learns, a row a task.

Hybrid HRL stands in both columns, beside the parts of it that the paper switches off, and beside all other methods.
"""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hhrl_bench.agent_style import lines
from hhrl_bench.curve_style import AT_THRESHOLD, BAND, draw_curves, draw_threshold, legend_below, rate_axes
from hhrl_bench.figures import save, style
from hhrl_bench.panels import new_panels
from hhrl_bench.training_records import TrainingOutcomesRecord

Trainings = Sequence[TrainingOutcomesRecord]

_REFERENCE, _ABLATIONS = "hybrid-hrl", ("hrl-0", "hrl-1", "hrl-2", "hrl-3")
_COLUMNS, _HEIGHT = ("HRL-0 to HRL-3", "other methods"), 1.75


def save_training_curves(trainings: Trainings, folder: Path) -> list[Path]:
    """Return the files written into the folder, SVG and PNG; none where no task has trainings of several methods.

    Raises:
        OutputError: if a file cannot be written.
    """
    if not rivals(trainings):
        return []
    with style():
        return save(draw_training_curves(trainings), folder, "training-results")


def rivals(trainings: Trainings) -> dict[str, Trainings]:
    """Return the trainings of every task on which there are several, by task."""
    by_task = groupby(sorted(trainings, key=lambda one: one.task), key=lambda one: one.task)
    groups = {task: list(group) for task, group in by_task}
    return {task: group for task, group in groups.items() if len(group) > 1}


def draw_training_curves(trainings: Trainings) -> Figure:
    """Return the figure of the tasks on which there are several trainings."""
    tasks = rivals(trainings)
    shown = [one for group in tasks.values() for one in group]
    columns = [column for column in _COLUMNS if any(one.method != _REFERENCE for one in _of(column, shown))]
    headings = [f"{task}: {column}" for task in tasks for column in columns]
    title = f"Training results, {' or '.join(dict.fromkeys(one.runs for one in shown))}"
    x, y = "env steps (thousands)", "validation success"
    figure, panels = new_panels(title, BAND, headings, x, y, len(columns), _HEIGHT)
    cells = [(group, column) for group in tasks.values() for column in columns]
    for axes, (group, column) in zip(panels, cells, strict=True):
        _draw(axes, _of(column, group))
        rate_axes(axes, max(one.env_steps[-1] for one in group))
    legend_below(figure, [*lines([one.method for one in shown]).values(), AT_THRESHOLD])
    return figure


def _of(column: str, trainings: Trainings) -> Trainings:
    ablations = column == _COLUMNS[0]
    return [one for one in trainings if one.method == _REFERENCE or (one.method in _ABLATIONS) == ablations]


def _draw(axes: Axes, trainings: Trainings) -> None:
    draw_threshold(axes)
    by_method = {one.method: one for one in trainings}
    for method, line in lines([*by_method]).items():
        training = by_method[method]
        draw_curves(axes, np.array(training.env_steps, np.float64), training.testing.array("success"), line)
