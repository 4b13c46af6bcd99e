"""One learned level: double Q-learning's choice, and what advantage learning does to targets."""

from functools import partial

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from hhrl_agents.algorithms.td_errors import LearnedLevel, double_q, shortfall
from hhrl_agents.networks.architectures import Architecture
from hhrl_agents.networks.mlp import MLP
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.networks.value_networks import mask_penalty
from hhrl_agents.seeding import Purpose, generators
from hhrl_agents.training.exploration import GREEDY
from hhrl_envs.observation import SIZE

SEEDS = (4, 9)
CHOICES, COUNT = 3, 8
Array = NDArray[np.float64]


def level_of(alpha: float, penalty: torch.Tensor | None = None) -> tuple[LearnedLevel, ParameterStack]:
    """A level of three choices whose target network differs from the online one."""
    shapes = {f"action.{name}": shape for name, shape in Architecture(SIZE, (16,), CHOICES).shapes().items()}
    stack = ParameterStack(shapes, generators(SEEDS, Purpose.INITIALISATION), torch.device("cpu"))
    noise = np.random.default_rng(1).normal(0.0, 0.3, tuple(stack.flat_target.shape))
    stack.flat_target.add_(torch.from_numpy(noise.astype(np.float32)))
    return LearnedLevel("action", partial(MLP, layer_norm=False), stack, alpha, penalty), stack


def batch() -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Targets [E, 1, K], choices [E, 1, K] and states [E, 11, K]."""
    rng = np.random.default_rng(0)
    target = torch.from_numpy(rng.normal(size=(2, 1, COUNT)).astype(np.float32))
    choices = torch.from_numpy(rng.integers(0, CHOICES, (2, 1, COUNT)))
    return target, choices, torch.from_numpy(rng.normal(size=(2, SIZE, COUNT)).astype(np.float32))


def values_of(parameters: dict[str, torch.Tensor], states: torch.Tensor, e: int) -> Array:
    """Q of one seed, [K, C], in numpy."""
    w1, b1, w2, b2 = (value[e].double().numpy() for value in parameters.values())
    values: Array = np.maximum(states[e].double().numpy().T @ w1 + b1, 0.0) @ w2 + b2
    return values


def test_double_q_takes_the_target_s_value_of_the_online_s_choice() -> None:
    online, target = torch.tensor([[[1.0], [5.0], [2.0]]]), torch.tensor([[[10.0], [20.0], [30.0]]])
    best, value = double_q(torch.cat((online, target)))
    assert (best.item(), value.item()) == (1, 20.0)


def test_the_first_of_equal_values_is_the_best() -> None:
    best, value = double_q(torch.tensor([[[5.0], [5.0], [2.0]], [[1.0], [2.0], [3.0]]]))
    assert (best.item(), value.item()) == (0, 1.0)


def test_the_shortfall_is_what_the_best_value_is_ahead() -> None:
    values = torch.tensor([[[1.0, -4.0], [5.0, -2.0], [2.0, -3.0]]])
    assert shortfall(values, torch.tensor([[[2, 1]]])).tolist() == [[[3.0, 0.0]]]


@pytest.mark.parametrize("alpha", [0.0, 0.5, 0.9])
def test_advantage_learning_takes_a_share_of_the_shortfall_off_the_target(alpha: float) -> None:
    (level, stack), (target, choices, states) = level_of(alpha), batch()
    errors = level.errors(target, choices, states)
    for e in range(len(SEEDS)):
        online, lagged = values_of(stack.online, states, e), values_of(stack.target, states, e)
        for k in range(COUNT):
            c = choices[e, 0, k]
            y = target[e, 0, k].item() - alpha * (lagged[k].max() - lagged[k, c])
            assert errors.errors[e, 0, k].item() == pytest.approx(y - online[k, c], rel=1e-4, abs=1e-5)
    assert torch.equal(target, batch()[0])


def test_an_absent_choice_is_no_best_one_to_fall_short_of() -> None:
    penalty, (target, choices, states) = mask_penalty((True, False, True)), batch()
    choices[choices == 1] = 2
    level, stack = level_of(0.5, penalty)
    errors = level.errors(target, choices, states)
    absent_is_best = 0
    for e in range(len(SEEDS)):
        online, lagged = values_of(stack.online, states, e), values_of(stack.target, states, e)
        absent_is_best += int((lagged.argmax(1) == 1).sum())
        for k in range(COUNT):
            c = choices[e, 0, k]
            y = target[e, 0, k].item() - 0.5 * (lagged[k, [0, 2]].max() - lagged[k, c])
            assert errors.errors[e, 0, k].item() == pytest.approx(y - online[k, c], rel=1e-4, abs=1e-5)
    assert absent_is_best
    chosen = level.choose(np.full((2, COUNT), GREEDY), states)
    best, _ = level.following(torch.cat((states, states)))
    assert set(chosen.ravel()) == set(best.ravel().tolist()) == {0, 2}


@pytest.mark.parametrize("alpha", [0.3, 0.9])
def test_advantage_learning_widens_gaps_and_keeps_the_order_of_choices(alpha: float) -> None:
    """Tabular: iterating Q <- r + gamma max Q(s') - alpha (max Q - Q) ends at V* - (V* - Q*) / (1 - alpha)."""
    rng, gamma = np.random.default_rng(2), 0.9
    rewards, following = rng.normal(size=(4, CHOICES)), rng.integers(0, 4, (4, CHOICES))

    def fixed_point(share: float) -> torch.Tensor:
        q = torch.zeros(1, CHOICES, 4, dtype=torch.float64)
        r, s = torch.from_numpy(rewards.T[None].copy()), torch.from_numpy(following.T[None].copy())
        for _ in range(600):
            ahead = double_q(torch.cat((q, q)))[1][0, 0]
            short = torch.cat([shortfall(q, torch.full((1, 1, 4), c)) for c in range(CHOICES)], 1)
            q = r + gamma * ahead[s] - share * short
        return q

    plain, wide = fixed_point(0.0), fixed_point(alpha)
    best = plain.amax(1, keepdim=True)
    np.testing.assert_allclose(wide, best - (best - plain) / (1.0 - alpha), atol=1e-6)
    assert torch.equal(wide.argsort(1), plain.argsort(1))
