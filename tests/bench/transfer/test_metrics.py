"""What transfer is worth, on curves whose answers are known, and at the edges where there is none."""

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hhrl_bench.errors import CurveError
from hhrl_bench.training.learning_curves import THRESHOLD, Curve, area, time_to_threshold
from hhrl_bench.transfer.metrics import asymptotic_gain, forward_transfer, jumpstart, transfer_ratio

STEPS = (0, 100, 300, 400)
AHEAD = Curve(STEPS, (0.5, 0.75, 1.0, 1.0))
BASE = Curve(STEPS, (0.0, 0.25, 0.5, 1.0))
NEVER, ALWAYS = Curve(STEPS, (0.0,) * 4), Curve(STEPS, (1.0,) * 4)

rates = st.floats(0.0, 1.0)


@st.composite
def pairs(draw: st.DrawFn) -> tuple[Curve, Curve]:
    gaps = draw(st.lists(st.integers(1, 10**6), max_size=8))
    steps = tuple(sum(gaps[:i]) for i in range(len(gaps) + 1))
    a, b = (draw(st.lists(rates, min_size=len(steps), max_size=len(steps))) for _ in range(2))
    return Curve(steps, tuple(a)), Curve(steps, tuple(b))


def test_metrics_of_two_curves_are_those_done_by_hand() -> None:
    assert jumpstart(AHEAD, BASE) == 0.5
    assert asymptotic_gain(AHEAD, BASE) == 0.0
    assert asymptotic_gain(NEVER, BASE) == -1.0
    assert (time_to_threshold(AHEAD), time_to_threshold(BASE)) == (300, 400)
    assert area(AHEAD) == (62.5 + 175.0 + 100.0) / 400
    assert area(BASE) == (12.5 + 75.0 + 75.0) / 400
    assert transfer_ratio(AHEAD, BASE) == pytest.approx(175.0 / 162.5)
    assert forward_transfer(AHEAD, BASE) == pytest.approx(175.0 / 237.5)


def test_time_to_threshold_is_the_first_report_at_or_above_it() -> None:
    assert time_to_threshold(Curve(STEPS, (0.0, THRESHOLD, 0.1, 1.0))) == 100
    assert time_to_threshold(ALWAYS) == 0
    assert time_to_threshold(Curve(STEPS, (0.9299,) * 4)) is None


def test_what_cannot_be_said_is_none() -> None:
    assert transfer_ratio(AHEAD, NEVER) is None
    assert forward_transfer(AHEAD, NEVER) == area(AHEAD)
    assert forward_transfer(AHEAD, ALWAYS) is None
    assert transfer_ratio(AHEAD, ALWAYS) == area(AHEAD) - 1.0


def test_a_single_report_is_a_flat_curve() -> None:
    a, b = Curve((0,), (0.75,)), Curve((0,), (0.5,))
    assert (area(a), jumpstart(a, b), asymptotic_gain(a, b)) == (0.75, 0.25, 0.25)
    assert (transfer_ratio(a, b), forward_transfer(a, b)) == (0.5, 0.5)
    assert time_to_threshold(a) is None


@given(pairs())
def test_a_curve_is_worth_nothing_over_itself(pair: tuple[Curve, Curve]) -> None:
    a, _ = pair
    assert jumpstart(a, a) == asymptotic_gain(a, a) == 0.0
    assert transfer_ratio(a, a) in (0.0, None)
    assert forward_transfer(a, a) in (0.0, None)


@given(pairs())
def test_areas_lie_within_the_curve_and_say_which_is_ahead(pair: tuple[Curve, Curve]) -> None:
    a, b = pair
    assert min(a.success) - 1e-12 <= area(a) <= min(max(a.success) + 1e-12, 1.0)
    for worth in (transfer_ratio(a, b), forward_transfer(a, b)):
        assert worth is None or (worth > 0.0) <= (area(a) > area(b))
    assert (forward_transfer(a, b) or 0.0) <= 1.0


@given(pairs())
def test_the_threshold_is_reached_there_and_not_before(pair: tuple[Curve, Curve]) -> None:
    curve, _ = pair
    reached = time_to_threshold(curve)
    before = [rate for steps, rate in zip(curve.env_steps, curve.success, strict=True) if steps < (reached or inf)]
    assert reached == 0 or max(before) < THRESHOLD
    assert reached is None or curve.success[curve.env_steps.index(reached)] >= THRESHOLD


@pytest.mark.parametrize(
    ("steps", "success", "said"),
    [
        ((), (), "has 0 steps and 0 successes"),
        ((0, 1), (0.5,), "has 2 steps and 1 successes"),
        ((0, 2, 2), (0.0, 0.0, 0.0), "0, 2, 2; write ascending ones that begin with 0"),
        ((0, 2, 1), (0.0, 0.0, 0.0), "0, 2, 1; write ascending"),
        ((5, 10), (0.0, 0.0), "begin with 0"),
        ((0, 1), (0.0, 1.01), "0, 1.01; write rates of 0 to 1"),
        ((0, 1), (-0.1, 1.0), "write rates"),
        ((0, 1), (0.0, nan), "0, nan; write rates"),
    ],
)
def test_what_is_no_curve_is_refused_in_one_line(steps: tuple[int, ...], success: tuple[float, ...], said: str) -> None:
    with pytest.raises(CurveError, match=said) as refusal:
        Curve(steps, success)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("metric", [jumpstart, asymptotic_gain, transfer_ratio, forward_transfer])
def test_curves_with_other_reports_are_not_compared(metric: object) -> None:
    other = Curve((0, 1, 2, 3, 4, 5, 6, 7), (0.0,) * 8)
    with pytest.raises(CurveError, match=r"at 0, 100, 300, 400 and 0, 1, 2, 3, \.\.\., 7 env steps"):
        metric(BASE, other)  # type: ignore[operator]
