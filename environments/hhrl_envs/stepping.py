"""One step of a batch, in its visible order."""

from hhrl_envs import layout as at
from hhrl_envs.blocks import locate
from hhrl_envs.compiled import Floats, Floats32, Ints, inner, kernel, unsigned
from hhrl_envs.dynamics import drive_agent
from hhrl_envs.feasibility import drive_shadow
from hhrl_envs.fronts import drive_front, judge_adversary, restrain, reward_adversary
from hhrl_envs.goals import FOLLOW, finish_stops, keep_band, switch_signals
from hhrl_envs.observation import observe
from hhrl_envs.outcomes import RUNNING, judge
from hhrl_envs.rewards import reward
from hhrl_envs.sensing import measure
from hhrl_envs.traffic import drive_slot

WAITING = 1.0  # in STATUS: the row's episode is over, the next one is due
MOVE, SHOW, MOVE_AND_SHOW = 1, 2, 3  # parts of a step


@kernel
def aim(m: Floats, c: Floats, actions: Ints, levels: Floats) -> int:
    """Make ``actions``, int64 [agent, row], the agents' targets and return -1.

    If one is no level nothing is changed, and its place among all of them is returned.
    """
    agents, rows = len(actions), actions.shape[1]
    for agent in range(agents):
        wrong = False
        for row in range(rows):
            wrong |= (actions[agent, row] < 0) | (actions[agent, row] >= levels.size)
        if wrong:
            return int(agent * rows + first_wrong(actions[agent], levels.size))
    for agent in range(agents):
        for first in range(0, rows, at.LANES):
            a = locate(unsigned(first // at.LANES), c)[1] + unsigned(agent) * at.AGENT + at.TARGET
            for i in range(min(at.LANES, rows - first)):
                m[a + unsigned(i)] = levels[actions[agent, first + i]]
    return -1


@inner
def first_wrong(actions: Ints, levels: int) -> int:
    """Return the place of the first action outside 0 to ``levels`` - 1."""
    row = 0
    while (actions[row] >= 0) & (actions[row] < levels):
        row += 1
    return row


@inner
def prepare(m: Floats, a: int, r: int, c: Floats, lanes: int) -> None:
    """Note who is running, count the steps of rows where somebody is, and call the others WAITING.

    Agents that are not running brake fully.
    """
    brake = c[at.EGO_MIN_ACCEL]
    for i in range(lanes):
        m[r + at.RUNNING + i] = 0.0
    for _ in range(unsigned(c[at.AGENTS])):
        for i in range(lanes):
            live = 1.0 if m[a + at.OUTCOME + i] == RUNNING else 0.0
            m[a + at.LIVE + i] = live
            m[a + at.TARGET + i] = m[a + at.TARGET + i] if live != 0.0 else brake
            m[r + at.RUNNING + i] = max(m[r + at.RUNNING + i], live)
        a += at.AGENT
    for i in range(lanes):
        m[r + at.STEPS + i] += m[r + at.RUNNING + i]
        m[r + at.STATUS + i] = WAITING * (1.0 - m[r + at.RUNNING + i])


@inner
def drive(m: Floats, s: int, a: int, r: int, c: Floats, lanes: int) -> None:
    """Switch signals and lines, then move everybody by one step, from the front of the queue to its back."""
    slots, agents = unsigned(c[at.SLOTS]), unsigned(c[at.AGENTS])
    if c[at.SIGNAL] != 0.0:
        switch_signals(m, s, slots, r, c, lanes)
    if c[at.FIRST_LINE] < c[at.LAST_LINE]:
        for agent in range(agents):
            finish_stops(m, s + agent * at.VEHICLE, a + agent * at.AGENT, c, lanes)
    if c[at.ADVERSARY] != 0.0:
        restrain(m, s + at.VEHICLE, a + at.AGENT, c, lanes)
    for behind in range(slots - unsigned(2)):
        slot = slots - unsigned(2) - behind
        if slot < agents:
            drive_front(m, s + slot * at.VEHICLE, a + slot * at.AGENT, c, lanes)
        else:
            drive_slot(m, s + slot * at.VEHICLE, c, lanes)
    drive_agent(m, s, a, c, lanes)
    if c[at.GOAL] == FOLLOW:
        keep_band(m, s, r, c, lanes)
    if agents > 1:
        drive_shadow(m, s, a, r, c, lanes)


@inner
def show(
    m: Floats, ego: int, first_agent: int, r: int, c: Floats,
    observations: Floats32, results: Floats, agent: int, first: int, lanes: int,
) -> int:  # fmt: skip
    """Judge and reward one agent in each lane, hand out what it gets, and return how many of them have ended.

    The results go to the rows from ``first`` of ``observations``, float32 [11, agent, row], and of ``results``, float64
    [RESULTS_SIZE, agent, row]. Doing it again without a step in between changes nothing.
    """
    s, a = ego + agent * at.VEHICLE, first_agent + agent * at.AGENT
    measure(m, s, a, c, lanes)
    judge(m, s, s - at.VEHICLE if agent > 0 else s, a, r, c, lanes)
    if (c[at.ADVERSARY] != 0.0) & (agent == 1):
        judge_adversary(m, first_agent, a, r, lanes)
    reward(m, a, c, lanes)
    if (c[at.ADVERSARY] != 0.0) & (agent == 1):
        reward_adversary(m, a, c, lanes)
    observe(m, a, observations, agent, first, lanes)
    for field in range(at.RESULTS_SIZE):
        place = a + at.RESULTS + unsigned(field * at.LANES)
        for i in range(lanes):
            results[field, agent, first + i] = m[place + i]
    ended = 0
    for i in range(lanes):
        ended += m[a + at.OUTCOME + i] != RUNNING
    return ended


@kernel
def advance_rows(m: Floats, c: Floats, observations: Floats32, results: Floats, parts: int, low: int, high: int) -> int:
    """Advance the blocks from low to high by one step, or by the parts of it that are asked for.

    Return how many agents have ended, if that is SHOWn. Those that had ended before keep their outcome and earn
    nothing.
    """
    ended, rows = 0, unsigned(observations.shape[2])
    for block in range(unsigned(low), unsigned(high)):
        s, a, r = locate(block, c)
        first = block * unsigned(at.LANES)
        lanes = min(unsigned(at.LANES), rows - first)
        if parts & MOVE:
            prepare(m, a, r, c, lanes)
            drive(m, s, a, r, c, lanes)
        if parts & SHOW:
            for agent in range(unsigned(c[at.AGENTS])):
                ended += show(m, s, a, r, c, observations, results, agent, first, lanes)
    return ended
