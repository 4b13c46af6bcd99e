"""One seed's Proximal Policy Optimization, by Stable-Baselines3."""

from functools import partial

import numpy as np
import numpy.typing as npt
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.vec_env import DummyVecEnv
from torch import nn

from hhrl_agents.base import FloatArray, IntArray
from hhrl_agents.global_streams import GlobalStreams
from hhrl_agents.learning_view import LearningView
from hhrl_agents.mlp import Parameters
from hhrl_agents.ppo_config import PPOConfig
from hhrl_envs import Outcome, Scenario

LOSSES = {"policy": "train/policy_gradient_loss", "value": "train/value_loss"}


class OutcomeCounter(BaseCallback):
    """Counts the episodes that end, int64 [outcomes], by `hhrl_envs.Outcome`."""

    def __init__(self) -> None:
        super().__init__()
        self.counts = np.zeros(len(Outcome), np.int64)

    def _on_step(self) -> bool:
        for done, info in zip(self.locals["dones"], self.locals["infos"], strict=True):
            self.counts[info["outcome"]] += done
        return True

    def take(self) -> IntArray:
        """Return what was counted since the last call."""
        counts, self.counts = self.counts, np.zeros_like(self.counts)
        return counts


class PPOSeed:
    """One seed's PPO, with its own environments and random draws; `counter` counts its training episodes."""

    def __init__(self, config: PPOConfig, scenario: Scenario, seed: int, world_seeds: npt.NDArray[np.uint64]) -> None:
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

    def advance(self, steps: int, learning_rate: float) -> FloatArray:
        """Return the mean `LOSSES` of the updates after one rollout, `steps` steps of every environment."""
        self._learning_rate = learning_rate
        self._ppo.n_steps = self._ppo.rollout_buffer.buffer_size = steps
        with self._streams.lent():
            self._ppo.learn(steps * self._ppo.n_envs, self.counter, reset_num_timesteps=False)
        return np.array([self._ppo.logger.name_to_value[name] for name in LOSSES.values()])

    def parameters(self) -> Parameters:
        """Return a copy of the policy's network as a flat method's: logits in place of action values."""
        parameters: dict[str, torch.Tensor] = {}
        for index, layer in enumerate(self._layers):
            weight, bias = layer.weight.detach().T[None], layer.bias.detach()[None, None]
            parameters[f"action.{index}.weight"] = weight.clone(memory_format=torch.contiguous_format)
            parameters[f"action.{index}.bias"] = bias.clone()
        return parameters

    @property
    def _layers(self) -> list[nn.Linear]:
        """The layers of the policy's network, the logits' last."""
        named = self._ppo.policy.named_modules()
        parts = ("mlp_extractor.policy_net", "action_net")
        return [layer for name, layer in named if name.startswith(parts) and isinstance(layer, nn.Linear)]
