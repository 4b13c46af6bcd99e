import copy

import numpy as np

from hhrl_envs import Simulator
from hhrl_envs.spares import Spares


def test_an_array_is_handed_out_again_only_when_nobody_holds_it() -> None:
    spares = Spares((4, 5), np.float64)
    first = spares.take()
    second = spares.take()
    assert first is not second
    view = first[1:3].T
    address = first.ctypes.data
    del first
    assert all(spares.take().ctypes.data != address for _ in range(5))
    del view
    again = [spares.take() for _ in range(2)]
    assert len({array.ctypes.data for array in again}) == 2


def test_what_a_simulator_handed_out_never_changes() -> None:
    simulator = Simulator("stop-line-v0", 64)
    simulator.reset(np.arange(64))
    kept = []
    for step in range(40):
        simulator.step(np.full(64, 2 + step % 4), autoreset=True)
        parts = (simulator.observations, simulator.rewards, simulator.reward_option, simulator.outcomes)
        kept.append((parts if step % 3 else parts[:1], copy.deepcopy(parts if step % 3 else parts[:1])))
    for given, copied in kept:
        for one, other in zip(given, copied, strict=True):
            np.testing.assert_array_equal(one, other)
