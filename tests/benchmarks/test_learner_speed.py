"""Environment steps a second of training next to Stable-Baselines3's DQN, and the price of the hierarchy.

Stacked seeds share every tensor operation, so a stack is measured in the steps of all its seeds.
"""

from collections.abc import Iterator

import pytest
import torch

from benchmarks.learners import arithmetic, learner, sb3_dqn
from benchmarks.systems import Compare, Report

pytestmark = pytest.mark.usefixtures("one_core", "one_thread")


@pytest.fixture
def one_thread() -> Iterator[None]:
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.mark.parametrize(("hidden", "seeds", "bar"), [(64, 1, 2.0), (64, 10, 7.0), (128, 1, 1.5), (128, 10, 3.0)])
def test_ddqn_next_to_sb3(compare: Compare, hidden: int, seeds: int, bar: float) -> None:
    compare(learner("ddqn", seeds, hidden), sb3_dqn(hidden), bar=bar, rounds=5)


@pytest.mark.parametrize("seeds", [1, 10])
def test_hybrid_hrl_next_to_ddqn(compare: Compare, seeds: int) -> None:
    compare(learner("hybrid-hrl", seeds), learner("ddqn", seeds), bar=0.33, rounds=5)


def test_hybrid_hrl_plus_next_to_ddqn_plus(compare: Compare, report: Report) -> None:
    compare(learner("hybrid-hrl-plus", 10), learner("ddqn-plus", 10), bar=0.33, rounds=5)
    report("matrix products", "", arithmetic(), "", "", "")
