"""Temporal-difference learning in compiled code: the errors of a level's values, their gradients, and Adam's steps.

One call takes a whole gradient step at every level. O* = argmax_o Q^o(s', o) and Y^o = r^o + gamma Q^o'(s', O*);
A* = argmax_a Q^a(s'^I, O*, a) and Y^a = r^a + gamma Q^a'(s'^I, O*, A*), where a prime on Q marks the target network
(Eq. (qo), (qa)). A flat method has the action level alone (Eq. (ddqn)). A level that is given has no values: O* is then
what the rule selects at s'.
"""

from typing import NamedTuple

import numpy as np

from hhrl_agents.networks.arithmetic import ZERO
from hhrl_agents.networks.layers import FAN_IN, FAN_OUT, FEATURES, backward, block, forward, values_of
from hhrl_agents.networks.parameters import Memory, advance_powers, descend
from hhrl_agents.replay.buffer import ACTIONS, DISCOUNT, NUMBERS, OPTIONS, REWARDS
from hhrl_envs.arrays import Floats, Floats32, Ints
from hhrl_envs.simulation.engine.compilation import inner, kernel


class Level(NamedTuple):
    """One level of a method.

    column: of its reward among those of a transition. layout: of its network; no rows where the level is given. mask:
    float32 [C], what is added to the values of its choices, -infinity for an absent one. learns: whether its
    parameters, `first` to `last` in the row of all, move.
    """

    column: int
    layout: Ints
    mask: Floats32
    learns: bool
    first: int
    last: int


class Room(NamedTuple):
    """Room for what a step computes on the way: three workspaces of `capacity` rows, and one weight."""

    capacity: int
    online: Floats32
    target: Floats32
    slopes: Floats32
    scratch: Floats32


class Batch(NamedTuple):
    """Mini-batches of K transitions, one or one for each level, M in all, side by side.

    rows: the replay's, float32 [capacity, numbers]; indices: int64 [M]; given: int64 [M], the options at next states
    where the option level has no network; firsts: int64 [levels], where in the M each level's K begin; weights: float32
    [levels, K], what squared errors are multiplied with. Both have a row for each level that learns.
    """

    rows: Floats32
    indices: Ints
    given: Ints
    firsts: Ints
    weights: Floats32


class Settings(NamedTuple):
    """The hyperparameters of a step: alpha of advantage learning, Adam's learning rate, the bound of gradients."""

    alpha: float
    learning_rate: float
    max_norm: float


class Found(NamedTuple):
    """What a step finds at each level that learns: errors Y - Q, float32 [levels, M], mean losses, largest |Q|."""

    errors: Floats32
    losses: Floats
    largest: Floats


def make_room(widths: list[int], layouts: list[Ints], capacity: int) -> Room:
    """Return room for networks with these widths of a workspace's row and these layouts."""
    width = max(widths)
    largest = max(int((layout[1:, FAN_IN] * layout[1:, FAN_OUT]).max()) for layout in layouts)
    online, target, slopes = (np.zeros(width * capacity, np.float32) for _ in range(3))
    return Room(capacity, online, target, slopes, np.zeros(largest, np.float32))


@kernel
def learn(
    memory: Memory, option: Level, action: Level, batch: Batch, room: Room, settings: Settings, found: Found
) -> None:
    """Take one gradient step at every level that learns."""
    count, numbers = batch.indices.size, batch.rows.shape[1] - NUMBERS
    advance_powers(memory.powers)
    options, actions = np.empty(count, np.int64), np.empty(count, np.int64)
    for m in range(count):
        row = batch.rows[batch.indices[m]]
        options[m], actions[m] = int(row[numbers + OPTIONS]), int(row[numbers + ACTIONS])
    best, values = batch.given.copy(), np.zeros(count, np.float32)
    if option.layout.shape[0]:
        _follow(memory, option, batch, batch.given, room, best, values)
    if option.learns:
        _learn_level(memory, option, batch, values, options, options, 0, room, settings, found)
    if action.learns:
        greedy, place = np.empty(count, np.int64), int(option.learns)
        _follow(memory, action, batch, best, room, greedy, values)
        _learn_level(memory, action, batch, values, options, actions, place, room, settings, found)


