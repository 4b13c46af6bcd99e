"""Lambda returns: the mixture of all multi-step returns of a rollout."""

import numpy as np

from hhrl_agents.base import BoolArray, FloatArray


def lambda_returns(
    rewards: FloatArray, discounts: FloatArray, values: FloatArray, ended: BoolArray, decay: float
) -> FloatArray:
    """Return G_t = r_t + gamma_t ((1 - lambda) V(s_{t+1}) + lambda G_{t+1}), float64 [T, ...], time first.

    Where an episode ended, at the time limit too, or the rollout does, G_{t+1} is V(s_{t+1}). With V = max_a Q these
    are Peng's Q(lambda) returns (Gallici et al. 2024, section 4).

    rewards: r_t; discounts: gamma_t, 0 after a terminal step; values: V of the state that step t led to, which is the
    final one of its episode where `ended`; all [T, ...].
    """
    returns = np.empty(rewards.shape)
    following = values[-1]
    for step in reversed(range(len(rewards))):
        following = np.where(ended[step], values[step], following)
        mixed = values[step] + decay * (following - values[step])
        following = returns[step] = rewards[step] + discounts[step] * mixed
    return returns
