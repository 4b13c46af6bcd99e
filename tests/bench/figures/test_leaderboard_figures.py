"""The figures of a leaderboard: what each shows, which there are, and that equal leaderboards give equal files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.patches import Rectangle

from hhrl_bench.evaluation.store import Store
from hhrl_bench.figures.leaderboard import save_leaderboard_figures
from hhrl_bench.figures.style import lines, style
from hhrl_bench.figures.table_one import PANELS, counterparts, draw_table_one
from hhrl_bench.figures.training import draw_training_curves
from hhrl_bench.leaderboard.entry import write_entry
from hhrl_bench.paper_table import TABLE_I
from hhrl_bench.training.learning_curves import TrainingOutcomesRecord
from support.boards import board, rules
from support.command_line import invoke
from support.trainings import STEPS, training
from support.whole_board import whole_board

LOW, HIGH = (0.0, 0.2, 0.4, 0.6), (0.0, 0.6, 0.9, 1.0)


def trainings(methods: Sequence[str], tasks: Sequence[str] = ("stop-line-v0",)) -> list[TrainingOutcomesRecord]:
    return [training([LOW, HIGH], method, task) for task in tasks for method in methods]


def headings(own: Sequence[TrainingOutcomesRecord]) -> list[str]:
    with style():
        return [axes.get_title(loc="left") for axes in draw_training_curves(own).axes]


def test_training_results_have_a_row_a_task_with_ablations_and_others() -> None:
    tasks = ("stop-line-v0", "stop-line-wet-v0")
    assert headings(trainings(["hrl-0", "hybrid-hrl", "ddqn"], tasks)) == [
        f"{task}: {column}" for task in tasks for column in ("HRL-0 to HRL-3", "other methods")
    ]
    assert headings(trainings(["hybrid-hrl", "ddqn"])) == ["stop-line-v0"]
    assert headings(trainings(["hrl-1", "hrl-0"])) == ["stop-line-v0"]
    assert headings(trainings(["hrl-1", "ddqn"])) == [
        "stop-line-v0: HRL-0 to HRL-3",
        "stop-line-v0: other methods",
    ]


def test_training_results_name_the_seeds_that_did_not_get_to_the_end() -> None:
    failed = training([LOW, (0.0, 0.6, None, None)], "ddqn", "stop-line-wet-v0")
    own = [*trainings(["hybrid-hrl", "ddqn"]), *trainings(["hybrid-hrl", "pqn"], ["stop-line-wet-v0"]), failed]
    assert headings(own) == ["stop-line-v0", "stop-line-wet-v0\nddqn: seeds 0-1, 1 not to the end"]


def test_training_results_are_means_over_seeds_and_hybrid_hrl_is_in_both_columns() -> None:
    own = trainings(["hrl-0", "hybrid-hrl", "ddqn"])
    with style():
        figure = draw_training_curves(own)
    looks = lines([one.method for one in own])
    for axes, methods in zip(figure.axes, (["hrl-0", "hybrid-hrl"], ["ddqn", "hybrid-hrl"]), strict=True):
        threshold, *curves = axes.get_lines()
        assert threshold.get_ydata() == [0.93, 0.93]
        assert {curve.get_color() for curve in curves} == {looks[method].colour for method in methods}
        for curve in curves:
            np.testing.assert_allclose(np.asarray(curve.get_xdata(), float), np.array(STEPS) / 1000)
            np.testing.assert_allclose(np.asarray(curve.get_ydata(), float), [0.0, 0.4, 0.65, 0.8])
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["ddqn", "hrl-0", "hybrid-hrl", "93%"]
    assert figure.get_suptitle().splitlines()[0] == "Training results, seeds 0-1"


def test_table_one_has_the_papers_rates_beside_ours() -> None:
    (task,) = board(rules()).tasks
    results = counterparts(rules(), task)
    assert [*results] == [row.policy for row in TABLE_I]
    with style():
        figure = draw_table_one(task, results)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["success", "collision", "not stop", "timeout"]
    for axes, rate in zip(figure.axes, PANELS, strict=True):
        heights = [bar.get_height() for bar in axes.patches if isinstance(bar, Rectangle)]
        theirs = [getattr(row, rate) / 100 for row in TABLE_I]
        ours = [getattr(results[row.policy].metrics, rate).mean for row in TABLE_I]
        np.testing.assert_allclose(heights, [*theirs, *ours])
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["the paper, 100 cases", "ours, 1,000 episodes"]


STORE = Store(Path("nowhere"))


def names(paths: Sequence[Path]) -> list[str]:
    return sorted(path.stem for path in paths if path.suffix == ".svg")


def test_scores_and_rival_trainings_have_figures(tmp_path: Path) -> None:
    rivals = board(rules(), trainings(["hrl-0", "hybrid-hrl"]))
    written = names(save_leaderboard_figures(rivals, STORE, tmp_path))
    assert written == ["time-and-comfort", "training-outcomes", "training-results"]


def test_table_one_is_drawn_beside_the_task_of_its_world_only(tmp_path: Path) -> None:
    for task, figures in (("stop-line-paper-v0", ["table-1-stop-line-paper-v0"]), ("stop-line-v0", [])):
        results = [one.model_copy(update={"task": task}) for one in rules()]
        assert names(save_leaderboard_figures(board(results), STORE, tmp_path)) == [*figures, "time-and-comfort"]


def test_many_trainings_on_one_task_have_a_figure_a_method(tmp_path: Path) -> None:
    methods = ["hrl-0", "hybrid-hrl", "ddqn", "pqn"]
    for tasks, figures in ((["stop-line-v0"], methods), (["stop-line-v0", "stop-line-wet-v0"], [])):
        written = names(save_leaderboard_figures(board([], trainings(methods, tasks)), STORE, tmp_path))
        assert {name for name in written if "outcomes" in name} == {f"training-outcomes-{name}" for name in figures}


def test_one_agent_without_curves_has_nothing_to_draw(tmp_path: Path) -> None:
    nothing = {"comparisons": (), "trainings": (), "trainings_sha256": (), "efficiency": (), "transfer": None}
    lonely = whole_board().model_copy(update={"results": whole_board().results[:1], **nothing})
    assert save_leaderboard_figures(lonely, STORE, tmp_path / "new") == []
    write_entry(lonely, tmp_path / "a.json")
    said = invoke("figures", str(tmp_path / "a.json"), "--out", str(tmp_path / "new"))
    assert (said.exit_code, "one agent a task and no curves: nothing to draw" in said.stderr) == (2, True)
    assert not (tmp_path / "new").exists()


def test_equal_leaderboards_give_equal_files(tmp_path: Path) -> None:
    own = board(rules(), trainings(["hrl-0", "ddqn"]))
    first, again = ([path.read_bytes() for path in save_leaderboard_figures(own, STORE, tmp_path)] for _ in range(2))
    assert first == again
    assert len(first) == 6
