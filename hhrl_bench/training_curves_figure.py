"""The figure of training results: how often each method succeeds on a task as it learns.

Where parts of Hybrid HRL are switched off, as in the paper, a task has a row of two panels: Hybrid HRL beside these
methods, and beside all others.
"""

from collections import Counter
from collections.abc import Sequence
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
_COLUMNS = ("HRL-0 to HRL-3", "other methods")
_ACROSS, _HEIGHT = 2, 1.75


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
