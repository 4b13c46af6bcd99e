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
from itertools import count
from typing import cast

import numpy as np

from hhrl_envs import observation
from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.profiles import PARAMETERS, STYLES
from hhrl_envs.simulation.engine.compilation import inner, unsigned
from hhrl_envs.sub_goals import SUB_GOALS

LANES, STRIDE = 256, 264


def count_fields(offset: int) -> int:
    """Return how many fields lie before an offset in a record: a field's number, or a record's size."""
    return int(offset) // STRIDE


def _offsets() -> Iterator[int]:
    """Yield the offsets of the fields of a record, one after the other, as unsigned integers."""
    return (cast(int, np.uint64(field * STRIDE)) for field in count())


def _take(fields: Iterator[int], number: int) -> tuple[int, ...]:
    """Return the next fields, so many of them."""
    return tuple(next(fields) for _ in range(number))


# The record of a vehicle: its state, where LINE is the position of its active stop-line.
_vehicle = _offsets()
POSITION, SPEED, ACCEL, JERK, LINE, PHASE, STANDING, SLOWING, NEXT_SLOW = _take(_vehicle, 9)
# The behaviour profile of a front vehicle; names and units stand in ``profiles``, PROFILE is where it begins.
DESIRED_SPEED, HEADWAY, MAX_ACCEL, COMFORT_DECEL, MIN_GAP = _take(_vehicle, 5)
LINE_DECEL, STOP_POSITION, LINE_SPEED, DWELL, START_DELAY = _take(_vehicle, 5)
SLOW_AT, SLOW_DECEL, SLOW_TIME, SLOW_EVERY = _take(_vehicle, 4)
STYLE, FAMILY, PER_DESIRED_SPEED, INTERACTION = _take(_vehicle, 4)
PROFILE = DESIRED_SPEED

# Phases of a scripted vehicle, stored as floats in PHASE.
APPROACHING, BRAKING, DWELLING, LEAVING = 0.0, 1.0, 2.0, 3.0

# What an agent at the wheel aims at, whether it was running when the step began, and its outcome if it ended just now.
TARGET, LIVE, FRESH = _take(_vehicle, 3)
# The friction of the road: each vehicle of a row has the row's, because only places in one record lie at distances that
# are known when a kernel is compiled. In plain worlds only the ego has it.
(ROAD_FRICTION,) = _take(_vehicle, 1)
# The elements of the state, in its order: what it measures, and what is computed from that.
MEASURED = _take(_vehicle, observation.SIZE)


def measured(symbol: str) -> int:
    """Return the field of an element of the state, such as ``"d_f"``."""
    return MEASURED[observation.place(symbol)]


V_E, A_E, J_E, D_D = map(measured, ("v_e", "a_e", "j_e", "d_d"))

# The signed terms of its reward, those of the sub-goals a field each. UNSAFE[k] and FAILURE[k] belong to sub-goal k;
# failures lie in the order of their outcomes.
GOALS = len(SUB_GOALS)
TIME, UNSMOOTH = _take(_vehicle, 2)
UNSAFE, FAILURES = _take(_vehicle, GOALS), _take(_vehicle, GOALS)
FAILURE_ORDER = tuple(sorted(range(GOALS), key=lambda k: SUB_GOALS[k].failure))
FAILURE = tuple(FAILURES[FAILURE_ORDER.index(k)] for k in range(GOALS))
TIMEOUT, SUCCESS = _take(_vehicle, 2)
TERMS, TERMS_SIZE = TIME, 4 + 2 * GOALS
# r^task; r^option and r^action if sub-goal k is the selected one; and its outcome.
(TASK,) = _take(_vehicle, 1)
OPTION, ACTION = _take(_vehicle, GOALS), _take(_vehicle, GOALS)
RESULTS, RESULTS_SIZE = TASK, 1 + 2 * GOALS
OPTION_RESULTS, ACTION_RESULTS = slice(1, 1 + GOALS), slice(1 + GOALS, RESULTS_SIZE)
(OUTCOME,) = _take(_vehicle, 1)
(VEHICLE,) = _take(_vehicle, 1)

# The record of the rows: the time of the green light, steps within the band, steps done, whether an agent is
# running, whether the episode is feasible, its STATUS (below), and how often its world was
# drawn anew; with learned front vehicles also the shadow ego's motion (see ``feasibility``).
_row = _offsets()
GREEN_AT, KEPT, STEPS, RUNNING, FEASIBLE, STATUS, ATTEMPT = _take(_row, 7)
SHADOW_POSITION, SHADOW_SPEED, SHADOW_ACCEL, CLEARED = _take(_row, 4)
(ROW,) = _take(_row, 1)

# The scenario's numbers, float64 [field]: physics, judgement, reward, draws, sensors.
_constants = count()
DT, PER_DT, HORIZON, LENGTH, LAG_GAIN, JERK_STEP, EGO_MIN_ACCEL, FRICTION = _take(_constants, 8)
SPEED_LIMIT, STOP_ZONE, STOP_SPEED, FIRST_LINE, LAST_LINE, ROUTE_END, GOAL = _take(_constants, 7)
FRONT_RANGE, LINE_RANGE, CLEAR_BY = _take(_constants, 3)
SIGMA_1, SIGMA_2, SIGMA_3, SIGMA_4, JERK_THRESHOLD, POSITIVE_JERK_ONLY, PRINTED_UNSAFE = _take(_constants, 7)
SAFE_GAP, PER_TWICE_DECEL, TIMEOUT_SCALE = _take(_constants, 3)
START_LOW, START_HIGH, START_SPEED_LOW, START_SPEED_HIGH = _take(_constants, 4)
GAP_LOW, GAP_HIGH, FRONT_SPEED_LOW, FRONT_SPEED_HIGH = _take(_constants, 4)
SIGNAL, GREEN_LOW, GREEN_HIGH = _take(_constants, 3)
NOISE_SPEED, NOISE_ACCEL, NOISE_DISTANCE, DROPOUT, DROPOUT_STEPS = _take(_constants, 5)
GHOSTS, GHOST_STRETCH, GHOST_NEAR = _take(_constants, 3)
BAND_LOW, BAND_HIGH, BAND_HEADWAY, BAND_SHARE = _take(_constants, 4)
FEASIBLE_ONLY, SLOTS, AGENTS = _take(_constants, 3)
ADVERSARY, HARDEST_BRAKE, PATIENCE, THROTTLE = _take(_constants, 4)
GOAL_PLACE, FARTHEST = _take(_constants, 2)  # what a front vehicle must leave free; what full braking must not pass
(GUARD,) = _take(_constants, 1)  # metres that scripted vehicles keep free whatever happens
SLIPPERY_SHARE, SLIPPERY_LOW, SLIPPERY_HIGH = _take(_constants, 3)
(FREE_THROTTLE,) = _take(_constants, 1)  # m/s^2 that scripted vehicles accelerate with whatever the road's grip
(CONSTANTS_SIZE,) = _take(_constants, 1)
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
