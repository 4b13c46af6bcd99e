import numpy as np
import pytest

from hhrl_agents.algorithms.pqn import lambda_returns

GAMMA = 0.9
STEPS = 12


def n_step_mixture(
    rewards: list[float], discounts: list[float], values: list[float], ended: list[bool], decay: float
) -> float:
    """The return of step 0 by its definition, (1 - lambda) sum_n lambda^(n-1) G^(n); the longest G takes the rest."""
    last = next((step for step, end in enumerate(ended) if end), len(ended) - 1)
    total, rewarded, discount = 0.0, 0.0, 1.0
    for step in range(last + 1):
        rewarded += discount * rewards[step]
        discount *= discounts[step]
        weight = decay**step * (1.0 if step == last else 1.0 - decay)
        total += weight * (rewarded + discount * values[step])
    return total


@pytest.mark.parametrize("decay", [0.0, 0.6, 1.0])
def test_returns_are_the_mixture_of_the_n_step_returns(decay: float) -> None:
    draw = np.random.default_rng(3)
    shape = (STEPS, 7)
    rewards, values, ended = draw.normal(size=shape), draw.normal(size=shape), draw.random(shape) < 0.2
    discounts = np.where(ended & (draw.random(shape) < 0.5), 0.0, GAMMA)
    assert (ended & (discounts > 0)).any()
    assert (ended & (discounts == 0)).any()
    returns = lambda_returns(rewards, discounts, values, ended, decay)
    for step, env in np.ndindex(*shape):
        rest = np.s_[step:, env]
        expected = n_step_mixture(
            rewards[rest].tolist(), discounts[rest].tolist(), values[rest].tolist(), ended[rest].tolist(), decay
        )
        assert returns[step, env] == pytest.approx(expected)


def test_a_time_limit_bootstraps_and_nothing_flows_back_through_an_end() -> None:
    rewards, values = np.array([1.0, 2.0, 100.0]), np.array([50.0, 10.0, 7.0])
    ended, discounts = np.array([False, True, False]), np.full(3, GAMMA)
    truncated = lambda_returns(rewards, discounts, values, ended, 1.0)
    np.testing.assert_allclose(truncated, [1.0 + GAMMA * (2.0 + GAMMA * 10.0), 2.0 + GAMMA * 10.0, 100.0 + GAMMA * 7.0])
    terminal = lambda_returns(rewards, np.array([GAMMA, 0.0, GAMMA]), values, ended, 1.0)
    np.testing.assert_allclose(terminal[:2], [1.0 + GAMMA * 2.0, 2.0])
