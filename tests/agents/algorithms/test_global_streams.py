import numpy as np
import pytest
import torch

from hhrl_agents.algorithms.ppo import GlobalStreams


def draw(streams: GlobalStreams) -> tuple[float, float]:
    with streams.lent():
        return float(np.random.random()), float(torch.rand(()))  # noqa: NPY002


def test_a_seed_s_draws_are_its_own_and_go_on() -> None:
    alone = GlobalStreams(3)
    expected = [draw(alone) for _ in range(3)]
    ours, others = GlobalStreams(3), GlobalStreams(4)
    drawn = [(draw(ours), draw(others), torch.manual_seed(7))[0] for _ in range(3)]
    assert drawn == expected
    assert len(set(expected)) == 3


def test_the_global_generators_stay_as_they_were_even_after_an_error() -> None:
    before = torch.get_rng_state().clone(), repr(np.random.get_state(legacy=False))  # noqa: NPY002
    with pytest.raises(ZeroDivisionError), GlobalStreams(3).lent():
        print(torch.rand(3), np.random.random(3), 1 / 0)  # noqa: NPY002
    assert torch.equal(torch.get_rng_state(), before[0])
    assert repr(np.random.get_state(legacy=False)) == before[1]  # noqa: NPY002
