"""Every misuse of a view is one line that names the value and what to write instead."""

import re
from dataclasses import replace
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from hhrl_envs import InputError, get_scenario
from hhrl_envs.views.gym_env import StopLineEnv, StopLineVectorEnv
from hhrl_envs.views.parallel_env import EGO, StopLineParallelEnv
from hhrl_envs.worlds import stop_line_v0
from support.misuse import refused

ACTIONS: list[Any] = [
    np.nan,
    np.inf,
    2.5,
    1.0,
    -1,
    6,
    17,
    2**70,
    None,
    "1",
    True,
    [1],
    (1, 2),
    [[1, 2], 3],
    {},
    np.float32(1.0),
]
SEEDS: list[Any] = [-1, 2**64, 1.0, np.nan, "7", True, (), {}]
MODES: list[Any] = ["ascii", "", 3, True]


@pytest.mark.parametrize("action", ACTIONS, ids=repr)
def test_actions(action: Any) -> None:
    parallel, single, vector = StopLineParallelEnv(), StopLineEnv(), StopLineVectorEnv(2)
    for env in (parallel, single, vector):
        env.reset(seed=1)
    allowed = "write an integer from 0 to 5, a level of 'stop-line-v0'"
    refused(lambda: parallel.step({EGO: action}), f"action of 'ego' is {action!r}", allowed)
    refused(lambda: single.step(action), f"action of 'ego' is {action!r}", allowed)
    if action is not True:  # numpy takes [0, True] for integers
        refused(lambda: vector.step([0, action]), "write ")  # type: ignore[arg-type]
    assert parallel.agents == [EGO]
    assert parallel.step({EGO: 5})[0][EGO] == pytest.approx(single.step(np.int64(5))[0])


def test_resets_of_some_rows_alone() -> None:
    envs, some = StopLineVectorEnv(2), np.array([True, False])
    refused(lambda: envs.reset(options={"reset_mask": some}), "reset_mask before the first reset; call reset(seed=...)")
    envs.reset(seed=1, options={})
    before = envs.simulator.state()
    for wrong in ([True, False], some[:1], some.astype(int), ~some & some, np.ones((2, 1), np.bool_), "all"):
        refused(partial(envs.reset, options={"reset_mask": wrong}), "reset_mask is ", "a numpy array of 2 truth values")
    assert all((array == before[name]).all() for name, array in envs.simulator.state().items())


@pytest.mark.parametrize("mode", ["same", "", None, 1, True], ids=repr)
def test_autoreset_modes(mode: Any) -> None:
    refused(lambda: StopLineVectorEnv(2, autoreset_mode=mode), f"autoreset_mode is {mode!r}; write an AutoresetMode or")


def test_steps_of_rows_that_have_ended_and_do_not_begin_by_themselves() -> None:
    envs = StopLineVectorEnv(3, autoreset_mode=AutoresetMode.DISABLED)
    envs.reset(seed=1)
    ended = np.zeros(3, np.bool_)
    while not ended.any():
        _, _, terminated, truncated, _ = envs.step(np.full(3, 5))
        ended = terminated | truncated
    over = np.flatnonzero(ended)
    refused(
        lambda: envs.step(np.full(3, 5)), f"the episode of row {over[0]} is over, as in {over.size} of 3 rows; call"
    )


def test_limits_that_would_cut_episodes() -> None:
    longer = replace(get_scenario("stop-line-v0"), id="longer-v0", horizon=900)
    said = "max_episode_steps is 600; write 900 or more, the horizon of 'longer-v0'"
    refused(lambda: gymnasium.make("hhrl_envs/StopLine-v0", scenario=longer), said)
    refused(lambda: gymnasium.make_vec("hhrl_envs/StopLine-v0", num_envs=2, scenario=longer), said)
    refused(lambda: gymnasium.make_vec("hhrl_envs/StopLine-v0", num_envs=2, max_episode_steps=99), "max_episode_steps")


@pytest.mark.parametrize("actions", [{}, {"egon": 0}, {EGO: 0, "front_1": 0}, 3, None, [0]], ids=repr)
def test_agents_of_a_step(actions: Any) -> None:
    env = StopLineParallelEnv()
    env.reset(seed=1)
    given = f"actions for {list(actions)}" if isinstance(actions, dict) else f"actions are {actions!r}"
    refused(lambda: env.step(actions), given, "write a dict with one action for each of ['ego']")


