"""What PettingZoo and Gymnasium declare is there: spaces, generators, limits, masks and keys."""

import copy
from typing import Any

import gymnasium
import numpy as np
import pygame
import pytest
from gymnasium.utils.play import play

from hhrl_envs import SCENARIOS, Outcome, platoon_v0, stop_line_v0
from hhrl_envs.views.gym_env import StopLineEnv, StopLineVectorEnv, gym_id
from hhrl_envs.views.parallel_env import EGO
from support.driving import careful_actions


def test_spaces_and_a_generator_of_the_parallel_view() -> None:
    env = platoon_v0.parallel_env()
    assert isinstance(env.np_random, np.random.Generator)
    for name in ("observation_space", "action_space"):
        spaces = getattr(env, f"{name}s")
        assert list(spaces) == env.possible_agents
        assert all(spaces[agent] is getattr(env, name)(agent) for agent in spaces)


def test_the_generator_follows_the_seed() -> None:
    one, two = stop_line_v0.parallel_env(), stop_line_v0.parallel_env()
    for env in (one, two):
        env.reset(seed=2**64 - 1)
    assert one.np_random.integers(1 << 60) == two.np_random.integers(1 << 60)
    assert copy.deepcopy(one).np_random.integers(1 << 60) == one.np_random.integers(1 << 60)
    before = two.np_random.integers(1 << 60)
    two.reset(seed=1)
    assert two.np_random.integers(1 << 60) != before
    vector = StopLineVectorEnv(2)
    vector.reset(seed=[5, 6])
    assert vector.np_random_seed == 5


@pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=lambda scenario: scenario.id)
def test_gymnasium_knows_how_long_an_episode_can_last(scenario: Any) -> None:
    assert gymnasium.spec(gym_id(scenario.id)).max_episode_steps == scenario.horizon


@pytest.mark.parametrize(("action", "outcome"), [(0, Outcome.TIMEOUT), (5, Outcome.NOT_STOP)])
def test_that_limit_changes_no_episode(action: int, outcome: Outcome) -> None:
    made, bare = gymnasium.make("hhrl_envs/SoloStop-v0"), StopLineEnv("solo-stop-v0")
    for env in (made, bare):
        env.reset(seed=5)
    over, steps = False, 0
    while not over:
        told, expected = made.step(action), bare.step(action)
        assert told[1:4] == expected[1:4]
        over, steps = told[2] or told[3], steps + 1
    assert told[4]["outcome"] == outcome
    assert (steps == bare.scenario.horizon) == (outcome == Outcome.TIMEOUT)


def test_the_last_info_says_whether_it_was_a_success() -> None:
    env, seen = stop_line_v0.parallel_env(), set()
    for seed in range(8):
        env.reset(seed=seed)
        while env.agents:
            infos = env.step({EGO: 5 if seed % 5 == 0 else careful_actions(env.simulator)[0]})[4]
        assert infos[EGO]["is_success"] is (infos[EGO]["outcome"] == Outcome.SUCCESS)
        seen.add(infos[EGO]["is_success"])
    assert seen == {True, False}


def test_all_actions_are_allowed() -> None:
    assert StopLineEnv().action_masks().tolist() == [True] * 6
    assert StopLineVectorEnv(3).action_masks().tolist() == [[True] * 6] * 3


@pytest.mark.parametrize("continuous", [False, True])
def test_somebody_plays(continuous: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env = gymnasium.make("hhrl_envs/StopLine-v0", render_mode="rgb_array", continuous_actions=continuous)
    roll_on: Any = np.zeros(1, np.float32) if continuous else 3
    pressed = [ord("w")] * 3 + [ord("s")] * 3 + [pygame.K_ESCAPE]
    chosen: list[float] = []

    def note(*step: Any) -> None:
        chosen.append(float(np.squeeze(step[2])))
        for event in (pygame.KEYUP, pygame.KEYDOWN):
            key = pressed[0] if event == pygame.KEYDOWN else (pressed.pop(0) if len(pressed) > 1 else ord("x"))
            pygame.event.post(pygame.event.Event(event, key=key))

    play(env, callback=note, noop=roll_on, fps=1000, seed=3)
    assert {0.0, 1.0, -1.0} <= set(chosen) if continuous else {3.0, 5.0, 0.0} <= set(chosen)
    assert env.reset(seed=1)[0].shape == (11,)
    assert np.asarray(env.render()).shape == (240, 960, 3)  # play has ended with pygame.quit()
