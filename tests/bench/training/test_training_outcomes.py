"""How the episodes of a training ended is read from its run directory, kept as a record, printed and drawn."""

import json
from collections.abc import Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from rich.console import Console

from hhrl_bench.errors import CurveError
from hhrl_bench.figures.style import style
from hhrl_bench.figures.training import OUTCOME_LINES, draw_trainings, save_trainings
from hhrl_bench.tables.learning import outcome_tables
from hhrl_bench.tables.terminal import print_tables
from hhrl_bench.text import NONE
from hhrl_bench.training.learning_curves import TRAINING_OUTCOMES, TrainingOutcomesRecord, read_outcomes

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


def test_outcomes_are_shares_by_seed_and_report_and_null_where_there_are_none(tmp_path: Path) -> None:
    read = read_outcomes(run(tmp_path, CURVES))
    assert (read.method, read.task, read.seeds) == ("ddqn", "stop-line-v0", (0, 2, 10))
    assert read.env_steps == (100, 200)
    assert read.training.success == ((0.25, None), (0.25, 0.0), (0.25, None))
    assert read.training.timeout == ((0.0, None), (0.0, 1.0), (0.0, None))
    assert read.testing.success == ((0.5, 0.75), (0.5, None), (0.5, None))
    assert read.runs == "seeds 0,2,10, 2 not to the end"
    for shares in (read.training, read.testing):
        total = np.sum([shares.array(name) for name in TRAINING_OUTCOMES], axis=0)
        np.testing.assert_array_equal(total[np.isfinite(total)], 1.0)


def test_the_outcomes_of_some_seeds_are_those_of_a_run_of_them_alone(tmp_path: Path) -> None:
    alone = read_outcomes(run(tmp_path / "alone", {seed: CURVES[seed] for seed in (0, 2)}))
    assert read_outcomes(run(tmp_path / "all", CURVES), (0, 2)) == alone
    with pytest.raises(CurveError, match=r"cannot read the learning curve .*curve-seed-1\.jsonl: No such file"):
        read_outcomes(tmp_path / "all", (0, 1))


def test_a_record_of_outcomes_is_json_and_read_back_equal(tmp_path: Path) -> None:
    record = read_outcomes(run(tmp_path, CURVES))
    assert TrainingOutcomesRecord.model_validate_json(record.model_dump_json()) == record


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seeds": [2, 0, 10]}, "its seeds ascend"),
        ({"seeds": [0, 2]}, "one share a seed and report"),
        ({"seeds": []}, "at least 1 item"),
        ({"env_steps": [200, 100]}, "its env steps ascend"),
        ({"env_steps": [100]}, "one share a seed and report"),
        ({"testing": {"success": [[0.5, 0.75], [0.5, None], [0.5]]}}, "one share a seed and report"),
        ({"testing": {"success": [[0.5, None], [0.5, None], [0.5, None]]}}, "null together"),
        ({"testing": {"success": [[0.6, 0.75], [0.5, None], [0.5, None]]}}, "add up to at most 1"),
        ({"testing": {"success": [[1.5, 0.75], [0.5, None], [0.5, None]]}}, "less than or equal to 1"),
        ({"testing": {"foiled": []}}, "Extra inputs"),
    ],
)
def test_a_record_that_contradicts_itself_is_refused(tmp_path: Path, change: dict[str, Any], said: str) -> None:
    data = json.loads(read_outcomes(run(tmp_path, CURVES)).model_dump_json())
    for key, value in change.items():
        data[key] = data[key] | value if isinstance(value, dict) else value
    with pytest.raises(ValidationError, match=said):
        TrainingOutcomesRecord.model_validate_json(json.dumps(data))


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
    np.testing.assert_allclose(means[OUTCOME_LINES["success"].colour], [0.5, 0.75])
    looks = {(line.colour, line.dashes) for line in OUTCOME_LINES.values()}
    assert len(looks) == len({*OUTCOME_LINES.values()}) == len(TRAINING_OUTCOMES)


def test_equal_trainings_give_equal_files(tmp_path: Path) -> None:
    trainings = [read_outcomes(run(tmp_path / "run", CURVES))]
    first, again = ([path.read_bytes() for path in save_trainings(trainings, tmp_path)] for _ in range(2))
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
        (
            {0: [FIRST, {"env_steps": 1}]},
            r"line 2 of .*jsonl is no report: episodes: is missing; add it \(and 1 more\)",
        ),
        ({0: [{**FIRST, "validation": {**RATES, "success": 2.0}}]}, "validation.success: write a number less"),
        ({0: [{**FIRST, "validation": {**RATES, "success": 1.0}}]}, "curves in .* are damaged: .* add up to at most 1"),
        ({0: [THEN, FIRST]}, "are damaged: .* its env steps ascend"),
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


def printed(trainings: Sequence[TrainingOutcomesRecord], width: int) -> list[str]:
    out = StringIO()
    print_tables(Console(file=out, width=width), outcome_tables(trainings))
    return out.getvalue().splitlines()


@pytest.mark.parametrize(("width", "outcomes"), [(30, 1), (45, 2), (65, 3), (80, 4), (140, 4)])
def test_the_table_fits_and_shows_as_many_outcomes_as_there_is_room_for(
    tmp_path: Path, width: int, outcomes: int
) -> None:
    one, other = run(tmp_path / "a", CURVES), run(tmp_path / "b", {0: [FIRST, THEN]})
    lines = printed([read_outcomes(one), read_outcomes(other)], width)
    assert max(map(len, lines)) <= width
    text = " ".join(" ".join(lines).split())
    assert "…" not in text
    assert "ddqn on stop-line-v0, seeds 0,2,10, 2 not to the end, 200 env steps" in text
    shown = [name for name in ("success", "collision", "not stop", "timeout") if name in text]
    assert shown == ["success", "collision", "not stop", "timeout"][:outcomes]
    assert ("wider terminal" in text) == (outcomes < 4)


def test_the_table_holds_means_over_seeds_at_the_first_middle_and_last_report_that_has_episodes(
    tmp_path: Path,
) -> None:
    rows = [{**FIRST, "env_steps": step, "episodes": {"success": step, "timeout": 9 - step}} for step in range(10)]
    rows[0]["episodes"] = {}
    rows[4]["validation"] = {**RATES, "success": 0.7, "timeout": 0.05}
    other = [{**rows[0], "validation": {**RATES, "success": 0.2}}]
    lines = printed([read_outcomes(run(tmp_path, {0: rows, 1: rows[:9], 2: other}))], 80)
    cells = {line.split()[0]: line.split()[1:] for line in lines if line.startswith(("start ", "middle ", "end "))}
    assert cells == {
        "start": ["11.1%", "0.0%", "0.0%", "88.9%", "40.0%", "0.0%", "25.0%", "25.0%"],
        "middle": ["55.6%", "0.0%", "0.0%", "44.4%", "70.0%", "0.0%", "25.0%", "5.0%"],
        "end": ["100.0%", "0.0%", "0.0%", "0.0%", "50.0%", "0.0%", "25.0%", "25.0%"],
    }


def test_a_training_without_episodes_has_none_in_the_table(tmp_path: Path) -> None:
    lines = printed([read_outcomes(run(tmp_path, {0: [{**FIRST, "episodes": {}}]}))], 80)
    assert sum(line.split().count(NONE) for line in lines) == 12
