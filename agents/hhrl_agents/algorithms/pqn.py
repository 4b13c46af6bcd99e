"""PQN, the parallelised Q-network: Q-learning without replay and without a target network.

Gallici et al. (2024), "Simplifying Deep Temporal Difference Learning": many environments take a short rollout, its
Q(lambda) returns are computed once, some epochs of shuffled mini-batches regress the values on them, and the rollout
is forgotten. Layer normalisation is what keeps this stable.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hhrl_agents.agent import ACTION, NO_OPTION
from hhrl_agents.algorithms.td_errors import Level, Room, Settings, make_room, regress
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.arithmetic import ONE, block
from hhrl_agents.networks.layers import FEATURES, forward
from hhrl_agents.networks.parameters import Memory, advance_powers
from hhrl_agents.seeding import Purpose, generator, restore_stream, save_stream
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.exploration import GREEDY
from hhrl_agents.training.learner import NOTHING, Start, ValueLearner
from hhrl_envs import Scenario
from hhrl_envs.arrays import Flags, Floats, Floats32, Ints, Keys
from hhrl_envs.simulation.engine.compilation import kernel
from hhrl_envs.state import State


class RolloutStep(NamedTuple):
    """One step of every environment, [n, ...]: s, a, r, what discounts V(s'), s' before any reset, and its end."""

    observations: Floats32
    actions: Ints
    rewards: Floats
    discounts: Floats
    next_observations: Floats32
    ended: Flags


class Targets(NamedTuple):
    """A rollout to learn from: states [K, features], actions int64 [K] and returns, float32 [K]."""

    states: Floats32
    actions: Ints
    returns: Floats32


class PQNLearner(ValueLearner):
    """Trains a method by PQN."""

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        seed: int,
        world_seeds: Keys,
        drivers: Drivers = EGO_ALONE,
        start: Start = NOTHING,
    ) -> None:
        super().__init__(method, scenario, seed, world_seeds, drivers, start)
        self._require_plain(drivers, start)
        self._network, self._shuffler = self._networks["action"], generator(seed, Purpose.SHUFFLING)
        layout, (first, last) = self.parameters.layouts["action"], self.parameters.parts["action"]
        self._level = Level(
            ACTION, layout, np.zeros(scenario.num_actions, np.float32), learns=True, first=first, last=last
        )
        size = self.config.rollout_size // self.config.minibatches
        self._room = make_room([self.parameters.widths["action"]], [layout], size)

    def state(self) -> State:
        """Return all that the training depends on; see `Learner.state`."""
        return {**super().state(), **save_stream(self._shuffler)}

    def restore(self, state: State) -> None:
        """Go on where another learner has been; see `Learner.restore`."""
        super().restore(state)
        restore_stream(self._shuffler, state)

    def _advance(self, env_steps: int, span: int) -> None:
        config, share = self.config, self.env_steps / span
        epsilon, learning_rate = config.epsilon_at(share), config.learning_rate_at(share)
        targets = self._targets([self._interact(epsilon) for _ in range(config.rollout_steps)])
        settings = Settings(0.0, learning_rate, config.max_gradient_norm)
        for _ in range(config.epochs):
            order = self._shuffler.permutation(config.rollout_size)
            for columns in np.split(order, config.minibatches):
                self._add_losses([fit(self._memory, self._level, targets, columns, self._room, settings)])
                self.updates += 1

    def _interact(self, epsilon: float) -> RolloutStep:
        """Step every environment once and return what happened."""
        features = self._environments.features
        tried = self._explorers[0].draw(epsilon)
        actions = np.where(tried == GREEDY, self._network.values(features).argmax(axis=1), tried)
        step, ended = self._environments.step(np.full_like(actions, NO_OPTION), actions)
        self.env_steps += self.config.n_envs
        return RolloutStep(features, actions, step.rewards[:, ACTION], step.discounts, step.next_observations, ended)

    def _targets(self, steps: Sequence[RolloutStep]) -> Targets:
        """Return the rollout's states and actions with their Q(lambda) returns by the network as it is now."""
        rollout = RolloutStep(*(np.stack(parts) for parts in zip(*steps, strict=True)))
        features = rollout.observations.shape[-1]
        best = self._network.values(rollout.next_observations.reshape(-1, features)).max(axis=1)
        values = best.astype(np.float64).reshape(rollout.rewards.shape)
        decay = self.config.trace_decay
        returns = lambda_returns(rollout.rewards, rollout.discounts, values, rollout.ended, decay)
        states = rollout.observations.reshape(-1, features)
        return Targets(states, rollout.actions.ravel(), returns.astype(np.float32).ravel())


@kernel
def fit(memory: Memory, level: Level, targets: Targets, columns: Ints, room: Room, settings: Settings) -> float:
    """Return the mean squared error of the values of these transitions, int64 [M], after one gradient step down it."""
    count = columns.size
    states = block(room.work, room.capacity, 0, count, level.layout[0, FEATURES])
    actions, errors, weights = room.choices[0], room.numbers[0], room.numbers[1, :count]
    for m in range(count):
        weights[m] = ONE
        actions[m] = targets.actions[columns[m]]
        for f in range(states.shape[1]):
            states[m, f] = targets.states[columns[m], f]
    values = forward(memory.online, level.layout, room.work, room.capacity, count, actions)
    for m in range(count):
        errors[m] = targets.returns[columns[m]] - values[m, actions[m]]
    advance_powers(memory.powers)
    return regress(memory, level, errors, actions, actions, 0, weights, room, settings)


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
