"""The compiled value network: attention where it has some, fully connected layers, and the gradients of both.

A network is a row of numbers, its parameters, and a `layout` that says where in it they lie. What a forward pass
leaves for the backward pass lies in a workspace of `capacity` rows: each of its blocks is [rows, width], one row a
state. One compiled function serves every architecture.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import prod

import numpy as np

from hhrl_agents.networks.architectures import NUM_OPTIONS, Architecture, Attended
from hhrl_agents.networks.arithmetic import ONE, ZERO, block, clear, fma, matrix
from hhrl_agents.networks.attention import attend, attend_backward
from hhrl_agents.networks.products import add_product, write_outer
from hhrl_envs.arrays import Floats32, Ints
from hhrl_envs.observation import SIZE, SYMBOLS
from hhrl_envs.simulation.engine.compilation import inner, kernel, spliced
from hhrl_envs.sub_goals import SSL

_LINEAR = int(Attended.LINEAR)
_LINE = tuple(SYMBOLS.index(element.symbol) for element in SSL.elements)
_EPSILON = np.float32(1e-5)  # what layer normalisation adds to the variance

# Columns of the layout; places of blocks are per row of the workspace. A row is a fully connected layer: the first one
# that of the attention, where there is some, the others those of the values.
WEIGHT, BIAS, FAN_IN, FAN_OUT, INPUTS, OUTPUTS, NORMS, FACTORS = range(8)
# More columns of the first row, which are the whole network's. Its layer reads the state itself: where a layer has its
# inputs, it leaves the weights I(s, o).
FEATURES, READS_OPTION, ATTENDED, LAYER_NORM, SEES_LINE, OPTION_WEIGHT = range(8, 14)
WEIGHTS, SCORED = INPUTS, OUTPUTS
_COLUMNS = 14


def layout_of(architecture: Architecture, first: int = 0) -> tuple[Ints, int]:
    """Return the layout, int64 [1 + layers, columns], of a network, and how many numbers a row of its workspace has.

    first: where among the parameters its own begin.
    """
    shapes = architecture.shapes()
    starts = dict(zip(shapes, np.cumsum([first, *map(prod, shapes.values())]).tolist(), strict=False))
    sizes = architecture.sizes
    layout = np.zeros((len(sizes), _COLUMNS), np.int64)
    layout[0, FEATURES : SEES_LINE + 1] = architecture.features, *map(int, architecture[3:])
    place = architecture.features  # of the state as it is seen, which is the first block
    if architecture.attended:
        weight, bias = starts["attention.state.weight"], starts["attention.state.bias"]
        layout[0, : OUTPUTS + 1] = weight, bias, SIZE, SIZE, place, place + SIZE
        layout[0, OPTION_WEIGHT] = starts["attention.option.weight"]
        place += 2 * SIZE
    prefix = "values." if architecture.reads_option else ""
    for layer, (fan_in, fan_out) in enumerate(pairwise(sizes)):
        weight, bias = starts[f"{prefix}{layer}.weight"], starts[f"{prefix}{layer}.bias"]
        outputs = place + fan_in
        layout[1 + layer, : OUTPUTS + 1] = weight, bias, fan_in, fan_out, place, outputs
        place = outputs
    place += sizes[-1]
    if architecture.layer_norm:
        for layer, width in enumerate(architecture.hidden):
            layout[1 + layer, [NORMS, FACTORS]] = place, place + width
            place += width + 1
    return layout, place


@spliced
def values_of(layout: Ints, work: Floats32, capacity: int, rows: int) -> Floats32:
    """Return the outputs that a forward pass left, [rows, outputs], a view."""
    last = layout[layout.shape[0] - 1]
    values: Floats32 = block(work, capacity, last[OUTPUTS], rows, last[FAN_OUT])
    return values


@inner
def forward(parameters: Floats32, layout: Ints, work: Floats32, capacity: int, rows: int, options: Ints) -> Floats32:
    """Return the values [rows, outputs] of the states that lie in the workspace's first block.

    options: int64 [rows], read by networks that read one.
    """
    states = block(work, capacity, 0, rows, layout[0, FEATURES])
    attends = layout[0, ATTENDED] > 0
    _read_state(layout, work, capacity, states, options)
    for layer in range(0 if attends else 1, layout.shape[0]):
        at = layout[layer]
        x = block(work, capacity, at[INPUTS], rows, at[FAN_IN]) if layer > 0 else states
        y = block(work, capacity, at[OUTPUTS], rows, at[FAN_OUT])
        _fill_rows(y, matrix(parameters, at[BIAS], 1, at[FAN_OUT]))
        add_product(x, matrix(parameters, at[WEIGHT], at[FAN_IN], at[FAN_OUT]), y)
        if layer == 0:
            first = layout[1]
            inputs = block(work, capacity, first[INPUTS], rows, first[FAN_IN])
            of_option = matrix(parameters, layout[0, OPTION_WEIGHT], NUM_OPTIONS, SIZE)
            weights = block(work, capacity, at[WEIGHTS], rows, SIZE)
            attend(y, of_option, states, options, at[ATTENDED] == _LINEAR, weights, inputs)
        elif layer < layout.shape[0] - 1:
            if layout[0, LAYER_NORM]:
                norms = block(work, capacity, at[NORMS], rows, at[FAN_OUT])
                _normalise(y, norms, block(work, capacity, at[FACTORS], rows, 1))
            _rectify(y)
    return values_of(layout, work, capacity, rows)


@spliced
def _read_state(layout: Ints, work: Floats32, capacity: int, states: Floats32, options: Ints) -> None:
    """Write into the inputs of the values' first layer the one-hot option, and the state unless attention will."""
    rows, features, first = states.shape[0], states.shape[1], layout[1]
    if not layout[0, SEES_LINE]:
        _hide_line(states)
    x = block(work, capacity, first[INPUTS], rows, first[FAN_IN])
    if not layout[0, ATTENDED]:
        for r in range(rows):
            for f in range(features):
                x[r, f] = states[r, f]
    if layout[0, READS_OPTION]:
        for r in range(rows):
            for option in range(NUM_OPTIONS):
                x[r, features + option] = ONE if option == options[r] else ZERO


