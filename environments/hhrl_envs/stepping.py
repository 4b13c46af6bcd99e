"""One step of a slice of rows, in its visible order."""

from hhrl_envs import layout
from hhrl_envs.batch import EPISODE, LIVE, SEED, TARGET, Batch, Results
from hhrl_envs.compiled import Codes, Flags, Ints, as_row, kernel
from hhrl_envs.dynamics import drive_agent
from hhrl_envs.feasibility import begin
from hhrl_envs.goals import FOLLOW, finish_stops, keep_band, switch_signals
from hhrl_envs.observation import observe
from hhrl_envs.outcomes import RUNNING, judge
from hhrl_envs.rewards import reward
from hhrl_envs.sensing import derive, measure, perturb
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
    measure(b.state, b.measured, 0, b.c, low, high)
    derive(b.measured, 0, b.c, low, high)
    judge(b.state, b.rows, b.steps, before, out.ended, b.fresh, 0, b.c, low, high)
    reward(b.measured, b.scratch[LIVE], b.fresh, out.rewards, 0, b.c, low, high)
    if b.c[layout.FIRST_LINE] < b.c[layout.LAST_LINE]:
        finish_stops(b.state, 0, b.c, low, high)


@kernel
def begin_row(b: Batch, out: Results, feasible_only: bool, i: int) -> None:
    """Put row ``i`` at the start of its current episode, with reward 0."""
    b.feasible[i] = begin(
        b.state, b.profile, b.rows, i, b.keys[SEED, i], b.keys[EPISODE, i], feasible_only, b.c, b.counts, b.families
    )
    b.steps[i] = 0
    out.ended[:, i] = RUNNING
    out.rewards[:, :, i] = 0.0
    measure(b.state, b.measured, 0, b.c, i, i + as_row(1))
    derive(b.measured, 0, b.c, i, i + as_row(1))


@kernel
def show(b: Batch, out: Results, low: int, high: int) -> None:
    """Write the observations: the truth as measured, or a delayed and noisy version of it."""
    if b.history.shape[0] > 0:
        perturb(b.measured, b.history, b.steps, b.keys, 0, b.c, low, high)
    observe(b.measured, out.observations, 0, low, high)


@kernel
def begin_rows(b: Batch, chosen: Flags, out: Results, feasible_only: bool) -> None:
    """Put the chosen rows, bool [row], at the start of their current episodes."""
    for i in range(as_row(chosen.size)):
        if chosen[i]:
            begin_row(b, out, feasible_only, i)
            show(b, out, i, i + as_row(1))


@kernel
def advance_rows(
    b: Batch, actions: Ints, before: Codes, out: Results, feasible_only: bool, autoreset: bool, low: int, high: int
) -> None:
    """Advance rows low to high by one step; with ``autoreset`` rows that had ended begin their next episode instead."""
    for start in range(as_row(low), as_row(high), BLOCK):
        stop = min(start + BLOCK, as_row(high))
        prepare(b, actions, before, start, stop)
        drive(b, start, stop)
        judge_and_reward(b, before, out, start, stop)
        if autoreset:
            for i in range(start, stop):
                if before[0, i] != RUNNING:
                    b.keys[EPISODE, i] += 1
                    begin_row(b, out, feasible_only, i)
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
