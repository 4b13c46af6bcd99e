"""What is learned from a mini-batch, by flat Double DQN and by the paper's Algorithms 1 and 2: one seed, with autograd.

It is here to be read beside the paper, and to hold another engine against. A step of Algorithm 1 selects by
`PolicyModule.best_options` and the argmax of `PolicyModule.action_values`; Algorithm 3 is
`hhrl_agents.reference.replay`.
"""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import NamedTuple

import torch
from torch import Tensor

from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.reference.conversion import AnyParameters, module_of
from hhrl_agents.reference.modules import PolicyModule
from hhrl_envs import Scenario
from hhrl_envs.errors import InputError
from hhrl_envs.simulation.rewards import FAILURE, SUCCESS, TIME, TIMEOUT, UNSAFE, UNSMOOTH

ByLevel = Mapping[str, Tensor]
"""A tensor for each level that is learned, "option" and "action"."""


class MiniBatch(NamedTuple):
    """B transitions: S_t, O_t, A_t, R^o_{t+1}, R^a_{t+1}, what discounts the next values, and S_{t+1}.

    observations, next_observations: float32 [B, features]; options, actions: int64 [B]; option_rewards, action_rewards,
    discounts: float32 [B], the last gamma (to the power of the steps taken), or 0 where the episode terminated.
    """

    observations: Tensor
    options: Tensor
    actions: Tensor
    option_rewards: Tensor
    action_rewards: Tensor
    discounts: Tensor
    next_observations: Tensor


def hybrid_rewards(terms: Tensor, options: Tensor) -> tuple[Tensor, Tensor]:
    """Return r^option and r^action of the selected options, [B] each: what Algorithm 2 is about, by the equations.

    Both have the penalty of time and the reward of success. What an unselected sub-goal is penalised for is the option
    level's fault, what the selected one is penalised for, and unsmoothness, the action level's. The algorithm as it is
    printed has the fault of failures the other way round.

    terms: the simulator's, [B, terms], see `hhrl_envs.simulation.rewards`; options: int64 [B].
    """
    shared = terms[:, [TIME, TIMEOUT, SUCCESS]].sum(1)
    penalties = terms[:, UNSAFE] + terms[:, FAILURE]
    selected = _of(penalties, options)
    return shared + penalties.sum(1) - selected, shared + terms[:, UNSMOOTH] + selected


@torch.no_grad()
def targets(online: PolicyModule, target: PolicyModule, batch: MiniBatch) -> dict[str, Tensor]:
    """Return Y of every level that is learned, float32 [B]; Eq. (ddqn), (qo), (qa), and advantage learning.

    The online networks choose, the target networks evaluate::

        O* = argmax_o Q^o(s', o)             Y^o = r^o + gamma Q^o'(s', O*)
        A* = argmax_a Q^a(s'^I, O*, a)       Y^a = r^a + gamma Q^a'(s'^I, O*, A*)

    Where a rule gives the option O* is what it selects at s'; a flat method has Y^a alone, without O*. Advantage
    learning takes alpha (max_c Q'(s, c) - Q'(s, C)) off, C the choice that was made at s.
    """
    levels, following, found = online.method.levels, batch.next_observations, {}
    best_options = online.best_options(following)
    if "option" in levels:
        value = _of(target.option_values(following), best_options)
        found["option"] = batch.option_rewards + batch.discounts * value
        found["option"] -= _shortfall(target, target.option_values(batch.observations), batch.options)
    if "action" in levels:
        best_actions = online.action_values(following, best_options).argmax(1)
        value = _of(target.action_values(following, best_options), best_actions)
        found["action"] = batch.action_rewards + batch.discounts * value
        of_state = target.action_values(batch.observations, batch.options)
        found["action"] -= _shortfall(target, of_state, batch.actions)
    return found


