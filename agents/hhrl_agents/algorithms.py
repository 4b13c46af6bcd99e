"""Double DQN, flat and hierarchical: what to choose, and the temporal-difference errors to learn from."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.base import NO_OPTION, Float32Array, FloatArray, IntArray
from hhrl_agents.exploration import GREEDY
from hhrl_agents.methods import Method
from hhrl_agents.mlp import MLP, Parameters
from hhrl_agents.networks import ActionNetwork, mask_penalty, one_hot, subset
from hhrl_agents.parameters import ParameterStack
from hhrl_agents.replay import OPTION, Batch
from hhrl_envs import Scenario

Choices = tuple[IntArray, IntArray]
"""Options and actions, int64 [E, n] each."""


class LevelErrors(NamedTuple):
    """The temporal-difference errors Y - Q of one level's network, and what their gradient needs.

    errors: [E, 1, M]; choices: whose values erred, int64 [E, 1, M]; values: of all choices, [E, C, M]; trace: of the
    network's forward pass; gradients: where its parameters' gradients belong.
    """

    errors: Tensor
    choices: Tensor
    values: Tensor
    network: Any
    trace: Any
    gradients: Parameters

    def backward(self, part: slice, weights: Tensor) -> FloatArray:
        """Return the losses float64 [E], the weighted mean squared errors of the columns `part`; write the gradients.

        weights: [E, 1, K] for the K columns of `part`.
        """
        errors = self.errors[..., part]
        weighted = errors * weights
        slope = torch.zeros_like(self.values[..., part])
        slope.scatter_(1, self.choices[..., part], weighted * (-2.0 / errors.shape[2]))
        self.network.backward(self.trace.columns(part), slope, self.gradients)
        losses: FloatArray = (weighted * errors).mean((1, 2)).cpu().double().numpy()
        return losses


class Algorithm(Protocol):
    """What the learner's loop asks of a value-learning algorithm for E stacked seeds.

    levels: the names of what is learned, which begin its parameters' names; choices: what each level chooses from.
    """

    levels: Sequence[str]
    choices: Sequence[IntArray]

    def choose(self, observations: Float32Array, tried: Sequence[IntArray]) -> Choices:
        """Return options and actions, int64 [E, n], for observations [E, n, 11].

        tried: for each of `levels` the choices [E, n] to try, or `GREEDY` where the highest value decides.
        """

    def td_errors(self, batch: Batch) -> tuple[LevelErrors, ...]:
        """Return the errors of each of `levels`."""


class DoubleDQN:
    """Flat Double DQN (Eq. (ddqn)): one action-value network, rewarded by the action level's column, r^task."""

    levels: Sequence[str] = ("action",)

    def __init__(self, method: Method, scenario: Scenario, stack: ParameterStack) -> None:
        norm = method.config.layer_norm
        self._online = MLP(subset(stack.online, "action."), layer_norm=norm)
        self._both = MLP(subset(stack.both, "action."), layer_norm=norm)
        self._target = MLP(subset(stack.target, "action."), layer_norm=norm)
        self._gradients = subset(stack.gradients, "action.")
        self._alpha, self._device = method.config.advantage_learning, stack.flat.device
        self.choices: Sequence[IntArray] = (np.arange(scenario.num_actions),)

    def choose(self, observations: Float32Array, tried: Sequence[IntArray]) -> Choices:
        """Return no options (-1) and the actions; see `Algorithm.choose`."""
        actions = _greedy_or(tried[0], self._online(_columns(observations, self._device)))
        return np.full_like(actions, NO_OPTION), actions

    def td_errors(self, batch: Batch) -> tuple[LevelErrors, ...]:
        """Return the errors of the action values; see `Algorithm.td_errors`."""
        _, value = double_q(self._both(_twice(batch.next_observations)))
        target = batch.action_rewards + batch.discounts * value
        values, trace = self._online.trace(batch.observations)
        errors = target - values.gather(1, batch.actions)
        if self._alpha > 0.0:
            errors -= self._alpha * shortfall(self._target(batch.observations), batch.actions)
        return (LevelErrors(errors, batch.actions, values, self._online, trace, self._gradients),)


