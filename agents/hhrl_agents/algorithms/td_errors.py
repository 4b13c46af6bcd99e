"""Temporal-difference learning in compiled code: the errors of a level's values, their gradients, and Adam's steps.

One call takes a whole gradient step at every level. O* = argmax_o Q^o(s', o) and Y^o = r^o + gamma Q^o'(s', O*);
A* = argmax_a Q^a(s'^I, O*, a) and Y^a = r^a + gamma Q^a'(s'^I, O*, A*), where a prime on Q marks the target network
(Eq. (qo), (qa)). A flat method has the action level alone (Eq. (ddqn)). A level that is given has no values: O* is then
what the rule selects at s'.
"""

from typing import NamedTuple

import numpy as np

from hhrl_agents.networks.arithmetic import ZERO, block, clear
from hhrl_agents.networks.layers import FAN_IN, FAN_OUT, FEATURES, OUTPUTS, backward, forward
from hhrl_agents.networks.parameters import Memory, advance_powers, descend
from hhrl_agents.replay.buffer import DISCOUNT, NUMBERS, OPTIONS, REWARDS
from hhrl_envs.arrays import Floats, Floats32, Ints
from hhrl_envs.simulation.engine.compilation import inner, kernel, spliced


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


Levels = tuple[Level, Level]
"""The option level and the action level."""


class Room(NamedTuple):
    """Room for what a step computes on the way: two workspaces of `capacity` rows, one weight, and M numbers a time.

    M is the capacity. choices: int64 [4, M], the options, those at the next states, the choices of a level and the best
    ones at the next states; numbers: float32 [2, M], the next states' values, and what choices fall short of the best.
    """

    capacity: int
    work: Floats32
    slopes: Floats32
    scratch: Floats32
    choices: Ints
    numbers: Floats32


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
    """What a step finds at each level that learns: errors Y - Q, float32 [levels, M], mean losses, largest |Q|.

    A level's errors are those of its own mini-batch; the other columns have no meaning.
    """

    errors: Floats32
    losses: Floats
    largest: Floats


def make_room(widths: list[int], layouts: list[Ints], capacity: int) -> Room:
    """Return room for networks with these widths of a workspace's row and these layouts."""
    width = max(widths)
    largest = max(int((layout[1:, FAN_IN] * layout[1:, FAN_OUT]).max()) for layout in layouts)
    work, slopes = (np.zeros(width * capacity, np.float32) for _ in range(2))
    choices, numbers = np.zeros((4, capacity), np.int64), np.zeros((2, capacity), np.float32)
    return Room(capacity, work, slopes, np.zeros(largest, np.float32), choices, numbers)


_NEXT_ONLINE, _NEXT_TARGET, _TARGET, _ONLINE = range(4)  # forward passes: of the next states, then of the states


@kernel
def learn(memory: Memory, levels: Levels, batch: Batch, room: Room, settings: Settings, found: Found) -> None:
    """Take one gradient step at every level that learns, the option level first."""
    count = batch.indices.size
    options, next_options, choices, best = room.choices[0], room.choices[1], room.choices[2], room.choices[3]
    next_values, shortfalls = room.numbers[0], room.numbers[1]
    _read_column(batch, OPTIONS, options)
    for m in range(count):
        next_options[m], shortfalls[m] = batch.given[m], ZERO
    advance_powers(memory.powers)
    place = 0
    for level in levels:  # the passes and the levels take turns in loops, so that each kernel is inlined once
        if level.layout.shape[0] == 0:
            continue
        _read_column(batch, OPTIONS + level.column, choices)
        for step in range(4):
            if not _is_needed(step, level, settings):
                continue
            ahead, is_online = step <= _NEXT_TARGET, step in (_NEXT_ONLINE, _ONLINE)
            # O* is needed for the mini-batches of all levels, all else for a level's own; the option's is first
            whole = not level.learns or (level.column == 0 and step == _NEXT_ONLINE)
            begin = 0 if whole else batch.firsts[place]
            size = count if whole else batch.weights.shape[1]
            if not _has_loaded(step, settings):
                _load(batch, ahead, level, room, begin, size)
            values = forward(
                memory.online if is_online else memory.target,
                level.layout,
                room.work,
                room.capacity,
                size,
                next_options[begin:] if ahead else options[begin:],
            )
            _read_values(step, level, values, choices, best, next_values, shortfalls, begin, size)
        if level.learns:
            begin, size = batch.firsts[place], batch.weights.shape[1]
            own = found.errors[place, begin:]
            _write_errors(level, batch, values, choices, next_values, shortfalls, settings, own, begin, size)
            found.largest[place] = _largest(values)
            found.losses[place] = regress(
                memory,
                level,
                own,
                choices[begin:],
                options[begin:],
                0,
                batch.weights[place],
                room,
                settings,
            )
            place += 1
        if level.column == 0:
            for m in range(count):
                next_options[m] = best[m]


