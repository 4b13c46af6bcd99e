"""The law: row i with seed s is the same trajectory, byte for byte, in every batch, on every thread, in every view."""

import copy
import pickle
from collections.abc import Callable
from math import inf, nextafter
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_envs import SCENARIOS, Goal, Outcome, get_scenario, layout, profiles
from hhrl_envs.gym_env import StopLineEnv
from hhrl_envs.parallel_env import StopLineParallelEnv
from hhrl_envs.simulator import Simulator
from hhrl_envs.vector_env import StopLineVectorEnv
from support.stories import Teller, chosen_level, digest

STEPS, SEED = 200, 90
BATCHES = ((7, 1, True), (64, 2, False), (128, 1, False), (129, 2, True), (1024, 1, True), (1024, 2, False))
WORLDS = [(scenario.id, 0) for scenario in SCENARIOS.values()] + [
    (scenario.id, min(3, scenario.traffic.max_fronts))
    for scenario in SCENARIOS.values()
    if scenario.goal != Goal.FOLLOW and scenario.traffic.max_fronts > 0
]
STORIES: dict[tuple[str, int], str] = {
    ("stop-line-v0", 0): "fc6cabd27c962c7c303a821e33e156435a2a849057a3ac9e1413cac2ea386a65",
    ("stop-line-heldout-v0", 0): "90ef73c861f9bfb7faddcb491b97d65e56a90463dac9d3f0533c645bc9ce40ae",
    ("stop-line-dense-v0", 0): "6e493e0817a1ed1fa00876db1a11bb9d2ac6c39a3aa979e45fbd8637a1f46c16",
    ("stop-line-erratic-v0", 0): "f432e0533a18eec3e45761a4d75ae954b3bd4b6ec747fb2a2fa93d1f0e1680a3",
    ("stop-line-wet-v0", 0): "84489d9764333553153e3c9e67a530e5ec10fe05e2b29c2f96a2679bea85e5bd",
    ("stop-line-noisy-v0", 0): "e9e463319674fe9f1215417f567f6078ad620fcb936d324fe336e209793ac321",
    ("follow-v0", 0): "38b1027a247d5261c46572e1bad0699a5496f5a6a810d3576f9f033010a3aa5f",
    ("solo-stop-v0", 0): "b59f13fa9d9c9c5a0b08e267dc14e41babffa47990f4b3bb7cfaecba311baf0b",
    ("red-light-v0", 0): "fbcdf43bacc06fb3b6a3741b1dc96ce0e8edc9aef5d84f3195c38b58e414a55e",
    ("stop-and-go-v0", 0): "3c8fb892e0c7d76b15ded15ccef7ed6e6fe32671540cfc44d9c07dbb28d7907a",
    ("two-stops-v0", 0): "4cb66ec17265ce6c10926f8898e966bef3d2222912549ddad84946c539f7cc1e",
    ("platoon-v0", 0): "9663e4149941c7ad3b1d54c3c12a9c0dfd8c9605da98fcb67caa731d0a7866d3",
    ("adversary-v0", 0): "f0bc8eac6d8147ef789dcd1402ef4e0aefa611e78eae91106bd392b1ba316333",
    ("stop-line-v0", 3): "7be215b6eb6b18765d48c510bba19ab0e626cc5d5f233632f0bcc8fd5c9d8beb",
    ("stop-line-heldout-v0", 3): "4a4da0f4f3554b66046d79deb3c50d6279dc1195be0f95c70e6ff203565b0818",
    ("stop-line-dense-v0", 3): "a4520ae9c5025abf2a5f032370b5456b8ccfd0d0b95d0eaacc4c8037b8e97b2a",
    ("stop-line-erratic-v0", 3): "d460b34bc9b7a6bbd130acd8f295c8ca9867766c14e0ebf40599aa84826eb344",
    ("stop-line-wet-v0", 3): "01f12b44892bb1fe647a4451005968e2f0dee06075ac5cc3b410858e990b1929",
    ("stop-line-noisy-v0", 3): "9fa9d3ca25e76ed0817f5eba93bf455910495c65be026b3c284691faa2adf456",
    ("red-light-v0", 3): "a9e87ad2ee0b5c531c65a7d15eac8335045e4a9a2ad4657c09d24e9bd2d7dbca",
    ("stop-and-go-v0", 3): "d209b86401206d5690fc5e29296368e9501201b20e32dde0be086074272bcb4a",
    ("two-stops-v0", 2): "43abd4ed3d32da3535064efc14a8cc1c7a7e06b246f51ba4953423231a66d790",
    ("platoon-v0", 3): "ac3a278dc4310a0d63fc4b406532d2b0d67a7753914771ea11a44bf15377922c",
    ("adversary-v0", 3): "c76474d496d7c90fef15ddb1a27ebc39a0056e0ee89913d69b1b0ba54f338b9f",
}
EACH = pytest.mark.parametrize(("scenario_id", "fronts"), WORLDS)


