"""The rows of the packed arrays that the compiled kernels work on.

Every array keeps the batch last, so that a loop over rows reads and writes contiguous memory. Slot 0 is the ego, slot
k its k-th front vehicle (nearest first); the slot after the last vehicle is a sentinel that drives far down the road,
so that every vehicle has a leader and no loop needs a special case. The agents are the first slots, so an agent's
number is its slot.
"""

# The state of vehicles, float64 [field, slot, row]. LINE is the position of the vehicle's active stop-line.
POSITION, SPEED, ACCEL, JERK, LINE, PHASE, STANDING, SLOWING, NEXT_SLOW = range(9)
STATE_SIZE = 9

# Phases of a scripted vehicle, stored as floats in PHASE.
APPROACHING, BRAKING, DWELLING, LEAVING = 0.0, 1.0, 2.0, 3.0

# The profiles of front vehicles, float64 [field, slot, row]; names and units stand in ``profiles``.
DESIRED_SPEED, HEADWAY, MAX_ACCEL, COMFORT_DECEL, MIN_GAP = range(5)
LINE_DECEL, STOP_POSITION, LINE_SPEED, DWELL, START_DELAY = range(5, 10)
SLOW_AT, SLOW_DECEL, SLOW_TIME, SLOW_EVERY = range(10, 14)
STYLE, FAMILY, PER_DESIRED_SPEED, INTERACTION = range(14, 18)
PROFILE_SIZE = 18

# What holds for a whole row, float64 [field, row].
GREEN_AT, KEPT = range(2)
ROW_SIZE = 2

# What an agent can measure, float64 [field, agent, row]: first the base quantities, then those of Eq. (dis).
V_E, A_E, J_E, D_F, V_F, A_F, D_D = range(7)
BASE_SIZE = 7
D_FC, FC_RATIO, D_DC, DC_RATIO = range(7, 11)
MEASURED_SIZE = 11

# The results of a step, float64 [field, agent, row]: reward terms first, then their sums.
TIME, UNSMOOTH, UNSAFE_SSL, UNSAFE_FFV, COLLISION, NOT_STOP, TIMEOUT, SUCCESS = range(8)
TERMS_SIZE = 8
REWARD_TASK = 8
REWARD_OPTION = 9  # and 10: one row an option
REWARD_ACTION = 11  # and 12
RESULTS_SIZE = 13

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
CONSTANTS_SIZE = 45

FAR = 1.0e6  # m; where absent vehicles drive and where a line stands that does not exist
