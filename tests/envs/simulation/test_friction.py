"""Roads whose friction differs from world to world, and that look alike."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_envs import SCENARIOS, Goal, InputError, Scenario, Simulator, Slippery
from hhrl_envs.simulation.initial_state import FRICTION
from hhrl_envs.views.parallel_env import StopLineParallelEnv
from support.draws import stream, unit
from support.driving import random_actions, states
from support.hidden import SLIPPERY
from support.reference import friction
from support.trajectories import TrajectoryRecorder

MAIN = SCENARIOS["stop-line-v0"]
ROWS = 400


def with_friction(scenario: Scenario, usual: float, slippery: Slippery | None = None) -> Scenario:
    return replace(scenario, feasible_only=False, road=replace(scenario.road, friction=usual, slippery=slippery))


def begun(scenario: Scenario, fronts: int = 0) -> Simulator:
    simulator = Simulator(scenario, ROWS, learned_fronts=fronts)
    simulator.reset(np.arange(ROWS) + 9)
    return simulator


def drawn(scenario: Scenario, seed: int) -> float:
    """The friction of the first world of a seed: two draws of a stream of the world's own."""
    world = np.uint64(stream(np.uint64(seed), 0, 0, 0))
    key = np.uint64(stream(world, 0, 0, int(FRICTION)))
    return friction(scenario, unit(key, 0), unit(key, 1))


def test_it_is_drawn_as_the_reference_says_and_nothing_else_of_a_world_is() -> None:
    scenario, plain = with_friction(MAIN, 0.9, Slippery(0.3, (0.1, 0.2))), begun(with_friction(MAIN, 0.9))
    simulator = begun(scenario)
    np.testing.assert_array_equal(simulator.friction[:60], [drawn(scenario, seed) for seed in range(9, 69)])
    ice = simulator.friction < 0.9
    assert abs(ice.mean() - 0.3) < 0.06
    assert ((simulator.friction[ice] >= 0.1) & (simulator.friction[ice] < 0.2)).all()
    assert (plain.friction == 0.9).all()
    np.testing.assert_array_equal(states(simulator), states(plain))
    assert [simulator.profiles(row) for row in range(ROWS)] == [plain.profiles(row) for row in range(ROWS)]
    assert simulator.observations.tobytes() == plain.observations.tobytes()


@pytest.mark.parametrize("fronts", [0, 2])
@pytest.mark.parametrize("grip", [0.35, 0.6])
@pytest.mark.parametrize("name", ["stop-line-v0", "stop-line-dense-v0", "two-stops-v0", "red-light-v0", "platoon-v0"])
def test_a_slippery_world_is_that_of_a_scenario_with_its_friction(name: str, grip: float, fronts: int) -> None:
    """To the last bit, where no scripted vehicle would speed up more than the road lets it."""
    known = SCENARIOS[name]
    assert grip * 9.81 > max(family.max_accel[1] for family in known.traffic.families)
    usual, slippery = with_friction(known, grip), with_friction(known, 1.0, Slippery(1.0, (grip, grip)))
    seeds = range(20)
    told = [TrajectoryRecorder(one, seeds, seeds, fronts).record(300) for one in (usual, slippery)]
    assert told[0] == told[1]


def accelerations(simulator: Simulator, steps: int = 150) -> NDArray[np.float64]:
    """What all vehicles accelerate with, [step, row, vehicle], with egos that do this and that."""
    found = []
    for chosen in random_actions(4, steps, ROWS, simulator.scenario.num_actions):
        simulator.step(chosen)
        found.append(states(simulator)[:, :, 2])
    return np.stack(found)


def test_it_cuts_brakes_and_throttle_of_all_vehicles() -> None:
    simulator = begun(with_friction(MAIN, 1.0, Slippery(0.8, (0.05, 0.15))))
    accels, grip = accelerations(simulator), simulator.friction[:, None] * 9.81
    assert not (accels > grip + 1e-9).any()
    assert not (accels[1:] < -grip - 0.1 - 1e-9).any()  # who creeps stands at once; some start too near to each other
    ice = simulator.friction < 0.5
    for own in (accels[:, ice, 0] / grip[ice, 0], accels[:, ice, 1] / grip[ice, 0]):
        assert np.nanmax(own) > 0.999
        assert np.nanmin(own) < -0.999
    assert np.nanmax(accels[:, ~ice, 1]) > 1.5
    assert np.nanmin(accels[:, ~ice, 0]) < -5.9


def test_scripted_vehicles_never_overlap_on_any_ice() -> None:
    family = replace(MAIN.traffic.families[0], slow_chance=1.0, slow_every=(5.0, 9.0), slow_decel=(9.0, 9.0))
    traffic = replace(MAIN.traffic, families=(family,), count_shares=(0.0,) * 4 + (1.0,), gap=(1.0, 9.0))
    simulator = begun(replace(with_friction(MAIN, 0.5, Slippery(0.9, (0.01, 0.3))), traffic=traffic))
    for _ in range(300):
        simulator.step(np.zeros(ROWS, np.int64))
        x = states(simulator)[:, 1:, 0]
        assert not (np.diff(x, axis=1) - MAIN.vehicle.length < 0.0).any()


def test_infos_at_reset_tell_it_and_observations_do_not() -> None:
    env, simulator = StopLineParallelEnv(SLIPPERY), Simulator(SLIPPERY, 30)
    simulator.reset(np.arange(30))
    told = [env.reset(seed=seed)[1]["ego"]["friction"] for seed in range(30)]
    assert told == simulator.friction.tolist()
    assert len(set(told)) > 5
    assert StopLineParallelEnv(MAIN).reset(seed=3)[1]["ego"]["friction"] == 1.0
    assert env.observation_space("ego").shape == StopLineParallelEnv(MAIN).observation_space("ego").shape


def test_the_next_world_has_a_friction_of_its_own() -> None:
    simulator = Simulator(SLIPPERY, 40)
    with pytest.raises(InputError, match="reset first"):
        _ = simulator.friction
    simulator.reset(np.arange(40))
    before = simulator.friction
    simulator.next_episode(np.arange(40) < 20)
    assert (simulator.friction[20:] == before[20:]).all()
    assert (simulator.friction[:20] != before[:20]).mean() > 0.5


def test_it_is_no_goal_s_matter() -> None:
    for known in SCENARIOS.values():
        simulator = Simulator(with_friction(known, 1.0, Slippery(0.5, (0.1, 0.3))), 20)
        simulator.reset(np.arange(20))
        assert 0 < (simulator.friction < 1.0).sum() < 20, Goal(known.goal)