def test_agents_of_a_space() -> None:
    env = StopLineParallelEnv()
    refused(lambda: env.action_space("egon"), "agent is 'egon'; write one of ['ego']")
    refused(lambda: env.observation_space("egon"), "agent is 'egon'; write one of ['ego']")


@pytest.mark.parametrize("seed", SEEDS, ids=repr)
def test_seeds(seed: Any) -> None:
    for env in (StopLineParallelEnv(), StopLineEnv()):
        refused(partial(env.reset, seed=seed), f"seed is {seed!r}; write an integer from 0 to 2^64 - 1")
    refused(lambda: StopLineVectorEnv(2).reset(seed=seed), "seed is ", "; write ")


def test_seeds_of_rows() -> None:
    vector = StopLineVectorEnv(3)
    refused(lambda: vector.reset(seed=[1, 2]), "seed is a list of 2; write one integer for each of 3 rows")
    refused(lambda: vector.reset(seed=[1, 2.5, 3]), "seed is 2.5; write an integer")  # type: ignore[list-item]
    refused(lambda: vector.reset(seed=2**64 - 2), "write an integer from 0 to 2^64 - 3, a list with one for each of 3")
    others: list[Any] = [np.array(5), np.array([[1, 2, 3]]), {1, 2, 3}, range(3)]
    for other in others:
        refused(partial(vector.reset, seed=other), "write an integer from 0 to 2^64 - 3, a list with one for each of 3")
    vector.reset(seed=2**64 - 3)
    assert [vector.simulator.key(row)[0] for row in range(3)] == [2**64 - 3, 2**64 - 2, 2**64 - 1]


def test_seeds_that_numpy_made_are_integers_too() -> None:
    for seed in (np.int64(7), np.uint64(7), np.int32(7)):
        assert StopLineParallelEnv().reset(seed=seed)[1][EGO]["seed"] == 7  # type: ignore[arg-type]


def test_step_and_render_before_reset() -> None:
    refused(lambda: StopLineParallelEnv().step({EGO: 0}), "step before reset; call reset(seed=...) first")
    refused(lambda: StopLineEnv().step(np.int64(0)), "step before reset; call reset(seed=...) first")
    refused(lambda: StopLineVectorEnv(1).step(np.zeros(1, np.int64)), "no episode has begun yet; call reset first")
    refused(StopLineParallelEnv(render_mode="rgb_array").render, "render before reset; call reset(seed=...) first")


def test_step_after_the_end() -> None:
    parallel, single = StopLineParallelEnv(), StopLineEnv()
    parallel.reset(seed=1)
    single.reset(seed=1)
    over = False
    while not over:
        parallel.step({EGO: 5})
        over = single.step(np.int64(5))[2]
    refused(lambda: parallel.step({EGO: 5}), "actions for ['ego'], but the episode is over; call reset() first")
    refused(lambda: single.step(np.int64(5)), "the episode is over; call reset() first")
    assert parallel.step({}) == ({}, {}, {}, {}, {})


@pytest.mark.parametrize("mode", MODES, ids=repr)
def test_render_modes(mode: Any) -> None:
    for make in (StopLineParallelEnv, StopLineEnv, stop_line_v0.env):
        given = partial(make, render_mode=mode)
        refused(given, f"render_mode is {mode!r}; write None, 'human' or 'rgb_array'")


def test_the_vector_view_has_no_window() -> None:
    refused(lambda: StopLineVectorEnv(2, render_mode="human"), "render_mode is 'human'", "a single environment")
    refused(StopLineVectorEnv(2, render_mode="rgb_array").render, "no episode has begun yet; call reset first")


@pytest.mark.parametrize("count", [0, -1, 1.5, "2", None, True], ids=repr)
def test_numbers_of_rows(count: Any) -> None:
    refused(lambda: StopLineVectorEnv(count), f"num_envs is {count!r}; write an integer, at least 1")


@pytest.mark.parametrize("option", [2, -2, 0.0, "SSL", True], ids=repr)
def test_options_to_show(option: Any) -> None:
    env = StopLineEnv()
    refused(lambda: env.show_option(option), f"option is {option!r}; write 0 (SSL), 1 (FFV), or None for a flat agent")


def test_the_messages_survive_gymnasiums_wrappers() -> None:
    env = gymnasium.make("hhrl_envs/StopLine-v0")
    env.reset(seed=1)
    with pytest.raises(InputError, match=re.escape("action of 'ego' is 17; write an integer from 0 to 5")):
        env.step(17)
