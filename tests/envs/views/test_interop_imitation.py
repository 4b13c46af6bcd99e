"""imitation clones a rule from rollouts that lay on the disk, and trains with GAIL, past many ends of both kinds."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_envs import SCENARIOS, Outcome, observation

pytest.importorskip("imitation", reason="imitation is not installed; run: make interop")
import torch
from imitation.algorithms.adversarial.gail import GAIL
from imitation.algorithms.bc import BC
from imitation.data import rollout, serialize
from imitation.data.wrappers import RolloutInfoWrapper
from imitation.rewards.reward_nets import BasicRewardNet
from imitation.util.logger import configure
from imitation.util.util import make_vec_env
from stable_baselines3 import PPO

pytestmark = pytest.mark.filterwarnings("ignore")  # of packages that are not ours
SHORT = replace(SCENARIOS["stop-line-v0"], id="short-v0", horizon=60, feasible_only=False)
EPISODES = 40
THROTTLE, ROLL_ON = 5, 3


def speed_up(observations: NDArray[np.float32], state: Any, _: Any) -> tuple[NDArray[np.int64], Any]:
    return np.where(observations[:, observation.V_E] < 0.7, THROTTLE, ROLL_ON), state


def make() -> Any:
    return make_vec_env(
        "hhrl_envs/StopLine-v0",
        rng=np.random.default_rng(0),
        n_envs=4,
        post_wrappers=[lambda env, _: RolloutInfoWrapper(env)],
        env_make_kwargs={"scenario": SHORT},
    )


def rollouts(envs: Any) -> Any:
    until = rollout.make_sample_until(min_episodes=EPISODES)
    return rollout.rollout(speed_up, envs, until, rng=np.random.default_rng(0), exclude_infos=False)


def test_behaviour_is_cloned(tmp_path: Path) -> None:
    envs = make()
    serialize.save(tmp_path / "rollouts", rollouts(envs))
    episodes = list(serialize.load(tmp_path / "rollouts"))
    assert len(episodes) >= EPISODES
    outcomes = {int(episode.infos[-1]["outcome"]) for episode in episodes}
    assert Outcome.TIMEOUT in outcomes
    assert len(outcomes) > 1
    steps = rollout.flatten_trajectories(episodes)
    assert 0.3 < (steps.acts == THROTTLE).mean() < 0.7
    torch.manual_seed(0)  # BC draws its first weights from there
    cloning = BC(
        observation_space=envs.observation_space,
        action_space=envs.action_space,
        demonstrations=steps,
        rng=np.random.default_rng(0),
        device="cpu",
        custom_logger=configure(tmp_path, []),
    )
    cloning.train(n_epochs=4, progress_bar=False)
    chosen, _ = cloning.policy.predict(steps.obs, deterministic=True)
    assert (chosen == steps.acts).mean() > 0.9


def test_gail_trains(tmp_path: Path) -> None:
    envs = make()
    trainer = GAIL(
        demonstrations=rollouts(envs),
        demo_batch_size=64,
        venv=envs,
        gen_algo=PPO("MlpPolicy", envs, n_steps=128, batch_size=64, n_epochs=1, device="cpu"),
        reward_net=BasicRewardNet(envs.observation_space, envs.action_space),
        allow_variable_horizon=True,
        log_dir=tmp_path,
        custom_logger=configure(tmp_path, []),
    )
    trainer.train(2048)
    assert len(trainer.gen_algo.ep_info_buffer) > 20
