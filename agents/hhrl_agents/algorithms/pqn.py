"""PQN, the parallelised Q-network: Q-learning without replay and without a target network, for E stacked seeds.

Gallici et al. (2024), "Simplifying Deep Temporal Difference Learning": many environments take a short rollout, its
Q(lambda) returns are computed once, some epochs of shuffled mini-batches regress the values on them, and the rollout
is forgotten. Layer normalisation is what keeps this stable.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hhrl_agents.agent import ACTION, NO_OPTION
from hhrl_agents.algorithms.td_errors import LevelErrors
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.mlp import MLP, subset
from hhrl_agents.seeding import Purpose, generators, restore_streams, save_streams
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.exploration import GREEDY
from hhrl_agents.training.learner import NOTHING, StackedLearner, Start
from hhrl_envs import Scenario
from hhrl_envs.arrays import Flags, Floats, Floats32, Ints, Keys
from hhrl_envs.state import State


class RolloutStep(NamedTuple):
    """One step of every environment, [E, n, ...]: s, a, r, what discounts V(s'), s' before any reset, and its end."""

    observations: Floats32
    actions: Ints
    rewards: Floats
    discounts: Floats
    next_observations: Floats32
    ended: Flags


class Targets(NamedTuple):
    """A rollout to learn from, K columns a seed: states [E, features, K], actions int64 and returns, [E, 1, K] each."""

    states: Tensor
    actions: Tensor
    returns: Tensor

    def pick(self, columns: Tensor) -> "Targets":
        """Return these columns of each seed, int64 [E, 1, M]."""
        states = self.states.gather(2, columns.expand(-1, self.states.shape[1], -1))
        return Targets(states, self.actions.gather(2, columns), self.returns.gather(2, columns))


class PQNLearner(StackedLearner):
    """Trains E independent seeds of a method by PQN."""

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        seeds: Sequence[int],
        world_seeds: Keys,
        device: str = "cpu",
        drivers: Drivers = EGO_ALONE,
        start: Start = NOTHING,
    ) -> None:
        super().__init__(method, scenario, seeds, world_seeds, device, drivers, start)
        self._require_plain(drivers, start)
        self._device = torch.device(device)
        self._network = MLP(subset(self.stack.online, "action."), layer_norm=self.config.layer_norm)
        self._gradients = subset(self.stack.gradients, "action.")
        self._shufflers = generators(seeds, Purpose.SHUFFLING)

    def state(self) -> State:
        """Return all that the training depends on; see `Learner.state`."""
        return {**super().state(), **save_streams(self._shufflers)}

    def restore(self, state: State) -> None:
        """Go on where another learner has been; see `Learner.restore`."""
        super().restore(state)
        restore_streams(self._shufflers, state)

    def _advance(self, env_steps: int) -> None:
        config, share = self.config, self.env_steps / env_steps
        epsilon, learning_rate = config.epsilon_at(share), config.learning_rate_at(share)
        targets = self._targets([self._interact(epsilon) for _ in range(config.rollout_steps)])
        for _ in range(config.epochs):
            for columns in self._shuffled():
                self._update(targets.pick(columns), learning_rate)

    def _interact(self, epsilon: float) -> RolloutStep:
        """Step every environment once and return what happened."""
        features = self._environments.features
        tried = self._explorers[0].draw(epsilon)
        greedy = self._network(self._columns(features[None])).max(1).indices.cpu().numpy()
        actions = np.where(tried == GREEDY, greedy, tried)
        step, ended = self._environments.step(np.full_like(actions, NO_OPTION), actions)
        self.env_steps += self.config.n_envs
        rewards = step.rewards[..., ACTION]
        return RolloutStep(features, actions, rewards, step.discounts, step.next_observations, ended)

    def _targets(self, steps: Sequence[RolloutStep]) -> Targets:
        """Return the rollout's states and actions with their Q(lambda) returns by the network as it is now."""
        rollout = RolloutStep(*(np.stack(parts) for parts in zip(*steps, strict=True)))
        best = self._network(self._columns(rollout.next_observations)).amax(1).cpu().double().numpy()
        values = best.reshape(len(self.seeds), len(steps), -1).swapaxes(0, 1)
        decay = self.config.trace_decay
        returns = lambda_returns(rollout.rewards, rollout.discounts, values, rollout.ended, decay)
        states, actions = self._columns(rollout.observations), self._columns(rollout.actions[..., None])
        return Targets(states, actions, self._columns(returns.astype(np.float32)[..., None]))

    def _shuffled(self) -> Sequence[Tensor]:
        """Return every column of a rollout once, each seed's in an order of its own, as mini-batches [E, 1, M]."""
        size = self.config.rollout_size
        orders = np.stack([shuffler.permutation(size) for shuffler in self._shufflers])
        return torch.from_numpy(orders).to(self._device).unsqueeze(1).chunk(self.config.minibatches, dim=2)

    def _update(self, batch: Targets, learning_rate: float) -> None:
        """Take one gradient step of every seed down the mean squared error of its mini-batch."""
        values, forward_pass = self._network.forward(batch.states)
        errors = batch.returns - values.gather(1, batch.actions)
        level = LevelErrors(errors, batch.actions, values, self._network, forward_pass, self._gradients)
        self._add_losses([level.backward(slice(None), torch.ones_like(errors))])
        self._optimiser.step(self.stack.gradient, learning_rate)
        self.updates += 1

    def _columns(self, rollout: npt.NDArray[np.generic]) -> Tensor:
        """Return [E, F, T n] for [T, E, n, F]."""
        by_feature = np.moveaxis(rollout, (1, 3), (0, 1))
        return torch.from_numpy(by_feature.reshape(*by_feature.shape[:2], -1)).to(self._device)


def lambda_returns(rewards: Floats, discounts: Floats, values: Floats, ended: Flags, decay: float) -> Floats:
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
