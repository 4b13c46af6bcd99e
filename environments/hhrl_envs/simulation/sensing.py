"""What an agent measures, and how its sensors distort that."""

import numpy as np

from hhrl_envs.arrays import Floats, Floats32, Keys
from hhrl_envs.observation import ELEMENTS, SCALES, SYMBOLS
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import in_turn, inner, kernel, spliced, unsigned
from hhrl_envs.simulation.engine.layout import locate_row
from hhrl_envs.simulation.engine.random_streams import normal, stream, unit
from hhrl_envs.simulation.sub_goal_kernels import D_F, KERNELS, lose_front, meet_ghost
from hhrl_envs.sub_goals import SUB_GOALS

NOISE = 7  # purpose of the noise streams, a step each from here on
DROPOUTS = 1 << 32  # purpose of the streams of drop-outs, beyond those of the noise
GHOSTS = 2 << 32  # purpose of the streams of ghosts
EXACT = -1
_DERIVED = {symbol for goal in SUB_GOALS for symbol in (goal.critical, goal.ratio)}
_NOISE = {None: EXACT, "speed": at.NOISE_SPEED, "accel": at.NOISE_ACCEL, "distance": at.NOISE_DISTANCE}
# The elements that sensors measure, a channel each: its index in the state, which of the scenario's numbers is the
# standard deviation of its noise (or EXACT), and whether it is never negative.
CHANNELS = tuple(index for index, symbol in enumerate(SYMBOLS) if symbol not in _DERIVED)
NOISE_OF = tuple(_NOISE[ELEMENTS[index].noise] for index in CHANNELS)
NEVER_NEGATIVE = tuple(ELEMENTS[index].never_negative for index in CHANNELS)


@inner
def measure_ego(m: Floats, s: int, lanes: int) -> None:
    """Write the elements of the state that belong to no sub-goal."""
    for i in range(lanes):
        speed, accel, jerk = m[s + at.SPEED + i], m[s + at.ACCEL + i], m[s + at.JERK + i]
        m[s + at.V_E + i] = speed
        m[s + at.A_E + i] = accel
        m[s + at.J_E + i] = jerk


measure_sub_goals = in_turn(kernels.measure for kernels in KERNELS)
derive = in_turn(kernels.derive for kernels in KERNELS)


@spliced
def measure(m: Floats, s: int, c: Floats, lanes: int) -> None:
    """Write what the agents of record ``s`` measure, truthfully, and all other elements of the state."""
    measure_ego(m, s, lanes)
    measure_sub_goals(m, s, c, lanes)


@inner
def drops_out(keys: Keys, agent: int, step: int, row: int, c: Floats) -> bool:
    """Return whether an agent's front sensor drops out in a step: drawn for each window but the first.

    It is keyed by (seed, episode, agent, window), so it does not depend on the batch.
    """
    window = step // int(c[at.DROPOUT_STEPS])
    key = stream(keys[0, row], keys[1, row], unsigned(agent), unsigned(DROPOUTS))
    return window > 0 and unit(key, unsigned(window)) < c[at.DROPOUT]


@inner
def ghost_ahead(m: Floats, s: int, keys: Keys, row: int, c: Floats) -> float:
    """Return where the nearest ghost before the front vehicle of an agent stands; where there is none, infinity.

    It is keyed by (seed, episode, stretch of road), so all agents meet the same ghosts.
    """
    stretch, start, position = c[at.GHOST_STRETCH], -c[at.START_HIGH], m[s + at.POSITION]
    low, high = position + c[at.GHOST_NEAR], position + m[s + D_F]
    key = stream(keys[0, row], keys[1, row], unsigned(0), unsigned(GHOSTS))
    first = max(int((low - start) / stretch), 0)
    for number in range(first, max(int((high - start) / stretch) + 1, 0)):
        place: float = start + (number + unit(key, unsigned(2 * number + 1))) * stretch
        if low <= place < high and unit(key, unsigned(2 * number)) < c[at.GHOSTS]:
            return place
    return np.inf


@inner
def blur(m: Floats, s: int, history: Floats, keys: Keys, agent: int, step: int, row: int, c: Floats) -> None:
    """Replace what one agent measures by delayed and noisy values, and derive the other elements from them.

    ``s`` is the agent's record plus its lane. ``history``, float64 [delay + 1, channel, agent, row], is a ring of
    the last measurements; before there are enough, the first ones are shown. Noise is keyed by (seed, episode,
    agent, step, channel), so it does not depend on the batch.
    """
    size = history.shape[0]
    shown = max(step - (size - 1), 0) % size
    key = stream(keys[0, row], keys[1, row], unsigned(agent), unsigned(NOISE + step))
    for channel in range(len(CHANNELS)):
        place = s + at.MEASURED[CHANNELS[channel]]
        history[step % size, channel, agent, row] = m[place]
        deviation = 0.0 if NOISE_OF[channel] == EXACT else c[NOISE_OF[channel]]
        value = history[shown, channel, agent, row] + deviation * normal(key, channel)
        m[place] = max(value, 0.0) if NEVER_NEGATIVE[channel] else value
    derive(m, s, c)


@kernel
def derive_states(states: Floats, c: Floats) -> None:
    """Compute the elements of SI states, float64 [n, SIZE], that are not measured anew from those that are.

    ``c`` are the numbers of a scenario, see ``constants.pack``.
    """
    m = np.empty(at.VEHICLE)
    for row in range(states.shape[0]):
        for index in range(states.shape[1]):
            m[at.MEASURED[index]] = states[row, index]
        derive(m, unsigned(0), c)
        for index in range(states.shape[1]):
            states[row, index] = m[at.MEASURED[index]]


@kernel
def blur_rows(
    m: Floats, c: Floats, observations: Floats32, keys: Keys, history: Floats, rows: int, low: int, high: int
) -> None:
    """Write the observations of the blocks from low to high as the sensors see them.

    ``history``, float64 [delay + 1, channel, agent, row], remembers the last measurements, drop-outs and ghosts
    included: a delay delays them too.
    """
    flickers, haunted = c[at.DROPOUT] > 0.0, c[at.GHOSTS] > 0.0
    for row in range(low * at.LANES, min(high * at.LANES, rows)):
        s, r = locate_row(row, c)
        step = int(m[r + at.STEPS])
        for agent in range(observations.shape[1]):
            measure(m, s, c, unsigned(1))
            if haunted:
                place = ghost_ahead(m, s, keys, row, c)
                if place < np.inf:
                    meet_ghost(m, s, place)
            if flickers and drops_out(keys, agent, step, row, c):
                lose_front(m, s, c)
            blur(m, s, history, keys, agent, step, row, c)
            observe(m, s, observations, agent, unsigned(row), unsigned(1))
            s += at.VEHICLE


@inner
def observe(m: Floats, s: int, out: Floats32, agent: int, first: int, lanes: int) -> None:
    """Write the observations of the agents of record ``s`` to ``out``, float32 [SIZE, agent, row], row ``first`` on."""
    for index in range(out.shape[0]):
        measured, scale = s + at.MEASURED[0] + unsigned(index * at.STRIDE), SCALES[index]
        for i in range(lanes):
            out[index, agent, first + i] = m[measured + i] * scale