@EACH
def test_in_every_batch_on_every_thread_with_and_without_autoreset(scenario_id: str, fronts: int) -> None:
    scenario, rng = get_scenario(scenario_id), np.random.default_rng(1)
    alone = [Teller(scenario, [seed], [0], fronts).tell(STEPS)[0] for seed in (SEED, SEED + 1)]
    assert alone[0] != alone[1]
    for size, threads, autoreset in BATCHES:
        seeds = rng.integers(0, 2**62, size).tolist()
        seeds[0], seeds[-1] = SEED, SEED + 1
        told = Teller(scenario, seeds, [0, size - 1], fronts, threads).tell(STEPS, autoreset)
        assert told == alone, f"{size} rows on {threads} threads, autoreset={autoreset}"


@EACH
def test_after_other_episodes_in_the_same_memory(scenario_id: str, fronts: int) -> None:
    scenario, seeds = get_scenario(scenario_id), range(SEED, SEED + 3)

    def use(simulator: Simulator) -> None:
        simulator.reset([5, 6, 7])
        for _ in range(150):
            simulator.step(np.full((3, 1 + fronts), 4).squeeze(), autoreset=True)

    fresh, used = (Teller(scenario, seeds, range(3), fronts, change=change).tell(STEPS) for change in (None, use))
    assert fresh == used


@EACH
def test_rows_do_not_notice_that_another_one_begins_anew(scenario_id: str, fronts: int) -> None:
    scenario, rows = get_scenario(scenario_id), 130
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
    shown = simulator.raw_observations[:, :, rows], simulator.raw_results[:, :, rows]
    return [part.tobytes() for part in (*shown, *(part[rows] for part in by_row))]


@EACH
def test_in_copies_of_an_environment(scenario_id: str, fronts: int) -> None:
    env = StopLineParallelEnv(scenario_id, learned_fronts=fronts)
    env.reset(seed=SEED)
    for _ in range(40):
        env.step(dict.fromkeys(env.agents, 4))
    copies = copy.deepcopy(env), pickle.loads(pickle.dumps(env))  # noqa: S301  (made here)
    while env.agents:
        actions = dict.fromkeys(env.agents, 5)
        told = env.step(actions)
        for other in copies:
            assert pickle.dumps(other.step(actions)) == pickle.dumps(told)
            assert other.state().tobytes() == env.state().tobytes()


@EACH
def test_in_the_pettingzoo_view(scenario_id: str, fronts: int) -> None:
    simulator = Simulator(get_scenario(scenario_id), 1, learned_fronts=fronts)
    simulator.reset([SEED])
    env = StopLineParallelEnv(scenario_id, learned_fronts=fronts)
    observations, infos = env.reset(seed=SEED)
    endings = 0
    for _ in range(2 * STEPS):
        agents, key, step = env.possible_agents, simulator.key(0), int(simulator.steps[0])
        chosen = [chosen_level(*key, step, slot, simulator.scenario.num_actions) for slot in range(len(agents))]
        simulator.step(chosen if fronts == 0 else [chosen])
        actions = dict(zip(agents, chosen, strict=True))
        told = env.step({agent: actions[agent] for agent in env.agents})
        for slot, agent in enumerate(agents):
            if agent in told[0]:
                check_agent(agent, told, simulator, slot)
        assert env.state().tobytes() == simulator.raw_observations[:, :, 0].T.tobytes()
        if not env.agents:
            simulator.reset_done()
            observations, infos = env.reset()
            assert observations["ego"].tobytes() == simulator.observations.tobytes()
            assert (infos["ego"]["seed"], infos["ego"]["episode"]) == simulator.key(0)
            endings += 1
    assert endings > 0


