"""The figures of a transfer study show every target and number, and are equal for equal studies."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from hhrl_bench.figures.leaderboard import save_transfer_figures
from hhrl_bench.figures.style import style
from hhrl_bench.figures.transfers import ARM_LINES, draw_transfer_curves, draw_transfer_matrix
from hhrl_bench.transfer.records import TransferRecord
from support.transfers import STEPS, study

HYBRID = [row for row in study().rows if row.method == "hybrid-hrl"]


def curves(rows: list[TransferRecord]) -> Figure:
    with style():
        return draw_transfer_curves(rows)


def matrix(rows: list[TransferRecord]) -> Figure:
    with style():
        return draw_transfer_matrix(rows)


def test_curves_have_a_panel_a_target_with_every_arm_and_the_threshold() -> None:
    rows = [row for row in HYBRID if row.source == "stop-line-v0"]
    figure = curves(rows)
    titles = ["red-light-v0, seeds 0-2,5", "stop-line-wet-v0, seeds 0-2,5", "two-stops-v0, seeds 0-2,5"]
    assert [axes.get_title(loc="left") for axes in figure.axes] == titles
    assert {axes.get_xlabel() for axes in figure.axes} == {"env steps (thousands)"}
    assert figure.axes[0].get_ylabel() == "validation success"
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == [*ARM_LINES, "93%"]
    threshold, *lines = figure.axes[2].get_lines()
    assert threshold.get_ydata() == [0.93, 0.93]
    by_colour = {line.get_color(): line for line in lines}
    for row in rows:
        if row.target == "two-stops-v0":
            line = by_colour[ARM_LINES[row.arm].colour]
            np.testing.assert_allclose(np.asarray(line.get_xdata(), float), np.array(STEPS) / 1000)
            np.testing.assert_allclose(np.asarray(line.get_ydata(), float), np.mean(row.success, axis=0))


def test_many_targets_are_labelled_at_the_lowest_panel_of_each_column() -> None:
    rows = [row for row in HYBRID if (row.source, row.target) == ("stop-line-v0", "two-stops-v0")]
    figure = curves([row.model_copy(update={"target": f"task-{i}"}) for row in rows for i in range(4)])
    labelled = [bool(axes.get_xlabel()) for axes in figure.axes]
    assert labelled == [False, True, True, True, False, False]
    assert [axes.axison for axes in figure.axes] == [True] * 4 + [False] * 2


def test_lines_differ_in_colour() -> None:
    assert len({line.colour for line in ARM_LINES.values()}) == len(ARM_LINES)


def test_the_matrix_writes_every_number_and_a_dash_where_there_is_none() -> None:
    figure = matrix(HYBRID)
    assert len(figure.axes) == 3
    success, frozen, tuned = ([text.get_text() for text in axes.texts] for axes in figure.axes)
    assert success == ["20%", "95%", "50%", "40%", "–", "–"]  # noqa: RUF001
    assert (frozen[:3], tuned[:3]) == (["+0.38", "+0.10", "+0.59"], ["+0.25", "+0.95", "+0.69"])
    assert [text.get_text() for text in figure.axes[0].get_yticklabels()] == ["stop-line-v0", "two-stops-v0"]
    targets = ["red-light-v0", "stop-line-wet-v0", "two-stops-v0"]
    assert [text.get_text() for text in figure.axes[-1].get_xticklabels()] == targets
    assert (figure.axes[0].get_ylabel(), figure.axes[-1].get_xlabel()) == ("source", "target")


def test_the_matrix_has_no_map_of_an_arm_that_is_not_there() -> None:
    figure = matrix([row for row in HYBRID if row.arm in {"scratch", "fine-tune"}])
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["forward transfer, fine-tune"]


def test_equal_studies_give_equal_files(tmp_path: Path) -> None:
    first = {path.name: path.read_bytes() for path in save_transfer_figures(study(), tmp_path)}
    names = ["curves-ddqn-stop-line-v0", "curves-hybrid-hrl-stop-line-v0", "curves-hybrid-hrl-two-stops-v0"]
    names += ["matrix-ddqn", "matrix-hybrid-hrl"]
    assert {*first} == {f"transfer-{name}.{kind}" for name in names for kind in ("svg", "png")}
    again = {path.name: path.read_bytes() for path in save_transfer_figures(study(), tmp_path)}
    assert first == again
