"""Training as the benchmarks measure it: ours, and Stable-Baselines3's DQN doing the same work.

The same network, mini-batches of 64, one gradient step for every four environment steps, end to end: environment,
replay and updates. A round goes on from where the last one stopped.
"""

from dataclasses import replace

import gymnasium
import numpy as np
import torch
from stable_baselines3 import DQN

from benchmarks.systems import SCENARIO, System
from hhrl_agents import METHODS
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner


def learner(name: str, hidden: int = 64, steps: int = 1_920) -> System:
    """Return the training of a seed of a registered method."""
    method = METHODS[name]
    config = replace(method.config, hidden=(hidden, hidden), warmup=method.config.n_envs * method.config.n_steps)
    worlds = np.arange(config.n_envs, dtype=np.uint64)
    trained = DoubleDQNLearner(replace(method, config=config), SCENARIO, 0, worlds)

    def run() -> None:
        for _ in trained.train(trained.env_steps + steps):
            pass

    return System(f"{name}, 2x{hidden}", steps, lambda: None, run)


def sb3_dqn(hidden: int = 64, steps: int = 2_000) -> System:
    """Return the training of Stable-Baselines3's DQN on the Gymnasium view, with its other settings as they come."""
    env = gymnasium.make("hhrl_envs:hhrl_envs/StopLine-v0")
    model = DQN(
        "MlpPolicy",
        env,
        policy_kwargs={"net_arch": [hidden, hidden]},
        batch_size=64,
        train_freq=4,
        gradient_steps=1,
        learning_starts=100,
        device="cpu",
    )
    model.learn(200)

    def run() -> None:
        model.learn(steps, reset_num_timesteps=False)

    return System(f"SB3 DQN, 2x{hidden}", steps, lambda: None, run)


def arithmetic() -> str:
    """Return the library of matrix products, the instructions it uses, and its threads."""
    build = torch.__config__.show()
    blas = next((line for line in build.splitlines() if "Kernel Library" in line or "BLAS" in line), "BLAS unknown")
    capability = torch.backends.cpu.get_cpu_capability()
    return f"{blas.strip(' -')}, {capability}, {torch.get_num_threads()} thread"
