"""The law: row i with seed s is the same trajectory, byte for byte, in every batch, on every thread, in every view."""

import copy
import pickle
from collections.abc import Callable
from math import inf
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_envs import SCENARIOS, Goal, Outcome, get_scenario
from hhrl_envs.scenario import profiles
from hhrl_envs.simulation.engine import layout
from hhrl_envs.simulation.engine import layout as layout_module
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.views.gym_env import StopLineEnv, StopLineVectorEnv
from hhrl_envs.views.parallel_env import StopLineParallelEnv
from support.hidden import HIDDEN
from support.trajectories import TrajectoryRecorder, chosen_level, digest

STEPS, SEED = 200, 90
FULL = layout.LANES  # of a block of rows
BATCHES = ((7, 1, True), (64, 2, False), (FULL, 1, False), (FULL + 1, 2, True), (1024, 1, True), (1024, 2, False))
KNOWN = {**SCENARIOS, **HIDDEN}
WORLDS = [(scenario.id, 0) for scenario in KNOWN.values()] + [
    (scenario.id, min(3, scenario.traffic.max_fronts))
    for scenario in KNOWN.values()
    if scenario.goal != Goal.FOLLOW and scenario.traffic.max_fronts > 0
]
DIGESTS: dict[tuple[str, int], str] = {
    ("stop-line-v0", 0): "fc6cabd27c962c7c303a821e33e156435a2a849057a3ac9e1413cac2ea386a65",
    ("follow-v0", 0): "38b1027a247d5261c46572e1bad0699a5496f5a6a810d3576f9f033010a3aa5f",
    ("red-light-v0", 0): "fbcdf43bacc06fb3b6a3741b1dc96ce0e8edc9aef5d84f3195c38b58e414a55e",
    ("two-stops-v0", 0): "4cb66ec17265ce6c10926f8898e966bef3d2222912549ddad84946c539f7cc1e",
    ("stop-line-v0", 3): "7be215b6eb6b18765d48c510bba19ab0e626cc5d5f233632f0bcc8fd5c9d8beb",
    ("platoon-v0", 3): "ac3a278dc4310a0d63fc4b406532d2b0d67a7753914771ea11a44bf15377922c",
    ("adversary-v0", 3): "8444078697ef547ce2bccd8b0ff3c0297e958c2a2ebd286346373637069af108",
}
EACH = pytest.mark.parametrize(("scenario_id", "fronts"), WORLDS)


@EACH
def test_in_every_batch_on_every_thread_with_and_without_autoreset(scenario_id: str, fronts: int) -> None:
    scenario, rng = KNOWN[scenario_id], np.random.default_rng(1)
    alone = [TrajectoryRecorder(scenario, [seed], [0], fronts).record(STEPS)[0] for seed in (SEED, SEED + 1)]
    assert alone[0] != alone[1]
    for size, threads, autoreset in BATCHES:
        seeds = rng.integers(0, 2**62, size).tolist()
        seeds[0], seeds[-1] = SEED, SEED + 1
        recorded = TrajectoryRecorder(scenario, seeds, [0, size - 1], fronts, threads).record(STEPS, autoreset)
        assert recorded == alone, f"{size} rows on {threads} threads, autoreset={autoreset}"


@EACH
def test_after_other_episodes_in_the_same_memory(scenario_id: str, fronts: int) -> None:
    scenario, seeds = KNOWN[scenario_id], range(SEED, SEED + 3)

    def use(simulator: Simulator) -> None:
        simulator.reset([5, 6, 7])
        for _ in range(150):
            simulator.step(np.full((3, 1 + fronts), 4).squeeze(), autoreset=True)

    fresh, used = (
        TrajectoryRecorder(scenario, seeds, range(3), fronts, change=change).record(STEPS) for change in (None, use)
    )
    assert fresh == used


@EACH
def test_rows_do_not_notice_that_another_one_begins_anew(scenario_id: str, fronts: int) -> None:
    scenario, rows = KNOWN[scenario_id], FULL + 2
    simulator = Simulator(scenario, rows, learned_fronts=fronts)
    simulator.reset(np.arange(rows))
    rng = np.random.default_rng(3)
    for step in range(STEPS):
        if step % 7 == 0:
            chosen = rng.integers(0, scenario.num_actions, (rows, 1 + fronts)).squeeze()
        simulator.step(chosen)
        anew = np.arange(rows) == step % rows
        before = others(simulator, ~anew)
        simulator.next_episode(anew)
        assert others(simulator, ~anew) == before


def others(simulator: Simulator, rows: NDArray[np.bool_]) -> list[bytes]:
    """All that these rows get, as bytes."""
    by_row = simulator.terms, simulator.feasible, simulator.steps
    shown = simulator.arrays.all_observations[:, :, rows], simulator.arrays.all_results[:, :, rows]
    return [part.tobytes() for part in (*shown, *(part[rows] for part in by_row))]


