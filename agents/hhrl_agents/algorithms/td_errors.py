"""Temporal-difference errors of Double DQN for stacked seeds: of one learned level, and of flat and hierarchical ones.

A level is a network of choices and their values; an algorithm says what to choose at each level, and towards which
target its values move.
"""

from collections.abc import Callable, Collection, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.agent import NO_OPTION
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import Parameters as FrozenParameters
from hhrl_agents.networks.attention import one_hot
from hhrl_agents.networks.mlp import MLP, Parameters, subset
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.networks.value_networks import ActionNetwork, mask_penalty
from hhrl_agents.policies.learned_agent import given_actions, given_options
from hhrl_agents.replay.buffer import MiniBatch
from hhrl_agents.training.exploration import GREEDY
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats, Floats32, Ints


class LevelErrors(NamedTuple):
    """The temporal-difference errors Y - Q of one level's network, and what their gradient needs.

    errors: [E, 1, M]; choices: whose values erred, int64 [E, 1, M]; values: of all choices, [E, C, M];
    forward_pass: what the network's has left; gradients: where its parameters' gradients belong.
    """

    errors: Tensor
    choices: Tensor
    values: Tensor
    network: Any
    forward_pass: Any
    gradients: Parameters

    def backward(self, part: slice, weights: Tensor) -> Floats:
        """Return the losses float64 [E], the weighted mean squared errors of the columns `part`; write the gradients.

        weights: [E, 1, K] for the K columns of `part`.
        """
        errors = self.errors[..., part]
        weighted = errors * weights
        slope = torch.zeros_like(self.values[..., part])
        slope.scatter_(1, self.choices[..., part], weighted * (-2.0 / errors.shape[2]))
        self.network.backward(self.forward_pass.columns(part), slope, self.gradients)
        losses: Floats = (weighted * errors).mean((1, 2)).cpu().double().numpy()
        return losses


class LearnedLevel:
    """One level of E stacked seeds: online and target networks of the parameters whose names begin with `level`.

    network: makes a network of its parameters; it is called with states [E, features, K], and with one-hot options
    where the level is given one. alpha: of advantage learning, 0 without. penalty: what its values are lowered by where
    a choice is absent, [C, 1].
    """

    def __init__(
        self,
        level: str,
        network: Callable[[Parameters], Any],
        stack: ParameterStack,
        alpha: float,
        penalty: Tensor | None = None,
    ) -> None:
        self._online = network(subset(stack.online, f"{level}."))
        self._target = network(subset(stack.target, f"{level}."))
        self._both = network(subset(stack.both, f"{level}."))
        self._gradients = subset(stack.gradients, f"{level}.")
        self._alpha, self._penalty = alpha, penalty

    def choose(self, tried: Ints, *inputs: Tensor) -> Ints:
        """Return the choices, int64 [E, n]: those `tried` [E, n], the best of the online network where it is GREEDY."""
        return np.where(tried == GREEDY, self._masked(self._online(*inputs)).max(1).indices.cpu().numpy(), tried)

    def following(self, *inputs: Tensor) -> tuple[Tensor, Tensor]:
        """Return the choices at the next states and their target values; see `double_q`.

        inputs: those of every seed's online network, then those of the target networks, [2E, features, K].
        """
        return double_q(self._masked(self._both(*inputs)))

    def errors(self, target: Tensor, choices: Tensor, *inputs: Tensor) -> LevelErrors:
        """Return the errors of the values of the `choices` made, int64 [E, 1, K], from the `target`, [E, 1, K]."""
        values, forward_pass = self._online.forward(*inputs)
        errors = target - values.gather(1, choices)
        if self._alpha > 0.0:
            errors -= self._alpha * shortfall(self._masked(self._target(*inputs)), choices)
        return LevelErrors(errors, choices, values, self._online, forward_pass, self._gradients)

    def _masked(self, values: Tensor) -> Tensor:
        return values if self._penalty is None else values + self._penalty


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


Choices = tuple[Ints, Ints]
"""Options and actions, int64 [E, n] each."""


class Algorithm(Protocol):
    """What the learner's loop asks of a value-learning algorithm for E stacked seeds.

    levels: the names of what is learned, which begin its parameters' names.
    """

    levels: Sequence[str]

    def choose(self, observations: Floats32, tried: Sequence[Ints]) -> Choices:
        """Return options and actions, int64 [E, n], for observations [E, n, features].

        tried: for each of `levels` the choices [E, n] to try, or `GREEDY` where the highest value decides.
        """

    def td_errors(self, batch: MiniBatch) -> tuple[LevelErrors, ...]:
        """Return the errors of each of `levels`."""


