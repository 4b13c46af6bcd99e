"""A small transfer study whose numbers are known, for tests of records, tables and figures."""

from functools import cache

import numpy as np

from hhrl_bench.transfer.records import TransferSetRecord
from hhrl_bench.transfer.summary import ArmCurves, TransferCurves, transfer_set
from hhrl_bench.transfer.transfer import ArmName

STEPS = tuple(range(0, 60_000, 10_000))
SEEDS = (0, 1, 2, 5)


def rising(begin: float, speed: float, end: float = 1.0) -> tuple[tuple[float, ...], ...]:
    """Return a success curve a seed, [4, 6], that rises from ``begin`` to ``end``, of later seeds a little slower."""
    times = np.array(STEPS) / STEPS[-1]
    curves = [begin + (end - begin) * np.minimum(times * speed * (1.0 - 0.05 * seed), 1.0) for seed in range(4)]
    return tuple(tuple(curve.round(4).tolist()) for curve in curves)


def arms(begin: float = 0.5, speed: float = 2.0, scratch: float = 1.2) -> dict[ArmName, ArmCurves]:
    """Return the four arms; a ``scratch`` below 1 does not reach the threshold."""
    return {
        "scratch": ArmCurves(SEEDS, STEPS, rising(0.0, scratch)),
        "fine-tune": ArmCurves(SEEDS, STEPS, rising(begin, speed)),
        "frozen-action": ArmCurves(SEEDS, STEPS, rising(0.0, 2.0 * speed, 0.96)),
        "zero-shot": ArmCurves(SEEDS, (0,), ((begin,),) * 4),
    }


@cache
def study() -> TransferSetRecord:
    """Return two methods from two sources on up to three targets, on some of which nobody succeeds, or at once."""
    return transfer_set(
        [
            TransferCurves("stop-line-v0", "two-stops-v0", "hybrid-hrl", arms()),
            TransferCurves("stop-line-v0", "red-light-v0", "hybrid-hrl", arms(0.2, 0.6, 0.5)),
            TransferCurves("stop-line-v0", "stop-line-wet-v0", "hybrid-hrl", arms(0.95, 4.0, 4.0)),
            TransferCurves("two-stops-v0", "red-light-v0", "hybrid-hrl", arms(0.4, 1.5)),
            TransferCurves("stop-line-v0", "two-stops-v0", "ddqn", arms(0.1, 1.2, 0.7)),
        ]
    )
