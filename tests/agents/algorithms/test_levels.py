"""One learned level: double Q-learning's choice, and what advantage learning does to targets."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_agents.agent import OPTION
from hhrl_agents.algorithms.td_errors import Batch, Found, Level, Settings, learn, make_room
from hhrl_agents.networks.architectures import Architecture
from hhrl_agents.networks.layers import layout_of
from hhrl_agents.networks.parameters import Adam, Memory
from hhrl_envs.arrays import Floats32, Ints
from hhrl_envs.observation import SIZE

CHOICES, COUNT = 3, 30
ABSENT = Level(1, np.zeros((0, 0), np.int64), np.zeros(1, np.float32), learns=False, first=0, last=0)
Array = NDArray[np.float64]


class Steps(NamedTuple):
    """Transitions: states [K, SIZE], choices int64 [K], rewards [K], discounts [K] and next states [K, SIZE]."""

    states: Array
    choices: Ints
    rewards: Array
    discounts: Array
    following: Array


def errors_of(
    network: Architecture, online: Array, target: Array, steps: Steps, alpha: float = 0.0, absent: tuple[int, ...] = ()
) -> Floats32:
    """The errors [K] of a level with these parameters, of which the `absent` choices are not there."""
    count = len(steps.choices)
    layout, width = layout_of(network)
    flat = online.astype(np.float32)
    mask = np.zeros(network.outputs, np.float32)
    mask[list(absent)] = -np.inf
    adam = Adam(flat.size)
    memory = Memory(flat, target.astype(np.float32), adam.gradient, adam.mean, adam.variance, adam.powers)
    level = Level(OPTION, layout, mask, learns=True, first=0, last=flat.size)
    numbers = (steps.rewards, np.full(count, 7.0), steps.discounts, steps.choices, np.zeros(count))
    rows = np.concatenate((steps.states, steps.following, np.stack(numbers, axis=1)), axis=1).astype(np.float32)
    weights = np.ones((1, count), np.float32)
    batch = Batch(rows, np.arange(count), np.zeros(count, np.int64), np.zeros(1, np.int64), weights)
    found = Found(np.zeros((1, count), np.float32), np.zeros(1), np.zeros(1))
    learn(memory, (level, ABSENT), batch, make_room([width], [layout], count), Settings(alpha, 0.0, 1.0), found)
    np.testing.assert_array_equal(memory.online, online.astype(np.float32))
    errors: Floats32 = found.errors[0]
    return errors


TABLE = Architecture(SIZE, (), CHOICES)
"""A network that is a table: its values at the k-th unit vector are the k-th row of its weight."""


def tabular(values: Any) -> Array:
    """The parameters of a table whose first rows are these values, [states, CHOICES]."""
    weight = np.zeros((SIZE, CHOICES))
    weight[: len(values)] = values
    return np.concatenate((weight.ravel(), np.zeros(CHOICES)))


def at(states: Any) -> Array:
    unit: Array = np.eye(SIZE)[np.asarray(states)]
    return unit


def error(online: Any, target: Any, choice: int, alpha: float = 0.0, absent: tuple[int, ...] = ()) -> float:
    """The error of a choice at state 0, whose values are zero online; the values of states 0 and 1 are `target`'s.

    online: the values of state 1, which follows.
    """
    steps = Steps(at([0]), np.array([choice]), np.zeros(1), np.ones(1), at([1]))
    return float(errors_of(TABLE, tabular([np.zeros(CHOICES), online]), tabular(target), steps, alpha, absent)[0])


def test_double_q_takes_the_target_s_value_of_the_online_s_choice() -> None:
    assert error([1.0, 5.0, 2.0], [[0.0] * 3, [10.0, 20.0, 30.0]], 0) == 20.0


def test_the_first_of_equal_values_is_the_best() -> None:
    assert error([5.0, 5.0, 2.0], [[0.0] * 3, [1.0, 2.0, 3.0]], 0) == 1.0


def test_an_absent_choice_is_not_the_best_one() -> None:
    assert error([1.0, 5.0, 2.0], [[0.0] * 3, [10.0, 20.0, 30.0]], 0, absent=(1,)) == 30.0
    assert error([5.0, 1.0, 2.0], [[0.0] * 3, [10.0, 20.0, 30.0]], 0, absent=(0,)) == 30.0


@pytest.mark.parametrize(
    ("values", "choice", "short"), [([1.0, 5.0, 2.0], 2, 3.0), ([-4.0, -2.0, -3.0], 1, 0.0), ([4.0, 5.0, 2.0], 0, 1.0)]
)
def test_the_shortfall_is_what_the_best_value_is_ahead(values: list[float], choice: int, short: float) -> None:
    assert error([0.0] * 3, [values, [0.0] * 3], choice, alpha=0.5) == -0.5 * short


HIDDEN = Architecture(SIZE, (16,), CHOICES)


def drawn() -> tuple[Array, Array, Steps]:
    """Parameters, of which the target's differ from the online ones, and transitions."""
    rng = np.random.default_rng(1)
    size = sum(fan_in * fan_out for fan_in, fan_out in HIDDEN.shapes().values())
    online, target = (rng.normal(0.0, 0.3, size).astype(np.float32).astype(np.float64) for _ in range(2))
    online[-CHOICES:] = target[-CHOICES:] = 0.0  # biases, so that every choice is the best one somewhere
    states, following = (rng.normal(size=(COUNT, SIZE)).astype(np.float32).astype(np.float64) for _ in range(2))
    choices, discounts = rng.integers(0, CHOICES, COUNT), rng.choice([0.0, 0.9], COUNT)
    return online, target, Steps(states, choices, rng.normal(size=COUNT), discounts, following)