@inner
def _fill_rows(y: Floats32, bias: Floats32) -> None:
    """Write the bias, [1, width], into every row.

    A loop of its own vectorises, because nothing that it reads can change in it.
    """
    for r in range(y.shape[0]):
        for j in range(y.shape[1]):
            y[r, j] = bias[0, j]


@inner
def _rectify(y: Floats32) -> None:
    for r in range(y.shape[0]):
        for j in range(y.shape[1]):
            y[r, j] = max(y[r, j], ZERO)


@spliced
def _hide_line(states: Floats32) -> None:
    for r in range(states.shape[0]):
        for trace in range(states.shape[1] // SIZE):
            for element in _LINE:
                states[r, trace * SIZE + element] = ZERO


@inner
def _normalise(y: Floats32, norms: Floats32, factors: Floats32) -> None:
    """Make the mean of every row 0 and its variance 1; keep the outputs and the factors that scaled them."""
    width = np.float32(y.shape[1])
    for r in range(y.shape[0]):
        mean = variance = ZERO
        for j in range(y.shape[1]):
            mean += y[r, j]
        mean /= width
        for j in range(y.shape[1]):
            centred = y[r, j] - mean
            variance = fma(centred, centred, variance)
        factors[r, 0] = ONE / np.sqrt(variance / width + _EPSILON)
        for j in range(y.shape[1]):
            y[r, j] = (y[r, j] - mean) * factors[r, 0]
            norms[r, j] = y[r, j]


@kernel
def evaluate(
    parameters: Floats32, layout: Ints, work: Floats32, capacity: int, states: Floats32, options: Ints, values: Floats32
) -> None:
    """Write the values [B, outputs] of states [B, features] and options int64 [B], `capacity` rows at a time."""
    for begin in range(0, states.shape[0], capacity):
        rows = min(capacity, states.shape[0] - begin)
        seen = block(work, capacity, 0, rows, layout[0, FEATURES])
        for r in range(rows):
            for f in range(seen.shape[1]):
                seen[r, f] = states[begin + r, f]
        found = forward(parameters, layout, work, capacity, rows, options[begin : begin + rows])
        for r in range(rows):
            for j in range(found.shape[1]):
                values[begin + r, j] = found[r, j]


@inner
def backward(
    parameters: Floats32,
    layout: Ints,
    work: Floats32,
    slopes: Floats32,
    scratch: Floats32,
    gradient: Floats32,
    capacity: int,
    first: int,
    rows: int,
    options: Ints,
) -> None:
    """Write the gradient by the parameters of the loss whose gradient by the values lies in `slopes`' last block.

    Only the rows `first` to `first + rows` of the forward pass count. slopes: a workspace like `work`; scratch: room
    for the largest weight; options: int64 [capacity], as in the forward pass.
    """
    for back in range(1, layout.shape[0]):
        layer = layout.shape[0] - back
        at = layout[layer]
        x = block(work, capacity, at[INPUTS], rows, at[FAN_IN], first)
        slope = block(slopes, capacity, at[OUTPUTS], rows, at[FAN_OUT], first)
        write_outer(x, slope, matrix(gradient, at[WEIGHT], at[FAN_IN], at[FAN_OUT]))
        _sum_rows(slope, matrix(gradient, at[BIAS], 1, at[FAN_OUT]))
        if layer == 1 and not layout[0, ATTENDED]:
            return
        turned = matrix(scratch, 0, at[FAN_OUT], at[FAN_IN])
        weight = matrix(parameters, at[WEIGHT], at[FAN_IN], at[FAN_OUT])
        _turn(weight, turned)
        before = block(slopes, capacity, at[INPUTS], rows, at[FAN_IN], first)
        clear(before)
        add_product(slope, turned, before)
        if layer > 1:
            _stop_at_zero(before, x)
            if layout[0, LAYER_NORM]:
                last = layout[layer - 1]
                norms = block(work, capacity, last[NORMS], rows, last[FAN_OUT], first)
                _denormalise(before, norms, block(work, capacity, last[FACTORS], rows, 1, first))
    _backward_of_attention(layout, work, slopes, gradient, capacity, first, rows, options)


@inner
def _turn(weight: Floats32, turned: Floats32) -> None:
    for j in range(turned.shape[0]):
        for i in range(turned.shape[1]):
            turned[j, i] = weight[i, j]


@inner
def _stop_at_zero(slope: Floats32, outputs: Floats32) -> None:
    """Set the gradient by outputs of a ReLU to zero where they are."""
    for r in range(slope.shape[0]):
        for i in range(slope.shape[1]):
            slope[r, i] = slope[r, i] if outputs[r, i] > ZERO else ZERO


@inner
def _sum_rows(slope: Floats32, out: Floats32) -> None:
    """Write the sum of the rows, [1, width]."""
    clear(out)
    for r in range(slope.shape[0]):
        for j in range(slope.shape[1]):
            out[0, j] += slope[r, j]


@inner
def _denormalise(slope: Floats32, norms: Floats32, factors: Floats32) -> None:
    """Turn the gradient by the outputs of a normalisation into that by its inputs."""
    width = np.float32(slope.shape[1])
    for r in range(slope.shape[0]):
        mean = along = ZERO
        for j in range(slope.shape[1]):
            mean += slope[r, j]
            along = fma(slope[r, j], norms[r, j], along)
        mean, along = mean / width, along / width
        for j in range(slope.shape[1]):
            slope[r, j] = (slope[r, j] - mean - norms[r, j] * along) * factors[r, 0]


@spliced
def _backward_of_attention(
    layout: Ints,
    work: Floats32,
    slopes: Floats32,
    gradient: Floats32,
    capacity: int,
    first: int,
    rows: int,
    options: Ints,
) -> None:
    """Write the gradient by the attention's parameters, given that by s^I in the slopes of the first layer's inputs."""
    features, at = layout[0, FEATURES], layout[1]
    scores = block(slopes, capacity, layout[0, SCORED], rows, SIZE, first)
    attend_backward(
        block(slopes, capacity, at[INPUTS], rows, at[FAN_IN], first),
        block(work, capacity, at[INPUTS], rows, at[FAN_IN], first),
        block(work, capacity, layout[0, WEIGHTS], rows, SIZE, first),
        options[first : first + rows],
        features,
        layout[0, ATTENDED] == _LINEAR,
        scores,
        matrix(gradient, layout[0, OPTION_WEIGHT], NUM_OPTIONS, SIZE),
    )
    states = block(work, capacity, 0, rows, features, first)
    write_outer(states, scores, matrix(gradient, layout[0, WEIGHT], SIZE, SIZE))
    _sum_rows(scores, matrix(gradient, layout[0, BIAS], 1, SIZE))


class ValueNetwork:
    """A network that evaluates the parameters at `first` of a row of numbers, float32 [P]."""

    _CAPACITY = 64

    def __init__(self, architecture: Architecture, parameters: Floats32, first: int = 0) -> None:
        self._parameters, self._architecture = parameters, architecture
        self._layout, self._width = layout_of(architecture, first)

    def values(self, states: Floats32, options: Ints | None = None) -> Floats32:
        """Return the values, float32 [B, outputs], of states [B, features] and options int64 [B] if it reads them."""
        return self._evaluate(states, options, self._CAPACITY)[0]

    def attention(self, states: Floats32, options: Ints) -> Floats32:
        """Return the attention weights I(s, o), float32 [B, SIZE]; uniform without attention.

        states: [B, SIZE] or more; traces of the state do not count.
        """
        rows = len(states)
        if not self._architecture.attended:
            return np.full((rows, SIZE), 1 / SIZE, np.float32)
        whole = np.zeros((rows, self._architecture.features), np.float32)
        whole[:, :SIZE] = states[:, :SIZE]
        _, work = self._evaluate(whole, options, rows)
        first = self._layout[0, WEIGHTS] * rows
        return work[first : first + rows * SIZE].reshape(rows, SIZE)

    def _evaluate(self, states: Floats32, options: Ints | None, capacity: int) -> tuple[Floats32, Floats32]:
        """Return the values, and the workspace of `capacity` rows that the forward pass of the last ones left."""
        values = np.empty((len(states), self._architecture.outputs), np.float32)
        work = np.empty(self._width * capacity, np.float32)
        options = np.zeros(len(states), np.int64) if options is None else np.ascontiguousarray(options, np.int64)
        states = np.ascontiguousarray(states, np.float32)
        evaluate(self._parameters, self._layout, work, capacity, states, options, values)
        return values, work


def flattened(parameters: Sequence[Floats32]) -> Floats32:
    """Return these parameters in one row of numbers, float32 [P]."""
    return np.concatenate([np.ravel(value) for value in parameters]).astype(np.float32)