@EACH
def test_in_copies_of_an_environment(scenario_id: str, fronts: int) -> None:
    env = StopLineParallelEnv(KNOWN[scenario_id], learned_fronts=fronts)
    env.reset(seed=SEED)
    for _ in range(40):
        env.step(dict.fromkeys(env.agents, 4))
    copies = copy.deepcopy(env), pickle.loads(pickle.dumps(env))  # noqa: S301  (made here)
    while env.agents:
        actions = dict.fromkeys(env.agents, 5)
        recorded = env.step(actions)
        for other in copies:
            assert pickle.dumps(other.step(actions)) == pickle.dumps(recorded)
            assert other.state().tobytes() == env.state().tobytes()


def test_in_copies_of_a_batch_that_threads_share() -> None:
    envs = StopLineVectorEnv(300, threads=2)
    envs.reset(seed=SEED)
    actions = np.full(300, 4)
    for _ in range(40):
        envs.step(actions)
    copies = copy.deepcopy(envs), pickle.loads(pickle.dumps(envs))  # noqa: S301  (made here)
    for _ in range(40):
        recorded = envs.step(actions)
        for other in copies:
            assert pickle.dumps(other.step(actions)) == pickle.dumps(recorded)


@EACH
def test_in_the_pettingzoo_view(scenario_id: str, fronts: int) -> None:
    simulator = Simulator(KNOWN[scenario_id], 1, learned_fronts=fronts)
    simulator.reset([SEED])
    env = StopLineParallelEnv(KNOWN[scenario_id], learned_fronts=fronts)
    observations, infos = env.reset(seed=SEED)
    endings = 0
    for _ in range(2 * STEPS):
        agents, key, step = env.possible_agents, simulator.key(0), int(simulator.steps[0])
        chosen = [chosen_level(*key, step, slot, simulator.scenario.num_actions) for slot in range(len(agents))]
        simulator.step(chosen if fronts == 0 else [chosen])
        actions = dict(zip(agents, chosen, strict=True))
        recorded = env.step({agent: actions[agent] for agent in env.agents})
        for slot, agent in enumerate(agents):
            if agent in recorded[0]:
                check_agent(agent, recorded, simulator, slot)
        assert env.state().tobytes() == simulator.arrays.all_observations[:, :, 0].T.tobytes()
        if not env.agents:
            simulator.reset_done()
            observations, infos = env.reset()
            assert observations["ego"].tobytes() == simulator.observations.tobytes()
            assert (infos["ego"]["seed"], infos["ego"]["episode_index"]) == simulator.key(0)
            endings += 1
    assert endings > 0


def check_agent(agent: str, recorded: Any, simulator: Simulator, slot: int) -> None:
    own, (observations, rewards, terminations, truncations, infos) = simulator.of_agent(slot), recorded
    assert observations[agent].tobytes() == own.observations.tobytes()
    assert np.float64(rewards[agent]).tobytes() == own.rewards.tobytes()
    assert infos[agent]["reward_option"].tobytes() == own.reward_option.tobytes()
    assert infos[agent]["reward_action"].tobytes() == own.reward_action.tobytes()
    outcome = Outcome(own.outcomes[0])
    assert infos[agent].get("outcome", Outcome.RUNNING) == outcome
    assert terminations[agent] == (outcome not in {Outcome.RUNNING, Outcome.TIMEOUT})
    assert truncations[agent] == (outcome == Outcome.TIMEOUT)
    if agent == "ego" and outcome:
        assert infos[agent]["feasible"] == simulator.feasible[0]


@pytest.mark.parametrize("continuous", [False, True])
@pytest.mark.parametrize("scenario_id", KNOWN)
def test_in_the_gymnasium_and_vector_views(scenario_id: str, continuous: bool) -> None:
    rows, row = 5, 3
    vector = StopLineVectorEnv(rows, KNOWN[scenario_id], continuous_actions=continuous)
    single = StopLineEnv(KNOWN[scenario_id], continuous_actions=continuous)
    batch, _ = vector.reset(seed=SEED - row)
    alone, _ = single.reset(seed=SEED)
    over = False
    vector.action_space.seed(4)
    for step in range(STEPS):
        assert batch[row].tobytes() == alone.tobytes()
        if step % 8 == 0:
            actions = vector.action_space.sample()
        batch, rewards, terminated, truncated, infos = vector.step(actions)
        if over:
            (alone, _), over = single.reset(), False
            continue
        alone, reward, ended, cut, info = single.step(actions[row])
        assert np.float64(reward).tobytes() == rewards[row].tobytes()
        assert info["reward_option"].tobytes() == infos["reward_option"][row].tobytes()
        assert info["reward_action"].tobytes() == infos["reward_action"][row].tobytes()
        assert (ended, cut) == (terminated[row], truncated[row])
        over = ended or cut


