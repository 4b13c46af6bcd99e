"""Learned agents: the greedy policies of trained networks, with levels that are given instead of learned."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.agent import NO_OPTION, Decision, HierarchicalAgent
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.attention import one_hot
from hhrl_agents.networks.mlp import MLP, Parameters, subset
from hhrl_agents.networks.value_networks import FROZEN, ActionNetwork, mask_penalty
from hhrl_agents.policies.observation_memory import Traces
from hhrl_agents.rules import paper_rules
from hhrl_agents.rules.controllers import PAPER_TUNING, ControllerAgent
from hhrl_envs import Option, Scenario
from hhrl_envs.arrays import Flags, Floats32, Ints
from hhrl_envs.errors import InputError
from hhrl_envs.observation import SIZE
from hhrl_envs.state import State

Metadata = Mapping[str, Any]

Options = Callable[[Floats32], Ints]
"""Options int64 [B] for what networks read, float32 [B, features], the observation first."""

Actions = Callable[[Floats32, Ints], Ints]
"""Actions int64 [B] for what networks read, float32 [B, features], and options int64 [B]."""


class LearnedAgent:
    """A flat agent that takes the action of the highest value, the first one on a tie.

    parameters: of all networks, level.name -> [1, in, out]; metadata: where they come from.
    """

    def __init__(self, method: Method, scenario: Scenario, parameters: Parameters, metadata: Metadata) -> None:
        self.method = method
        self.scenario = scenario
        self.parameters = dict(parameters)
        self.metadata = dict(metadata)
        self._memory = Traces(method.config.memory)
        self._build()

    def _build(self) -> None:
        self._flat = MLP(subset(self.parameters, "action."), layer_norm=self.method.config.layer_norm)

    def reset(self, mask: Flags) -> None:
        """Forget the rows that start a new episode; see `Agent.reset`."""
        self._memory.begin(mask)

    def state(self) -> State:
        """Return what is remembered of the rows; see `hhrl_agents.stateful.Stateful`."""
        return self._memory.state()

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        self._memory.restore(state)

    @torch.no_grad()
    def act(self, observations: Floats32) -> Decision:
        """Return no option (-1) and the greedy action, int64 [B] each; see `Agent.act`."""
        actions = _best(self._flat(_states(self._memory.observe(observations))))
        return Decision(np.full_like(actions, NO_OPTION), actions)


class HierarchicalLearnedAgent(LearnedAgent):
    """A hierarchical agent; a level that is learned takes the choice of the highest value, the first one on a tie."""

    def _build(self) -> None:
        method, scenario, parameters = self.method, self.scenario, self.parameters
        self._select: Options = self._best_option
        self._pursue: Actions = self._best_action
        if "option" in method.levels:
            self._option = MLP(subset(parameters, "option."), layer_norm=method.config.layer_norm)
            self._penalty = mask_penalty(scenario.option_mask)
        else:
            self._select = given_options(method, scenario)
        if "action" in method.levels:
            self._action = ActionNetwork(subset(parameters, "action."), method.config)
        else:
            self._pursue = given_actions(method, scenario, parameters)

    @torch.no_grad()
    def act(self, observations: Floats32) -> Decision:
        """Return the option, and the action given it, int64 [B] each; see `Agent.act`."""
        features = self._memory.observe(observations)
        option = self._select(features)
        return Decision(option, self._pursue(features, option))

    @torch.no_grad()
    def act_with_option(self, observations: Floats32, option: Ints) -> Ints:
        """Return the actions given the options, int64 [B]; see `HierarchicalAgent.act_with_option`."""
        return self._pursue(self._memory.observe(observations), option)

    @torch.no_grad()
    def attention(self, observations: Floats32, option: Ints) -> Floats32:
        """Return the attention I(s, o) on the state elements, float32 [B, elements], each row summing to 1.

        Raises:
            InputError: if the action level is given, and has no network to attend with.
        """
        if "action" not in self.method.levels:
            raise InputError(f"method {self.method.id!r} has no attention: its action level is given")
        weights: Floats32 = self._action.attention(_states(observations), _options(option))[0].T.numpy()
        return weights

    def _best_option(self, features: Floats32) -> Ints:
        return _best(self._option(_states(features)) + self._penalty)

    def _best_action(self, features: Floats32, option: Ints) -> Ints:
        return _best(self._action(_states(features), _options(option)))


def given_options(method: Method, scenario: Scenario) -> Options:
    """Return the option level of the method's rule; rules remember nothing, so the state alone decides."""
    rule = paper_rules.RULES[method.option](scenario)
    return lambda features: rule.select(features[:, :SIZE])


def given_actions(method: Method, scenario: Scenario, parameters: Parameters) -> Actions:
    """Return the action level of a method with `ffv`: that policy under FFV, the analytic controllers under the rest.

    parameters: those of the policy, their names behind `FROZEN`; others are ignored.
    """
    if method.ffv is None:
        raise InputError(f"the action level of method {method.id!r} is learned, not given")
    ffv: HierarchicalAgent = HierarchicalLearnedAgent(method.ffv, scenario, subset(parameters, FROZEN), {})
    controllers = ControllerAgent(scenario, PAPER_TUNING)

    def act(features: Floats32, option: Ints) -> Ints:
        observations = features[:, :SIZE]
        following = ffv.act_with_option(observations, np.full_like(option, Option.FFV))
        return np.where(option == Option.FFV, following, controllers.act_with_option(observations, option))

    return act


def agent_metadata(method: Method, scenario: Scenario, seed: int, env_steps: int) -> dict[str, Any]:
    """Return the metadata of a trained agent: what it is, where it was trained, how long, with which versions."""
    return {
        "method": method.id,
        "config": method.data(),
        "config_hash": method.config_hash,
        "scenario": scenario.id,
        "spec_hash": scenario.spec_hash,
        "interface_hash": scenario.interface_hash,
        "seed": seed,
        "env_steps": env_steps,
        "versions": {"numpy": np.__version__, "torch": torch.__version__},
    }


def make_agent(method: Method, scenario: Scenario, parameters: Parameters, metadata: Metadata) -> LearnedAgent:
    """Return the learned agent of the kind that `method` trains; see `LearnedAgent` for the arguments."""
    kind = HierarchicalLearnedAgent if method.hierarchical else LearnedAgent
    return kind(method, scenario, parameters, metadata)


def _states(features: Floats32) -> Tensor:
    return torch.from_numpy(np.array(features, np.float32, order="C")).unsqueeze(0).transpose(1, 2)


def _options(option: Ints) -> Tensor:
    return one_hot(torch.tensor(option).view(1, 1, -1))


def _best(values: Tensor) -> Ints:
    best: Ints = values[0].max(0).indices.numpy()
    return best
