import copy

import numpy as np

from hhrl_envs import Simulator
from hhrl_envs.simulation.engine.layout import OPTION_RESULTS
from hhrl_envs.simulation.engine.memory import ArrayPool


def test_arrays_are_handed_out_again_only_when_nobody_holds_one_of_them() -> None:
    pool = ArrayPool(agents=2, rows=5)
    first = pool.take()
    kept, address = first.all_results[OPTION_RESULTS].T, first.all_results.ctypes.data
    del first
    assert all(pool.take().all_results.ctypes.data != address for _ in range(5))
    del kept
    flags = pool.take().terminations
    assert pool.take().terminations is not flags


def test_arrays_that_nobody_holds_are_filled_again() -> None:
    pool = ArrayPool(agents=1, rows=5)
    address = pool.take().all_codes.ctypes.data
    assert pool.take().all_codes.ctypes.data == address


def test_a_copied_simulator_hands_out_views_of_its_own_results() -> None:
    simulator = Simulator("stop-line-v0", 3)
    simulator.reset(np.arange(3))
    twin = copy.deepcopy(simulator)
    for one in (simulator, twin):
        one.step([5, 5, 5])
    assert np.shares_memory(twin.arrays.observations, twin.arrays.all_observations)
    np.testing.assert_array_equal(twin.observations, simulator.observations)


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
