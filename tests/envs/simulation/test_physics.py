"""What no driving may break, tried with any scenario, seed, number of learned front vehicles and actions."""

from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hhrl_envs import SCENARIOS, Goal, Outcome, Simulator, observation
from hhrl_envs.simulation.traffic import HARDEST_DECEL
from hhrl_envs.views.spaces import observation_space
from support.driving import states
from support.hidden import HIDDEN
from support.reference import Facts, braking, rewards

ROWS, STEPS = 12, 150
RUNNING, TOUCHING = Outcome.RUNNING, (Outcome.COLLISION, Outcome.REAR_ENDED)
ROUNDING = 1e-9


@st.composite
def drives(draw: st.DrawFn) -> tuple[Simulator, NDArray[Any]]:
    """A simulator at its beginning, and target accelerations or levels [step, row, agent]."""
    scenario = draw(st.sampled_from([*SCENARIOS.values(), *HIDDEN.values()]))
    most = 0 if scenario.goal == Goal.FOLLOW else scenario.traffic.max_fronts
    simulator = Simulator(scenario, ROWS, learned_fronts=draw(st.integers(0, most)))
    seed, held, levels = draw(st.integers(0, 2**63)), draw(st.sampled_from([1, 5, 25])), scenario.vehicle.levels
    simulator.reset(np.arange(ROWS, dtype=np.uint64) + np.uint64(seed))
    rng = np.random.default_rng(seed)
    size = (-(-STEPS // held), ROWS, simulator.num_agents)
    favourite = draw(st.integers(0, len(levels) - 1))
    chosen = np.where(rng.random(size) < 0.3, favourite, rng.integers(0, len(levels), size))
    actions = rng.uniform(levels[0], levels[-1], size) if draw(st.booleans()) else chosen
    actions = np.repeat(actions, held, axis=0)[:STEPS]
    return simulator, actions[:, :, 0] if simulator.num_agents == 1 else actions


def outcomes(simulator: Simulator) -> NDArray[np.int8]:
    return np.stack([simulator.of_agent(agent).outcomes for agent in range(simulator.num_agents)])


@settings(max_examples=40, deadline=None, derandomize=True, database=None)
@given(drive=drives())
def test_nobody_breaks_the_laws_of_motion(drive: tuple[Simulator, NDArray[Any]]) -> None:
    simulator, actions = drive
    scenario, before, ended = simulator.scenario, states(simulator), outcomes(simulator) != RUNNING
    grip, agents = simulator.friction[:, None] * 9.81 + ROUNDING, simulator.num_agents
    for step, chosen in enumerate(actions):
        simulator.step(chosen)
        after = states(simulator)
        x, v, a = np.moveaxis(after - before, -1, 0)
        assert not (x < 0.0).any(), "a vehicle moved backwards"
        assert not (after[:, :, 1] < 0.0).any()
        if step > 0 or scenario.road.slippery is None:  # on a slippery road some start too near to each other
            assert not (after[:, :, 2] < -np.minimum(HARDEST_DECEL, grip) - 0.1 - ROUNDING).any()
        if scenario.road.slippery is not None:
            assert not (after[:, agents:, 2] > grip).any()
        for agent in range(simulator.num_agents):
            running = ~ended[agent]
            mean = 0.5 * (before[:, agent, 1] + after[:, agent, 1])
            check_agent(simulator, running, after[:, agent], x[:, agent] - mean * scenario.dt, a[:, agent])
        assert not (v > np.maximum(3.3, grip) * scenario.dt).any()
        check_overlaps(simulator, after, ended)
        before, ended = after, outcomes(simulator) != RUNNING


def check_agent(
    simulator: Simulator,
    running: NDArray[np.bool_],
    after: NDArray[np.float64],
    beyond: NDArray[np.float64],
    change: NDArray[np.float64],
) -> None:
    """Positions by the trapezoidal rule, all else within limits; where a limit of the speed binds, jerk is free."""
    scenario, speed, accel = simulator.scenario, after[running, 1], after[running, 2]
    np.testing.assert_allclose(beyond[running], 0.0, atol=ROUNDING)
    assert (speed <= scenario.road.speed_limit).all()
    levels, grip = scenario.vehicle.levels, simulator.friction[running] * 9.81
    assert (accel >= -np.minimum(-levels[0], grip) - ROUNDING).all()
    assert (accel <= np.minimum(levels[-1], grip) + ROUNDING).all()
    free = (speed > 0.0) & (speed < scenario.road.speed_limit)
    assert (np.abs(change[running][free]) <= scenario.vehicle.jerk_limit * scenario.dt + 1e-6).all()


def check_overlaps(simulator: Simulator, after: NDArray[np.float64], ended: NDArray[np.bool_]) -> None:
    """Running agents touch nobody, and whoever newly touches ends in a way that says so, but for earlier causes."""
    now, agents = outcomes(simulator), simulator.num_agents
    gaps = after[:, 1:, 0] - simulator.scenario.vehicle.length - after[:, :-1, 0]
    assert not (gaps[:, agents:] <= 0.0).any(), "scripted vehicles overlap"
    for agent in range(min(agents, gaps.shape[1])):
        touching = (gaps[:, agent] <= 0.0) & ~ended[agent]
        assert (now[agent][touching] == Outcome.COLLISION).all()
        collided = (now[agent] == Outcome.COLLISION) & ~ended[agent]
        assert (gaps[collided, agent] <= 0.0).all()
    for agent in range(1, agents):
        struck = (gaps[:, agent - 1] <= 0.0) & ~ended[agent]
        adversary = simulator.scenario.adversary is not None and agent == 1
        assert adversary or (now[agent][struck] != RUNNING).all()
        fault = (now[agent] == Outcome.REAR_ENDED) & ~ended[agent]
        assert (gaps[fault, agent - 1] <= 0.0).all()


@settings(max_examples=25, deadline=None, derandomize=True, database=None)
@given(drive=drives())
def test_full_braking_is_never_beaten_in_position(drive: tuple[Simulator, NDArray[Any]]) -> None:
    simulator, actions = drive
    start = states(simulator)[:, : simulator.num_agents, :2]
    slowest = [
        [braking(simulator.scenario, x, v, STEPS, friction) for x, v in row]
        for row, friction in zip(start.tolist(), simulator.friction.tolist(), strict=True)
    ]
    for step, chosen in enumerate(actions, start=1):
        running = (outcomes(simulator) == RUNNING).T
        simulator.step(chosen)
        x = states(simulator)[:, : simulator.num_agents, 0]
        limit = np.array(slowest)[:, :, step]
        assert (x >= limit - ROUNDING)[running].all()


@settings(max_examples=25, deadline=None, derandomize=True, database=None)
@given(drive=drives())
def test_observations_are_numbers_in_their_space_and_rewards_follow_the_equations(
    drive: tuple[Simulator, NDArray[Any]],
) -> None:
    simulator, actions = drive
    space, live = observation_space(simulator.scenario), outcomes(simulator) == RUNNING
    for step, chosen in enumerate(actions):
        before = states(simulator)
        simulator.step(chosen)
        for agent in range(simulator.num_agents):
            own = simulator.of_agent(agent)
            seen = own.observations[live[agent]]
            assert (seen >= space.low).all(), observation.SYMBOLS[int((seen < space.low).any(axis=0).argmax())]
            assert (seen <= space.high).all(), observation.SYMBOLS[int((seen > space.high).any(axis=0).argmax())]
            assert np.isfinite(own.rewards).all()
        if step % 5 == 0:
            check_rewards(simulator, before, live)
        live = outcomes(simulator) == RUNNING


def check_rewards(simulator: Simulator, before: NDArray[np.float64], live: NDArray[np.bool_]) -> None:
    """The rewards of the ego, term by term, of rows where it was running."""
    scenario, after = simulator.scenario, states(simulator)
    for row in np.flatnonzero(live[0]).tolist():
        x, speed, accel = after[row, 0]
        leader = after[row, 1] if after.shape[1] > 1 else np.full(3, np.nan)
        d_f = leader[0] - scenario.vehicle.length - x
        facts = Facts(
            v_e=speed,
            j_e=(accel - before[row, 0, 2]) / scenario.dt,
            d_d=min(simulator.lines[row] - x, scenario.sensor.line_range),
            d_f=np.inf if np.isnan(d_f) else max(d_f, 0.0),
            v_f=leader[1],
            outcome=Outcome(simulator.outcomes[row]),
        )
        task, option, action = rewards(facts, scenario)
        wanted = [task, *option, *action]
        got = [simulator.rewards[row], *simulator.reward_option[row], *simulator.reward_action[row]]
        np.testing.assert_allclose(got, wanted, rtol=1e-9, atol=1e-9)
