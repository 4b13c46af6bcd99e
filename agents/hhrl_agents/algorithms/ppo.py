"""Proximal Policy Optimization by Stable-Baselines3: a control of the on-policy kind, made outside this package."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from math import ceil
from typing import Any

import gymnasium
import numpy as np
import stable_baselines3
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import DummyVecEnv
from torch import nn

from hhrl_agents.methods.configs import PPOConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import Parameters
from hhrl_agents.seeding import Purpose, generator
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.environments import require_world_seeds
from hhrl_agents.training.learner import NOTHING, Learner, Start
from hhrl_envs import Outcome, Scenario
from hhrl_envs.arrays import Floats, Floats32, Ints, Keys
from hhrl_envs.simulation.rewards import TIMEOUT, UNSMOOTH
from hhrl_envs.views.gym_env import StopLineEnv

LOSSES = {"policy": "train/policy_gradient_loss", "value": "train/value_loss"}
"""The losses that are reported, and what the library calls them."""


class PPOLearner(Learner):
    """Trains a method by PPO.

    Stable-Baselines3 keeps its state to itself, so a training that was stopped begins anew. It draws from the global
    generators of numpy and torch, so that no two learners may run at a time.
    """

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        seed: int,
        world_seeds: Keys,
        drivers: Drivers = EGO_ALONE,
        start: Start = NOTHING,
    ) -> None:
        super().__init__(method, scenario, seed, losses=[*LOSSES])
        self._require_plain(drivers, start)
        require_world_seeds(world_seeds, self.config.n_envs)
        self._trained = PPOSeed(self.config, scenario, seed, world_seeds)

    def _advance(self, env_steps: int, span: int) -> None:
        """Take one rollout, the last one as short as the budget asks for, and its updates; see `Learner._advance`."""
        config = self.config
        steps = min(config.rollout_steps, ceil((env_steps - self.env_steps) / config.n_envs))
        learning_rate = config.learning_rate_at(
            1.0 - ceil((span - self.env_steps) / config.n_envs) * config.n_envs / span
        )
        self._add_losses(self._trained.advance(steps, learning_rate))
        self.env_steps += steps * config.n_envs
        self.updates += config.epochs * ceil(steps * config.n_envs / config.batch_size)

    def _policy_parameters(self) -> Parameters:
        return self._trained.parameters()

    def _take_outcome_counts(self) -> Ints:
        return self._trained.counter.take()

    def _metadata(self) -> dict[str, Any]:
        versions = {"torch": torch.__version__, "stable_baselines3": stable_baselines3.__version__}
        return {**super()._metadata(), "versions": versions}


class OutcomeCounter(BaseCallback):
    """Counts the episodes that end, int64 [outcomes], by `hhrl_envs.Outcome`."""

    def __init__(self) -> None:
        super().__init__()
        self.counts = np.zeros(len(Outcome), np.int64)

    def _on_step(self) -> bool:
        for done, info in zip(self.locals["dones"], self.locals["infos"], strict=True):
            self.counts[info["outcome"]] += done
        return True

    def take(self) -> Ints:
        """Return what was counted since the last call."""
        counts, self.counts = self.counts, np.zeros_like(self.counts)
        return counts


class PPOSeed:
    """One seed's PPO, with its own environments and random draws; `counter` counts its training episodes."""

    def __init__(self, config: PPOConfig, scenario: Scenario, seed: int, world_seeds: Keys) -> None:
        self.counter = OutcomeCounter()
        self._learning_rate = config.learning_rate
        self._streams = GlobalStreams(seed)
        worlds = [partial(LearningView, scenario, config, int(world_seed)) for world_seed in world_seeds]
        with self._streams.lent():
            self._ppo = PPO(
                "MlpPolicy",
                DummyVecEnv([*worlds]),
                learning_rate=lambda _: self._learning_rate,
                n_steps=config.rollout_steps,
                batch_size=config.batch_size,
                n_epochs=config.epochs,
                gamma=config.gamma,
                gae_lambda=config.gae_lambda,
                clip_range=config.clip,
                ent_coef=config.entropy_coefficient,
                vf_coef=config.value_coefficient,
                max_grad_norm=config.max_gradient_norm,
                policy_kwargs={"net_arch": list(config.hidden), "activation_fn": nn.ReLU},
                device="cpu",
            )
        self._layers[-1].bias.data += config.throttle_bias * torch.tensor(scenario.vehicle.levels)
        self._ppo.set_logger(Logger(folder=None, output_formats=[]))

    def advance(self, steps: int, learning_rate: float) -> Floats:
        """Return the mean `LOSSES` of the updates after one rollout, `steps` steps of every environment."""
        self._learning_rate = learning_rate
        self._ppo.n_steps = self._ppo.rollout_buffer.buffer_size = steps
        with self._streams.lent():
            self._ppo.learn(steps * self._ppo.n_envs, self.counter, reset_num_timesteps=False)
        return np.array([self._ppo.logger.name_to_value[name] for name in LOSSES.values()])

    def parameters(self) -> Parameters:
        """Return a copy of the policy's network as a flat method's: logits in place of action values."""
        parameters: dict[str, Floats32] = {}
        for index, layer in enumerate(self._layers):
            weight, bias = layer.weight.detach().numpy().T[None], layer.bias.detach().numpy()[None, None]
            parameters[f"action.{index}.weight"] = weight.copy()
            parameters[f"action.{index}.bias"] = bias.copy()
        return parameters

    @property
    def _layers(self) -> list[nn.Linear]:
        """The layers of the policy's network, the logits' last."""
        named = self._ppo.policy.named_modules()
        parts = ("mlp_extractor.policy_net", "action_net")
        return [layer for name, layer in named if name.startswith(parts) and isinstance(layer, nn.Linear)]


