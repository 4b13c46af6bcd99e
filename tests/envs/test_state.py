"""A simulator's state: another simulator that takes it up goes on to the same bits."""

import numpy as np
import pytest

from hhrl_envs import InputError, Simulator
from hhrl_envs.state import count, read_count

ROWS = 6


def drive(simulator: Simulator, steps: int, seed: int) -> list[bytes]:
    rng, seen = np.random.default_rng(seed), []
    shape = ROWS if simulator.num_agents == 1 else (ROWS, simulator.num_agents)
    for _ in range(steps):
        simulator.step(rng.integers(0, simulator.scenario.num_actions, shape))
        shown = simulator.arrays.all_observations, simulator.arrays.all_results, simulator.arrays.all_codes
        seen.append(b"".join(part.tobytes() for part in shown))
        simulator.reset_done()
    return seen


@pytest.mark.parametrize(("scenario", "fronts"), [("stop-line-v0", 0), ("stop-line-noisy-v0", 0), ("platoon-v0", 2)])
def test_another_simulator_goes_on_to_the_same_bits(scenario: str, fronts: int) -> None:
    first, second = (Simulator(scenario, ROWS, learned_fronts=fronts) for _ in range(2))
    first.reset(np.arange(ROWS))
    drive(first, 70, seed=1)
    saved = first.state()
    observations, key = first.observations.copy(), first.key(0)
    expected = drive(first, 150, seed=2)
    second.restore(saved)
    assert second.observations.tobytes() == observations.tobytes()
    assert second.key(0) == key
    assert drive(second, 150, seed=2) == expected


def test_the_state_of_another_simulator_is_refused() -> None:
    small, large = (Simulator("stop-line-v0", rows) for rows in (ROWS, 300))
    small.reset(np.arange(ROWS))
    with pytest.raises(InputError, match=r"the state holds float64 .* as 'numbers'; it must be float64"):
        large.restore(small.state())
    with pytest.raises(InputError, match="call reset"):
        large.state()


def test_a_count_is_read_as_it_was_written() -> None:
    assert read_count({"steps": count(7)}, "steps") == 7
    with pytest.raises(InputError, match="the state holds nothing as 'steps'"):
        read_count({}, "steps")
