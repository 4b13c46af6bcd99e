"""Gymnasium's three ways to begin episodes anew: the native vector view does what a vector of single views does."""

from dataclasses import replace
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv
from gymnasium.wrappers.vector import DictInfoToList, RecordEpisodeStatistics

from hhrl_envs import SCENARIOS, InputError
from hhrl_envs.views.gym_env import StopLineEnv, StopLineVectorEnv
from support.driving import random_actions

SHORT = replace(SCENARIOS["stop-line-noisy-v0"], id="short-v0", horizon=50, feasible_only=False)
"""Most of its episodes end on the time limit, some before; what is seen depends on what was seen before."""

MODES = pytest.mark.parametrize("mode", AutoresetMode, ids=lambda mode: mode.name)
ROWS, STEPS = 5, 300


def both(mode: AutoresetMode) -> tuple[Any, Any]:
    sync = SyncVectorEnv([partial(StopLineEnv, SHORT)] * ROWS, autoreset_mode=mode)
    return StopLineVectorEnv(ROWS, SHORT, autoreset_mode=mode), sync


def assert_same_infos(native: dict[str, Any], other: dict[str, Any]) -> None:
    """Every entry of the single views is there, with the same values where the single view of a row has one."""
    for name, values in other.items():
        if name.startswith("_"):
            assert np.array_equal(native.get(name, np.ones(ROWS, np.bool_)), values)
        elif isinstance(values, dict):
            assert_same_infos(native[name], values)
        else:
            rows = np.flatnonzero(other[f"_{name}"])
            assert all(np.array_equal(native[name][row], values[row]) for row in rows)
    assert {name for name in native if not name.startswith("_")} == {name for name in other if not name.startswith("_")}


@MODES
def test_it_tells_the_story_of_single_views(mode: AutoresetMode) -> None:
    native, sync = both(mode)
    begun, expected = native.reset(seed=3), sync.reset(seed=3)
    assert np.array_equal(begun[0], expected[0])
    assert_same_infos(begun[1], expected[1])
    endings, outcomes = 0, set()
    for actions in random_actions(2, STEPS, ROWS, SHORT.num_actions):
        told, expected = native.step(actions), sync.step(actions)
        for mine, other in zip(told[:4], expected[:4], strict=True):
            assert np.array_equal(mine, other)
        assert_same_infos(told[4], expected[4])
        ended = told[2] | told[3]
        endings += int(ended.sum())
        outcomes |= set(told[4].get("final_info", told[4])["outcome"][ended].tolist())
        if mode is AutoresetMode.DISABLED and ended.any():
            begun = native.reset(options={"reset_mask": ended})
            expected = sync.reset(options={"reset_mask": ended})
            assert np.array_equal(begun[0], expected[0])
    assert endings > 20
    assert len(outcomes) > 1


def test_a_reset_of_some_rows_with_seeds_leaves_the_others_alone() -> None:
    native, sync = both(AutoresetMode.NEXT_STEP)
    for envs in (native, sync):
        envs.reset(seed=3)
        envs.step(np.full(ROWS, 3))
    some = np.array([True, False, False, True, False])
    begun, _ = native.reset(seed=90, options={"reset_mask": some})
    expected, _ = sync.reset(seed=90, options={"reset_mask": some})
    assert np.array_equal(begun, expected)
    assert [native.simulator.key(row) for row in range(ROWS)] == [(90, 0), (4, 0), (5, 0), (93, 0), (7, 0)]
    assert np.array_equal(native.step(np.full(ROWS, 3))[0], sync.step(np.full(ROWS, 3))[0])


@pytest.mark.parametrize(
    ("kind", "mode"),
    [
        *((kind, mode) for kind in ("native", "sync", "async") for mode in list(AutoresetMode)[:2]),
        ("native", AutoresetMode.DISABLED),  # the others take the mask away before the statistics see it
    ],
)
def test_statistics_of_episodes_are_those_of_the_view(kind: str, mode: AutoresetMode) -> None:
    single = [partial(StopLineEnv, SHORT)] * 2
    makers: dict[str, Any] = {
        "native": partial(StopLineVectorEnv, 2, SHORT, autoreset_mode=mode),
        "sync": partial(SyncVectorEnv, single, autoreset_mode=mode),
        "async": partial(AsyncVectorEnv, single, autoreset_mode=mode, daemon=True),
    }
    envs = RecordEpisodeStatistics(makers[kind]())
    envs.reset(seed=3)
    total, returns, began = np.zeros(2), [], np.zeros(2, np.bool_)
    for actions in random_actions(2, STEPS, 2, SHORT.num_actions):
        _, rewards, terminated, truncated, infos = envs.step(actions)
        ended = terminated | truncated
        total = np.where(began, 0.0, total + rewards)
        for row in np.flatnonzero(ended):
            returns.append(total[row])
            assert infos["episode"]["r"][row] == pytest.approx(total[row])
            total[row] = 0.0
        began = ended if mode is AutoresetMode.NEXT_STEP else np.zeros(2, np.bool_)
        if mode is AutoresetMode.DISABLED and ended.any():
            envs.reset(options={"reset_mask": ended})
    envs.close()
    assert len(returns) > 8
    assert len(set(returns)) > 4


def test_infos_as_a_list_of_rows() -> None:
    envs = DictInfoToList(StopLineVectorEnv(2, SHORT, autoreset_mode="SameStep"))
    _, infos = envs.reset(seed=3)
    keys: set[str] = set(infos[0])
    for _ in range(SHORT.horizon):
        *_, infos = envs.step(np.full(2, 0))
    assert [set(info) - keys for info in infos] == [{"final_obs", "final_info"}] * 2
    assert set(infos[0]["final_info"]) == keys


@pytest.mark.filterwarnings("ignore")  # Gymnasium logs the error, too
def test_errors_keep_their_words_across_processes() -> None:
    envs = AsyncVectorEnv([partial(StopLineEnv, SHORT)] * 2, daemon=True)
    envs.reset(seed=1)
    with pytest.raises(InputError, match=r"action of 'ego' is .*17.*; write an integer from 0 to 5"):
        envs.step(np.array([0, 17]))
    envs.close(terminate=True)


@pytest.mark.parametrize("options", [{}, {"autoreset_mode": "Disabled"}])
def test_pictures_of_all_rows(options: dict[str, Any]) -> None:
    envs: Any = gymnasium.make_vec("hhrl_envs/StopLine-v0", 3, render_mode="rgb_array", **options)
    envs.reset(seed=[4, 5, 4])
    pictures = envs.render()
    single = StopLineEnv(render_mode="rgb_array")
    single.reset(seed=5)
    assert np.array_equal(pictures[1], single.render())
    assert np.array_equal(pictures[0], pictures[2])
    assert envs.metadata["render_fps"] == 10
    assert StopLineVectorEnv(2).render() is None
