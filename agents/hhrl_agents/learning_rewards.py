"""What a learner is rewarded with: the environment's rewards, level by level."""

import numpy as np

from hhrl_agents.base import FloatArray, IntArray
from hhrl_agents.methods import Method
from hhrl_agents.replay import ACTION, OPTION
from hhrl_envs import Outcome
from hhrl_envs.rewards import TIMEOUT, UNSMOOTH
from hhrl_envs.simulator import Results


def level_rewards(method: Method, results: Results, options: IntArray) -> FloatArray:
    """Return the scaled rewards of both levels for the last step, float64 [B, 2], given the selected options [B].

    results: what the agents that learn got from that step.

    With the hybrid reward they are r^option and r^action of the selected option, otherwise r^task twice. Algorithm 2
    (`credit`) is the other way round: a failure of the selected sub-goal is the option's fault, of the other one the
    action's. The penalty for unsmoothness, part of r^task and r^action, counts for `jerk_weight`. Where a time limit
    counts as truncation its penalty, part of all of them, is left out.
    """
    unsmooth = results.terms[:, UNSMOOTH]
    rewards = np.empty((len(unsmooth), 2))
    if method.hybrid_reward:
        rows = np.arange(len(unsmooth))
        rewards[:, OPTION] = results.reward_option[rows, options]
        rewards[:, ACTION] = results.reward_action[rows, options]
        if method.config.credit == "algorithm-2":
            rewards = rewards[:, ::-1] + np.stack((-unsmooth, unsmooth), axis=1)
    else:
        rewards[:] = results.rewards[:, None]
    excess = (1.0 - method.config.jerk_weight) * unsmooth
    rewards -= np.stack((np.zeros_like(excess) if method.hybrid_reward else excess, excess), axis=1)
    if method.config.timeout == "truncation":
        rewards -= results.terms[:, TIMEOUT, None]
    scaled: FloatArray = rewards * method.config.reward_scale
    return scaled


def discounts(method: Method, results: Results) -> FloatArray:
    """Return what the value of the next state is multiplied with, float64 [B]: gamma, or 0 after a terminal step."""
    ongoing = results.outcomes == Outcome.RUNNING
    if method.config.timeout == "truncation":
        ongoing |= results.outcomes == Outcome.TIMEOUT
    return np.where(ongoing, method.config.gamma, 0.0)
