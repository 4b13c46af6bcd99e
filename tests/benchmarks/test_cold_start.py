"""Seconds from starting Python to a first step and a first update, with kernels to compile and from the cache."""

import os
import subprocess
import sys
from itertools import count
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.systems import Report

FIRST_STEP = """
from hhrl_envs import stop_line_v0
env = stop_line_v0.parallel_env()
env.reset(seed=0)
env.step({"ego": 0})
"""

FIRST_UPDATE = """
import numpy as np
from hhrl_agents import METHODS
from hhrl_agents.training.learner import make_learner
from hhrl_envs import get_scenario
method = METHODS["hybrid-hrl"]
worlds = np.arange(method.config.n_envs, dtype=np.uint64)
learner = make_learner(method, get_scenario("stop-line-v0"), 0, worlds)
next(learner.train(method.config.warmup + method.config.n_envs))
assert learner.updates > 0
"""


def run(code: str, cache: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)


@pytest.mark.parametrize(
    ("what", "code", "cache", "bar"),
    [
        ("step", FIRST_STEP, "empty", 4),
        ("step", FIRST_STEP, "warm", 1),
        ("update", FIRST_UPDATE, "empty", 20),
        ("update", FIRST_UPDATE, "warm", 2),
    ],
)
def test_first(
    benchmark: BenchmarkFixture, report: Report, tmp_path: Path, what: str, code: str, cache: str, bar: int
) -> None:
    folders = (tmp_path / (str(n) if cache == "empty" else "kept") for n in count())
    benchmark.pedantic(run, setup=lambda: ((code, next(folders)), {}), rounds=3, warmup_rounds=1)
    if benchmark.stats is not None:
        report(f"first {what}, {cache} cache", f"{benchmark.stats.stats.min:.2f} s", "", "", "", f"at most {bar} s")
