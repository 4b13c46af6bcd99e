"""What the sensors tell, against plain Python: drop-outs of the front vehicle, ghosts, delay and noise."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hhrl_envs import SCENARIOS, Ghosts, Goal, Scenario, Sensor, Simulator, observation
from hhrl_envs.simulation.sensing import CHANNELS, DROPOUTS, GHOSTS, NOISE
from hhrl_envs.views.spaces import observation_space
from support.draws import stream, unit
from support.driving import random_actions
from support.reference import sensed, window

MAIN = SCENARIOS["stop-line-v0"]
TRAFFIC = [scenario for scenario in SCENARIOS.values() if scenario.traffic.max_fronts > 0]
SYMBOLS, FRONT = observation.SYMBOLS, [observation.place(symbol) for symbol in ("d_f", "v_f", "a_f")]
ROWS, STEPS, SEED = 3, 90, 70


@st.composite
def sensors(draw: st.DrawFn) -> tuple[Scenario, int]:
    """A scenario with drop-outs, or with a delay and noise beside them, and a number of learned front vehicles."""
    scenario, errors = draw(st.sampled_from(TRAFFIC)), draw(st.sampled_from([0.0, 0.5]))
    sensor = Sensor(
        front_range=draw(st.sampled_from([20.0, 100.0])),
        noise_distance=errors,
        noise_speed=errors,
        noise_accel=errors,
        delay=draw(st.sampled_from([0, 1, 7])),
        dropout=draw(st.sampled_from([0.0, 0.1, 0.5, 0.95])),
        dropout_time=draw(st.sampled_from([0.001, 0.1, 0.26, 1.0, 2.5])),
        ghosts=draw(st.sampled_from([None, Ghosts(0.5, 10.0, 0.5), Ghosts(1.0, 12.5, 6.0), Ghosts(0.8, 1000.0, 3.0)])),
    )
    fronts = 0 if scenario.goal == Goal.FOLLOW else draw(st.integers(0, scenario.traffic.max_fronts))
    return replace(scenario, sensor=sensor, feasible_only=False), fronts


def shown(simulator: Simulator) -> NDArray[np.float64]:
    """What every agent sees in SI units, float64 [agent, row, element]."""
    return np.stack([observation.to_si(simulator.of_agent(k).observations) for k in range(simulator.num_agents)])


class Rolled(NamedTuple):
    """What agents see, [step, agent, row, element], whether rows went on until then, all else that agents get.

    Last where they are, [step, agent, row].
    """

    seen: NDArray[np.float64]
    went_on: NDArray[np.bool_]
    got: list[bytes]
    positions: NDArray[np.float64]


def roll(scenario: Scenario, fronts: int) -> Rolled:
    simulator = Simulator(scenario, ROWS, learned_fronts=fronts)
    simulator.reset(np.arange(ROWS) + SEED)
    seen, went_on, got, positions = [shown(simulator)], [simulator.steps == 0], [], [where(simulator)]
    for step, chosen in enumerate(random_actions(2, STEPS, ROWS * (1 + fronts), scenario.num_actions), start=1):
        simulator.step(chosen if fronts == 0 else chosen.reshape(ROWS, 1 + fronts))
        seen.append(shown(simulator))
        positions.append(where(simulator))
        went_on.append(simulator.steps == step)
        got.append(simulator.arrays.all_results.tobytes() + simulator.arrays.all_codes.tobytes())
    return Rolled(np.stack(seen), np.stack(went_on), got, np.stack(positions))


def where(simulator: Simulator) -> NDArray[np.float64]:
    """Where every agent is, float64 [agent, row]."""
    return np.stack([simulator.motion(slot)[:, 0] for slot in range(simulator.num_agents)])


def normal(seed: int, agent: int, step: int, channel: int) -> float:
    key = np.uint64(stream(np.uint64(seed), 0, agent, NOISE + step))
    return sum(unit(key, 12 * channel + part) for part in range(12)) - 6.0


def lost_steps(scenario: Scenario, seed: int, agent: int, steps: int) -> set[int]:
    """The steps in which an agent's front sensor drops out: a draw for every window but the first."""
    key, dropout = np.uint64(stream(np.uint64(seed), 0, agent, DROPOUTS)), scenario.sensor.dropout
    windows = [window(scenario, step) for step in range(steps)]
    return {step for step, number in enumerate(windows) if number > 0 and unit(key, number) < dropout}


def ghost_places(scenario: Scenario, seed: int) -> list[float]:
    """Where the ghosts of an episode stand, in the order of the road, as far as any agent can see."""
    ghosts, start = scenario.sensor.ghosts, -scenario.road.start_distance[1]
    if ghosts is None:
        return []
    key = np.uint64(stream(np.uint64(seed), 0, 0, GHOSTS))
    count = int((scenario.sensor.front_range - start + 300.0) / ghosts.stretch) + 1
    there = [number for number in range(count) if unit(key, 2 * number) < ghosts.share]
    return [start + (number + unit(key, 2 * number + 1)) * ghosts.stretch for number in there]


def ghost_ahead(scenario: Scenario, places: list[float], position: float, d_f: float) -> float | None:
    """How far ahead the ghost stands that is reported, if any: the nearest one that is not too near, before d_f."""
    ghosts = scenario.sensor.ghosts
    shown = [place - position for place in places if ghosts and ghosts.near <= place - position < d_f]
    return min(shown, default=None)


