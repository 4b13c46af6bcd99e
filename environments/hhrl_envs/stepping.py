"""One step of a slice of rows, in its visible order."""

from hhrl_envs import layout
from hhrl_envs.batch import LIVE, TARGET, Batch, Results
from hhrl_envs.compiled import Codes, Ints, as_row, kernel
from hhrl_envs.dynamics import drive_agent
from hhrl_envs.goals import FOLLOW, finish_stops, keep_band, switch_signals
from hhrl_envs.outcomes import RUNNING, judge
from hhrl_envs.rewards import reward
from hhrl_envs.showing import measure_truth, show
from hhrl_envs.traffic import drive_slot

BLOCK = as_row(256)  # rows whose arrays fit the fast caches


@kernel
def prepare(b: Batch, actions: Ints, before: Codes, low: int, high: int) -> None:
    """Look up the target accelerations, note which rows are running and count their step."""
    for i in range(low, high):
        running = before[0, i] == RUNNING
        b.scratch[LIVE, i] = 1.0 if running else 0.0
        b.steps[i] += 1 if running else 0
    for i in range(low, high):
        b.scratch[TARGET, i] = b.levels[actions[i]]


@kernel
def drive(b: Batch, low: int, high: int) -> None:
    """Switch the signals, then move everybody by one step, from the front of the queue to its back."""
    if b.c[layout.SIGNAL] != 0.0:
        switch_signals(b.state, b.rows, b.steps, b.c, low, high)
    for k in range(b.state.shape[1] - 2, 0, -1):
        drive_slot(b.state, b.profile, k, b.c, low, high)
    drive_agent(b.state, b.scratch[TARGET], 0, b.c, low, high)
    if b.c[layout.GOAL] == FOLLOW:
        keep_band(b.state, b.rows, b.c, low, high)


@kernel
def judge_and_reward(b: Batch, before: Codes, out: Results, low: int, high: int) -> None:
    """Write outcomes and rewards from the truth, then move the active line on where a stop was completed."""
    measure_truth(b, low, high)
    judge(b.state, b.rows, b.steps, before, out.ended, b.fresh, 0, b.c, low, high)
    reward(b.measured, b.scratch[LIVE], b.fresh, out.rewards, 0, b.c, low, high)
    if b.c[layout.FIRST_LINE] < b.c[layout.LAST_LINE]:
        finish_stops(b.state, 0, b.c, low, high)


@kernel
def advance_rows(b: Batch, actions: Ints, before: Codes, out: Results, low: int, high: int) -> None:
    """Advance rows low to high by one step; those that had ended ``before`` keep their outcome and earn nothing."""
    for start in range(as_row(low), as_row(high), BLOCK):
        stop = min(start + BLOCK, as_row(high))
        prepare(b, actions, before, start, stop)
        drive(b, start, stop)
        judge_and_reward(b, before, out, start, stop)
        show(b, out, start, stop)


@kernel
def bad_action(actions: Ints, levels: int) -> int:
    """Return the position of the first action outside 0 to ``levels`` - 1, or -1."""
    worst = False
    for i in range(actions.size):
        worst |= (actions[i] < 0) | (actions[i] >= levels)
    if worst:
        for i in range(actions.size):
            if (actions[i] < 0) | (actions[i] >= levels):
                return i
    return -1
