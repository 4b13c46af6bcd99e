"""Transfer records made of success curves, and made again from the curves that a record holds."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hhrl_bench.arms import ARMS, CONTROL, ArmName
from hhrl_bench.errors import CurveError
from hhrl_bench.records import SCHEMA_VERSION
from hhrl_bench.statistics import CONFIDENCE
from hhrl_bench.summaries import BOOTSTRAP_SEED
from hhrl_bench.transfer_metrics import THRESHOLD, Curve, area
from hhrl_bench.transfer_records import Group, TransferRecord, TransferSetRecord
from hhrl_bench.transfer_summary import comparison, steps_to_threshold, summary


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
    groups: dict[Group, dict[ArmName, ArmCurves]] = {}
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
    group = Group(method, source, target)
    if CONTROL not in curves or set(curves) - set(ARMS):
        raise CurveError(f"{group} has the arms {', '.join(curves)}; write {CONTROL} and others of {', '.join(ARMS)}")
    rows = []
    for arm in (arm for arm in ARMS if arm in curves):
        try:
            rows.append(_row(group, arm, curves[arm], curves[CONTROL], rng))
        except CurveError as error:
            raise CurveError(f"{arm} of {group}: {error}") from error
    return tuple(rows)


def _row(group: Group, arm: ArmName, own: ArmCurves, control: ArmCurves, rng: np.random.Generator) -> TransferRecord:
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
