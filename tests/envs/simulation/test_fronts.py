"""Learned front vehicles, watched from outside: how they begin, end, drive on and are rewarded."""

from collections import Counter

import numpy as np
import pytest

from hhrl_envs import Goal, Outcome, Simulator, get_scenario
from hhrl_envs.simulation.traffic import HARDEST_DECEL
from hhrl_envs.views.parallel_env import StopLineParallelEnv
from hhrl_envs.views.spaces import observation_space
from support.driving import traffic_actions
from support.recording import LEARNED, Recording, recorded
from support.reference import Facts, judge, rewards

EACH = pytest.mark.parametrize(("scenario_id", "fronts"), LEARNED)
ONE_LINE = pytest.mark.parametrize(
    ("scenario_id", "fronts"),
    [(name, n) for name, n in LEARNED if get_scenario(name).goal == Goal.STOP and name != "two-stops-v0"],
)
OF_EGO = {Outcome.COLLISION, Outcome.NOT_STOP, Outcome.SUCCESS, Outcome.TIMEOUT}
HANDED_OVER, WRECKED = (Outcome.SUCCESS, Outcome.NOT_STOP), (Outcome.COLLISION, Outcome.REAR_ENDED)


def adversarial(tape: Recording, agent: int) -> bool:
    return tape.scenario.adversary is not None and agent == 1


@EACH
def test_they_begin_ahead_of_the_ego_and_where_an_ego_alone_would(scenario_id: str, fronts: int) -> None:
    scenario = get_scenario(scenario_id)
    rows = 300
    simulator = Simulator(scenario, rows, learned_fronts=fronts)
    simulator.reset(np.arange(rows))
    begun = np.stack([simulator.vehicles(row)[:, 0] for row in range(rows)])
    low, high = scenario.road.start_distance
    assert (begun[:, fronts] <= -low).all()
    assert (begun[:, fronts] >= -high).all()
    assert (np.diff(begun[:, : fronts + 1]) > scenario.vehicle.length).all()
    counts = set((~np.isnan(begun[:, 1:])).sum(axis=1).tolist())
    shares = enumerate(scenario.traffic.count_shares)
    assert counts == {count for count, share in shares if count >= fronts and share > 0.0}


@EACH
def test_each_ends_once_in_one_way_and_the_row_with_the_last(scenario_id: str, fronts: int) -> None:
    tape = recorded(scenario_id, fronts)
    ends, rows = tape.ends(), range(tape.outcomes.shape[2])
    for agent in range(tape.agents):
        allowed = OF_EGO | ({Outcome.REAR_ENDED} if agent > 0 else set())
        if adversarial(tape, agent):
            allowed = {Outcome.COLLISION, Outcome.SUCCESS, Outcome.FOILED}
        for row in rows:
            own, end = tape.outcomes[:, agent, row], ends[agent, row]
            assert 0 < end <= tape.scenario.horizon
            assert not own[:end].any()
            assert (own[end:] == own[end]).all()
            assert own[end] in allowed
            assert not tape.rewards[end + 1 :, agent, row].any()
    last = ends.max(axis=0)
    wanted = np.minimum(np.arange(tape.frames)[:, None], last)
    np.testing.assert_array_equal(tape.steps, wanted)


def test_together_the_recordings_show_every_outcome_of_ego_fronts_and_adversary() -> None:
    seen: Counter[tuple[str, Outcome]] = Counter()
    for scenario_id, fronts in LEARNED:
        tape = recorded(scenario_id, fronts)
        for agent in range(tape.agents):
            name = "adversary" if adversarial(tape, agent) else ("front" if agent > 0 else "ego")
            seen.update((name, Outcome(outcome)) for outcome in tape.outcomes[-1, agent])
    wanted = {("ego", outcome) for outcome in OF_EGO} | {("front", outcome) for outcome in OF_EGO}
    wanted |= {("front", Outcome.REAR_ENDED), ("adversary", Outcome.SUCCESS), ("adversary", Outcome.FOILED)}
    assert wanted <= set(seen)
    assert len(np.unique(recorded("platoon-v0", 3).ends()[:, 0])) > 1


@ONE_LINE
def test_outcomes_are_those_of_an_independent_judge(scenario_id: str, fronts: int) -> None:
    tape = recorded(scenario_id, fronts)
    for agent in range(tape.agents):
        if adversarial(tape, agent):
            continue
        for row, end in enumerate(tape.ends()[agent]):
            for frame in range(1, end + 1):
                positions = tape.vehicles[frame, row, :, 0]
                told = judge(tape.scenario, positions, tape.vehicles[frame, row, agent, 1], agent, frame)
                assert told == tape.outcomes[frame, agent, row], (agent, row, frame)


def facts_of(tape: Recording, frame: int, agent: int, row: int) -> Facts:
    x, speed, accel = tape.vehicles[frame, row, agent]
    leader = tape.vehicles[frame, row, agent + 1] if agent + 1 < tape.vehicles.shape[2] else np.full(3, np.nan)
    d_f = leader[0] - tape.scenario.vehicle.length - x
    return Facts(
        v_e=speed,
        j_e=(accel - tape.vehicles[frame - 1, row, agent, 2]) / tape.scenario.dt,
        d_d=min(-x, tape.scenario.sensor.line_range),
        d_f=np.inf if np.isnan(d_f) else max(d_f, 0.0),
        v_f=leader[1],
        outcome=Outcome(tape.outcomes[frame, agent, row]),
    )


