"""Transfer records made of success curves, and made again from the curves that a record holds."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hhrl_bench.errors import CurveError
from hhrl_bench.schema import SCHEMA_VERSION
from hhrl_bench.statistics.censored_times import ratio_of_medians
from hhrl_bench.statistics.intervals import BOOTSTRAP_SEED, CONFIDENCE, bootstrap_mean
from hhrl_bench.training.learning_curves import THRESHOLD, Curve, area, read_outcomes, time_to_threshold
from hhrl_bench.transfer.metrics import asymptotic_gain, forward_transfer, jumpstart, transfer_ratio
from hhrl_bench.transfer.records import (
    ArmGroup,
    ComparisonRecord,
    SeedsMetricRecord,
    StepsRatioRecord,
    StepsRecord,
    TransferRecord,
    TransferSetRecord,
)
from hhrl_bench.transfer.transfer import ARMS, CONTROL, ArmName, Transfer, sensible_arms
from hhrl_envs.arrays import Floats


@dataclass(frozen=True, slots=True)
class ArmCurves:
    """The success rates [seeds, reports] of one arm at ``env_steps`` [reports].

    Zero-shot may have a single report, at step 0: it does not learn.
    """

    seeds: tuple[int, ...]
    env_steps: tuple[int, ...]
    success: tuple[tuple[float, ...], ...]

    def curves(self) -> list[Curve]:
        """Return the curve of every seed.

        Raises:
            CurveError: if they are not one a seed, the seeds do not ascend, or a curve is none.
        """
        if list(self.seeds) != sorted(set(self.seeds)):
            raise CurveError(f"its seeds are {self.seeds}; write ascending ones, each once")
        if not 1 <= len(self.seeds) == len(self.success):
            raise CurveError(
                f"{len(self.seeds)} seeds have {len(self.success)} curves; write one each, for one or more"
            )
        return [Curve(self.env_steps, tuple(rates)) for rates in self.success]


class TransferCurves(NamedTuple):
    """The arms of one method from one source task on one target task."""

    source: str
    target: str
    method: str
    curves: Mapping[ArmName, ArmCurves]


def transfer_set(transfers: Iterable[TransferCurves], bootstrap_seed: int = BOOTSTRAP_SEED) -> TransferSetRecord:
    """Return the record of a study; its errors are those of :func:`transfer_rows`."""
    groups = [transfer_rows(*transfer, np.random.default_rng(bootstrap_seed)) for transfer in transfers]
    return TransferSetRecord(
        schema_version=SCHEMA_VERSION,
        confidence=CONFIDENCE,
        bootstrap_seed=bootstrap_seed,
        rows=tuple(row for rows in groups for row in rows),
    )


def recompute(record: TransferSetRecord) -> TransferSetRecord:
    """Return what the stored curves and bootstrap seed come to: an equal record, if no number of it was changed."""
    groups: dict[ArmGroup, dict[ArmName, ArmCurves]] = {}
    for row in record.rows:
        arms = groups.setdefault(row.group, {})
        arms[row.arm] = ArmCurves(row.seeds, row.env_steps, row.success)
    transfers = (TransferCurves(group.source, group.target, group.method, arms) for group, arms in groups.items())
    return transfer_set(transfers, record.bootstrap_seed)


def transfer_rows(
    source: str, target: str, method: str, curves: Mapping[ArmName, ArmCurves], rng: np.random.Generator
) -> tuple[TransferRecord, ...]:
    """Return the record of every arm there is, in the order of ARMS.

    Raises:
        CurveError: if an arm is unknown, scratch is missing, seeds or reports differ between arms, or curves are none.
    """
    group = ArmGroup(method, source, target)
    if CONTROL not in curves or set(curves) - set(ARMS):
        raise CurveError(f"{group} has the arms {', '.join(curves)}; write {CONTROL} and others of {', '.join(ARMS)}")
    rows = []
    for arm in (arm for arm in ARMS if arm in curves):
        try:
            rows.append(_row(group, arm, curves[arm], curves[CONTROL], rng))
        except CurveError as error:
            raise CurveError(f"{arm} of {group}: {error}") from error
    return tuple(rows)


def _row(group: ArmGroup, arm: ArmName, own: ArmCurves, control: ArmCurves, rng: np.random.Generator) -> TransferRecord:
    b = control.curves()
    if len(control.env_steps) < 2:
        raise CurveError(f"{CONTROL} has a single report; train it for a budget")
    a = [_drawn_out(curve, control.env_steps) if arm == "zero-shot" else curve for curve in own.curves()]
    if own.seeds != control.seeds:
        raise CurveError(f"its seeds are {own.seeds}, those of {CONTROL} {control.seeds}; train the same seeds")
    return TransferRecord(
        **group._asdict(),
        arm=arm,
        seeds=own.seeds,
        budget=control.env_steps[-1],
        threshold=THRESHOLD,
        env_steps=a[0].env_steps,
        success=tuple(curve.success for curve in a),
        start=summary([curve.success[0] for curve in a], rng),
        final=summary([curve.success[-1] for curve in a], rng),
        area=summary([area(curve) for curve in a], rng),
        steps_to_threshold=steps_to_threshold(a),
        over_scratch=None if arm == CONTROL else comparison(a, b, rng),
    )


def _drawn_out(curve: Curve, env_steps: tuple[int, ...]) -> Curve:
    """Return a curve of a single report drawn out over ``env_steps``; another one is returned as it is."""
    return Curve(env_steps, curve.success * len(env_steps)) if len(curve.success) == 1 else curve


def comparison(a: Sequence[Curve], b: Sequence[Curve], rng: np.random.Generator) -> ComparisonRecord:
    """Return what the curves ``a`` are worth over the curves ``b``, seed by seed."""
    pairs = list(zip(a, b, strict=True))
    return ComparisonRecord(
        jumpstart=summary([jumpstart(*pair) for pair in pairs], rng),
        asymptotic_gain=summary([asymptotic_gain(*pair) for pair in pairs], rng),
        transfer_ratio=summary([transfer_ratio(*pair) for pair in pairs], rng),
        forward_transfer=summary([forward_transfer(*pair) for pair in pairs], rng),
        steps_ratio=_steps_ratio(a, b, rng),
    )


def summary(values: Sequence[float | None], rng: np.random.Generator) -> SeedsMetricRecord:
    """Return the values of all seeds, and the mean of those that are defined with its bootstrap interval."""
    defined = np.array([value for value in values if value is not None])
    if not defined.size:
        return SeedsMetricRecord(per_seed=tuple(values), mean=None, low=None, high=None, n=0)
    mean, low, high, _, n, _ = bootstrap_mean(defined, rng, "bootstrap-seeds")
    return SeedsMetricRecord(per_seed=tuple(values), mean=mean, low=_finite(low), high=_finite(high), n=n)


def steps_to_threshold(curves: Sequence[Curve]) -> StepsRecord:
    """Return every seed's time to threshold, and their median with the censored ones beyond the budget."""
    times = tuple(time_to_threshold(curve) for curve in curves)
    reached = sum(time is not None for time in times)
    return StepsRecord(per_seed=times, median=_finite(float(np.median(censored_times(curves)))), reached=reached)


