"""RLlib trains on the PettingZoo view. ray[rllib] pins an older Gymnasium, so ``make interop`` runs this apart."""

import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from hhrl_envs import triad
from hhrl_envs.views.parallel_env import EGO

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # RLlib and what it imports use names that are being retired
    pytest.importorskip("ray.rllib", reason="ray[rllib] is not installed; run: make interop", exc_type=ImportError)
    import ray
    from ray.rllib.algorithms.ppo import PPOConfig
    from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
    from ray.rllib.env.wrappers.pettingzoo_env import ParallelPettingZooEnv
    from ray.tune.registry import register_env

pytestmark = pytest.mark.filterwarnings("ignore")  # RLlib warns of its own ways, with every release of others


@pytest.fixture(scope="module")
def _cluster() -> Iterator[None]:
    ray.init(num_cpus=1, include_dashboard=False, object_store_memory=100_000_000, log_to_driver=False)
    yield
    ray.shutdown()


def make_env(config: dict[str, Any]) -> ParallelPettingZooEnv:
    return ParallelPettingZooEnv(triad(config.get("scenario", "stop-line-v0")).parallel_env())


@pytest.mark.parametrize("scenario_id", ["stop-line-v0", "two-stops-v0"])
def test_the_wrapped_view_tells_the_same_story(scenario_id: str) -> None:
    wrapped, alone = make_env({"scenario": scenario_id}), triad(scenario_id).parallel_env()
    assert (wrapped.reset(seed=4)[0][EGO] == alone.reset(seed=4)[0][EGO]).all()
    while alone.agents:
        told, expected = wrapped.step({EGO: 5}), alone.step({EGO: 5})
        assert np.array_equal(told[0][EGO], expected[0][EGO])
        assert [part[EGO] for part in told[1:4]] == [part[EGO] for part in expected[1:4]]
    assert told[2]["__all__"] or told[3]["__all__"]


@pytest.mark.usefixtures("_cluster")
def test_ppo_trains_a_few_iterations() -> None:
    register_env("stop-line", make_env)
    config = (
        PPOConfig()
        .environment("stop-line", env_config={"scenario": "solo-stop-v0"})
        .env_runners(num_env_runners=0)
        .learners(num_learners=0)
        .multi_agent(policies={EGO}, policy_mapping_fn=lambda agent, *_, **__: agent)
        .rl_module(model_config=DefaultModelConfig(fcnet_hiddens=[32, 32]))
        .training(train_batch_size_per_learner=1200, minibatch_size=200, num_epochs=2, lr=1e-3)
        .debugging(seed=1)
    )
    algorithm = config.build_algo()
    for _ in range(3):
        result = algorithm.train()
    algorithm.stop()
    runners = result["env_runners"]
    assert runners["num_env_steps_sampled_lifetime"] >= 3600
    assert np.isfinite(runners["episode_return_mean"])
    assert np.isfinite(result["learners"][EGO]["policy_loss"])
