"""Seconds from starting Python to the first step done, with kernels to compile and with kernels from the cache."""

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


def first_step(cache: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    subprocess.run([sys.executable, "-c", FIRST_STEP], env=environment, check=True)


@pytest.mark.parametrize(("cache", "bar"), [("empty", 4), ("warm", 1)])
def test_first_step(benchmark: BenchmarkFixture, report: Report, tmp_path: Path, cache: str, bar: int) -> None:
    folders = (tmp_path / (str(n) if cache == "empty" else "kept") for n in count())
    benchmark.pedantic(first_step, setup=lambda: ((next(folders),), {}), rounds=3, warmup_rounds=1)
    if benchmark.stats is not None:
        report(f"first step, {cache} cache", f"{benchmark.stats.stats.min:.2f} s", "", "", "", f"at most {bar} s")