class DoubleDQN:
    """Flat Double DQN (Eq. (ddqn)): one action-value network, rewarded by the action level's column, r^task."""

    def __init__(self, method: Method, stack: ParameterStack) -> None:
        self.levels: Sequence[str] = method.levels
        network = partial(MLP, layer_norm=method.config.layer_norm)
        self._action = LearnedLevel("action", network, stack, method.config.advantage_learning)
        self._device = stack.flat.device

    def choose(self, observations: Floats32, tried: Sequence[Ints]) -> Choices:
        """Return no options (-1) and the actions; see `Algorithm.choose`."""
        actions = self._action.choose(tried[0], _columns(observations, self._device))
        return np.full_like(actions, NO_OPTION), actions

    def td_errors(self, batch: MiniBatch) -> tuple[LevelErrors, ...]:
        """Return the errors of the action values; see `Algorithm.td_errors`."""
        _, value = self._action.following(_twice(batch.next_observations))
        target = batch.action_rewards + batch.discounts * value
        return (self._action.errors(target, batch.actions, batch.observations),)


class HierarchicalDoubleDQN:
    """Option and action values, both one-step and both acting at every step (Eq. (qo), (qa)).

    O* = argmax_o Q^o(s', o) and Y^o = r^o + gamma Q^o'(s', O*); A* = argmax_a Q^a(s'^I, O*, a) and
    Y^a = r^a + gamma Q^a'(s'^I, O*, A*), where a prime on Q marks the target network. A level that is given has no
    values: O* is then what the rule selects at s'.

    frozen: the parameters of a given action level; fixed: levels of the stack that choose and do not learn.
    """

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        stack: ParameterStack,
        frozen: FrozenParameters = MappingProxyType({}),
        fixed: Collection[str] = (),
    ) -> None:
        self._device = stack.flat.device
        self.levels: Sequence[str] = tuple(level for level in method.levels if level not in fixed)
        self._option = self._action = None
        alpha = method.config.advantage_learning
        if "option" in method.levels:
            network = partial(MLP, layer_norm=method.config.layer_norm)
            penalty = mask_penalty(scenario.option_mask).to(self._device)
            self._option = LearnedLevel("option", network, stack, alpha, penalty)
        else:
            self._given_options = given_options(method, scenario)
        if "action" in method.levels:
            self._action = LearnedLevel("action", partial(ActionNetwork, config=method.config), stack, alpha)
        else:
            self._given_actions = given_actions(method, scenario, frozen)

    def choose(self, observations: Floats32, tried: Sequence[Ints]) -> Choices:
        """Return the options, and the actions given those; see `Algorithm.choose`."""
        states, rows, shape = _columns(observations, self._device), _rows(observations), tried[0].shape
        trials, greedy = dict(zip(self.levels, tried, strict=True)), np.full(shape, GREEDY)
        if self._option:
            options = self._option.choose(trials.get("option", greedy), states)
        else:
            options = self._given_options(rows).reshape(shape)
        if self._action:
            trial = trials.get("action", greedy)
            return options, self._action.choose(trial, states, one_hot(self._column(options)))
        return options, self._given_actions(rows, options.reshape(-1)).reshape(shape)

    def td_errors(self, batch: MiniBatch) -> tuple[LevelErrors, ...]:
        """Return the errors of the learned levels' values; see `Algorithm.td_errors`."""
        following, errors = _twice(batch.next_observations), []
        if self._option:
            best, value = self._option.following(following)
        else:
            best = self._options_at(batch.next_observations)
        if self._option and "option" in self.levels:
            target = batch.option_rewards + batch.discounts * value
            errors.append(self._option.errors(target, batch.options, batch.observations))
        if self._action and "action" in self.levels:
            _, value = self._action.following(following, _twice(one_hot(best)))
            target = batch.action_rewards + batch.discounts * value
            errors.append(self._action.errors(target, batch.actions, batch.observations, one_hot(batch.options)))
        return tuple(errors)

    def _options_at(self, states: Tensor) -> Tensor:
        """Return the given options, int64 [E, 1, K], for states [E, features, K]."""
        rows = states.transpose(1, 2).cpu().numpy()
        return self._column(self._given_options(_rows(rows)).reshape(rows.shape[:2]))

    def _column(self, options: Ints) -> Tensor:
        return torch.from_numpy(options).to(self._device).unsqueeze(1)


def make_algorithm(
    method: Method, scenario: Scenario, stack: ParameterStack, frozen: FrozenParameters, fixed: Collection[str] = ()
) -> Algorithm:
    """Return the algorithm that learns the method's levels; see `HierarchicalDoubleDQN` for `frozen` and `fixed`."""
    if method.hierarchical:
        return HierarchicalDoubleDQN(method, scenario, stack, frozen, fixed)
    return DoubleDQN(method, stack)


def _rows(features: Floats32) -> Floats32:
    return features.reshape(-1, features.shape[-1])


def _columns(observations: Floats32, device: torch.device) -> Tensor:
    return torch.from_numpy(observations).to(device).transpose(1, 2)


def _twice(tensor: Tensor) -> Tensor:
    return torch.cat((tensor, tensor))
