"""Environment steps a second of training, acting and learning together, with one torch thread.

Stacked seeds share every tensor operation: the figure to compare is the time of a whole stack with that of one seed.
"""

from dataclasses import replace

import numpy as np
import pytest
import torch
from pytest_benchmark.fixture import BenchmarkFixture

from hhrl_agents import METHODS
from hhrl_agents.learners import Learner
from hhrl_envs import get_scenario

STEPS = 4_000


@pytest.mark.parametrize("seeds", [1, 5])
@pytest.mark.parametrize("name", ["ddqn", "hybrid-hrl"])
def test_training_steps(benchmark: BenchmarkFixture, name: str, seeds: int) -> None:
    torch.set_num_threads(1)
    method = replace(METHODS[name], config=replace(METHODS[name].config, warmup=METHODS[name].config.n_envs))
    worlds = np.arange(seeds * method.config.n_envs, dtype=np.uint64).reshape(seeds, -1)
    learner = Learner(method, get_scenario("stop-line-v0"), range(seeds), worlds)
    list(learner.train(STEPS))  # compiles, and fills the replay
    benchmark.extra_info["env_steps"] = seeds * STEPS
    benchmark.extra_info["updates"] = STEPS // method.config.steps_per_update
    benchmark(lambda: list(learner.train(learner.env_steps + STEPS)))
