"""One step of a block of rows, in its visible order."""

from hhrl_envs import layout as at
from hhrl_envs.blocks import locate
from hhrl_envs.compiled import Codes, Floats, Floats32, Ints, inner, kernel, spliced, unsigned
from hhrl_envs.dynamics import drive_agent
from hhrl_envs.feasibility import drive_shadow
from hhrl_envs.fronts import drive_fronts, judge_adversary, reward_adversary
from hhrl_envs.goals import keep_band, switch_lines
from hhrl_envs.observation import observe
from hhrl_envs.outcomes import RUNNING, TIMEOUT, judge
from hhrl_envs.rewards import reward
from hhrl_envs.sensing import measure
from hhrl_envs.traffic import drive_slot

WAITING = 1.0  # in STATUS: the row's episode is over, the next one is due


@kernel
def aim(m: Floats, c: Floats, actions: Ints, levels: Floats) -> int:
    """Make ``actions``, int64 [agent x row], the agents' targets and return -1.

    If one is no level nothing is changed, and its place among all of them is returned.
    """
    agents, count, wrong = int(c[at.AGENTS]), unsigned(levels.size), False
    rows = actions.size // agents
    for place in range(actions.size):
        wrong |= unsigned(actions[place]) >= count  # so is what is negative
    if wrong:
        return first_wrong(actions, levels.size)
    for agent in range(agents):
        for first in range(0, rows, at.LANES):
            target = locate(unsigned(first // at.LANES), c)[0] + unsigned(agent) * at.VEHICLE + at.TARGET
            given = unsigned(agent * rows + first)
            for i in range(unsigned(min(at.LANES, rows - first))):
                m[target + i] = levels[unsigned(actions[given + i])]
    return -1


@inner
def first_wrong(actions: Ints, levels: int) -> int:
    """Return the place of the first action outside 0 to ``levels`` - 1."""
    place = 0
    while (actions[place] >= 0) & (actions[place] < levels):
        place += 1
    return place


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
def drive_traffic(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Move all scripted vehicles by one step, from the front of the queue to its back."""
    slots, agents = unsigned(c[at.SLOTS]), unsigned(c[at.AGENTS])
    for behind in range(slots - unsigned(1) - agents):
        drive_slot(m, s + (slots - unsigned(2) - behind) * at.VEHICLE, c, lanes)


@spliced
def judge_all(m: Floats, s: int, r: int, c: Floats, lanes: int) -> None:
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
    drive_traffic(m, s, c, lanes)
    if special is not None:
        drive_fronts(m, s, c, lanes)
    drive_agent(m, s, c, lanes)
    if special is not None:
        keep_band(m, s, r, c, lanes)
        drive_shadow(m, s, r, c, lanes)


@spliced
def appraise(m: Floats, s: int, r: int, c: Floats, special: bool | None, lanes: int) -> None:
    """Write what the agents of a block measure, their outcomes and their rewards."""
    judge_all(m, s, r, c, lanes)
    if special is not None:
        judge_adversary(m, s, r, c, lanes)
    for agent in range(unsigned(c[at.AGENTS])):
        reward(m, s + agent * at.VEHICLE, c, lanes)
    if special is not None:
        reward_adversary(m, s, c, lanes)
