"""Double DQN, flat and hierarchical: what to choose, and the temporal-difference errors to learn from."""

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.base import NO_OPTION, Float32Array, IntArray
from hhrl_agents.exploration import GREEDY
from hhrl_agents.methods import Method
from hhrl_agents.networks import MLP, ActionNetwork, level_shapes, mask_penalty, one_hot
from hhrl_agents.parameters import ParameterStack
from hhrl_agents.replay import ACTION, OPTION, Batch
from hhrl_envs import Scenario

Choices = tuple[IntArray, IntArray]
"""Options and actions, int64 [E, n] each."""


class Algorithm(Protocol):
    """What the learner's loop asks of a value-learning algorithm for E stacked seeds."""

    @property
    def stacks(self) -> Mapping[str, ParameterStack]:
        """The parameters of each level's network, the option level first."""

    @property
    def choices(self) -> Sequence[IntArray]:
        """What each level chooses from."""

    def choose(self, observations: Float32Array, tried: Sequence[IntArray]) -> Choices:
        """Return options and actions, int64 [E, n], for observations [E, n, 11].

        tried: for each of `stacks` the choices [E, n] to try, or `GREEDY` where the highest value decides.
        """

    def td_errors(self, batch: Batch) -> tuple[Tensor, ...]:
        """Return for each of `stacks` the errors Y - Q, [E, K], differentiable in Q's online parameters."""


class DoubleDQN:
    """Flat Double DQN (Eq. (ddqn)): one action-value network, rewarded by the action level's column, r^task."""

    def __init__(self, method: Method, scenario: Scenario, streams: Sequence[np.random.Generator]) -> None:
        shapes = level_shapes(method, scenario.num_actions)
        self.stacks = {level: ParameterStack(shapes[level], streams) for level in shapes}
        self._online, self._both = MLP(self.stacks["action"].online), MLP(self.stacks["action"].both)
        self.choices = (np.arange(scenario.num_actions),)

    @torch.no_grad()
    def choose(self, observations: Float32Array, tried: Sequence[IntArray]) -> Choices:
        """Return no options (-1) and the actions; see `Algorithm.choose`."""
        actions = _greedy_or(tried[0], self._online(torch.from_numpy(observations)))
        return np.full_like(actions, NO_OPTION), actions

    def td_errors(self, batch: Batch) -> tuple[Tensor, ...]:
        """Return the errors of the action values; see `Algorithm.td_errors`."""
        with torch.no_grad():
            _, value = double_q(self._both(_twice(batch.next_observations)))
            target = batch.rewards[ACTION] + batch.discounts * value
        return (target - _taken(self._online(batch.observations), batch.actions),)


class HierarchicalDoubleDQN:
    """Option and action values, both one-step and both acting at every step (Eq. (qo), (qa)).

    O* = argmax_o Q^o(s', o) and Y^o = r^o + gamma Q^o'(s', O*); A* = argmax_a Q^a(s'^I, O*, a) and
    Y^a = r^a + gamma Q^a'(s'^I, O*, A*), where a prime on Q marks the target network.
    """

    def __init__(self, method: Method, scenario: Scenario, streams: Sequence[np.random.Generator]) -> None:
        shapes = level_shapes(method, scenario.num_actions)
        self.stacks = {level: ParameterStack(shapes[level], streams) for level in shapes}
        option, action = self.stacks["option"], self.stacks["action"]
        self._option, self._option_both = MLP(option.online), MLP(option.both)
        self._action, self._action_both = ActionNetwork(action.online), ActionNetwork(action.both)
        self._penalty = mask_penalty(scenario.option_mask)
        self.choices = (np.flatnonzero(scenario.option_mask), np.arange(scenario.num_actions))

    @torch.no_grad()
    def choose(self, observations: Float32Array, tried: Sequence[IntArray]) -> Choices:
        """Return the options, and the actions given those; see `Algorithm.choose`."""
        states = torch.from_numpy(observations)
        options = _greedy_or(tried[OPTION], self._option(states) + self._penalty)
        return options, _greedy_or(tried[ACTION], self._action(states, one_hot(torch.from_numpy(options))))

    def td_errors(self, batch: Batch) -> tuple[Tensor, ...]:
        """Return the errors of the option values and of the action values; see `Algorithm.td_errors`."""
        with torch.no_grad():
            following = _twice(batch.next_observations)
            best, option_value = double_q(self._option_both(following) + self._penalty)
            _, action_value = double_q(self._action_both(following, _twice(one_hot(best))))
            option_target = batch.rewards[OPTION] + batch.discounts * option_value
            action_target = batch.rewards[ACTION] + batch.discounts * action_value
        option_values = _taken(self._option(batch.observations), batch.options)
        action_values = _taken(self._action(batch.observations, one_hot(batch.options)), batch.actions)
        return option_target - option_values, action_target - action_values


def double_q(values: Tensor) -> tuple[Tensor, Tensor]:
    """Return the online network's best choice [E, K] and the target network's value of it [E, K].

    values: [2E, K, C], the online networks' of every seed, then the target networks'.
    """
    online, target = values.chunk(2)
    best = online.argmax(-1)
    return best, _taken(target, best)


def _greedy_or(tried: IntArray, values: Tensor) -> IntArray:
    return np.where(tried == GREEDY, values.argmax(-1).numpy(), tried)


def _taken(values: Tensor, choices: Tensor) -> Tensor:
    return values.gather(-1, choices.unsqueeze(-1)).squeeze(-1)


def _twice(tensor: Tensor) -> Tensor:
    return torch.cat((tensor, tensor))
