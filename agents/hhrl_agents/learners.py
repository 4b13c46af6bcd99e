"""The learner: act, store, learn, repeat; for every method, and for E stacked seeds at once."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch

from hhrl_agents.algorithms import Algorithm, DoubleDQN, HierarchicalDoubleDQN
from hhrl_agents.base import FloatArray, IntArray
from hhrl_agents.exploration import Explorer
from hhrl_agents.learned import LearnedAgent, describe, make_agent
from hhrl_agents.learning_rewards import discounts, level_rewards
from hhrl_agents.methods import Method
from hhrl_agents.replay import ReplayBuffer, Transitions
from hhrl_agents.sampling import HierarchicalPrioritizedSampler, Sampler, UniformSampler
from hhrl_agents.seeding import Purpose, generators
from hhrl_envs import Outcome, Scenario, Simulator
from hhrl_envs.errors import InputError
from hhrl_envs.observation import SIZE


@dataclass(frozen=True)
class Progress:
    """What happened in training since the last report, all counts for each seed.

    Attributes:
        env_steps: environment steps so far.
        updates: gradient steps so far.
        losses: level -> mean loss since the last report, float64 [E]; not a number without a gradient step.
        outcome_counts: training episodes that ended since the last report, int64 [E, 6], by `hhrl_envs.Outcome`.
    """

    env_steps: int
    updates: int
    losses: dict[str, FloatArray]
    outcome_counts: IntArray


class Learner:
    """Trains E independent seeds of one method, stacked into shared tensors; see `Learner.train`.

    method: what to train; scenario: the world to train in; seeds: one for each of the E learners, of all of its random
    draws; world_seeds: uint64 [E, n_envs], the worlds of its environments. A seed's draws do not depend on the others.
    The tensors are small: train with one torch thread, more only wait for each other.
    """

    def __init__(
        self, method: Method, scenario: Scenario, seeds: Sequence[int], world_seeds: npt.NDArray[np.uint64]
    ) -> None:
        config = method.config
        if np.shape(world_seeds) != (len(seeds), config.n_envs):
            raise InputError(f"world_seeds have shape {np.shape(world_seeds)}; write {(len(seeds), config.n_envs)}")
        self.method, self.scenario, self.seeds = method, scenario, tuple(seeds)
        self.env_steps = self.updates = 0
        kind = HierarchicalDoubleDQN if method.hierarchical else DoubleDQN
        self.algorithm: Algorithm = kind(method, scenario, generators(seeds, Purpose.INITIALISATION))
        self._stacks = list(self.algorithm.stacks.values())
        self._optimiser = torch.optim.Adam([stack.flat for stack in self._stacks], lr=config.learning_rate, fused=True)
        self._replay = ReplayBuffer(len(seeds), config.n_envs, config.replay_capacity)
        self._sampler = self._make_sampler()
        self._explorers = self._make_explorers()
        self._simulator = Simulator(scenario, len(seeds) * config.n_envs)
        self._simulator.reset(world_seeds.reshape(-1))
        self._clear_meters()

    def train(self, env_steps: int) -> Iterator[Progress]:
        """Yield a report every `report_every` environment steps and at the end, while training for `env_steps`.

        The schedules of exploration and learning rate span these `env_steps`, which are each seed's, rounded up to
        whole steps of its `n_envs` environments.
        """
        config = self.method.config
        for done in range(0, env_steps, config.n_envs):
            share = done / env_steps
            self._interact(linear(1.0, config.final_epsilon, share / config.exploration_share))
            self._set_learning_rate(linear(config.learning_rate, config.final_learning_rate, share))
            while self._update_is_due():
                self._update()
            last = done + config.n_envs >= env_steps
            if last or self.env_steps % config.report_every < config.n_envs:
                yield self._report()

    def policies(self) -> list[LearnedAgent]:
        """Return each seed's greedy policy as it is now, E agents that later training does not change."""
        return [self._policy(index, seed) for index, seed in enumerate(self.seeds)]

    def _interact(self, epsilon: float) -> None:
        """Step every environment once and store what happened."""
        simulator, shape = self._simulator, (len(self.seeds), self.method.config.n_envs)
        observations = simulator.observations.copy().reshape(*shape, SIZE)
        tried = [explorer.draw(epsilon) for explorer in self._explorers]
        options, actions = self.algorithm.choose(observations, tried)
        simulator.step(actions.reshape(-1))
        step = Transitions(
            observations,
            options,
            actions,
            level_rewards(self.method, simulator, options.reshape(-1)).reshape(*shape, 2),
            discounts(self.method, simulator).reshape(shape),
            simulator.observations.reshape(*shape, SIZE),
        )
        self._sampler.added(self._replay.add(step))
        self._count_outcomes()
        simulator.reset_done()
        self.env_steps += shape[1]

    def _update_is_due(self) -> bool:
        config = self.method.config
        return self.updates * config.steps_per_update < self.env_steps - config.warmup

    def _update(self) -> None:
        """Take one gradient step at every level of every seed."""
        config = self.method.config
        draw = self._sampler.draw(self._replay.stored)
        errors = self.algorithm.td_errors(self._replay.gather(draw.indices))
        for level, (stack, error) in enumerate(zip(self._stacks, errors, strict=True)):
            weights = torch.from_numpy(draw.weights[level % len(draw.weights)])
            losses = (weights * error.square()).sum(-1) / config.batch_size
            stack.set_gradients(losses, config.max_gradient_norm)
            self._losses[level] += losses.detach().numpy()
        self._optimiser.step()
        self._sampler.update(draw.indices, np.stack([error.detach().abs().numpy() for error in errors]))
        self.updates += 1
        if self.updates % config.target_interval == 0:
            for stack in self._stacks:
                stack.copy_to_target()

    def _set_learning_rate(self, learning_rate: float) -> None:
        for group in self._optimiser.param_groups:
            group["lr"] = learning_rate

    def _make_sampler(self) -> Sampler:
        streams, config = generators(self.seeds, Purpose.REPLAY), self.method.config
        if self.method.hierarchical_per:
            return HierarchicalPrioritizedSampler(streams, self._replay.capacity, config)
        return UniformSampler(streams, config.batch_size)

    def _make_explorers(self) -> list[Explorer]:
        streams, config = generators(self.seeds, Purpose.EXPLORATION), self.method.config
        return [Explorer(streams, config.n_envs, found, config.exploration_hold) for found in self.algorithm.choices]

    def _policy(self, index: int, seed: int) -> LearnedAgent:
        parameters = {
            f"{level}.{name}": value
            for level, stack in self.algorithm.stacks.items()
            for name, value in stack.snapshot(index).items()
        }
        return make_agent(
            self.method, self.scenario, parameters, describe(self.method, self.scenario, seed, self.env_steps)
        )

    def _count_outcomes(self) -> None:
        rows = np.flatnonzero(self._simulator.outcomes != Outcome.RUNNING)
        np.add.at(self._outcome_counts, (rows // self.method.config.n_envs, self._simulator.outcomes[rows]), 1)

    def _report(self) -> Progress:
        with np.errstate(invalid="ignore"):
            means = self._losses / (self.updates - self._reported_updates)
        losses = dict(zip(self.algorithm.stacks, means, strict=True))
        report = Progress(self.env_steps, self.updates, losses, self._outcome_counts)
        self._clear_meters()
        return report

    def _clear_meters(self) -> None:
        self._reported_updates = self.updates
        self._losses = np.zeros((len(self._stacks), len(self.seeds)))
        self._outcome_counts = np.zeros((len(self.seeds), len(Outcome)), np.int64)


def linear(start: float, end: float, share: float) -> float:
    """Return the value at `share` of the way from `start` to `end`; `end` beyond it."""
    return start + (end - start) * min(share, 1.0)