@settings(max_examples=40, deadline=None, derandomize=True, database=None)
@given(drawn=sensors())
def test_readings_are_those_of_the_reference_and_all_else_is_as_with_perfect_sensors(
    drawn: tuple[Scenario, int],
) -> None:
    scenario, fronts = drawn
    perfect = replace(scenario, sensor=Sensor(front_range=scenario.sensor.front_range))
    truth, went_on, got, positions = roll(perfect, fronts)
    read, _, received, _ = roll(scenario, fronts)
    assert received == got
    agent, row = fronts // 2, int(went_on.sum(axis=0).argmax())
    steps = int(went_on[:, row].sum())
    each = [dict(zip(SYMBOLS, state.tolist(), strict=True)) for state in truth[:steps, agent, row]]
    noisy = {SYMBOLS[index]: channel for channel, index in enumerate(CHANNELS)}
    errors = [
        {symbol: normal(SEED + row, agent, step, channel) for symbol, channel in noisy.items()}
        for step in range(len(each))
    ]
    places = ghost_places(scenario, SEED + row)
    own = positions[:steps, agent, row].tolist()
    ghosts = [ghost_ahead(scenario, places, x, state["d_f"]) for x, state in zip(own, each, strict=True)]
    wanted = sensed(scenario, each, lost_steps(scenario, SEED + row, agent, len(each)), ghosts, errors)
    told = [[state[symbol] for symbol in SYMBOLS] for state in wanted]
    np.testing.assert_allclose(read[:steps, agent, row], told, rtol=1e-5, atol=2e-5)
    space = observation_space(scenario)
    seen = read[:, 0][went_on] * observation.SCALES
    assert ((seen >= space.low) & (seen <= space.high)).all()


def test_a_lost_front_vehicle_looks_like_an_empty_road_and_one_that_is_seen_as_ever() -> None:
    """Without noise to the last bit, in windows that begin with the episode; in the first of them nothing is lost."""
    flickering = replace(MAIN, sensor=Sensor(dropout=0.5, dropout_time=0.5))
    (truth, went_on, _, _), (read, _, _, _) = roll(MAIN, 0), roll(flickering, 0)
    each = [lost_steps(flickering, SEED + row, 0, STEPS + 1) for row in range(ROWS)]
    lost = np.array([[step in of_row for of_row in each] for step in range(STEPS + 1)])
    windows = lost[:STEPS].reshape(-1, 5, ROWS)
    assert not windows[0].any()
    assert (windows.all(axis=1) == windows.any(axis=1)).all()
    assert 0.2 < windows[1:].mean() < 0.8
    assert (read[:, 0][lost & went_on][:, FRONT] == [100.0, MAIN.road.speed_limit, 0.0]).all()
    kept = went_on & ~lost
    np.testing.assert_array_equal(read[:, 0][kept], truth[:, 0][kept])
    own = [index for index, symbol in enumerate(SYMBOLS) if "f" not in symbol]
    np.testing.assert_array_equal(read[..., own], truth[..., own])


@pytest.mark.parametrize("dropout", [0.05, 0.5, 0.95])
def test_agents_lose_their_front_vehicles_for_the_share_of_time_and_apart_from_each_other(dropout: float) -> None:
    rows, sensor = 600, Sensor(front_range=1000.0, dropout=dropout, dropout_time=0.3)
    traffic = replace(MAIN.traffic, count_shares=(0.0, 0.0, 1.0))
    simulator = Simulator(replace(MAIN, sensor=sensor, traffic=traffic, feasible_only=False), rows, learned_fronts=1)
    simulator.reset(np.arange(rows))
    windows = []
    for _ in range(10):
        for _ in range(3):
            simulator.step(np.full((rows, 2), 3))
        windows.append(shown(simulator)[:, :, FRONT[0]] == 1000.0)
    lost = np.stack(windows)
    both = dropout * dropout
    assert abs(lost.mean() - dropout) < 0.02
    assert abs((lost[:, 0] & lost[:, 1]).mean() - both) < 0.03
    assert abs((lost[:-1] & lost[1:]).mean() - both) < 0.03
    assert abs((lost[:, :, :-1] & lost[:, :, 1:]).mean() - both) < 0.03


def test_the_next_episode_has_drop_outs_of_its_own() -> None:
    simulator, told = Simulator(replace(MAIN, sensor=Sensor(dropout=0.5, dropout_time=0.2)), 1), []
    simulator.reset([SEED])
    for _ in range(2):
        reads = []
        for _ in range(60):
            simulator.step(np.zeros(1, np.int64))
            reads.append(observation.to_si(simulator.observations)[0, FRONT[0]] == 100.0)
        told.append(reads)
        simulator.next_episode()
    assert told[0] != told[1]


def test_a_ghost_stands_at_one_place_for_all_agents_until_it_is_near() -> None:
    """On a free road every stretch has one, and each is reported from afar until it is 6 m away."""
    sensor = Sensor(ghosts=Ghosts(1.0, 40.0, 6.0))
    traffic = replace(MAIN.traffic, count_shares=(1.0,))
    haunted = replace(MAIN, sensor=sensor, traffic=traffic)
    read, went_on, _, positions = roll(haunted, 0)
    for row in range(ROWS):
        d_f, v_f, a_f = read[went_on[:, row], 0, row][:, FRONT].T
        stands = positions[went_on[:, row], 0, row] + d_f
        seen = d_f < 100.0
        assert seen.any()
        assert (v_f[seen] == 0.0).all()
        assert (a_f == 0.0).all()
        assert d_f.min() >= 6.0 - 1e-5
        places = np.array(ghost_places(haunted, SEED + row))
        assert (np.diff(places) > 0.0).all()
        np.testing.assert_allclose(np.abs(stands[seen][:, None] - places).min(axis=1), 0.0, atol=1e-4)


def test_sensors_that_drop_out_or_see_ghosts_are_not_perfect() -> None:
    assert Sensor(dropout_time=3.0).perfect
    assert not Sensor(dropout=0.01).perfect
    assert not Sensor(ghosts=Ghosts(0.01)).perfect
