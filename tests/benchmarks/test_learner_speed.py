"""Environment steps a second of training next to Stable-Baselines3's DQN, and the price of the hierarchy."""

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


@pytest.mark.parametrize(("hidden", "bar"), [(64, 12.0), (128, 6.0)])
def test_ddqn_next_to_sb3(compare: Compare, hidden: int, bar: float) -> None:
    compare(learner("ddqn", hidden), sb3_dqn(hidden), bar=bar, rounds=5)


def test_hybrid_hrl_next_to_ddqn(compare: Compare) -> None:
    compare(learner("hybrid-hrl"), learner("ddqn"), bar=0.4, rounds=5)


def test_hybrid_hrl_plus_next_to_ddqn_plus(compare: Compare, report: Report) -> None:
    compare(learner("hybrid-hrl-plus"), learner("ddqn-plus"), bar=0.4, rounds=5)
    report("matrix products of Stable-Baselines3", "", arithmetic(), "", "", "")