def check_agent(agent: str, told: Any, simulator: Simulator, slot: int) -> None:
    own, (observations, rewards, terminations, truncations, infos) = simulator.of_agent(slot), told
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
@pytest.mark.parametrize("scenario_id", SCENARIOS)
def test_in_the_gymnasium_and_vector_views(scenario_id: str, continuous: bool) -> None:
    rows, row = 5, 3
    vector = StopLineVectorEnv(rows, scenario_id, continuous_actions=continuous)
    single = StopLineEnv(scenario_id, continuous_actions=continuous)
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
        assert by_index.raw_observations.tobytes() == by_value.raw_observations.tobytes()
        assert by_index.raw_results.tobytes() == by_value.raw_results.tobytes()


NUMBERS = {
    "stop-line-v0": ("DT", "PER_DT", "LENGTH", "LAG_GAIN", "SPEED_LIMIT", "SIGMA_1", "SIGMA_2", "SIGMA_3"),
    "stop-line-dense-v0": ("START_LOW", "START_HIGH", "START_SPEED_LOW", "GAP_LOW", "GAP_HIGH", "FRONT_SPEED_LOW"),
    "stop-line-wet-v0": ("GRIP", "PER_TWICE_DECEL"),
}
FEW = {"GRIP": 4}  # bits: the last one of an acceleration mostly drowns in the speed's rounding
PARAMETERS = (
    "desired_speed", "headway", "max_accel", "comfort_decel", "min_gap", "line_decel", "stop_position", "line_speed",
)  # fmt: skip


def story(scenario_id: str, fronts: int, change: Callable[[Simulator], None] | None = None) -> str:
    seeds = range(100, 116)
    return digest(Teller(get_scenario(scenario_id), seeds, range(len(seeds)), fronts, change=change).tell(200))


@pytest.mark.parametrize("fronts", [0, 2])
@pytest.mark.parametrize("scenario_id", NUMBERS)
def test_one_bit_of_a_number_shows(scenario_id: str, fronts: int) -> None:
    before = story(scenario_id, fronts)
    assert story(scenario_id, fronts) == before
    for name in NUMBERS[scenario_id]:

        def nudge(simulator: Simulator, place: int = getattr(layout, name), bits: int = FEW.get(name, 1)) -> None:
            simulator._constants[place] += bits * np.spacing(simulator._constants[place])

        assert story(scenario_id, fronts, nudge) != before, name


@pytest.mark.parametrize("fronts", [0, 2])
def test_one_bit_of_a_profile_shows(fronts: int) -> None:
    before = story("stop-line-v0", fronts)
    for name in PARAMETERS:

        def nudge(simulator: Simulator, column: int = list(profiles.PARAMETERS).index(name)) -> None:
            families = simulator._tables[1]
            families[:, 2 * column : 2 * column + 2] = np.nextafter(families[:, 2 * column : 2 * column + 2], inf)

        assert story("stop-line-v0", fronts, nudge) != before, name


@pytest.mark.parametrize(("scenario_id", "fronts"), STORIES)
def test_stories_match_their_golden_digest(scenario_id: str, fronts: int) -> None:
    told = story(scenario_id, fronts)
    assert told == STORIES[scenario_id, fronts], f"({scenario_id!r}, {fronts}): the motion changed: {told}"


def test_one_bit_of_a_vehicles_motion_shows_in_the_next_frame_of_all_that_follow() -> None:
    scenario = get_scenario("stop-line-v0")
    plain, nudged = (Simulator(scenario, 130, learned_fronts=2) for _ in range(2))
    for simulator in (plain, nudged):
        simulator.reset(np.arange(130))
    fields, slot = nudged._memory.fields, int(layout.VEHICLE) // layout.LANES
    speed = fields[1, slot + int(layout.SPEED) // layout.LANES]
    speed[1] = nextafter(speed[1], inf)  # front_1 of row 129
    kept = np.full((130, 3), 3)
    for _ in range(3):
        plain.step(kept)
        nudged.step(kept)
    same = (plain.vehicles(128) == nudged.vehicles(128)) | np.isnan(plain.vehicles(128))
    assert same.all()
    assert (plain.vehicles(129)[1] != nudged.vehicles(129)[1]).any()