def test_a_level_and_its_acceleration_are_the_same_action() -> None:
    scenario, levels = get_scenario("platoon-v0"), np.array(get_scenario("platoon-v0").vehicle.levels)
    by_index, by_value = (Simulator(scenario, 130, learned_fronts=3) for _ in range(2))
    by_index.reset(np.arange(130))
    by_value.reset(np.arange(130))
    for chosen in np.random.default_rng(2).integers(0, len(levels), (60, 130, 4)):
        by_index.step(chosen)
        by_value.step(levels[chosen])
        assert by_index.arrays.all_observations.tobytes() == by_value.arrays.all_observations.tobytes()
        assert by_index.arrays.all_results.tobytes() == by_value.arrays.all_results.tobytes()


NUMBERS = {
    "stop-line-v0": ("DT", "PER_DT", "LENGTH", "LAG_GAIN", "SPEED_LIMIT", "SIGMA_1", "SIGMA_2", "SIGMA_3"),
    "stop-line-dense-v0": ("START_LOW", "START_HIGH", "START_SPEED_LOW", "GAP_LOW", "GAP_HIGH", "FRONT_SPEED_LOW"),
    "stop-line-wet-v0": ("FRICTION", "PER_TWICE_DECEL"),
}
FEW = {"FRICTION": 4}  # bits: the last one of an acceleration mostly drowns in the speed's rounding
PARAMETERS = (
    "desired_speed", "headway", "max_accel", "comfort_decel", "min_gap", "line_decel", "stop_position", "line_speed",
)  # fmt: skip


def recorded_digest(scenario_id: str, fronts: int, change: Callable[[Simulator], None] | None = None) -> str:
    seeds = range(100, 116)
    return digest(TrajectoryRecorder(KNOWN[scenario_id], seeds, range(len(seeds)), fronts, change=change).record(200))


@pytest.mark.parametrize("fronts", [0, 2])
@pytest.mark.parametrize("scenario_id", NUMBERS)
def test_one_bit_of_a_number_shows(scenario_id: str, fronts: int) -> None:
    before = recorded_digest(scenario_id, fronts)
    assert recorded_digest(scenario_id, fronts) == before
    for name in NUMBERS[scenario_id]:

        def nudge(simulator: Simulator, place: int = getattr(layout, name), bits: int = FEW.get(name, 1)) -> None:
            simulator._constants[place] += bits * np.spacing(simulator._constants[place])

        assert recorded_digest(scenario_id, fronts, nudge) != before, name


@pytest.mark.parametrize("fronts", [0, 2])
def test_one_bit_of_a_profile_shows(fronts: int) -> None:
    before = recorded_digest("stop-line-v0", fronts)
    for name in PARAMETERS:

        def nudge(simulator: Simulator, column: int = list(profiles.PARAMETERS).index(name)) -> None:
            tables = simulator._constants[layout.COUNTS + simulator.scenario.num_vehicles :]
            families = tables.reshape(-1, layout_module.FAMILY_TABLE_WIDTH)
            families[:, 2 * column : 2 * column + 2] = np.nextafter(families[:, 2 * column : 2 * column + 2], inf)

        assert recorded_digest("stop-line-v0", fronts, nudge) != before, name


@pytest.mark.parametrize(("scenario_id", "fronts"), DIGESTS)
def test_trajectories_match_their_golden_digest(scenario_id: str, fronts: int) -> None:
    recorded = recorded_digest(scenario_id, fronts)
    assert recorded == DIGESTS[scenario_id, fronts], f"({scenario_id!r}, {fronts}): the motion changed: {recorded}"


def test_one_bit_of_one_vehicle_shows_in_its_row_alone() -> None:
    rows = FULL + 2
    plain, nudged = (Simulator(get_scenario("stop-line-v0"), rows, learned_fronts=2) for _ in range(2))
    for simulator in (plain, nudged):
        simulator.reset(np.arange(rows))
    nudged._memory.vehicles(rows - 1)[1, 1] += np.spacing(nudged._memory.vehicles(rows - 1)[1, 1])
    for _ in range(3):
        plain.step(np.full((rows, 3), 3))
        nudged.step(np.full((rows, 3), 3))
    before, after = (np.stack([each.vehicles(row) for row in range(rows)]) for each in (plain, nudged))
    differs = (before != after) & ~np.isnan(before)
    assert differs[rows - 1, 1].any()
    assert not differs[: rows - 1].any()