class HierarchicalDoubleDQN:
    """Option and action values, both one-step and both acting at every step (Eq. (qo), (qa)).

    O* = argmax_o Q^o(s', o) and Y^o = r^o + gamma Q^o'(s', O*); A* = argmax_a Q^a(s'^I, O*, a) and
    Y^a = r^a + gamma Q^a'(s'^I, O*, A*), where a prime on Q marks the target network.
    """

    levels: Sequence[str] = ("option", "action")

    def __init__(self, method: Method, scenario: Scenario, stack: ParameterStack) -> None:
        config = method.config
        self._option, self._option_target, self._option_both = (
            MLP(subset(parameters, "option."), layer_norm=config.layer_norm)
            for parameters in (stack.online, stack.target, stack.both)
        )
        self._action, self._action_target, self._action_both = (
            ActionNetwork(subset(parameters, "action."), config)
            for parameters in (stack.online, stack.target, stack.both)
        )
        self._gradients = [subset(stack.gradients, f"{level}.") for level in self.levels]
        self._alpha, self._device = config.advantage_learning, stack.flat.device
        self._penalty = mask_penalty(scenario.option_mask).to(self._device)
        self.choices: Sequence[IntArray] = (np.flatnonzero(scenario.option_mask), np.arange(scenario.num_actions))

    def choose(self, observations: Float32Array, tried: Sequence[IntArray]) -> Choices:
        """Return the options, and the actions given those; see `Algorithm.choose`."""
        states = _columns(observations, self._device)
        options = _greedy_or(tried[OPTION], self._option(states) + self._penalty)
        given = one_hot(torch.from_numpy(options).to(self._device).unsqueeze(1))
        return options, _greedy_or(tried[1], self._action(states, given))

    def td_errors(self, batch: Batch) -> tuple[LevelErrors, ...]:
        """Return the errors of the option values and of the action values; see `Algorithm.td_errors`."""
        following, given = _twice(batch.next_observations), one_hot(batch.options)
        best, option_value = double_q(self._option_both(following) + self._penalty)
        _, action_value = double_q(self._action_both(following, _twice(one_hot(best))))
        values, trace = self._option.trace(batch.observations)
        errors = batch.option_rewards + batch.discounts * option_value - values.gather(1, batch.options)
        option = LevelErrors(errors, batch.options, values, self._option, trace, self._gradients[0])
        values, action_trace = self._action.trace(batch.observations, given)
        errors = batch.action_rewards + batch.discounts * action_value - values.gather(1, batch.actions)
        action = LevelErrors(errors, batch.actions, values, self._action, action_trace, self._gradients[1])
        if self._alpha > 0.0:
            old = self._option_target(batch.observations) + self._penalty
            option.errors.sub_(self._alpha * shortfall(old, batch.options))
            action.errors.sub_(self._alpha * shortfall(self._action_target(batch.observations, given), batch.actions))
        return option, action


def double_q(values: Tensor) -> tuple[Tensor, Tensor]:
    """Return the online network's best choice, int64 [E, 1, K], and the target network's value of it, [E, 1, K].

    values: [2E, C, K], the online networks' of every seed, then the target networks'.
    """
    online, target = values.chunk(2)
    best = online.max(1, keepdim=True).indices
    return best, target.gather(1, best)


def shortfall(values: Tensor, choices: Tensor) -> Tensor:
    """Return how much less than the best of `values` [E, C, K] the value of each choice is, [E, 1, K]."""
    return values.max(1, keepdim=True).values - values.gather(1, choices)


def _greedy_or(tried: IntArray, values: Tensor) -> IntArray:
    return np.where(tried == GREEDY, values.max(1).indices.cpu().numpy(), tried)


def _columns(observations: Float32Array, device: torch.device) -> Tensor:
    return torch.from_numpy(observations).to(device).transpose(1, 2)


def _twice(tensor: Tensor) -> Tensor:
    return torch.cat((tensor, tensor))
