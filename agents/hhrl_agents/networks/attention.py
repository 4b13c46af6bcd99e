"""The compiled attention of the action network: how much each element of the state counts for the selected option.

I(s, o) = softmax(Linear(s) + Linear(o)), and the layers of the values read s^I = SIZE I * s (Figure 2 of the paper:
SIZE I * Linear(s)). SIZE keeps the elements at their scale: uniform weights change nothing. Traces of the state are
weighted like the elements that they follow.
"""

import numpy as np

from hhrl_agents.networks.arithmetic import ZERO, clear, exp, fma, matrix, stack
from hhrl_envs.arrays import Floats, Floats32, Ints
from hhrl_envs.observation import SIZE
from hhrl_envs.simulation.engine.compilation import inner

_SIZE = np.float32(SIZE)
_ROWS = 16  # whose exponentials are computed in one loop
_KEPT = _ROWS * SIZE


@inner
def attend(
    scored: Floats32,
    of_option: Floats32,
    states: Floats32,
    options: Ints,
    is_linear: bool,
    weights: Floats32,
    x: Floats32,
) -> None:
    """Write the weights I(s, o), [rows, SIZE], and s^I into the first columns of `x`, as many as `states` has.

    scored: Linear(s), [rows, SIZE]; of_option: the weight of the other linear layer, [options, SIZE]; is_linear:
    whether the weights are those of Linear(s).
    """
    for r in range(states.shape[0]):
        for j in range(SIZE):
            weights[r, j] = scored[r, j] + of_option[options[r], j]
    _softmax(weights)
    for r in range(states.shape[0]):
        for trace in range(0, states.shape[1], SIZE):
            for j in range(SIZE):
                element = scored[r, j] if is_linear and trace == 0 else states[r, trace + j]
                x[r, trace + j] = weights[r, j] * element * _SIZE


@inner
def _softmax(scores: Floats32) -> None:
    """Put the softmax of every row in its place, with the exponentials and their sum in float64."""
    kept = stack(_KEPT)
    for first in range(0, scores.shape[0], _ROWS):
        rows = min(_ROWS, scores.shape[0] - first)
        powers = matrix(kept, 0, rows, SIZE)
        for r in range(rows):
            highest = np.float32(-np.inf)
            for j in range(scores.shape[1]):
                highest = max(highest, scores[first + r, j])
            for j in range(scores.shape[1]):
                powers[r, j] = np.float64(scores[first + r, j]) - highest
        _exponentiate(matrix(kept, 0, 1, rows * SIZE))
        for r in range(rows):
            total = 0.0
            for j in range(scores.shape[1]):
                total += powers[r, j]
            for j in range(scores.shape[1]):
                scores[first + r, j] = np.float32(powers[r, j] / total)


@inner
def _exponentiate(numbers: Floats) -> None:
    """Raise e to each of the numbers, [1, size], in one long loop."""
    for n in range(numbers.shape[1]):
        numbers[0, n] = exp(numbers[0, n])


@inner
def attend_backward(
    slope: Floats32,
    attended: Floats32,
    weights: Floats32,
    options: Ints,
    features: int,
    is_linear: bool,
    scores: Floats32,
    of_option: Floats32,
) -> None:
    """Write the gradients by Linear(s), `scores`, and by the weight of the option's layer, given that by s^I, `slope`.

    attended: s^I; of both and the slope the first columns, `features`, count. The rest is as in `attend`.
    """
    clear(of_option)
    for r in range(weights.shape[0]):
        total = ZERO
        for j in range(SIZE):
            share = ZERO
            for trace in range(0, features, SIZE):
                share = fma(slope[r, trace + j], attended[r, trace + j], share)
            scores[r, j] = share
            total += share
        for j in range(SIZE):
            scores[r, j] = fma(-weights[r, j], total, scores[r, j])
            of_option[options[r], j] += scores[r, j]
            if is_linear:
                scores[r, j] = fma(slope[r, j] * weights[r, j], _SIZE, scores[r, j])
