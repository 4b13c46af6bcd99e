"""The learner: act, store, learn, repeat; for every method, and for E stacked seeds at once."""

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hhrl_agents.algorithms.td_errors import make_algorithm
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.adam import Adam
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.networks.value_networks import method_shapes
from hhrl_agents.policies.checkpoints import frozen_parameters
from hhrl_agents.policies.learned_agent import LearnedAgent, describe, make_agent
from hhrl_agents.replay.buffer import ReplayBuffer
from hhrl_agents.replay.n_step import MultiStep
from hhrl_agents.replay.samplers import make_sampler
from hhrl_agents.seeding import Purpose, generators
from hhrl_agents.stateful import Stateful, gather, scatter
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.environments import StackedEnvironments
from hhrl_agents.training.exploration import Explorer
from hhrl_agents.training.learner import Progress, beyond_bound
from hhrl_agents.training.start import NOTHING, Start
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats
from hhrl_envs.errors import require_value
from hhrl_envs.state import State, count, read, read_count

_COUNTS = ("env_steps", "updates", "_reported_updates")


class Learner:
    """Trains E independent seeds of one method, stacked into shared tensors; a `TrainableStack`.

    method: what to train; scenario: the world to train in; seeds: one for each of the E learners, of all of its random
    draws; world_seeds: uint64 [E, n_envs], the worlds of its environments; drivers: which vehicles learn, and who
    drives the others; start: what the seeds begin with. A seed's draws do not depend on the others.
    The tensors are small: train with one torch thread, more only wait for each other.
    """

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        seeds: Sequence[int],
        world_seeds: npt.NDArray[np.uint64],
        device: str = "cpu",
        drivers: Drivers = EGO_ALONE,
        start: Start = NOTHING,
    ) -> None:
        config = method.config
        self.method, self.scenario, self.seeds = method, scenario, tuple(seeds)
        self._environments = StackedEnvironments(method, scenario, len(seeds), world_seeds, drivers)
        capacity, width = config.replay_capacity, self._environments.width
        require_value(capacity >= width, "replay_capacity", capacity, f"at least {width}, a step of every vehicle")
        self.env_steps = self.updates = 0
        shapes, place = method_shapes(method, scenario.num_actions), torch.device(device)
        start.require_fit(method, shapes, seeds)
        self.stack = ParameterStack(shapes, generators(seeds, Purpose.INITIALISATION), place)
        for index, parameters in enumerate(start.parameters):
            self.stack.take_over(index, parameters)
        self._frozen, self._epsilon = frozen_parameters(method), start.epsilon
        self.algorithm = make_algorithm(method, scenario, self.stack, self._frozen, start.fixed)
        levels = self.algorithm.levels
        parts = [self.stack.part(f"{level}.") for level in levels]
        self._optimiser = Adam(self.stack.flat, parts, config.max_gradient_norm)
        features = config.features
        self._replay = ReplayBuffer(len(seeds), capacity, features, place)
        self._sampler = make_sampler(method, generators(seeds, Purpose.REPLAY), len(levels), self._replay.capacity)
        self._multistep = MultiStep(config.n_steps)
        self._explorers = self._make_explorers()
        self._values: dict[str, Tensor] = {}
        self._clear_meters()

    def train(self, env_steps: int) -> Iterator[Progress]:
        """Yield a report every `report_every` environment steps and at the end, until `env_steps` are done.

        After `restore` it goes on from the steps done before. The schedules of exploration and learning rate span these
        `env_steps`, which are each seed's, rounded up to whole steps of its `n_envs` environments.
        """
        config = self.method.config
        for done in range(self.env_steps, env_steps, config.n_envs):
            share = done / env_steps
            self._interact(linear(self._epsilon, config.final_epsilon, share / config.exploration_share))
            learning_rate = linear(config.learning_rate, config.final_learning_rate, share)
            while self._update_is_due():
                self._update(learning_rate)
            last = done + config.n_envs >= env_steps
            if last or self.env_steps % config.report_every < config.n_envs:
                yield self._report()

    def policies(self) -> list[LearnedAgent]:
        """Return each seed's greedy policy as it is now, E agents that later training does not change."""
        return [self._policy(index, seed) for index, seed in enumerate(self.seeds)]

    def state(self) -> State:
        """Return all that the training depends on, as it is at a report; see `TrainableStack.state`."""
        counts = {name: count(getattr(self, name)) for name in _COUNTS}
        return {
            **gather(self._parts()),
            **counts,
            "losses": self._losses.copy(),
            "outcomes": self._environments.outcome_counts.copy(),
        }

    def restore(self, state: State) -> None:
        """Return nothing; go on where a learner made with the same arguments has been; see `TrainableStack.restore`.

        Raises:
            InputError: if it is the state of another learner.
        """
        scatter(self._parts(), state)
        for name in _COUNTS:
            setattr(self, name, read_count(state, name))
        self._losses[:] = read(state, "losses", self._losses)
        self._environments.outcome_counts[:] = read(state, "outcomes", self._environments.outcome_counts)
        self._environments.look()

    def _parts(self) -> dict[str, Stateful]:
        explorers = {f"explorer-{index}": explorer for index, explorer in enumerate(self._explorers)}
        return {
            "parameters": self.stack,
            "optimiser": self._optimiser,
            "replay": self._replay,
            "sampler": self._sampler,
            "multistep": self._multistep,
            **self._environments.parts(),
            **explorers,
        }

    def _interact(self, epsilon: float) -> None:
        """Step every environment once and store what happened."""
        environments = self._environments
        tried = [explorer.draw(epsilon) for explorer in self._explorers]
        joined = self._multistep.push(*environments.step(*self.algorithm.choose(environments.features, tried)))
        if joined is not None:
            self._sampler.added(self._replay.add(joined))
        self.env_steps += self.method.config.n_envs

    def _update_is_due(self) -> bool:
        config = self.method.config
        return bool(self.updates * config.steps_per_update < self.env_steps - config.warmup)

    @np.errstate(all="ignore")  # a seed that has diverged goes on beside the others
    def _update(self, learning_rate: float) -> None:
        """Take one gradient step at every level of every seed."""
        config = self.method.config
        draw = self._sampler.draw(self._replay.stored)
        levels = self.algorithm.td_errors(self._replay.gather(draw.indices))
        for index, (level, part, weights) in enumerate(zip(levels, draw.parts, draw.weights, strict=True)):
            self._losses[index] += level.backward(part, torch.from_numpy(weights).to(self.stack.flat.device))
        self._optimiser.step(self.stack.gradient, learning_rate)
        errors = np.stack([level.errors[:, 0].abs().cpu().numpy() for level in levels])
        self._sampler.update(draw.indices, errors.astype(np.float64))
        self._values = {name: level.values for name, level in zip(self.algorithm.levels, levels, strict=True)}
        self.updates += 1
        if self.updates % config.target_interval == 0:
            self.stack.move_target(config.target_rate)

    def _make_explorers(self) -> list[Explorer]:
        streams, width = generators(self.seeds, Purpose.EXPLORATION), self._environments.width
        config = self.method.config
        return [Explorer(streams, width, found, config.exploration_hold) for found in self.algorithm.choices]

    def _policy(self, index: int, seed: int) -> LearnedAgent:
        metadata = describe(self.method, self.scenario, seed, self.env_steps)
        return make_agent(self.method, self.scenario, self.stack.snapshot(index) | self._frozen, metadata)

    def _report(self) -> Progress:
        with np.errstate(invalid="ignore"):
            means = self._losses / (self.updates - self._reported_updates)
        losses = dict(zip(self.algorithm.levels, means, strict=True))
        report = Progress(self.env_steps, self.updates, losses, self._environments.outcome_counts, self._diverged())
        self._clear_meters()
        return report

    def _diverged(self) -> dict[int, str]:
        """Return the seeds whose values in the last mini-batch cannot be; max |r| is a collision's, or one stored."""
        if not self._values:
            return {}
        reward, config = self.scenario.reward, self.method.config
        usual = config.reward_scale * max(reward.sigma_3, reward.sigma_4)
        largest, alpha = np.maximum(self._replay.largest_reward(), usual), config.advantage_learning
        return beyond_bound(self._values, largest * (1.0 + alpha) / (1.0 - alpha), config.gamma)

    def _clear_meters(self) -> None:
        self._reported_updates = self.updates
        self._values = {}
        self._losses: Floats = np.zeros((len(self.algorithm.levels), len(self.seeds)))
        self._environments.clear_counts()


def linear(start: float, end: float, share: float) -> float:
    """Return the value at `share` of the way from `start` to `end`; `end` beyond it."""
    return start + (end - start) * min(share, 1.0)
