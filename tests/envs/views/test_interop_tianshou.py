"""Tianshou's DQN trains on the Gymnasium view, and several of them on the PettingZoo view, past many ends."""

from dataclasses import replace
from typing import Any

import gymnasium
import pytest
from pettingzoo.utils import parallel_to_aec

from hhrl_envs import SCENARIOS, NumericInfos, triad

pytest.importorskip("tianshou", reason="Tianshou is not installed; run: make interop")
from tianshou.algorithm.modelfree.dqn import DQN, DiscreteQLearningPolicy
from tianshou.algorithm.multiagent.marl import MultiAgentOffPolicyAlgorithm
from tianshou.algorithm.optim import AdamOptimizerFactory
from tianshou.data import Collector, VectorReplayBuffer
from tianshou.env import DummyVectorEnv, PettingZooEnv
from tianshou.trainer import OffPolicyTrainerParams
from tianshou.utils.net.common import Net

pytestmark = pytest.mark.filterwarnings("ignore")  # of packages that are not ours
SHORT = replace(SCENARIOS["stop-line-v0"], id="short-v0", horizon=60, feasible_only=False)


def dqn(env: Any) -> DQN[Any]:
    net = Net(state_shape=(11,), action_shape=6, hidden_sizes=[32])
    policy = DiscreteQLearningPolicy(
        model=net, action_space=env.action_space, observation_space=env.observation_space, eps_training=0.5
    )
    return DQN(policy=policy, optim=AdamOptimizerFactory(lr=1e-3), target_update_freq=100)


def train(algorithm: Any, make: Any, reduction: Any = None) -> Any:
    collector = Collector(algorithm, DummyVectorEnv([make] * 2), VectorReplayBuffer(4000, 2))
    collector.reset()
    return algorithm.run_training(
        OffPolicyTrainerParams(
            training_collector=collector,
            max_epochs=1,
            epoch_num_steps=1000,
            collection_step_num_env_steps=100,
            batch_size=32,
            update_step_num_gradient_steps_per_sample=0.1,
            show_progress=False,
            verbose=False,
            multi_agent_return_reduction=reduction,
        )
    )


def test_dqn_trains() -> None:
    def make() -> Any:
        return gymnasium.make("hhrl_envs:hhrl_envs/StopLine-v0", scenario=SHORT)

    done = train(dqn(make()), make)
    assert done.train_episode > 5


def test_several_agents_train() -> None:
    def make() -> PettingZooEnv:
        view = NumericInfos(triad(SHORT).parallel_env(learned_fronts=2))
        return PettingZooEnv(parallel_to_aec(view))

    env = make()
    done = train(
        MultiAgentOffPolicyAlgorithm(algorithms=[dqn(env) for _ in env.agents], env=env), make, lambda each: each[:, 0]
    )
    assert done.train_episode > 3
