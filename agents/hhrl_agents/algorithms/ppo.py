"""Proximal Policy Optimization by Stable-Baselines3: a control of the on-policy kind, made outside this package."""

from collections.abc import Iterator, Sequence
from math import ceil
from typing import cast

import numpy as np
import numpy.typing as npt
import stable_baselines3

from hhrl_agents.algorithms.double_dqn import linear
from hhrl_agents.algorithms.ppo_seed import LOSSES, PPOSeed
from hhrl_agents.methods.configs import PPOConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.policies.learned_agent import LearnedAgent, describe, make_agent
from hhrl_agents.training.learner import Progress
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats
from hhrl_envs.errors import InputError
from hhrl_envs.state import State


class PPOLearner:
    """Trains E independent seeds of PPO side by side; the interface and the arguments are those of `Learner`."""

    def __init__(
        self, method: Method, scenario: Scenario, seeds: Sequence[int], world_seeds: npt.NDArray[np.uint64]
    ) -> None:
        self._config = cast(PPOConfig, method.config)
        if np.shape(world_seeds) != (len(seeds), self._config.n_envs):
            raise InputError(
                f"world_seeds have shape {np.shape(world_seeds)}; write {(len(seeds), self._config.n_envs)}"
            )
        self.method, self.scenario, self.seeds = method, scenario, tuple(seeds)
        self.env_steps = self.updates = 0
        self._trained = [
            PPOSeed(self._config, scenario, seed, worlds) for seed, worlds in zip(seeds, world_seeds, strict=True)
        ]

    def train(self, env_steps: int) -> Iterator[Progress]:
        """Yield a report after the rollout that reaches `report_every` environment steps, and at the end.

        The learning rate's schedule spans these `env_steps`, which are each seed's, rounded up to whole steps of its
        `n_envs` environments; the last rollout is as short as they ask for.
        """
        config, losses = self._config, list[Floats]()
        remaining = ceil(env_steps / config.n_envs)
        while remaining:
            steps = min(config.rollout_steps, remaining)
            share = 1.0 - remaining * config.n_envs / env_steps
            losses.append(self._advance(steps, linear(config.learning_rate, config.final_learning_rate, share)))
            remaining -= steps
            if not remaining or self.env_steps % config.report_every < steps * config.n_envs:
                yield self._report(losses)
                losses = []

    def policies(self) -> list[LearnedAgent]:
        """Return each seed's most probable actions as a policy as it is now, which later training does not change."""
        return [self._policy(seed, trained) for seed, trained in zip(self.seeds, self._trained, strict=True)]

    def state(self) -> None:
        """Return None: Stable-Baselines3 keeps its state to itself, so training begins anew where it was stopped."""

    def restore(self, state: State) -> None:
        """Return nothing; there is nothing to restore."""

    def _advance(self, steps: int, learning_rate: float) -> Floats:
        """Return every seed's losses, [E, losses], after one rollout and its updates."""
        losses = np.stack([trained.advance(steps, learning_rate) for trained in self._trained])
        self.env_steps += steps * self._config.n_envs
        self.updates += self._config.epochs * ceil(steps * self._config.n_envs / self._config.batch_size)
        return losses

    def _report(self, losses: Sequence[Floats]) -> Progress:
        means = np.mean(losses, axis=0)
        counts = np.stack([trained.counter.take() for trained in self._trained])
        return Progress(self.env_steps, self.updates, dict(zip(LOSSES, means.T, strict=True)), counts)

    def _policy(self, seed: int, trained: PPOSeed) -> LearnedAgent:
        metadata = describe(self.method, self.scenario, seed, self.env_steps)
        metadata["versions"]["stable_baselines3"] = stable_baselines3.__version__
        return make_agent(self.method, self.scenario, trained.parameters(), metadata)
