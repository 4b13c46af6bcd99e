"""Steps a second next to the quickest peers, each pair in one run.

Random actions are all drawn beforehand. With the two strongest brakes among them the ego mostly stands before it
reaches anything; without them many episodes end, and beginning the next ones is in the price. Both are shown.
"""

import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks.highway import highway_env
from benchmarks.sumo import sumo
from benchmarks.systems import STRONG_BRAKES, Compare, cartpole, parallel_env, simulator, vector_env

CORES = len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
actions = pytest.mark.parametrize("lowest", [0, STRONG_BRAKES], ids=["all-actions", "no-strong-brakes"])


@actions
@pytest.mark.usefixtures("one_core")
def test_parallel_env_next_to_sumo(compare: Compare, tmp_path: Path, lowest: int) -> None:
    with sumo(tmp_path) as peer:
        compare(parallel_env(lowest), peer, bar=1.5)


@pytest.mark.usefixtures("one_core")
def test_parallel_env_next_to_highway_env(compare: Compare) -> None:
    compare(parallel_env(STRONG_BRAKES), highway_env(), bar=700, rounds=5)


@actions
@pytest.mark.usefixtures("one_core")
def test_vector_env_next_to_cartpole(compare: Compare, lowest: int) -> None:
    compare(vector_env(lowest), cartpole(), bar=3)


@pytest.mark.skipif(CORES < 2, reason="two threads need two cores")
def test_two_threads_next_to_one(compare: Compare, a_core_each: Callable[[], None]) -> None:
    two, one = simulator(threads=2), simulator(threads=1)
    a_core_each()
    compare(two, one, bar=1.7)