def values_of(parameters: Array, states: Array) -> Array:
    """Q, [K, C], in numpy."""
    w1, b1, w2, b2 = np.split(parameters, np.cumsum([SIZE * 16, 16, 16 * CHOICES]))
    inside = np.maximum(states @ w1.reshape(SIZE, 16) + b1, 0.0)
    values: Array = inside @ w2.reshape(16, CHOICES) + b2
    return values


@pytest.mark.parametrize("alpha", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("absent", [(), (0,), (1,)])
def test_advantage_learning_takes_a_share_of_the_shortfall_off_the_target(
    alpha: float, absent: tuple[int, ...]
) -> None:
    """An absent choice is no best one, to bootstrap from or to fall short of."""
    online, target, steps = drawn()
    present = [choice for choice in range(CHOICES) if choice not in absent]
    steps = steps._replace(choices=np.array(present)[steps.choices % len(present)])
    errors = errors_of(HIDDEN, online, target, steps, alpha, absent)
    here, lagged = values_of(online, steps.states), values_of(target, steps.states)
    following, aims = values_of(online, steps.following), values_of(target, steps.following)
    for k, choice in enumerate(steps.choices):
        best = present[following[k, present].argmax()]
        y = steps.rewards[k] + steps.discounts[k] * aims[k, best]
        y -= alpha * (lagged[k, present].max() - lagged[k, choice])
        assert errors[k] == pytest.approx(y - here[k, choice], rel=1e-4, abs=1e-5)
    assert all((lagged.argmax(1) == choice).any() and (following.argmax(1) == choice).any() for choice in absent)


@pytest.mark.parametrize("alpha", [0.3, 0.9])
def test_advantage_learning_widens_gaps_and_keeps_the_order_of_choices(alpha: float) -> None:
    """Tabular: iterating Q <- r + gamma max Q(s') - alpha (max Q - Q) ends at V* - (V* - Q*) / (1 - alpha)."""
    rng, gamma = np.random.default_rng(2), 0.9
    rewards, following = rng.normal(size=(4, CHOICES)), rng.integers(0, 4, (4, CHOICES))
    every = np.arange(4 * CHOICES)
    steps = Steps(at(every // CHOICES), every % CHOICES, rewards.ravel(), np.full(12, gamma), at(following.ravel()))

    def fixed_point(share: float) -> Array:
        q = np.zeros((4, CHOICES))
        for _ in range(600):
            q = q + errors_of(TABLE, tabular(q), tabular(q), steps, share).reshape(q.shape)
        return q

    plain, wide = fixed_point(0.0), fixed_point(alpha)
    best = plain.max(1, keepdims=True)
    np.testing.assert_allclose(wide, best - (best - plain) / (1.0 - alpha), rtol=1e-4, atol=1e-4)
    np.testing.assert_array_equal(wide.argsort(1), plain.argsort(1))
