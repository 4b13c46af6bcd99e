"""The learner: act, store, learn, repeat; for every method, and for E stacked seeds at once."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch

from hhrl_agents.adam import Adam
from hhrl_agents.algorithms import make_algorithm
from hhrl_agents.base import FloatArray, IntArray
from hhrl_agents.exploration import Explorer
from hhrl_agents.frozen import frozen_parameters
from hhrl_agents.learned import LearnedAgent, describe, make_agent
from hhrl_agents.learning_rewards import discounts, level_rewards
from hhrl_agents.methods import Method
from hhrl_agents.multistep import MultiStep
from hhrl_agents.networks import method_shapes
from hhrl_agents.parameters import ParameterStack
from hhrl_agents.replay import ReplayBuffer, Transitions
from hhrl_agents.sampling import make_sampler
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
        self,
        method: Method,
        scenario: Scenario,
        seeds: Sequence[int],
        world_seeds: npt.NDArray[np.uint64],
        device: str = "cpu",
    ) -> None:
        config = method.config
        if np.shape(world_seeds) != (len(seeds), config.n_envs):
            raise InputError(f"world_seeds have shape {np.shape(world_seeds)}; write {(len(seeds), config.n_envs)}")
        self.method, self.scenario, self.seeds = method, scenario, tuple(seeds)
        self.env_steps = self.updates = 0
        shapes, place = method_shapes(method, scenario.num_actions), torch.device(device)
        self.stack = ParameterStack(shapes, generators(seeds, Purpose.INITIALISATION), place)
        self._frozen = frozen_parameters(method)
        self.algorithm = make_algorithm(method, scenario, self.stack, self._frozen)
        levels = self.algorithm.levels
        parts = [self.stack.part(f"{level}.") for level in levels]
        self._optimiser = Adam(self.stack.flat, parts, config.max_gradient_norm)
        self._replay = ReplayBuffer(len(seeds), config.n_envs, config.replay_capacity, place)
        self._sampler = make_sampler(method, generators(seeds, Purpose.REPLAY), len(levels), self._replay.capacity)
        self._multistep = MultiStep(config.n_steps)
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
            learning_rate = linear(config.learning_rate, config.final_learning_rate, share)
            while self._update_is_due():
                self._update(learning_rate)
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
        joined = self._multistep.push(step, (simulator.outcomes != Outcome.RUNNING).reshape(shape))
        if joined is not None:
            self._sampler.added(self._replay.add(joined))
        self._count_outcomes()
        simulator.reset_done()
        self.env_steps += shape[1]

    def _update_is_due(self) -> bool:
        config = self.method.config
        return self.updates * config.steps_per_update < self.env_steps - config.warmup

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
        self.updates += 1
        if self.updates % config.target_interval == 0:
            self.stack.move_target(config.target_rate)

    def _make_explorers(self) -> list[Explorer]:
        streams, config = generators(self.seeds, Purpose.EXPLORATION), self.method.config
        return [Explorer(streams, config.n_envs, found, config.exploration_hold) for found in self.algorithm.choices]

    def _policy(self, index: int, seed: int) -> LearnedAgent:
        metadata = describe(self.method, self.scenario, seed, self.env_steps)
        return make_agent(self.method, self.scenario, self.stack.snapshot(index) | self._frozen, metadata)

    def _count_outcomes(self) -> None:
        rows = np.flatnonzero(self._simulator.outcomes != Outcome.RUNNING)
        np.add.at(self._outcome_counts, (rows // self.method.config.n_envs, self._simulator.outcomes[rows]), 1)

    def _report(self) -> Progress:
        with np.errstate(invalid="ignore"):
            means = self._losses / (self.updates - self._reported_updates)
        losses = dict(zip(self.algorithm.levels, means, strict=True))
        report = Progress(self.env_steps, self.updates, losses, self._outcome_counts)
        self._clear_meters()
        return report

    def _clear_meters(self) -> None:
        self._reported_updates = self.updates
        self._losses = np.zeros((len(self.algorithm.levels), len(self.seeds)))
        self._outcome_counts = np.zeros((len(self.seeds), len(Outcome)), np.int64)


def linear(start: float, end: float, share: float) -> float:
    """Return the value at `share` of the way from `start` to `end`; `end` beyond it."""
    return start + (end - start) * min(share, 1.0)
