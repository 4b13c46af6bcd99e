from contextlib import AbstractContextManager, nullcontext
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from hhrl_envs import SCENARIOS, Goal, Outcome, Scenario
from hhrl_envs.scenario.registry import SUPERSEDED
from hhrl_envs.views.gym_env import StopLineEnv, StopLineVectorEnv, gym_id
from hhrl_envs.views.parallel_env import EGO, StopLineParallelEnv
from hhrl_envs.worlds import stop_line_v0
from support.driving import random_actions

EACH = pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=lambda scenario: scenario.id)


@EACH
def test_gymnasium_accepts_the_single_view(scenario: Scenario, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    with told_if_superseded(scenario):
        made = gymnasium.make(gym_id(scenario.id))
    check_env(made.unwrapped)


@EACH
def test_gymnasium_accepts_continuous_actions(scenario: Scenario) -> None:
    with told_if_superseded(scenario):
        made = gymnasium.make(gym_id(scenario.id), continuous_actions=True)
    check_env(made.unwrapped, skip_render_check=True)


def told_if_superseded(scenario: Scenario) -> AbstractContextManager[object]:
    """Gymnasium itself warns of a scenario that has a newer version."""
    return pytest.deprecated_call(match="out of date") if scenario.id in SUPERSEDED else nullcontext()


@EACH
def test_all_views_tell_the_same_story(scenario: Scenario) -> None:
    steps, seed = 1300, 11
    actions = random_actions(4, steps, 3, scenario.num_actions)
    vector = StopLineVectorEnv(3, scenario)
    single, parallel = StopLineEnv(scenario), StopLineParallelEnv(scenario, learned_fronts=0)
    batch, begun = vector.reset(seed=seed)
    alone, info = single.reset(seed=seed + 1)
    assert begun["feasible"][1] == info["feasible"]
    together, told_at_reset = parallel.reset(seed=seed + 1)
    world = {name: told_at_reset[EGO][name] for name in ("profiles", "seed", "episode_index")}
    for simulator, row in ((vector.simulator, 1), (single.simulator, 0)):
        assert (simulator.profiles(row), *simulator.key(row)) == tuple(world.values())
    assert (batch[1] == alone).all()
    assert (batch[1] == together[EGO]).all()
    over, endings = False, 0
    for chosen in actions:
        batch, rewards, terminated, truncated, infos = vector.step(chosen)
        assert vector.observation_space.contains(batch)
        if over:
            alone, _ = single.reset()
            together, _ = parallel.reset()
            story: Any = (alone, 0.0, False, False)
        else:
            story = single.step(chosen[1])
            told = parallel.step({EGO: int(chosen[1])})
            assert (told[0][EGO] == story[0]).all()
            assert (told[1][EGO], told[2][EGO], told[3][EGO]) == story[1:4]
            assert (story[4]["reward_option"] == infos["reward_option"][1]).all()
            assert (told[4][EGO]["reward_action"] == infos["reward_action"][1]).all()
            assert told[4][EGO].get("outcome", Outcome.RUNNING) == infos["outcome"][1]
        assert (batch[1] == story[0]).all()
        assert (rewards[1], terminated[1], truncated[1]) == tuple(story[1:4])
        over = bool(terminated[1] or truncated[1])
        endings += over
    assert endings > 0


def test_make_vec_gives_the_native_vector_view() -> None:
    env = gymnasium.make_vec("hhrl_envs/StopLine-v0", num_envs=4, vectorization_mode="vector_entry_point")
    assert isinstance(env.unwrapped, StopLineVectorEnv)
    observations, infos = env.reset(seed=[9, 8, 7, 6])  # type: ignore[arg-type]
    assert observations.shape == (4, 11)
    assert infos["feasible"].all()
    again, _ = StopLineVectorEnv(1).reset(seed=7)
    assert (again[0] == observations[2]).all()


def test_reset_without_a_seed_goes_on_to_the_next_episode() -> None:
    env = stop_line_v0.parallel_env()
    _, first = env.reset(seed=3)
    _, second = env.reset()
    assert (first[EGO]["seed"], first[EGO]["episode_index"]) == (3, 0)
    assert (second[EGO]["seed"], second[EGO]["episode_index"]) == (3, 1)
    fresh = stop_line_v0.parallel_env()
    assert fresh.reset()[1][EGO]["seed"] != stop_line_v0.parallel_env().reset()[1][EGO]["seed"]


@EACH
@pytest.mark.parametrize("fronts", [0, 1, 3])
def test_states_and_observations_lie_in_their_spaces(scenario: Scenario, fronts: int) -> None:
    most = 0 if scenario.goal == Goal.FOLLOW else scenario.traffic.max_fronts
    env = StopLineParallelEnv(scenario, learned_fronts=min(fronts, most))
    for seed in range(8):
        observations, _ = env.reset(seed=seed)
        assert (env.state() == np.concatenate(list(observations.values()))).all()
        chosen = random_actions(seed, scenario.horizon, len(env.possible_agents), scenario.num_actions)
        while env.agents:
            levels = dict(zip(env.possible_agents, chosen[env.simulator.steps[0]].tolist(), strict=True))
            observations = env.step({agent: levels[agent] for agent in env.agents})[0]
            for agent, seen in observations.items():
                assert env.observation_space(agent).contains(seen)
            assert env.state_space.contains(env.state())
