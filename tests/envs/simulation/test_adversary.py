"""The adversary: within human limits, judged by how the ego fares, and paid for it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hhrl_envs import Adversary, Outcome, Simulator, get_scenario
from support.driving import states
from support.recording import recorded

SCENARIO = get_scenario("adversary-v0")
FAILED = (Outcome.COLLISION, Outcome.NOT_STOP, Outcome.TIMEOUT)
ROWS = 32


@settings(max_examples=12, deadline=None, derandomize=True, database=None)
@given(seed=st.integers(0, 2**32), hold=st.integers(1, 60), wish=st.sampled_from([(0,), (0, 5), (0, 1, 2, 3, 4, 5)]))
def test_it_keeps_to_its_limits_whatever_it_wants(seed: int, hold: int, wish: tuple[int, ...]) -> None:
    rng = np.random.default_rng(seed)
    simulator = Simulator(SCENARIO, ROWS, learned_fronts=1)
    simulator.reset(np.arange(ROWS) + seed)
    stood = np.zeros(ROWS)
    for step in range(400):
        if step % hold == 0:
            wanted = rng.choice(wish, ROWS)
        running = simulator.of_agent(1).outcomes == Outcome.RUNNING
        simulator.step(np.stack([np.zeros(ROWS, np.int64), wanted], axis=1))
        speed, accel = states(simulator)[:, 1, 1:].T
        assert accel[running].min(initial=0.0) >= -4.5 - 1e-9
        stood += running & (speed == 0.0)
        used_up = running & (stood * SCENARIO.dt > 8.0 + 3 * SCENARIO.dt)
        assert not used_up.any(), "it stood longer than its patience lasts"


@pytest.mark.parametrize("fronts", [1, 3])
def test_it_succeeds_where_the_ego_failed_without_need(fronts: int) -> None:
    tape = recorded("adversary-v0", fronts)
    ends = tape.ends()
    for row in range(tape.outcomes.shape[2]):
        ego, own = Outcome(tape.outcomes[-1, 0, row]), Outcome(tape.outcomes[-1, 1, row])
        if own == Outcome.COLLISION:
            assert ends[1, row] <= ends[0, row]
            continue
        deserved = ego in FAILED and bool(tape.feasible[ends[0, row], row])
        assert own == (Outcome.SUCCESS if deserved else Outcome.FOILED)
        assert ends[1, row] == ends[0, row]


@pytest.mark.parametrize("fronts", [1, 3])
def test_its_rewards_are_the_documented_ones(fronts: int) -> None:
    tape, reward = recorded("adversary-v0", fronts), SCENARIO.reward
    jerk = np.diff(tape.vehicles[:, :, 1, 2], axis=0) / SCENARIO.dt
    lost = (Outcome.FOILED, Outcome.COLLISION)
    prizes = {Outcome.SUCCESS: reward.sigma_4, **dict.fromkeys(lost, -reward.sigma_4)}
    for row, end in enumerate(tape.ends()[1]):
        for frame in range(1, end + 1):
            outcome = Outcome(tape.outcomes[frame, 1, row])
            option = -reward.sigma_1 + prizes.get(outcome, 0.0)
            task = option - (reward.sigma_2 if abs(jerk[frame - 1, row]) > reward.jerk_threshold else 0.0)
            task -= reward.sigma_3 if outcome == Outcome.COLLISION else 0.0
            assert tape.rewards[frame, 1, row] == pytest.approx(task)
            assert tape.reward_option[frame, 1, row] == pytest.approx([option, option])
            assert tape.reward_action[frame, 1, row] == pytest.approx([task, task])


def test_the_line_does_not_bind_it() -> None:
    simulator = Simulator(SCENARIO, ROWS, learned_fronts=1)
    simulator.reset(np.arange(ROWS))
    for _ in range(150):
        simulator.step(np.tile([0, 4], (ROWS, 1)))
    passed = states(simulator)[:, 1, 0] > SCENARIO.vehicle.length
    assert (passed & (simulator.of_agent(1).outcomes == Outcome.RUNNING)).any()
    assert not (simulator.of_agent(1).outcomes == Outcome.NOT_STOP).any()


def test_its_wreck_stays_where_it_is() -> None:
    simulator = Simulator(replace(SCENARIO, adversary=Adversary(patience=1.0)), ROWS, learned_fronts=1)
    simulator.reset(np.arange(ROWS))
    since = np.zeros(ROWS)
    for _ in range(300):
        simulator.step(np.tile([0, 5], (ROWS, 1)))
        since += simulator.of_agent(1).outcomes == Outcome.COLLISION
        assert not states(simulator)[since > 50, 1, 1].any()
    assert (since > 100).any()