@spliced
def _is_needed(step: int, level: Level, settings: Settings) -> bool:
    """Return whether a level needs a forward pass: one that does not learn needs its best choices alone."""
    return step == _NEXT_ONLINE or (level.learns and (step != _TARGET or settings.alpha > 0.0))


@spliced
def _has_loaded(step: int, settings: Settings) -> bool:
    """Return whether the pass before has left its states in the workspace, and this one reads the same."""
    return step == _NEXT_TARGET or (step == _ONLINE and settings.alpha > 0.0)


@spliced
def _read_values(
    step: int,
    level: Level,
    values: Floats32,
    choices: Ints,
    best: Ints,
    next_values: Floats32,
    shortfalls: Floats32,
    begin: int,
    size: int,
) -> None:
    """Write what a forward pass is for: best choices, the next states' values, or what choices fall short of the best.

    All are [M], given the values [M, C] of the pass.
    """
    for k in range(size):
        m = begin + k
        if step == _NEXT_ONLINE:
            best[m] = _best(values, k, level.mask)
        elif step == _NEXT_TARGET:
            next_values[m] = values[k, best[m]]
        elif step == _TARGET:
            shortfalls[m] = values[k, _best(values, k, level.mask)] - values[k, choices[m]]


@spliced
def _write_errors(
    level: Level,
    batch: Batch,
    values: Floats32,
    choices: Ints,
    next_values: Floats32,
    shortfalls: Floats32,
    settings: Settings,
    errors: Floats32,
    begin: int,
    size: int,
) -> None:
    """Write Y - Q, less alpha times what a choice falls short of the best one, [M]."""
    alpha = np.float32(settings.alpha)
    rows, numbers = batch.rows, batch.rows.shape[1] - NUMBERS
    for k in range(size):
        m = begin + k
        row = batch.indices[m]
        target = rows[row, numbers + REWARDS + level.column] + rows[row, numbers + DISCOUNT] * next_values[m]
        errors[k] = target - values[k, choices[m]] - alpha * shortfalls[m]


@spliced
def _read_column(batch: Batch, number: int, column: Ints) -> None:
    """Write a whole number of every transition, int64 [M]."""
    place = batch.rows.shape[1] - NUMBERS + number
    for m in range(batch.indices.size):
        column[m] = np.int64(batch.rows[batch.indices[m], place])


@spliced
def regress(
    memory: Memory,
    level: Level,
    errors: Floats32,
    choices: Ints,
    options: Ints,
    first: int,
    weights: Floats32,
    room: Room,
    settings: Settings,
) -> float:
    """Return the weighted mean squared error of the rows from `first` on, K, after a step of Adam down it.

    weights: of the squared errors, float32 [K]. The online network's forward pass of these states lies in `room`.
    """
    size = weights.size
    last = level.layout[level.layout.shape[0] - 1]
    slopes = block(room.slopes, room.capacity, last[OUTPUTS], size, last[FAN_OUT], first)
    clear(slopes)
    loss, factor = 0.0, np.float32(-2.0 / size)
    for k in range(size):
        weighted = errors[first + k] * weights[k]
        slopes[k, choices[first + k]] = weighted * factor
        loss += np.float64(weighted) * np.float64(errors[first + k])
    backward(
        memory.online,
        level.layout,
        room.work,
        room.slopes,
        room.scratch,
        memory.gradient,
        room.capacity,
        first,
        size,
        options,
    )
    descend(memory, level.first, level.last, settings.learning_rate, settings.max_norm)
    return loss / size


@spliced
def _load(batch: Batch, ahead: bool, level: Level, room: Room, begin: int, size: int) -> None:
    """Write the transitions' states, or the next ones if `ahead`, into the workspace's first block."""
    features = level.layout[0, FEATURES]
    states = block(room.work, room.capacity, 0, size, features)
    for m in range(size):
        row = batch.indices[begin + m]
        for f in range(features):
            states[m, f] = batch.rows[row, f + features] if ahead else batch.rows[row, f]


@inner
def _largest(values: Floats32) -> float:
    """Return the largest absolute value."""
    largest = 0.0
    for m in range(values.shape[0]):
        for choice in range(values.shape[1]):
            largest = max(largest, abs(np.float64(values[m, choice])))
    return largest


@inner
def _best(values: Floats32, m: int, mask: Floats32) -> int:
    """Return the choice of the highest value in row `m`, the first one on a tie."""
    best = 0
    for choice in range(1, values.shape[1]):
        if values[m, choice] + mask[choice] > values[m, best] + mask[best]:
            best = choice
    return best