States = tuple[Any, torch.Tensor]


class GlobalStreams:
    """What one seed draws from the global generators of numpy and torch, a pure function of the seed."""

    def __init__(self, seed: int) -> None:
        drawn = int(generator(seed, Purpose.INITIALISATION).integers(2**32))
        legacy = np.random.RandomState(drawn)
        self._states: States = (legacy.get_state(), torch.Generator().manual_seed(drawn).get_state())

    @contextmanager
    def lent(self) -> Iterator[None]:
        """Return a context in which the global generators go on where this seed's last draws ended.

        Torch computes with one thread in it, from which small networks gain, and in one order of every sum. After it
        all is what it was before.
        """
        before, threads = _states(), torch.get_num_threads()
        torch.set_num_threads(1)
        _set(self._states)
        try:
            yield
        finally:
            self._states = _states()
            _set(before)
            torch.set_num_threads(threads)


def _states() -> States:
    return np.random.get_state(), torch.get_rng_state()  # noqa: NPY002


def _set(states: States) -> None:
    np.random.set_state(states[0])  # noqa: NPY002
    torch.set_rng_state(states[1])


class LearningView(gymnasium.Wrapper[Floats32, Any, Floats32, Any]):
    """One environment of a learner: episode after episode of the world `world_seed`, with scaled rewards.

    Where a time limit counts as truncation its penalty is left out; else it terminates. `info` holds `outcome` alone.
    """

    def __init__(self, scenario: Scenario, config: PPOConfig, world_seed: int) -> None:
        self._view = StopLineEnv(scenario)
        super().__init__(self._view)
        self._config = config
        self._first_seed: int | None = world_seed

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats32, dict[str, Any]]:
        """Return the first observation, float32 [SIZE], of the world's next episode, whatever the seed, and no info."""
        seed, self._first_seed = self._first_seed, None
        return self._view.reset(seed=seed, options=options)[0], {}

    def step(self, action: Any) -> tuple[Floats32, float, bool, bool, dict[str, Any]]:
        """Return observation, scaled r^task, terminated, truncated and the outcome after one step."""
        observation, reward, terminated, truncated, info = self._view.step(action)
        terms = self._view.parallel.simulator.terms[0]
        reward -= (1.0 - self._config.jerk_weight) * float(terms[UNSMOOTH])
        if truncated and self._config.timeout == "truncation":
            reward -= float(terms[TIMEOUT])
        elif truncated:
            terminated, truncated = True, False
        outcome = {"outcome": info.get("outcome", Outcome.RUNNING)}
        return observation, reward * self._config.reward_scale, terminated, truncated, outcome
