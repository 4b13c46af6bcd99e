"""One step of a block of rows, in its visible order."""

from hhrl_envs.arrays import Codes, Floats, Floats32, Ints, Keys
from hhrl_envs.simulation.adversary import judge_adversary, restrain, reward_adversary
from hhrl_envs.simulation.dynamics import drive_agent
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import inner, kernel, spliced, unsigned
from hhrl_envs.simulation.engine.layout import WAITING, locate
from hhrl_envs.simulation.feasibility import drive_shadow
from hhrl_envs.simulation.outcomes import judge, keep_band, switch_lines
from hhrl_envs.simulation.reset import reset_due
from hhrl_envs.simulation.rewards import reward_as_read, reward_floored
from hhrl_envs.simulation.sensing import measure, observe
from hhrl_envs.simulation.traffic import drive_front, drive_traffic
from hhrl_envs.sub_goals import RUNNING, TIMEOUT


@kernel
def aim(m: Floats, c: Floats, actions: Ints, levels: Floats) -> bool:
    """Return whether ``actions``, int64 [agent x row], are all levels; if so, make them the agents' targets."""
    agents, count, wrong = int(c[at.AGENTS]), unsigned(levels.size), False
    rows = actions.size // agents
    for place in range(actions.size):
        wrong |= unsigned(actions[place]) >= count  # so is what is negative
    if wrong:
        return False
    for agent in range(agents):
        for first in range(0, rows, at.LANES):
            target = locate(unsigned(first // at.LANES), c)[0] + unsigned(agent) * at.VEHICLE + at.TARGET
            given = unsigned(agent * rows + first)
            for i in range(unsigned(min(at.LANES, rows - first))):
                m[target + i] = levels[unsigned(actions[given + i])]
    return True


@spliced
def prepare(m: Floats, s: int, r: int, c: Floats, lanes: int) -> None:
    """Note who is running, count the steps of rows where somebody is, and call the others WAITING.

    Agents that are not running brake fully.
    """
    brake = c[at.EGO_MIN_ACCEL]
    for i in range(lanes):
        m[r + at.RUNNING + i] = 0.0
    for agent in range(unsigned(c[at.AGENTS])):
        own = s + agent * at.VEHICLE
        for i in range(lanes):
            target, runs = m[own + at.TARGET + i], m[own + at.OUTCOME + i] == RUNNING
            live = 1.0 if runs else 0.0
            m[own + at.LIVE + i] = live
            m[own + at.TARGET + i] = target if runs else brake
            m[r + at.RUNNING + i] = max(m[r + at.RUNNING + i], live)
    for i in range(lanes):
        m[r + at.STEPS + i] += m[r + at.RUNNING + i]
        m[r + at.STATUS + i] = WAITING * (1.0 - m[r + at.RUNNING + i])


@spliced
def measure_and_judge(m: Floats, s: int, r: int, c: Floats, lanes: int) -> None:
    """Write what every agent measures, and its outcome."""
    for agent in range(unsigned(c[at.AGENTS])):
        own = s + agent * at.VEHICLE
        measure(m, own, c, lanes)
        judge(m, own, own - at.VEHICLE if agent > 0 else own, r, c, lanes)


@spliced
def hand_out(m: Floats, s: int, observations: Floats32, results: Floats, codes: Codes, first: int, lanes: int) -> int:
    """Write what every agent gets to the rows from ``first``, and return how many agents have ended."""
    ended = 0
    for agent in range(unsigned(observations.shape[1])):
        own = s + agent * at.VEHICLE
        observe(m, own, observations, agent, first, lanes)
        for field in range(results.shape[0]):
            place = own + at.RESULTS + unsigned(field * at.STRIDE)
            for i in range(lanes):
                results[field, agent, first + i] = m[place + i]
        for i in range(lanes):
            outcome = m[own + at.OUTCOME + i]
            over, late = outcome != RUNNING, outcome == TIMEOUT
            codes[0, agent, first + i] = int(outcome)
            codes[1, agent, first + i] = over & (not late)
            codes[2, agent, first + i] = late
            ended += over
    return ended


@spliced
def move(m: Floats, s: int, r: int, c: Floats, special: bool | None, lanes: int) -> None:
    """Let signals switch and all vehicles of a block drive, front to back."""
    prepare(m, s, r, c, lanes)
    if special is not None:
        switch_lines(m, s, r, c, lanes)
    drive_traffic(m, s, c, special, lanes)
    if special is not None:
        drive_fronts(m, s, c, special, lanes)
    drive_agent(m, s, c, special, lanes)
    if special is not None:
        keep_band(m, s, r, c, lanes)
        drive_shadow(m, s, r, c, lanes)


@spliced
def measure_and_reward(m: Floats, s: int, r: int, c: Floats, special: bool | None, lanes: int) -> None:
    """Write what the agents of a block measure, their outcomes and their rewards."""
    measure_and_judge(m, s, r, c, lanes)
    if special is not None:
        judge_adversary(m, s, r, c, lanes)
    for agent in range(unsigned(c[at.AGENTS])):
        if special is None:
            reward_floored(m, s + agent * at.VEHICLE, c, lanes)
        else:
            reward_as_read(m, s + agent * at.VEHICLE, c, lanes)
    if special is not None:
        reward_adversary(m, s, c, lanes)


MOVE, BEGIN, SHOW = 1, 2, 4  # what there is to do, to be added up
MOVE_AND_SHOW = MOVE | SHOW
BACKWARDS = 8  # to be added where the blocks are to be taken from the last to the first


@kernel
def advance_rows(
    m: Floats, c: Floats, keys: Keys, observations: Floats32, results: Floats, codes: Codes,
    parts: int, special: bool | None, low: int, high: int,
) -> int:  # fmt: skip
    """Do the ``parts`` of a step for the blocks from low to high and return how many agents have ended.

    It is -1 if rows cannot begin yet, because their worlds are OPEN; see ``reset``.

    MOVE is one step of all rows, BEGIN begins the episodes that are due, SHOW fills ``observations``, float32 [SIZE,
    agent, row], ``results``, float64 [RESULTS_SIZE, agent, row], and ``codes``, int8 [3, agent, row]: the outcome,
    whether it terminated the episode, whether it truncated it. To SHOW a step again changes nothing.

    ``keys``, uint64 [2, row], are seed and episode of the rows. ``special`` is None for an ego alone that has to stop
    at one line and whose reward and road are as usual, so that what other scenarios need is not even compiled. Agents
    that had ended before keep their outcome and earn nothing. BACKWARDS in every other step begins with the blocks that
    the step before has left in the cache.
    """
    ended, still_open, rows = 0, 0, unsigned(observations.shape[2])
    for n in range(unsigned(high - low)):
        block = unsigned(high) - unsigned(1) - n if parts & BACKWARDS else unsigned(low) + n
        s, r = locate(block, c)
        first = block * unsigned(at.LANES)
        lanes = min(unsigned(at.LANES), rows - first)
        if parts & MOVE:
            move(m, s, r, c, special, lanes)
        if parts & BEGIN:
            still_open += reset_due(m, s, r, keys, first, c, special, lanes)
        if parts & SHOW:
            measure_and_reward(m, s, r, c, special, lanes)
            ended += hand_out(m, s, observations, results, codes, first, lanes)
    return -1 if still_open > 0 else ended


@inner
def drive_fronts(m: Floats, ego: int, c: Floats, special: bool | None, lanes: int) -> None:
    """Advance all learned front vehicles by one step, front to back; ``ego`` is the egos' record."""
    if c[at.ADVERSARY] != 0.0:
        restrain(m, ego + at.VEHICLE, c, lanes)
    fronts = unsigned(c[at.AGENTS]) - unsigned(1)
    for ahead in range(fronts):
        drive_front(m, ego + (fronts - ahead) * at.VEHICLE, c, special, lanes)
