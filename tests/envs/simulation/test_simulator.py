from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_envs import SCENARIOS, InputError, Outcome, Scenario, Sensor, Simulator, get_scenario, observation
from hhrl_envs.simulation.rewards import TIME, TIMEOUT
from support.driving import careful_actions, random_actions
from support.reference import Facts, distances, rewards

MAIN = get_scenario("stop-line-v0")
EACH = pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=lambda scenario: scenario.id)


def roll(scenario: Scenario, seeds: NDArray[np.int64], actions: NDArray[np.int64]) -> bytes:
    """Every observation, reward and outcome of the rows, row by row, with auto-reset."""
    simulator = Simulator(scenario, seeds.size)
    simulator.reset(seeds)
    trail = []
    for chosen in actions:
        simulator.step(chosen)
        trail.append(
            np.concatenate(
                [
                    simulator.observations.astype(np.float64),
                    simulator.terms,
                    simulator.reward_option,
                    simulator.reward_action,
                    simulator.outcomes[:, None].astype(np.float64),
                ],
                axis=1,
            )
        )
        simulator.reset_done()
    return np.stack(trail, axis=1).tobytes()


def facts_of(simulator: Simulator, row: int, line: float, accel_before: float) -> Facts:
    vehicles = simulator.vehicles(row)
    x, v, a = vehicles[0]
    d_d = min(line - x, simulator.scenario.sensor.line_range)
    front = vehicles[1] if len(vehicles) > 1 and not np.isnan(vehicles[1, 0]) else np.array([np.inf, 0.0, 0.0])
    d_f = front[0] - simulator.scenario.vehicle.length - x
    jerk = (a - accel_before) / simulator.scenario.dt
    return Facts(v, jerk, d_d, d_f, front[1], Outcome(simulator.outcomes[row]))


@EACH
def test_rows_are_bit_identical_in_every_batch(scenario: Scenario) -> None:
    seeds = np.arange(64)
    actions = random_actions(1, 150, 64, scenario.num_actions)
    together = np.frombuffer(roll(scenario, seeds, actions)).reshape(64, -1)
    for start, size in ((0, 1), (3, 7), (20, 33)):
        rows = slice(start, start + size)
        alone = np.frombuffer(roll(scenario, seeds[rows], actions[:, rows])).reshape(size, -1)
        assert alone.tobytes() == together[rows].tobytes()


@EACH
def test_rewards_and_observations_follow_the_equations(scenario: Scenario) -> None:
    rows, truthful = 15, replace(scenario, sensor=Sensor())
    simulator = Simulator(truthful, rows)
    simulator.reset(np.arange(rows))
    for chosen in mixed_actions(simulator, 400):
        before = [simulator.vehicles(i)[0, 2] for i in range(rows)]
        simulator.step(chosen)
        for i in range(rows):
            check_row(simulator, i, before[i])
        simulator.reset_done()


def test_the_main_scenario_ends_in_every_way_and_no_other() -> None:
    simulator = Simulator(MAIN, 60)
    simulator.reset(np.arange(60))
    seen: set[int] = set()
    for chosen in mixed_actions(simulator, 620):
        simulator.step(chosen)
        seen.update(simulator.outcomes.tolist())
        simulator.reset_done()
    assert seen == {Outcome.RUNNING, Outcome.COLLISION, Outcome.NOT_STOP, Outcome.SUCCESS, Outcome.TIMEOUT}


def mixed_actions(simulator: Simulator, steps: int) -> Iterator[NDArray[np.int64]]:
    """A third of the rows drives carefully, one stands, the others do this and that."""
    rows = simulator.num_rows
    for chosen in random_actions(3, steps, rows, simulator.scenario.num_actions):
        mixed = np.where(np.arange(rows) % 3 == 0, careful_actions(simulator), chosen)
        mixed[-1] = 0
        yield mixed


