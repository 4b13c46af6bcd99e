"""Double DQN for stacked seeds, flat and hierarchical: act, store, learn from the replay, move the target networks."""

from collections.abc import Mapping, Sequence

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.algorithms.td_errors import make_algorithm
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import Parameters
from hhrl_agents.policies.checkpoints import frozen_parameters
from hhrl_agents.replay.buffer import ReplayBuffer
from hhrl_agents.replay.hierarchical import make_sampler
from hhrl_agents.replay.n_step import MultiStep
from hhrl_agents.seeding import Purpose, generators
from hhrl_agents.stateful import Stateful
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.learner import NOTHING, StackedLearner, Start
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats, Keys
from hhrl_envs.errors import require_value


class DoubleDQNLearner(StackedLearner):
    """Trains E independent seeds of a method by Double DQN, flat or hierarchical."""

    _values: dict[str, Tensor]

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
        config, width = self.config, self._environments.width
        capacity = config.replay_capacity
        require_value(capacity >= width, "replay_capacity", capacity, f"at least {width}, a step of every vehicle")
        self._frozen, self._first_epsilon = frozen_parameters(method), start.epsilon
        self.algorithm = make_algorithm(method, scenario, self.stack, self._frozen, start.fixed)
        self._replay = ReplayBuffer(len(seeds), capacity, config.features, torch.device(device))
        levels, streams = len(self.algorithm.levels), generators(seeds, Purpose.REPLAY)
        self._sampler = make_sampler(method, streams, levels, capacity)
        self._multistep = MultiStep(config.n_steps)

    def _advance(self, env_steps: int) -> None:
        share = self.env_steps / env_steps
        self._interact(self.config.epsilon_at(share, self._first_epsilon))
        while self._update_is_due():
            self._update(self.config.learning_rate_at(share))

    def _interact(self, epsilon: float) -> None:
        """Step every environment once and store what happened."""
        environments = self._environments
        tried = [explorer.draw(epsilon) for explorer in self._explorers]
        joined = self._multistep.push(*environments.step(*self.algorithm.choose(environments.features, tried)))
        if joined is not None:
            self._sampler.added(self._replay.add(joined))
        self.env_steps += self.config.n_envs

    def _update_is_due(self) -> bool:
        return bool(self.updates * self.config.steps_per_update < self.env_steps - self.config.warmup)

    @np.errstate(all="ignore")  # a seed that has diverged goes on beside the others
    def _update(self, learning_rate: float) -> None:
        """Take one gradient step at every level of every seed."""
        draw = self._sampler.draw(self._replay.stored)
        levels = self.algorithm.td_errors(self._replay.gather(draw.indices))
        self._add_losses(
            level.backward(part, torch.from_numpy(weights).to(self.stack.flat.device))
            for level, part, weights in zip(levels, draw.parts, draw.weights, strict=True)
        )
        self._optimiser.step(self.stack.gradient, learning_rate)
        errors = np.stack([level.errors[:, 0].abs().cpu().numpy() for level in levels])
        self._sampler.update(draw.indices, errors.astype(np.float64))
        self._values = {name: level.values for name, level in zip(self.algorithm.levels, levels, strict=True)}
        self.updates += 1
        if self.updates % self.config.target_interval == 0:
            self.stack.move_target(self.config.target_rate)

    def _parts(self) -> dict[str, Stateful]:
        return {
            **super()._parts(),
            "replay": self._replay,
            "sampler": self._sampler,
            "multistep": self._multistep,
        }

    def _parameters(self, index: int) -> Parameters:
        return {**super()._parameters(index), **self._frozen}

    def _diverged(self) -> dict[int, str]:
        """Return the seeds whose values in the last mini-batch cannot be; max |r| is a collision's, or one stored."""
        if not self._values:
            return {}
        reward, config = self.scenario.reward, self.config
        usual = config.reward_scale * max(reward.sigma_3, reward.sigma_4)
        largest, alpha = np.maximum(self._replay.largest_reward(), usual), config.advantage_learning
        return beyond_bound(self._values, largest * (1.0 + alpha) / (1.0 - alpha), config.gamma)

    def _clear_meters(self) -> None:
        super()._clear_meters()
        self._values = {}


def beyond_bound(values: Mapping[str, Tensor], largest_reward: Floats, gamma: float) -> dict[int, str]:
    """Return the seeds whose values lie beyond max |r| / (1 - gamma), each with the reason in words.

    values: level -> values of a mini-batch, [E, C, M]; largest_reward: max |r| of each seed, float64 [E].
    """
    with np.errstate(divide="ignore"):
        bound = largest_reward / np.float64(1.0 - gamma)
    reached = {level: value.abs().amax((1, 2)).cpu().double().numpy() for level, value in values.items()}
    return {
        int(index): f"its {level} values reach {largest[index]:.3g}, the rewards allow {bound[index]:.3g}"
        for level, largest in reached.items()
        for index in np.flatnonzero(largest > bound)
    }
