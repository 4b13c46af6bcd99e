"""Transfer records hold what the curves come to, say where nothing can be said, and are made again from the curves."""

import json
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from hhrl_bench.errors import CurveError
from hhrl_bench.statistics.intervals import BOOTSTRAP_SEED
from hhrl_bench.training.learning_curves import Curve, area
from hhrl_bench.transfer.metrics import forward_transfer
from hhrl_bench.transfer.records import TransferRecord, TransferSetRecord
from hhrl_bench.transfer.summary import ArmCurves, TransferCurves, recompute, transfer_rows, transfer_set
from hhrl_bench.transfer.transfer import ARMS, ArmName
from support.transfers import SEEDS, STEPS, arms, study

GRID = (0, 100, 200)
FLAT, RISES, LATE = (0.5, 0.5, 0.5), (0.0, 0.95, 1.0), (0.0, 0.0, 1.0)


def rows_of(**curves: Any) -> dict[str, TransferRecord]:
    arms = {name.replace("_", "-"): ArmCurves((3, 4), GRID, rates) for name, rates in curves.items()}
    rows = transfer_rows("a", "b", "m", arms, np.random.default_rng(0))  # type: ignore[arg-type]
    return {row.arm: row for row in rows}


def test_a_row_holds_the_metrics_of_every_seed_and_their_means() -> None:
    rows = rows_of(fine_tune=(RISES, LATE), scratch=(LATE, LATE))
    row, control = rows["fine-tune"], rows["scratch"]
    assert (row.source, row.target, row.method, row.seeds, row.budget) == ("a", "b", "m", (3, 4), 200)
    assert row.success == (RISES, LATE)
    assert (row.start.per_seed, row.final.per_seed) == ((0.0, 0.0), (1.0, 1.0))
    assert row.area.per_seed == (area(Curve(GRID, RISES)), 0.25)
    assert (row.steps_to_threshold.per_seed, row.steps_to_threshold.median) == ((100, 200), 150.0)
    assert row.over_scratch is not None
    gained = forward_transfer(Curve(GRID, RISES), Curve(GRID, LATE))
    assert gained is not None
    metric = row.over_scratch.forward_transfer
    assert (metric.per_seed, metric.mean, metric.n) == ((gained, 0.0), gained / 2, 2)
    assert (metric.low, metric.high) == (0.0, gained)
    ratio = row.over_scratch.steps_ratio
    assert (ratio.at_least, ratio.at_most, ratio.low, ratio.high) == (0.75, 0.75, 0.5, 1.0)
    assert control.over_scratch is None


def test_censored_and_undefined_seeds_are_null_and_counted() -> None:
    row = rows_of(fine_tune=(RISES, FLAT), scratch=((1.0,) * 3, (0.0,) * 3))["fine-tune"]
    assert (row.steps_to_threshold.per_seed, row.steps_to_threshold.reached) == ((100, None), 1)
    assert row.steps_to_threshold.median is None
    assert row.over_scratch is not None
    ahead, ratio = row.over_scratch.forward_transfer, row.over_scratch.transfer_ratio
    assert (ahead.per_seed, ahead.n, ahead.mean, ahead.low) == ((None, 0.5), 1, 0.5, None)
    assert (ratio.per_seed[1], ratio.n) == (None, 1)
    assert row.over_scratch.steps_ratio.at_most is None


def test_a_metric_that_no_seed_has_is_null() -> None:
    row = rows_of(fine_tune=(RISES, FLAT), scratch=((0.0,) * 3,) * 2)["fine-tune"]
    assert row.over_scratch is not None
    metric = row.over_scratch.transfer_ratio
    assert (metric.per_seed, metric.mean, metric.low, metric.high, metric.n) == ((None, None), None, None, None, 0)


def test_zero_shot_keeps_its_success_over_the_budget() -> None:
    given = arms()
    [row] = [row for row in transfer_rows("a", "b", "m", given, np.random.default_rng(0)) if row.arm == "zero-shot"]
    assert row.env_steps == STEPS
    assert row.success == ((0.5,) * len(STEPS),) * len(SEEDS)
    assert (row.start, row.final) == (row.area, row.area)
    assert (row.steps_to_threshold.reached, row.steps_to_threshold.median) == (0, None)


def test_rows_come_in_the_order_of_the_arms_whatever_that_of_the_curves() -> None:
    forward, given = transfer_rows("a", "b", "m", arms(), np.random.default_rng(0)), arms()
    backward = {arm: given[arm] for arm in reversed(given)}
    assert tuple(row.arm for row in forward) == tuple(ARMS)
    assert transfer_rows("a", "b", "m", backward, np.random.default_rng(0)) == forward


def test_a_study_is_json_and_made_again_from_its_curves() -> None:
    record = study()
    again = TransferSetRecord.model_validate_json(record.model_dump_json())
    assert again == record == recompute(again)
    assert (record.bootstrap_seed, len(record.rows)) == (BOOTSTRAP_SEED, 20)
    reordered = record.model_copy(update={"rows": record.rows[::-1]})
    assert {row.model_dump_json() for row in recompute(reordered).rows} == {
        row.model_dump_json() for row in record.rows
    }