def check_row(simulator: Simulator, i: int, accel_before: float) -> None:
    facts = facts_of(simulator, i, simulator.lines[i], accel_before)
    task, option, action = rewards(facts, simulator.scenario)
    ours = [simulator.rewards[i], *simulator.reward_option[i], *simulator.reward_action[i]]
    np.testing.assert_allclose(ours, [task, *option, *action], rtol=1e-12, atol=1e-12)
    sr = simulator.terms[i, [TIME, TIMEOUT, TIMEOUT + 1]].sum()
    sums = simulator.reward_option[i] + simulator.reward_action[i] - sr
    np.testing.assert_allclose(sums, task, rtol=1e-12, atol=1e-12)
    si, d = observation.to_si(simulator.observations[i]), distances(facts, simulator.scenario)
    wanted = {observation.DC_RATIO: np.clip(d["d_dc"] / max(d["d_ds"], 0.5), -1.0, 10.0)}
    if facts.outcome != Outcome.COLLISION:
        wanted |= {observation.V_E: facts.v_e, observation.J_E: facts.j_e, observation.D_D: facts.d_d}
        wanted |= {observation.D_DC: d["d_dc"], observation.D_FC: d["d_fc"]}
    np.testing.assert_allclose(si[[*wanted]], [*wanted.values()], rtol=1e-6, atol=1e-6)


@EACH
def test_vehicles_keep_within_physics(scenario: Scenario) -> None:
    rows = 100
    simulator = Simulator(scenario, rows)
    simulator.reset(np.arange(rows) + 77)
    actions = random_actions(5, 500, rows, scenario.num_actions)
    before = np.stack([simulator.vehicles(i) for i in range(rows)])
    for chosen in actions:
        simulator.step(chosen)
        after = np.stack([simulator.vehicles(i) for i in range(rows)])
        assert not (after[:, :, 0] < before[:, :, 0]).any(), "a vehicle moved backwards"
        assert np.nanmin(after[:, :, 1]) >= 0.0
        assert after[:, 0, 1].max() <= scenario.road.speed_limit
        gaps = after[:, 1:, 0] - scenario.vehicle.length - after[:, :-1, 0]
        assert not (gaps[:, 1:] <= 0.0).any(), "scripted vehicles overlap"
        d_f = np.concatenate([gaps, np.full((rows, 1), np.inf)], axis=1)[:, 0]
        running = simulator.outcomes == Outcome.RUNNING
        assert not (d_f[running] <= 0.0).any(), "an overlap went unnoticed"
        before = after


@EACH
def test_full_braking_is_never_beaten_in_position(scenario: Scenario) -> None:
    rows = 128
    braking, other = Simulator(scenario, rows), Simulator(scenario, rows)
    braking.reset(np.arange(rows))
    other.reset(np.arange(rows))
    for chosen in random_actions(9, 120, rows, scenario.num_actions):
        braking.step(np.zeros(rows, np.int64))
        other.step(chosen)
        d_braking = braking.observations[:, observation.D_D]
        assert (other.observations[:, observation.D_D] <= d_braking).all()


@EACH
def test_feasible_worlds_can_be_survived_and_leave_time(scenario: Scenario) -> None:
    rows = 300
    simulator = Simulator(scenario, rows)
    simulator.reset(np.arange(rows))
    feasible = simulator.feasible.copy()
    assert feasible.all() == scenario.feasible_only or feasible.mean() > 0.5
    for _ in range(scenario.horizon):
        simulator.step(np.zeros(rows, np.int64))
    assert not ((simulator.outcomes == Outcome.COLLISION) & feasible).any()
    fronts = [simulator.vehicles(i)[1:2, 0] for i in range(rows)]
    rears = [front[0] - scenario.vehicle.length for front in fronts if front.size and not np.isnan(front[0])]
    assert not scenario.road.lines or min(rears, default=1.0) > 0.0


def test_an_ended_row_keeps_its_outcome_and_earns_nothing() -> None:
    simulator = Simulator(MAIN, 3)
    simulator.reset(np.arange(3))
    throttle = np.full(3, MAIN.num_actions - 1)
    while not (simulator.outcomes != Outcome.RUNNING).all():
        simulator.step(throttle)
    outcomes, steps = simulator.outcomes.copy(), simulator.steps.copy()
    simulator.step(throttle)
    assert (simulator.outcomes == outcomes).all()
    assert (simulator.steps == steps).all()
    assert not simulator.terms.any()


