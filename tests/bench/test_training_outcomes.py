"""How the episodes of a training ended is read from its run directory, and drawn."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hhrl_bench.errors import CurveError
from hhrl_bench.figures import style
from hhrl_bench.training_outcomes import OUTCOMES, read_outcomes
from hhrl_bench.training_outcomes_figure import LINES, draw_trainings, save_trainings

RATES = {"success": 0.5, "timeout": 0.25, "not_stop": 0.25, "collision": 0.0}
FIRST = {"env_steps": 100, "losses": {}, "episodes": {"success": 1, "collision": 3}, "validation": RATES}
THEN = {"env_steps": 200, "losses": {}, "episodes": {}, "validation": {**RATES, "success": 0.75, "timeout": 0.0}}
FAILED = {"env_steps": 200, "episodes": {"timeout": 2}, "validation": None, "failed": "its loss is not finite"}
CURVES = {0: [FIRST, THEN], 2: [FIRST, FAILED], 10: [FIRST]}


def run(folder: Path, curves: Mapping[int, Sequence[Mapping[str, Any]]]) -> Path:
    """Return a run directory with these curves."""
    folder.mkdir(exist_ok=True)
    (folder / "config.json").write_text(json.dumps({"method": {"id": "ddqn"}, "task": "stop-line-v0"}))
    for seed, rows in curves.items():
        (folder / f"curve-seed-{seed}.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    return folder


def test_outcomes_are_shares_by_seed_and_report_and_nan_where_there_are_none(tmp_path: Path) -> None:
    read, nan = read_outcomes(run(tmp_path, CURVES)), np.nan
    assert (read.method, read.task, read.seeds) == ("ddqn", "stop-line-v0", (0, 2, 10))
    assert read.env_steps.tolist() == [100.0, 200.0]
    np.testing.assert_array_equal(read.training["success"], [[0.25, nan], [0.25, 0.0], [0.25, nan]])
    np.testing.assert_array_equal(read.training["timeout"], [[0.0, nan], [0.0, 1.0], [0.0, nan]])
    np.testing.assert_array_equal(read.testing["success"], [[0.5, 0.75], [0.5, nan], [0.5, nan]])
    assert read.stopped == 2
    for shares in (read.training, read.testing):
        total = np.sum([shares[name] for name in OUTCOMES], axis=0)
        np.testing.assert_array_equal(total[np.isfinite(total)], 1.0)


def test_the_figure_has_a_column_a_training_and_names_every_line(tmp_path: Path) -> None:
    one, other = run(tmp_path / "a", CURVES), run(tmp_path / "b", {0: [FIRST, THEN]})
    with style():
        figure = draw_trainings([read_outcomes(one), read_outcomes(other)])
    above, below = figure.axes[:2], figure.axes[2:]
    assert [axes.get_title(loc="left").split("\n")[1] for axes in above] == [
        "stop-line-v0, seeds 0,2,10, 2 not to the end",
        "stop-line-v0, seeds 0",
    ]
    assert {axes.get_xlabel() for axes in below} == {"env steps (thousands)"}
    assert (above[0].get_ylabel(), below[0].get_ylabel()) == ("training episodes", "validation episodes")
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["success", "timeout", "not stop", "collision"]
    means = {str(line.get_color()): np.asarray(line.get_ydata(), float) for line in below[0].get_lines()}
    np.testing.assert_allclose(means[LINES["success"].colour], [0.5, 0.75])
    assert len({(line.colour, line.dashes) for line in LINES.values()}) == len({*LINES.values()}) == len(OUTCOMES)


def test_equal_trainings_give_equal_files(tmp_path: Path) -> None:
    runs = [run(tmp_path / "run", CURVES)]
    first, again = ([path.read_bytes() for path in save_trainings(runs, tmp_path)] for _ in range(2))
    assert first == again
    assert {path.name for path in tmp_path.glob("training*")} == {
        f"training-outcomes.{kind}" for kind in ("svg", "png")
    }


@pytest.mark.parametrize(
    ("curves", "said"),
    [
        ({}, "holds no learning curves"),
        ({0: []}, "holds no learning curves"),
        ({0: [FIRST, THEN], 1: [THEN]}, "the reports of seed 1 in .* at other env steps"),
        ({0: [FIRST, {"env_steps": 1}]}, r"line 2 of .*jsonl is no report: episodes: Field required \(and 1 more\)"),
        ({0: [{**FIRST, "validation": {**RATES, "success": 2.0}}]}, "validation.success: Input should be less"),
    ],
)
def test_curves_that_cannot_be_read_are_refused_in_one_line(tmp_path: Path, curves: Any, said: str) -> None:
    with pytest.raises(CurveError, match=said) as refusal:
        read_outcomes(run(tmp_path, curves))
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("config", [None, "{", "[]", '{"method": "x"}'])
def test_a_folder_that_is_no_run_is_refused(tmp_path: Path, config: str | None) -> None:
    if config is not None:
        (tmp_path / "config.json").write_text(config)
    with pytest.raises(CurveError, match=r"has no config\.json to read"):
        read_outcomes(tmp_path)
