"""The rows of the packed arrays that the compiled kernels work on.

Every array keeps the batch last (``[field, slot, row]``), so that a loop over rows reads and writes contiguous memory.
Slot 0 is the ego, slot k its k-th front vehicle (nearest first); the slot after the last vehicle is a sentinel that
stands far down the road, so that every vehicle has a leader and no loop needs a special case.
"""

# The state array, float64 by field, slot and row.
POSITION, SPEED, ACCEL, JERK, PHASE, STANDING, SLOWING = range(7)
STATE_SIZE = 7

# Phases of a scripted vehicle, stored as floats in PHASE.
APPROACHING, BRAKING, DWELLING, LEAVING = 0.0, 1.0, 2.0, 3.0

# The profile array, float64 by field, slot and row; the names and units stand in ``profiles``
DESIRED_SPEED, HEADWAY, MAX_ACCEL, COMFORT_DECEL, MIN_GAP = range(5)
LINE_DECEL, STOP_POSITION, LINE_SPEED, DWELL, START_DELAY = range(5, 10)
SLOW_AT, SLOW_DECEL, SLOW_TIME = range(10, 13)
STYLE, FAMILY = range(13, 15)
PROFILE_SIZE = 15

# The constants, float64 by field: the scenario's numbers
DT, HORIZON = range(2)
LENGTH, LAG_GAIN, JERK_STEP, EGO_MIN_ACCEL = range(2, 6)
SPEED_LIMIT, STOP_ZONE, STOP_SPEED, SENSOR_RANGE, CLEAR_BY = range(6, 11)
SIGMA_1, SIGMA_2, SIGMA_3, SIGMA_4, JERK_THRESHOLD, POSITIVE_JERK_ONLY = range(11, 17)
SAFE_GAP, NOMINAL_DECEL, TIMEOUT_SCALE = range(17, 20)
START_LOW, START_HIGH, START_SPEED_LOW, START_SPEED_HIGH = range(20, 24)
GAP_LOW, GAP_HIGH, FRONT_SPEED_LOW, FRONT_SPEED_HIGH = range(24, 28)
CONSTANTS_SIZE = 28

# The results, float64 by field and row: reward terms first, then their sums
TIME, UNSMOOTH, UNSAFE_SSL, UNSAFE_FFV, COLLISION, NOT_STOP, TIMEOUT, SUCCESS = range(8)
TERMS_SIZE = 8
REWARD_TASK = 8
REWARD_OPTION = 9  # and 10: one row an option
REWARD_ACTION = 11  # and 12
RESULTS_SIZE = 13

FAR = 1.0e6  # m; where absent vehicles drive