def censored_times(curves: Sequence[Curve]) -> Floats:
    """Return every curve's time to threshold [n]; infinite: never reached."""
    times = (time_to_threshold(curve) for curve in curves)
    return np.array([inf if time is None else time for time in times], np.float64)


def _steps_ratio(a: Sequence[Curve], b: Sequence[Curve], rng: np.random.Generator) -> StepsRatioRecord:
    ratio = ratio_of_medians(censored_times(a), censored_times(b), b[0].env_steps[-1], rng)
    at_most, low, high = map(_finite, (ratio.at_most, ratio.low, ratio.high))
    return StepsRatioRecord(at_least=ratio.at_least, at_most=at_most, low=low, high=high)


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None


def transfer_record(transfers: Iterable[Transfer]) -> TransferSetRecord | None:
    """Return what the curves of finished transfers come to; None without a transfer.

    Raises:
        InputError: if a source or a curve is missing.
    """
    curves = [_curves(transfer) for transfer in transfers]
    return transfer_set(curves) if curves else None


def _curves(transfer: Transfer) -> TransferCurves:
    source = transfer.load()
    arms = {
        arm.id: _arm_curves(transfer.folder_of(arm.id), transfer.seeds)
        for arm in sensible_arms(source.method, transfer.target)
    }
    return TransferCurves(source.scenario, transfer.target.id, source.method.id, arms)


def _arm_curves(folder: Path, seeds: tuple[int, ...]) -> ArmCurves:
    """Return the curves of a run; a seed that failed succeeds no more from then on."""
    outcomes = read_outcomes(folder, seeds)
    success = tuple(tuple(rate or 0.0 for rate in curve) for curve in outcomes.testing.success)
    return ArmCurves(outcomes.seeds, outcomes.env_steps, success)
