"""What the calibration aims at: the rows of Rules 1 to 4 in the paper's Table I, and the bars around them."""

from functools import cache

import numpy as np

from hhrl_bench.paper_table import CASES, TABLE_I
from hhrl_bench.statistics.intervals import wilson
from hhrl_envs.arrays import Floats

ROWS = TABLE_I[:4]
RATES = ("collision", "not_stop", "timeout", "success")
COLUMNS = ("return_option", "return_action", "steps", "unsmooth", "unsafe", *RATES)
STEPS_TOLERANCE = 0.2
SCALES = {"return_option": 10.0, "return_action": 10.0, "unsmooth": 0.5, "unsafe": 5.0}
MARGIN = 0.5  # share of a bar's arm that the search keeps to, for it sees few episodes
STEEP = 20.0  # what leaving that share costs


@cache
def paper() -> Floats:
    """Return Table I's rows of Rules 1 to 4, float64 [4, 9]; rates as shares."""
    percent = dict.fromkeys(RATES, float(CASES))
    return np.array([[getattr(row, column) / percent.get(column, 1.0) for column in COLUMNS] for row in ROWS])


@cache
def bars() -> tuple[Floats, Floats]:
    """Return the bounds of every cell's bar, two float64 [4, 9]; NaN where a cell has none.

    A rate has to lie in the 95% Wilson interval of the paper's 100 cases, the steps within 20% of the paper's.
    """
    low, high = np.full((2, len(ROWS), len(COLUMNS)), np.nan)
    steps = COLUMNS.index("steps")
    low[:, steps] = paper()[:, steps] * (1.0 - STEPS_TOLERANCE)
    high[:, steps] = paper()[:, steps] * (1.0 + STEPS_TOLERANCE)
    for i, row in enumerate(ROWS):
        for column in RATES:
            interval = wilson(getattr(row, column), CASES)
            low[i, COLUMNS.index(column)], high[i, COLUMNS.index(column)] = interval.low, interval.high
    return low, high


def objective(table: Floats) -> float:
    """Return how far the nine columns of the four rules, float64 [4, 9], are from Table I; 0: all 36 cells are met.

    A cell with a bar costs the square of its difference in units of the bar's arm on that side, and steeply more
    beyond ``MARGIN`` of it. One without costs its difference in units of ``SCALES``, squared where that is below 1.
    """
    low, high = bars()
    difference = table - paper()
    arm = np.where(difference > 0.0, high - paper(), paper() - low)
    barred = arm > 0.0
    bar = np.abs(difference[barred]) / arm[barred]
    softly = [COLUMNS.index(column) for column in SCALES]
    soft = np.abs(difference[:, softly]) / np.array(list(SCALES.values()))
    return float(np.sum(bar**2 + STEEP * np.maximum(bar - MARGIN, 0.0)) + np.sum(np.minimum(soft, soft**2)))
