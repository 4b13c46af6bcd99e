"""Double DQN, flat and hierarchical: what to choose, and the temporal-difference errors to learn from."""

from collections.abc import Collection, Sequence
from functools import partial
from types import MappingProxyType
from typing import Protocol

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.agent import NO_OPTION
from hhrl_agents.algorithms.level import LearnedLevel, LevelErrors
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.mlp import MLP, Parameters
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.networks.value_networks import ActionNetwork, mask_penalty, one_hot
from hhrl_agents.policies.given_levels import given_options
from hhrl_agents.policies.learned_agent import frozen_actions
from hhrl_agents.replay.buffer import Batch
from hhrl_agents.training.exploration import GREEDY
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats32, Ints

Choices = tuple[Ints, Ints]
"""Options and actions, int64 [E, n] each."""


class Algorithm(Protocol):
    """What the learner's loop asks of a value-learning algorithm for E stacked seeds.

    levels: the names of what is learned, which begin its parameters' names; choices: what each level chooses from.
    """

    levels: Sequence[str]
    choices: Sequence[Ints]

    def choose(self, observations: Floats32, tried: Sequence[Ints]) -> Choices:
        """Return options and actions, int64 [E, n], for observations [E, n, features].

        tried: for each of `levels` the choices [E, n] to try, or `GREEDY` where the highest value decides.
        """

    def td_errors(self, batch: Batch) -> tuple[LevelErrors, ...]:
        """Return the errors of each of `levels`."""


class DoubleDQN:
    """Flat Double DQN (Eq. (ddqn)): one action-value network, rewarded by the action level's column, r^task."""

    def __init__(self, method: Method, scenario: Scenario, stack: ParameterStack) -> None:
        self.levels: Sequence[str] = method.levels
        self.choices: Sequence[Ints] = (np.arange(scenario.num_actions),)
        network = partial(MLP, layer_norm=method.config.layer_norm)
        self._action = LearnedLevel("action", network, stack, method.config.advantage_learning)
        self._device = stack.flat.device

    def choose(self, observations: Floats32, tried: Sequence[Ints]) -> Choices:
        """Return no options (-1) and the actions; see `Algorithm.choose`."""
        actions = self._action.choose(tried[0], _columns(observations, self._device))
        return np.full_like(actions, NO_OPTION), actions

    def td_errors(self, batch: Batch) -> tuple[LevelErrors, ...]:
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
        frozen: Parameters = MappingProxyType({}),
        fixed: Collection[str] = (),
    ) -> None:
        self._device = stack.flat.device
        self.levels: Sequence[str] = tuple(level for level in method.levels if level not in fixed)
        choices = {"option": np.flatnonzero(scenario.option_mask), "action": np.arange(scenario.num_actions)}
        self.choices: Sequence[Ints] = tuple(choices[level] for level in self.levels)
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
            self._given_actions = frozen_actions(method, scenario, frozen)

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

    def td_errors(self, batch: Batch) -> tuple[LevelErrors, ...]:
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
    method: Method, scenario: Scenario, stack: ParameterStack, frozen: Parameters, fixed: Collection[str] = ()
) -> Algorithm:
    """Return the algorithm that learns the method's levels; see `HierarchicalDoubleDQN` for `frozen` and `fixed`."""
    if method.hierarchical:
        return HierarchicalDoubleDQN(method, scenario, stack, frozen, fixed)
    return DoubleDQN(method, scenario, stack)


def _rows(features: Floats32) -> Floats32:
    return features.reshape(-1, features.shape[-1])


def _columns(observations: Floats32, device: torch.device) -> Tensor:
    return torch.from_numpy(observations).to(device).transpose(1, 2)


def _twice(tensor: Tensor) -> Tensor:
    return torch.cat((tensor, tensor))
