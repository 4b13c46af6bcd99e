"""Learned agents: the greedy policies of trained networks, with levels that are given instead of learned."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from hhrl_agents.agent import NO_OPTION, Decision, HierarchicalAgent
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import FROZEN, Parameters, architectures
from hhrl_agents.networks.layers import ValueNetwork, flattened
from hhrl_agents.policies.observation_memory import Traces
from hhrl_agents.rules import paper_rules
from hhrl_agents.rules.controllers import ControllerAgent
from hhrl_agents.rules.tuning import PAPER_TUNING
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
        self._networks = {
            level: ValueNetwork(network, flattened([self.parameters[f"{level}.{name}"] for name in network.shapes()]))
            for level, network in architectures(method, scenario.num_actions).items()
        }
        self._build()

    def _build(self) -> None:
        """Make what acts out of the networks."""

    def reset(self, mask: Flags) -> None:
        """Forget the rows that start a new episode; see `Agent.reset`."""
        self._memory.begin(mask)

    def state(self) -> State:
        """Return what is remembered of the rows; see `hhrl_agents.stateful.Stateful`."""
        return self._memory.state()

    def restore(self, state: State) -> None:
        """Take up a state; see `hhrl_agents.stateful.Stateful`."""
        self._memory.restore(state)

    def act(self, observations: Floats32) -> Decision:
        """Return no option (-1) and the greedy action, int64 [B] each; see `Agent.act`."""
        actions = _best(self._networks["action"].values(self._memory.observe(observations)))
        return Decision(np.full_like(actions, NO_OPTION), actions)


class HierarchicalLearnedAgent(LearnedAgent):
    """A hierarchical agent; a level that is learned takes the choice of the highest value, the first one on a tie."""

    def _build(self) -> None:
        method, scenario = self.method, self.scenario
        self._select: Options = self._best_option
        self._pursue: Actions = self._best_action
        self._penalty = np.where(scenario.option_mask, 0.0, -np.inf).astype(np.float32)
        if "option" not in method.levels:
            self._select = given_options(method, scenario)
        if "action" not in method.levels:
            self._pursue = given_actions(method, scenario, self.parameters)

    def act(self, observations: Floats32) -> Decision:
        """Return the option, and the action given it, int64 [B] each; see `Agent.act`."""
        features = self._memory.observe(observations)
        option = self._select(features)
        return Decision(option, self._pursue(features, option))

    def act_with_option(self, observations: Floats32, option: Ints) -> Ints:
        """Return the actions given the options, int64 [B]; see `HierarchicalAgent.act_with_option`."""
        return self._pursue(self._memory.observe(observations), option)

    def attention(self, observations: Floats32, option: Ints) -> Floats32:
        """Return the attention I(s, o) on the state elements, float32 [B, elements], each row summing to 1.

        Raises:
            InputError: if the action level is given, and has no network to attend with.
        """
        if "action" not in self.method.levels:
            raise InputError(f"method {self.method.id!r} has no attention: its action level is given")
        return self._networks["action"].attention(observations, option)

    def _best_option(self, features: Floats32) -> Ints:
        return _best(self._networks["option"].values(features) + self._penalty)

    def _best_action(self, features: Floats32, option: Ints) -> Ints:
        return _best(self._networks["action"].values(features, option))


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
    ffv: HierarchicalAgent = HierarchicalLearnedAgent(method.ffv, scenario, _below(parameters, FROZEN), {})
    controllers = ControllerAgent(scenario, PAPER_TUNING)

    def act(features: Floats32, option: Ints) -> Ints:
        observations = features[:, :SIZE]
        following = ffv.act_with_option(observations, np.full_like(option, Option.FFV))
        return np.where(option == Option.FFV, following, controllers.act_with_option(observations, option))

    return act


def agent_metadata(method: Method, scenario: Scenario, seed: int, env_steps: int, *, exact: bool) -> dict[str, Any]:
    """Return the metadata of a trained agent: what it is, where it was trained, how long, and whether that is exact.

    They hold nothing of the machine, so that the same training leaves the same file everywhere, if it is `exact`.
    """
    return {
        "method": method.id,
        "config": method.data(),
        "config_hash": method.config_hash,
        "scenario": scenario.id,
        "spec_hash": scenario.spec_hash,
        "interface_hash": scenario.interface_hash,
        "seed": seed,
        "env_steps": env_steps,
        "exact": exact,
    }


def make_agent(method: Method, scenario: Scenario, parameters: Parameters, metadata: Metadata) -> LearnedAgent:
    """Return the learned agent of the kind that `method` trains; see `LearnedAgent` for the arguments."""
    kind = HierarchicalLearnedAgent if method.hierarchical else LearnedAgent
    return kind(method, scenario, parameters, metadata)


def _best(values: Floats32) -> Ints:
    best: Ints = values.argmax(axis=1)
    return best


def _below(parameters: Parameters, prefix: str) -> dict[str, Floats32]:
    return {name.removeprefix(prefix): value for name, value in parameters.items() if name.startswith(prefix)}
