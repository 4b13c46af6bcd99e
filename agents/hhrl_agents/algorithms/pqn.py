"""PQN, the parallelised Q-network: Q-learning without replay and without a target network, for E stacked seeds.

Gallici et al. (2024), "Simplifying Deep Temporal Difference Learning": many environments take a short rollout, its
Q(lambda) returns are computed once, some epochs of shuffled mini-batches regress the values on them, and the rollout
is forgotten. Layer normalisation is what keeps this stable.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hhrl_agents.agent import ACTION, NO_OPTION
from hhrl_agents.algorithms.double_dqn import linear
from hhrl_agents.algorithms.level import LevelErrors
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.adam import Adam
from hhrl_agents.networks.mlp import MLP
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.networks.value_networks import method_shapes, subset
from hhrl_agents.policies.learned_agent import LearnedAgent, describe, make_agent
from hhrl_agents.seeding import Purpose, generators, restore_streams, save_streams
from hhrl_agents.stateful import Stateful, gather, scatter
from hhrl_agents.training.drivers import EGO_ALONE
from hhrl_agents.training.environments import StackedEnvironments
from hhrl_agents.training.exploration import GREEDY, Explorer
from hhrl_agents.training.learner import Progress
from hhrl_envs import Scenario
from hhrl_envs.arrays import Flags, Floats, Floats32, Ints
from hhrl_envs.state import State, count, read_count

_COUNTS = ("env_steps", "updates", "_reported_updates")


class Step(NamedTuple):
    """One step of every environment, [E, n, ...]: s, a, r, what discounts V(s'), s' before any reset, and its end."""

    observations: Floats32
    actions: Ints
    rewards: Floats
    discounts: Floats
    next_observations: Floats32
    ended: Flags


class Targets(NamedTuple):
    """A rollout to learn from, as K columns a seed: states [E, 11, K], actions int64 and returns, [E, 1, K] each."""

    states: Tensor
    actions: Tensor
    returns: Tensor

    def pick(self, columns: Tensor) -> "Targets":
        """Return these columns of each seed, int64 [E, 1, M]."""
        states = self.states.gather(2, columns.expand(-1, self.states.shape[1], -1))
        return Targets(states, self.actions.gather(2, columns), self.returns.gather(2, columns))


class PQNLearner:
    """Trains E independent seeds of PQN, stacked into shared tensors; see `double_dqn.Learner`."""

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        seeds: Sequence[int],
        world_seeds: npt.NDArray[np.uint64],
        device: str = "cpu",
    ) -> None:
        config = method.config
        self.method, self.scenario, self.seeds = method, scenario, tuple(seeds)
        self._environments = StackedEnvironments(method, scenario, len(seeds), world_seeds, EGO_ALONE)
        self.env_steps = self.updates = 0
        self._device = torch.device(device)
        shapes = method_shapes(method, scenario.num_actions)
        self.stack = ParameterStack(shapes, generators(seeds, Purpose.INITIALISATION), self._device)
        self._network = MLP(subset(self.stack.online, "action."), layer_norm=config.layer_norm)
        self._gradients = subset(self.stack.gradients, "action.")
        self._optimiser = Adam(self.stack.flat, [self.stack.part("action.")], config.max_gradient_norm)
        self._shufflers = generators(seeds, Purpose.SHUFFLING)
        choices, streams = np.arange(scenario.num_actions), generators(seeds, Purpose.EXPLORATION)
        self._explorer = Explorer(streams, config.n_envs, choices, config.exploration_hold)
        self._clear_meters()

    def train(self, env_steps: int) -> Iterator[Progress]:
        """Yield a report about every `report_every` environment steps and at the end, until `env_steps` are done.

        After `restore` it goes on from the steps done before. The schedules of exploration and learning rate span these
        `env_steps`, which are each seed's, rounded up to whole rollouts of its `n_envs` environments.
        """
        config = self.method.config
        for done in range(self.env_steps, env_steps, config.rollout_size):
            share = done / env_steps
            epsilon = linear(1.0, config.final_epsilon, share / config.exploration_share)
            targets = self._targets([self._interact(epsilon) for _ in range(config.rollout_steps)])
            learning_rate = linear(config.learning_rate, config.final_learning_rate, share)
            for _ in range(config.epochs):
                for columns in self._shuffled():
                    self._update(targets.pick(columns), learning_rate)
            last = done + config.rollout_size >= env_steps
            if last or self.env_steps % config.report_every < config.rollout_size:
                yield self._report()

    def policies(self) -> list[LearnedAgent]:
        """Return each seed's greedy policy as it is now, E agents that later training does not change."""
        return [self._policy(index, seed) for index, seed in enumerate(self.seeds)]

    def state(self) -> State:
        """Return all that the training depends on, as it is at a report; see `TrainableStack.state`."""
        counts = {name: count(getattr(self, name)) for name in _COUNTS}
        return {**gather(self._parts()), **save_streams(self._shufflers), **counts}

    def restore(self, state: State) -> None:
        """Return nothing; go on where a learner made with the same arguments has been; see `TrainableStack.restore`.

        Raises:
            InputError: if it is the state of another learner.
        """
        scatter(self._parts(), state)
        restore_streams(self._shufflers, state)
        for name in _COUNTS:
            setattr(self, name, read_count(state, name))
        self._environments.look()

    def _parts(self) -> dict[str, Stateful]:
        return {
            "parameters": self.stack,
            "optimiser": self._optimiser,
            "explorer": self._explorer,
            **self._environments.parts(),
        }

    def _interact(self, epsilon: float) -> Step:
        """Step every environment once and return what happened."""
        features = self._environments.features
        tried = self._explorer.draw(epsilon)
        greedy = self._network(self._columns(features[None])).max(1).indices.cpu().numpy()
        actions = np.where(tried == GREEDY, greedy, tried)
        step, ended = self._environments.step(np.full_like(actions, NO_OPTION), actions)
        self.env_steps += self.method.config.n_envs
        rewards = step.rewards[..., ACTION]
        return Step(features, actions, rewards, step.discounts, step.next_observations, ended)

    def _targets(self, steps: Sequence[Step]) -> Targets:
        """Return the rollout's states and actions with their Q(lambda) returns by the network as it is now."""
        rollout = Step(*(np.stack(parts) for parts in zip(*steps, strict=True)))
        best = self._network(self._columns(rollout.next_observations)).amax(1).cpu().double().numpy()
        values = best.reshape(len(self.seeds), len(steps), -1).swapaxes(0, 1)
        decay = self.method.config.trace_decay
        returns = lambda_returns(rollout.rewards, rollout.discounts, values, rollout.ended, decay)
        states, actions = self._columns(rollout.observations), self._columns(rollout.actions[..., None])
        return Targets(states, actions, self._columns(returns.astype(np.float32)[..., None]))

    def _shuffled(self) -> Sequence[Tensor]:
        """Return every column of a rollout once, each seed's in an order of its own, as mini-batches [E, 1, M]."""
        size = self.method.config.rollout_size
        orders = np.stack([shuffler.permutation(size) for shuffler in self._shufflers])
        return torch.from_numpy(orders).to(self._device).unsqueeze(1).chunk(self.method.config.minibatches, dim=2)

    def _update(self, batch: Targets, learning_rate: float) -> None:
        """Take one gradient step of every seed down the mean squared error of its mini-batch."""
        values, trace = self._network.trace(batch.states)
        errors = batch.returns - values.gather(1, batch.actions)
        level = LevelErrors(errors, batch.actions, values, self._network, trace, self._gradients)
        self._losses += level.backward(slice(None), torch.ones_like(errors))
        self._optimiser.step(self.stack.gradient, learning_rate)
        self.updates += 1

    def _columns(self, rollout: npt.NDArray[np.generic]) -> Tensor:
        """Return [E, F, T n] for [T, E, n, F]."""
        by_feature = np.moveaxis(rollout, (1, 3), (0, 1))
        return torch.from_numpy(by_feature.reshape(*by_feature.shape[:2], -1)).to(self._device)

    def _policy(self, index: int, seed: int) -> LearnedAgent:
        metadata = describe(self.method, self.scenario, seed, self.env_steps)
        return make_agent(self.method, self.scenario, self.stack.snapshot(index), metadata)

    def _report(self) -> Progress:
        losses = {"action": self._losses / (self.updates - self._reported_updates)}
        report = Progress(self.env_steps, self.updates, losses, self._environments.outcome_counts)
        self._clear_meters()
        return report

    def _clear_meters(self) -> None:
        self._reported_updates = self.updates
        self._losses = np.zeros(len(self.seeds))
        self._environments.clear_counts()


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
