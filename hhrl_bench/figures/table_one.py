"""The figure of Table I: how episodes end for the paper's policies, the paper's cases beside our test episodes."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import PercentFormatter

from hhrl_bench import paper_table
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.records import MetricRecord, ResultRecord, TaskRecord
from hhrl_bench.figures.style import Palette, name_below, new_panels, save_figure, style
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.statistics.intervals import wilson

PANELS = ("success", "collision", "not_stop", "timeout")
"""The keys of the metrics, a panel each."""

_PAPER, _OURS, _WIDTH = Palette.GREY, Palette.BLUE, 0.38

Bar = tuple[float, float, float]
"""A rate and the bounds of its interval."""


def save_table_one(board: LeaderboardRecord, folder: Path) -> list[Path]:
    """Draw the figure of the task that Table I is shown beside into a folder, and return the files, SVG and PNG.

    It needs results of several of the policies there.

    Raises:
        OutputError: if a file cannot be written.
    """
    written: list[Path] = []
    with style():
        for task in board.tasks:
            results = counterparts(board.results, task)
            if task.id == paper_table.TABLE_I_TASK and len(results) > 1:
                written += save_figure(draw_table_one(task, results), folder, f"table-1-{task.id}")
    return written


def counterparts(results: Sequence[ResultRecord], task: TaskRecord) -> dict[str, ResultRecord]:
    """Return our results on a task of the policies in Table I, by the names that it gives them.

    Those that were trained in another world are none: the paper's were trained in their own.
    """
    ours = {
        result.agent: result
        for result in results
        if result.task == task.id
        and result.option is None
        and all(run.training is None or run.training.scenario == task.scenario for run in result.runs)
    }
    return {row.policy: ours[row.counterpart] for row in paper_table.TABLE_I if row.counterpart in ours}


def draw_table_one(task: TaskRecord, results: dict[str, ResultRecord]) -> Figure:
    """Return the figure of our results beside the paper's rows; results by the policy of the paper."""
    rows = [row for row in paper_table.TABLE_I if row.policy in results]
    headings = [METRICS[rate].heading for rate in PANELS]
    title, subtitle = f"Table I and {task.id}", "lines: 95% intervals"
    figure, panels = new_panels(title, subtitle, headings, "", "share of the episodes", 2, 2.0)
    for axes, rate in zip(panels, PANELS, strict=True):
        _draw_bars(axes, -_WIDTH / 2, [_papers(getattr(row, rate)) for row in rows], _PAPER)
        _draw_bars(axes, _WIDTH / 2, [_ours(getattr(results[row.policy].metrics, rate)) for row in rows], _OURS)
        axes.set_xticks(range(len(rows)), [row.policy.replace(" HRL", "\nHRL") for row in rows])
        axes.tick_params(axis="x", length=0)
        axes.set_ylim(0.0, 1.05)
        axes.yaxis.set_major_formatter(PercentFormatter(1.0, decimals=0))
        axes.grid(visible=True, axis="y")
    names = (f"the paper, {paper_table.CASES} cases", f"ours, {task.episodes:,} episodes")
    handles = [Patch(color=colour, label=name) for name, colour in zip(names, (_PAPER, _OURS), strict=True)]
    name_below(figure, handles)
    return figure


def _papers(cases: int) -> Bar:
    estimate = wilson(cases, paper_table.CASES)
    return estimate.mean, estimate.low, estimate.high


def _ours(metric: MetricRecord) -> Bar:
    mean = np.nan if metric.mean is None else metric.mean
    return mean, mean if metric.low is None else metric.low, mean if metric.high is None else metric.high


def _draw_bars(axes: Axes, offset: float, bars: Sequence[Bar], colour: str) -> None:
    mean, low, high = np.array(bars).T
    arms = np.maximum((mean - low, high - mean), 0.0)
    places = np.arange(len(bars)) + offset
    axes.bar(
        places,
        mean,
        _WIDTH,
        color=colour,
        yerr=arms,
        error_kw={"ecolor": Palette.INK, "elinewidth": 1.0, "capsize": 2},
    )