@pytest.mark.parametrize(
    "path",
    [
        ("area", "per_seed", 0),
        ("start", "mean"),
        ("success", 1, 2),
        ("threshold",),
        ("steps_to_threshold", "median"),
        ("over_scratch", "steps_ratio", "low"),
        ("over_scratch", "transfer_ratio", "high"),
    ],
)
def test_a_changed_number_is_not_what_the_curves_come_to(path: tuple[str | int, ...]) -> None:
    data = json.loads(study().model_dump_json())
    place = data["rows"][2]
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = place[path[-1]] * 0.9 + 0.01
    changed = TransferSetRecord.model_validate_json(json.dumps(data))
    assert recompute(changed) != changed


def test_an_interval_of_another_bootstrap_seed_is_another() -> None:
    curves = np.random.default_rng(0).random((15, 3)).tolist()
    control = ArmCurves(tuple(range(15)), GRID, tuple(map(tuple, curves)))
    first, again, other = (
        transfer_set([TransferCurves("a", "b", "m", {"scratch": control})], seed) for seed in (1, 1, 2)
    )
    assert first == again
    assert first.rows[0].area.low != other.rows[0].area.low
    assert first.rows[0].area.mean == other.rows[0].area.mean


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seeds": [1, 0, 2, 5]}, "its seeds ascend"),
        ({"seeds": [0, 1, 2]}, "one success curve a seed"),
        ({"budget": 1}, "its budget is the last"),
        ({"arm": "scratch"}, "all arms but scratch"),
        ({"arm": "zero-shot"}, "zero-shot does not learn"),
        ({"arm": "partly"}, "Input should be 'zero-shot'"),
        ({"env_steps": [0, 1]}, "write one success a step"),
        ({"over_scratch": None}, "all arms but scratch"),
        ({"start": {"per_seed": [0.5], "mean": 0.5, "low": None, "high": None, "n": 1}}, "one value a seed"),
        ({"steps_to_threshold": {"per_seed": [1], "median": 1.0, "reached": 1}}, "one value a seed"),
        ({"success": [[2.0] * 6] * 4}, "less than or equal to 1"),
        ({"more": 1}, "Extra inputs"),
    ],
)
def test_a_record_that_contradicts_itself_is_refused(change: dict[str, Any], said: str) -> None:
    data = json.loads(study().rows[2].model_dump_json())
    assert data["arm"] == "fine-tune"
    with pytest.raises(ValidationError, match=said):
        TransferRecord.model_validate_json(json.dumps(data | change))


@pytest.mark.parametrize(("kept", "said"), [(slice(0, 3), "has no scratch"), ((0, 3, 3), "has scratch twice")])
def test_a_set_has_every_arm_once_and_a_control(kept: Any, said: str) -> None:
    data = json.loads(study().model_dump_json())
    data["rows"] = data["rows"][kept] if isinstance(kept, slice) else [data["rows"][i] for i in kept]
    with pytest.raises(ValidationError, match=said):
        TransferSetRecord.model_validate_json(json.dumps(data))


GOOD = ArmCurves((0, 1), GRID, (RISES, LATE))


@pytest.mark.parametrize(
    ("curves", "said"),
    [
        ({"fine-tune": GOOD}, "m from a on b has the arms fine-tune; write scratch and others of zero-shot, "),
        ({"scratch": GOOD, "tuned": GOOD}, "has the arms scratch, tuned; write"),
        ({"scratch": GOOD, "fine-tune": ArmCurves((0, 2), GRID, (RISES, LATE))}, "train the same seeds"),
        ({"scratch": GOOD, "fine-tune": ArmCurves((0, 1), GRID, (RISES,))}, "2 seeds have 1 curves"),
        ({"scratch": ArmCurves((), GRID, ())}, "0 seeds have 0 curves"),
        ({"scratch": ArmCurves((1, 0), GRID, (RISES, LATE))}, "write ascending ones"),
        ({"scratch": ArmCurves((1,), (0,), ((0.5,),))}, "scratch has a single report"),
        (
            {"scratch": GOOD, "fine-tune": ArmCurves((0, 1), (0, 1, 2), (RISES, LATE))},
            "fine-tune of m from a on b: two",
        ),
        ({"scratch": ArmCurves((0, 1), GRID, (RISES, (0.0, 2.0, 0.0)))}, "write rates of 0 to 1"),
    ],
)
def test_arms_that_cannot_be_compared_are_refused_in_one_line(curves: dict[ArmName, ArmCurves], said: str) -> None:
    with pytest.raises(CurveError, match=said) as refusal:
        transfer_rows("a", "b", "m", curves, np.random.default_rng(0))
    assert "\n" not in str(refusal.value)