@ONE_LINE
def test_they_are_rewarded_by_the_same_equations(scenario_id: str, fronts: int) -> None:
    tape = recorded(scenario_id, fronts)
    for agent in range(tape.agents):
        if adversarial(tape, agent):
            continue
        got, wanted = [], []
        for row, end in enumerate(tape.ends()[agent]):
            for frame in {*range(1, end + 1, 3), end}:
                task, option, action = rewards(facts_of(tape, frame, agent, row), tape.scenario)
                wanted.append([task, *option, *action])
                two_levels = tape.reward_option[frame, agent, row], tape.reward_action[frame, agent, row]
                got.append([tape.rewards[frame, agent, row], *two_levels[0], *two_levels[1]])
        np.testing.assert_allclose(got, wanted, rtol=1e-9, atol=1e-9)


@EACH
def test_nobody_moves_backwards_brakes_too_hard_or_touches_unnoticed(scenario_id: str, fronts: int) -> None:
    tape = recorded(scenario_id, fronts)
    scenario, gaps = tape.scenario, tape.gaps()
    assert not (np.diff(tape.vehicles[:, :, :, 0], axis=0) < 0.0).any()
    hardest = min(HARDEST_DECEL, scenario.road.friction * 9.81)
    assert np.nanmin(tape.vehicles[:, :, :, 2]) >= -hardest - 0.1 - 1e-9
    assert np.nanmin(tape.vehicles[:, :, :, 1]) >= 0.0
    for agent in range(tape.agents):
        running = tape.outcomes[:, agent] == Outcome.RUNNING
        assert tape.vehicles[:, :, agent, 1][running].max() <= scenario.road.speed_limit
        if agent < gaps.shape[2]:
            assert not (gaps[:, :, agent][running] <= 0.0).any()
        if agent > 0 and not adversarial(tape, agent):
            assert not (gaps[:, :, agent - 1][running] <= 0.0).any()
    assert not (gaps[:, :, fronts + 1 :] <= 0.0).any()


@ONE_LINE
def test_after_success_they_dwell_then_drive_on_and_keep_their_distance(scenario_id: str, fronts: int) -> None:
    tape = recorded(scenario_id, fronts)
    checked = 0
    for agent in range(1, tape.agents):
        for row, end in enumerate(tape.ends()[agent]):
            if tape.outcomes[-1, agent, row] != Outcome.SUCCESS or adversarial(tape, agent):
                continue
            after = tape.vehicles[end + 1 :, row, agent]
            dwell = int(float(tape.profiles[row][agent - 1]["dwell"]) / tape.scenario.dt)
            assert not after[: dwell - 1, 1].any(), "it did not dwell"
            if agent < tape.gaps().shape[2]:
                assert not (tape.gaps()[end:, row, agent] <= 0.0).any()
            alone = np.isnan(tape.vehicles[0, row, agent + 1 :, 0]).all()
            if alone and len(after) > dwell + 100:
                assert after[-1, 0] > after[0, 0] + 5.0, "it did not drive on"
                checked += 1
    assert checked > 0 or scenario_id not in {"stop-line-v0", "platoon-v0"}


@EACH
def test_wrecks_come_to_a_stand_and_stay(scenario_id: str, fronts: int) -> None:
    tape = recorded(scenario_id, fronts)
    vehicle, dt = tape.scenario.vehicle, tape.scenario.dt
    brake = min(-vehicle.levels[0], tape.scenario.road.friction * 9.81)
    reaction = round((3.0 * vehicle.lag + (brake + vehicle.levels[-1]) / vehicle.jerk_limit) / dt)
    for agent in range(tape.agents):
        for row, end in enumerate(tape.ends()[agent]):
            if tape.outcomes[-1, agent, row] in WRECKED:
                speeds = tape.vehicles[end + reaction :, row, agent, 1]
                braking = -np.diff(speeds) >= 0.9 * brake * dt
                assert (braking | (speeds[1:] == 0.0)).all()


@EACH
def test_agents_see_numbers_within_their_space_as_long_as_they_live(scenario_id: str, fronts: int) -> None:
    tape = recorded(scenario_id, fronts)
    space = observation_space(tape.scenario)
    ends = tape.ends()
    for agent in range(tape.agents):
        alive = np.arange(tape.frames)[:, None] <= ends[agent]
        seen = tape.observations[:, agent][alive]
        assert (seen >= space.low).all()
        assert (seen <= space.high).all()
    assert np.isfinite(tape.observations).all()


def test_whoever_is_struck_while_it_stands_is_not_at_fault() -> None:
    env = StopLineParallelEnv("stop-line-v0", learned_fronts=1)
    env.reset(seed=2)
    while "ego" in env.agents:
        infos = env.step({agent: 5 if agent == "ego" else 0 for agent in env.agents})[4]
    assert infos["ego"]["outcome"] == Outcome.COLLISION
    assert infos["front_1"]["outcome"] == Outcome.REAR_ENDED
    assert env.agents == []


@EACH
def test_an_agent_s_terms_add_up_to_its_task_reward(scenario_id: str, fronts: int) -> None:
    tape = recorded(scenario_id, fronts)
    np.testing.assert_allclose(tape.terms.sum(axis=-1), tape.rewards, atol=1e-9)
    simulator = Simulator(scenario_id, 5, learned_fronts=fronts)
    simulator.reset(np.arange(5))
    for actions in traffic_actions(simulator, 0, 200):
        simulator.step(actions)
    each = [simulator.of_agent(agent).outcomes for agent in range(1 + fronts)]
    np.testing.assert_array_equal(simulator.agent_outcomes, np.stack(each, axis=1))
    np.testing.assert_array_equal(simulator.of_agent(0).terms, simulator.terms)