def test_episodes_of_a_seed_differ_and_seeds_of_rows_do_not_leak() -> None:
    simulator = Simulator(MAIN, 2)
    simulator.reset([5, 5])
    first = simulator.observations.copy()
    assert (first[0] == first[1]).all()
    simulator.next_episode(np.array([True, False]))
    assert (simulator.observations[0] != first[0]).any()
    assert (simulator.observations[1] == first[1]).all()
    assert simulator.key(0) == (5, 1)


def test_profiles_are_logged_within_their_families_ranges() -> None:
    simulator = Simulator(MAIN, 50)
    simulator.reset(np.arange(50))
    families = {family.name: family for family in MAIN.traffic.families}
    profiles = [profile for row in range(50) for profile in simulator.profiles(row)]
    assert {profile["family"] for profile in profiles} == set(families)
    for profile in profiles:
        low, high = families[str(profile["family"])].headway
        assert low <= float(profile["headway"]) <= high


@pytest.mark.parametrize(
    ("actions", "words"),
    [
        (np.array([0, 6]), "action 6"),
        (np.array([-1, 0]), "action -1"),
        (np.array([0.0, np.nan]), "acceleration nan"),
        (np.array([-6.5, 0.0]), "acceleration -6.5"),
        (np.array([True, False]), "bool"),
        (np.array([0]), r"shape \(2,\)"),
    ],
)
def test_bad_actions_are_named(actions: NDArray[Any], words: str) -> None:
    simulator = Simulator(MAIN, 2)
    simulator.reset([0, 1])
    with pytest.raises(InputError, match=words):
        simulator.step(actions)


@pytest.mark.parametrize("what", ["observations", "terms", "steps", "feasible", "outcomes", "agent_outcomes"])
def test_before_the_first_reset_there_is_nothing_to_read(what: str) -> None:
    simulator = Simulator(MAIN, 2)
    for read in (lambda: getattr(simulator, what), lambda: simulator.key(0)):
        with pytest.raises(InputError, match="no episode has begun yet; call reset first"):
            read()


def test_step_before_reset_and_bad_seeds_are_errors() -> None:
    simulator = Simulator(MAIN, 2)
    with pytest.raises(InputError, match="reset"):
        simulator.step(np.array([0, 0]))
    for seeds in ([-1, 2], [1], [0.5, 1.0]):
        with pytest.raises(InputError, match="seed"):
            simulator.reset(seeds)
    with pytest.raises(InputError, match="num_rows"):
        Simulator(MAIN, 0)


@pytest.mark.parametrize(
    ("misuse", "words"),
    [
        (lambda s: s.vehicles(3), "row is 3; write an integer from 0 to 2"),
        (lambda s: s.motion(9), "slot is 9; write an integer from 0 to 5"),
        (lambda s: s.profiles(99), "row is 99"),
        (lambda s: s.key(-1), "row is -1"),
        (lambda s: s.of_agent(1), "agent is 1; write 0"),
        (lambda s: s.next_episode([True] * 3), "chosen is"),
        (lambda s: s.next_episode(np.ones(2, np.bool_)), "3 truth values"),
        (lambda s: s.step(np.array([0, 2**63, 0], np.uint64)), "action 9223372036854775808 of row 1"),
        (lambda s: s.key("a"), "row is 'a'; write an integer from 0 to 2"),
        (lambda s: s.reset([5, -1, 2]), "a seed is -1; write integers from 0 to"),
        (lambda s: s.reset([5, 1]), "seeds are int64 .* write 3 integers"),
        (lambda s: s.restore(None), "the state is a NoneType"),
    ],
)
def test_rows_agents_and_masks_that_are_not_there_are_named(misuse: Callable[[Simulator], object], words: str) -> None:
    simulator = Simulator("stop-line-v0", 3)
    with pytest.raises(InputError, match="reset"):
        simulator.observations  # noqa: B018
    with pytest.raises(InputError, match="reset"):
        simulator.vehicles(0)
    simulator.reset(np.arange(3))
    with pytest.raises(InputError, match=words):
        misuse(simulator)


@pytest.mark.parametrize(
    "arguments", [("stop-line-v9", 3), ("stop-line-v0", 1.5), ("stop-line-v0", 3, "2"), (MAIN, 3, 1, 9)]
)
def test_simulators_that_cannot_be_are_refused(arguments: tuple[Any, ...]) -> None:
    with pytest.raises(InputError):
        Simulator(*arguments)
