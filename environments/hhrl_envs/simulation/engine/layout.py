"""Where the numbers of a batch lie in memory, and the scenario's numbers in their array.

The memory of a batch is one float64 array of blocks, each block the numbers of ``LANES`` rows. A block is a sequence
of records: one for the rows themselves, then one for every vehicle; a record is a sequence of fields, and a field holds
one number for each lane. ``memory[record + FIELD + lane]`` is therefore how a kernel reads and writes: with all
distances known when it is compiled, its loops over lanes vectorise without checks for overlap. Fields lie ``STRIDE``
numbers apart, an odd number of cache lines: a power of two would map all of them to the same few lines.

Slot 0 is the ego, slot k its k-th front vehicle (nearest first); the slot after the last vehicle is a sentinel that
drives far down the road, so that every vehicle has a leader and no loop needs a special case. The agents are the first
slots, so an agent's number is its slot, and its record that of its vehicle.

Field offsets and records are unsigned: a signed index might be negative, and wrapping it around keeps loops from
vectorising. So does a load within a choice: a kernel loads its numbers, and those of the scenario before its loop, and
then chooses between them.
"""

from collections.abc import Iterator
from typing import cast

import numpy as np

from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.profiles import PARAMETERS, STYLES
from hhrl_envs.simulation.engine.compilation import inner, unsigned

LANES, STRIDE = 256, 264


def _fields(count: int, first: int = 0) -> Iterator[int]:
    """Yield the offsets of ``count`` fields, as unsigned integers."""
    return (cast(int, np.uint64(field * STRIDE)) for field in range(first, first + count))


# A vehicle's state. LINE is the position of its active stop-line.
POSITION, SPEED, ACCEL, JERK, LINE, PHASE, STANDING, SLOWING, NEXT_SLOW = _fields(9)
# The behaviour profile of a front vehicle; names and units stand in ``profiles``, PROFILE is where it begins.
DESIRED_SPEED, HEADWAY, MAX_ACCEL, COMFORT_DECEL, MIN_GAP = _fields(5, 9)
LINE_DECEL, STOP_POSITION, LINE_SPEED, DWELL, START_DELAY = _fields(5, 14)
SLOW_AT, SLOW_DECEL, SLOW_TIME, SLOW_EVERY = _fields(4, 19)
STYLE, FAMILY, PER_DESIRED_SPEED, INTERACTION = _fields(4, 23)
PROFILE = DESIRED_SPEED

# Phases of a scripted vehicle, stored as floats in PHASE.
APPROACHING, BRAKING, DWELLING, LEAVING = 0.0, 1.0, 2.0, 3.0

# What an agent at the wheel aims at, whether it was running when the step began, and its outcome if it ended just now.
TARGET, LIVE, FRESH = _fields(3, 27)
# What it measures, in the order of Eq. (state); see ``observation``.
V_E, A_E, J_E, D_F, V_F, A_F, D_FC, FC_RATIO, D_D, D_DC, DC_RATIO = _fields(11, 30)
MEASURED = V_E
# The signed terms of its reward; then r^task, r^option and r^action of every option; and its outcome.
TIME, UNSMOOTH, UNSAFE_SSL, UNSAFE_FFV, COLLISION, NOT_STOP, TIMEOUT, SUCCESS = _fields(8, 41)
TERMS, TERMS_SIZE = TIME, 8
TASK, OPTION_SSL, OPTION_FFV, ACTION_SSL, ACTION_FFV = _fields(5, 49)
RESULTS, RESULTS_SIZE = TASK, 5
(OUTCOME,) = _fields(1, 54)
(VEHICLE,) = _fields(1, 55)

# What holds for a whole row: the time of the green light, steps within the band, steps done, whether an agent is
# running, whether the episode is feasible, its STATUS (below), and how often its world was
# drawn anew; with learned front vehicles also the shadow ego's motion (see ``feasibility``).
GREEN_AT, KEPT, STEPS, RUNNING, FEASIBLE, STATUS, ATTEMPT = _fields(7)
SHADOW_POSITION, SHADOW_SPEED, SHADOW_ACCEL, CLEARED = _fields(4, 7)
(ROW,) = _fields(1, 11)

# The scenario's numbers, float64 [field].
DT, PER_DT, HORIZON, LENGTH, LAG_GAIN, JERK_STEP, EGO_MIN_ACCEL, GRIP = range(8)
SPEED_LIMIT, STOP_ZONE, STOP_SPEED, FIRST_LINE, LAST_LINE, ROUTE_END, GOAL = range(8, 15)
FRONT_RANGE, LINE_RANGE, CLEAR_BY = range(15, 18)
SIGMA_1, SIGMA_2, SIGMA_3, SIGMA_4, JERK_THRESHOLD, POSITIVE_JERK_ONLY = range(18, 24)
SAFE_GAP, PER_TWICE_DECEL, TIMEOUT_SCALE = range(24, 27)
START_LOW, START_HIGH, START_SPEED_LOW, START_SPEED_HIGH = range(27, 31)
GAP_LOW, GAP_HIGH, FRONT_SPEED_LOW, FRONT_SPEED_HIGH = range(31, 35)
SIGNAL, GREEN_LOW, GREEN_HIGH = range(35, 38)
NOISE_SPEED, NOISE_ACCEL, NOISE_DISTANCE = range(38, 41)
BAND_LOW, BAND_HIGH, BAND_HEADWAY, BAND_SHARE = range(41, 45)
FEASIBLE_ONLY, SLOTS, AGENTS = range(45, 48)
ADVERSARY, HARDEST_BRAKE, PATIENCE, THROTTLE = range(48, 52)
GOAL_PLACE, FARTHEST = range(52, 54)  # what a front vehicle must leave free; what full braking must not pass
CONSTANTS_SIZE = 54
# Behind them: the cumulative shares of 0, 1, 2, ... front vehicles, then the table of the profile families, row by row.
COUNTS = CONSTANTS_SIZE

FAR = 1.0e6  # m; where absent vehicles drive and where a line stands that does not exist

# STATUS of a row: its episode has begun; is over, and the next one is due; and, while a world is drawn for that (see
# ``reset``), the world is to be drawn, is being tried, is decided.
BEGUN, WAITING, TO_DRAW, OPEN, DECIDED = 0.0, 1.0, 2.0, 3.0, 4.0
# Columns of a row's key: the seed, the number of its episode.
SEED, EPISODE = 0, 1

# Columns of the table of profile families: low and high of every parameter, cumulative weight, slow chance, cumulative
# shares of the styles.
RANGES = len(PARAMETERS)
WEIGHT, SLOW_CHANCE, STYLE_SHARES = range(2 * RANGES, 2 * RANGES + 3)
FAMILY_TABLE_WIDTH = STYLE_SHARES + len(STYLES)


@inner
def locate(block: int, c: Floats) -> tuple[int, int]:
    """Return where the records of a block begin: the ego's, the rows'."""
    begin = block * (ROW + unsigned(c[SLOTS]) * VEHICLE)
    return begin + ROW, begin


@inner
def locate_row(row: int, c: Floats) -> tuple[int, int]:
    """Return the places of one row: the records of its block, see ``locate``, plus its lane."""
    s, r = locate(unsigned(row // LANES), c)
    lane = unsigned(row % LANES)
    return s + lane, r + lane