@inner
def _follow(
    memory: Memory, level: Level, batch: Batch, options: Ints, room: Room, best: Ints, values: Floats32
) -> None:
    """Write the online network's best choices at the next states, and the target network's values of them, [M] each."""
    count, features = batch.indices.size, level.layout[0, FEATURES]
    _load(batch, features, features, room.online, room.capacity)
    _load(batch, features, features, room.target, room.capacity)
    online = forward(memory.online, level.layout, room.online, room.capacity, count, options)
    target = forward(memory.target, level.layout, room.target, room.capacity, count, options)
    for m in range(count):
        best[m] = _best(online[m], level.mask)
        values[m] = target[m, best[m]]


@inner
def _learn_level(
    memory: Memory,
    level: Level,
    batch: Batch,
    values: Floats32,
    options: Ints,
    choices: Ints,
    place: int,
    room: Room,
    settings: Settings,
    found: Found,
) -> None:
    """Write the errors of the values of `choices` [M], and move the level's parameters down those of its mini-batch.

    values: what the next states are worth; options: what the network reads; place: of the level among those that learn.
    """
    count, features = batch.indices.size, level.layout[0, FEATURES]
    _load(batch, 0, features, room.online, room.capacity)
    online = forward(memory.online, level.layout, room.online, room.capacity, count, options)
    errors, reward = found.errors[place], 2 * features + REWARDS + level.column
    found.largest[place] = 0.0
    for m in range(count):
        row = batch.rows[batch.indices[m]]
        errors[m] = row[reward] + row[2 * features + DISCOUNT] * values[m] - online[m, choices[m]]
        for choice in range(online.shape[1]):
            found.largest[place] = max(found.largest[place], abs(np.float64(online[m, choice])))
    if settings.alpha > 0.0:
        _load(batch, 0, features, room.target, room.capacity)
        target = forward(memory.target, level.layout, room.target, room.capacity, count, options)
        for m in range(count):
            short = target[m, _best(target[m], level.mask)] - target[m, choices[m]]
            errors[m] -= np.float32(settings.alpha) * short
    first, size = batch.firsts[place], batch.weights.shape[1]
    found.losses[place] = regress(
        memory, level, errors, choices, options, first, size, batch.weights[place], room, settings
    )


@inner
def regress(
    memory: Memory,
    level: Level,
    errors: Floats32,
    choices: Ints,
    options: Ints,
    first: int,
    size: int,
    weights: Floats32,
    room: Room,
    settings: Settings,
) -> float:
    """Return the weighted mean squared error of the rows `first` to `first + size` after a step of Adam down it.

    The forward pass of these states lies in `room.online`.
    """
    slopes = values_of(level.layout, room.slopes, room.capacity, first + size)
    slopes[first:] = ZERO
    loss, factor = 0.0, np.float32(-2.0 / size)
    for k in range(size):
        weighted = errors[first + k] * weights[k]
        slopes[first + k, choices[first + k]] = weighted * factor
        loss += np.float64(weighted) * np.float64(errors[first + k])
    backward(
        memory.online,
        level.layout,
        room.online,
        room.slopes,
        room.scratch,
        memory.gradient,
        room.capacity,
        first,
        size,
        options,
    )
    part = slice(level.first, level.last)
    descend(
        memory.online[part],
        memory.gradient[part],
        memory.mean[part],
        memory.variance[part],
        memory.powers,
        settings.learning_rate,
        settings.max_norm,
    )
    return loss / size


@inner
def _load(batch: Batch, column: int, features: int, work: Floats32, capacity: int) -> None:
    """Write the states that begin at a column of the transitions into a workspace's first block."""
    states = block(work, capacity, 0, batch.indices.size, features)
    for m in range(batch.indices.size):
        row = batch.rows[batch.indices[m]]
        for f in range(features):
            states[m, f] = row[column + f]


@inner
def _best(values: Floats32, mask: Floats32) -> int:
    """Return the choice of the highest value, the first one on a tie."""
    best = 0
    for choice in range(1, values.size):
        if values[choice] + mask[choice] > values[best] + mask[best]:
            best = choice
    return best