def td_errors(online: PolicyModule, target: PolicyModule, batch: MiniBatch) -> dict[str, Tensor]:
    """Return the errors Y - Q(s, C) of every level that is learned, [B], whose gradients reach the online networks."""
    wanted, errors = targets(online, target, batch), {}
    if "option" in wanted:
        errors["option"] = wanted["option"] - _of(online.option_values(batch.observations), batch.options)
    if "action" in wanted:
        values = online.action_values(batch.observations, batch.options)
        errors["action"] = wanted["action"] - _of(values, batch.actions)
    return errors


def losses(errors: ByLevel, weights: ByLevel, parts: Mapping[str, slice]) -> dict[str, Tensor]:
    """Return the weighted mean squared error of every level, over its part of the mini-batch.

    weights: what the squared errors of that part are multiplied with, [K].
    """
    return {level: (weights[level] * error[parts[level]].square()).mean() for level, error in errors.items()}


def _of(values: Tensor, choices: Tensor) -> Tensor:
    """Return the value of each choice, [B], for values [B, choices] and choices int64 [B]."""
    return values.gather(1, choices.unsqueeze(1)).squeeze(1)


def _shortfall(target: PolicyModule, values: Tensor, choices: Tensor) -> Tensor:
    alpha: float = target.method.config.advantage_learning
    return alpha * (values.amax(1) - _of(values, choices)) if alpha > 0.0 else torch.zeros_like(values[:, 0])


class ReferenceLearner:
    """One seed's online and target networks and an Adam for each level that learns.

    parameters: what both networks begin with, as a checkpoint has them; target: the target networks' own, if they are
    others; levels: those that go on learning, all that the method learns by default.

    Attributes:
        online, target: the networks.
        levels: the levels that go on learning.
    """

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        parameters: AnyParameters,
        target: AnyParameters | None = None,
        levels: Sequence[str] | None = None,
        device: str = "cpu",
    ) -> None:
        if not isinstance(method.config, DoubleDQNConfig):
            raise InputError(f"method {method.id!r} learns by {method.algorithm}; name one that learns by double-dqn")
        self._config = method.config
        self.levels = tuple(method.levels if levels is None else levels)
        self.online = module_of(method, scenario, parameters).to(device)
        self.target = deepcopy(self.online) if target is None else module_of(method, scenario, target).to(device)
        self._optimisers = {
            level: torch.optim.Adam(self._network(level).parameters(), betas=(0.9, 0.999), eps=1e-8)
            for level in self.levels
        }

    def losses(self, batch: MiniBatch, weights: ByLevel, parts: Mapping[str, slice] | None = None) -> dict[str, Tensor]:
        """Return the losses of the levels that learn and write their gradients into the online networks, clipped.

        parts: which rows each level learns from, all of them by default; see `losses`. The gradient of each level's
        network is scaled to a norm of at most `max_gradient_norm`.
        """
        errors = td_errors(self.online, self.target, batch)
        errors = {level: errors[level] for level in self.levels}
        everything = dict.fromkeys(self.levels, slice(None))
        found = losses(errors, weights, everything if parts is None else parts)
        for level, loss in found.items():
            network = self._network(level)
            network.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            torch.nn.utils.clip_grad_norm_(network.parameters(), self._config.max_gradient_norm)
        return {level: loss.detach() for level, loss in found.items()}

    def update(
        self, batch: MiniBatch, weights: ByLevel, learning_rate: float, parts: Mapping[str, slice] | None = None
    ) -> dict[str, Tensor]:
        """Take one gradient step at every level that learns; return the losses before it."""
        found = self.losses(batch, weights, parts)
        for optimiser in self._optimisers.values():
            optimiser.param_groups[0]["lr"] = learning_rate
            optimiser.step()
        return found

    @torch.no_grad()
    def move_target(self) -> None:
        """Move the target networks by the share `target_rate` towards the online ones; 1 copies them."""
        for lagging, leading in zip(self.target.parameters(), self.online.parameters(), strict=True):
            lagging.lerp_(leading, self._config.target_rate)

    def _network(self, level: str) -> torch.nn.Module:
        return self.online.get_submodule(level)
