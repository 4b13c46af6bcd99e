"""The window of render_mode="human": what it shows, its pace, its close button, and two windows at once."""

import copy
import pickle
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pygame
import pytest

from hhrl_envs import Option
from hhrl_envs.rendering.canvas import GREEN, ORANGE
from hhrl_envs.rendering.window import Window
from hhrl_envs.views.gym_env import StopLineEnv
from hhrl_envs.views.parallel_env import EGO, StopLineParallelEnv
from hhrl_envs.worlds import two_stops_v0

FRAME = np.full((240, 960, 3), (10, 200, 30), np.uint8)


@pytest.fixture(autouse=True)
def _no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


def shown(window: Window) -> np.ndarray:
    assert window._window is not None
    return pygame.surfarray.array3d(window._window.get_surface()).swapaxes(0, 1)


def press_close(window: Window) -> None:
    pygame.event.post(pygame.event.Event(pygame.WINDOWCLOSE, window=window._window))


def test_a_window_shows_the_frame() -> None:
    window = Window("test", 1000)
    window.show(FRAME)
    assert np.array_equal(shown(window), FRAME)
    window.close()


def test_frames_keep_their_pace() -> None:
    window = Window("test", 20)
    window.show(FRAME)
    start = time.perf_counter()
    for _ in range(6):
        window.show(FRAME)
    assert time.perf_counter() - start > 0.24  # six frames of 0.05 s, less the clock's rounding
    window.close()


def test_the_close_button_closes_its_window_only_and_for_good() -> None:
    one, two = Window("one", 1000), Window("two", 1000)
    one.show(FRAME)
    two.show(FRAME)
    press_close(two)
    one.show(FRAME)
    two.show(FRAME)
    assert (one.closed, two.closed) == (False, True)
    two.show(FRAME)
    assert two._window is None
    one.close()


def window_of(env: StopLineParallelEnv) -> Window:
    assert env._renderer is not None
    assert env._renderer._window is not None
    return env._renderer._window


def test_a_copy_has_a_window_of_its_own() -> None:
    env = StopLineParallelEnv(render_mode="human")
    env.reset(seed=3)
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):  # noqa: S301  (made here)
        env.step({EGO: 0})
        other.step({EGO: 0})
        assert window_of(other) is not window_of(env)
        assert not window_of(other).closed
        other.close()
    env.close()
    assert window_of(copy.deepcopy(env)).closed


def test_an_episode_goes_on_without_its_window() -> None:
    env = two_stops_v0.parallel_env(render_mode="human")
    env.reset(seed=3)
    assert env._renderer is not None
    assert env._renderer._window is not None
    env.step({EGO: 0})
    press_close(env._renderer._window)
    start = time.perf_counter()
    for _ in range(300):
        env.step({EGO: 0})
    assert env._renderer._window.closed
    assert time.perf_counter() - start < 15.0  # three hundred shown steps would take thirty seconds
    env.close()


def test_every_reset_and_step_is_shown_and_render_returns_nothing() -> None:
    human, array = StopLineParallelEnv(render_mode="human"), StopLineParallelEnv(render_mode="rgb_array")
    for env in (human, array):
        env.reset(seed=3)
    assert human._renderer is not None
    assert human.render() is None
    for action in (5, 0, 0):
        assert human._renderer._window is not None
        picture = array.render()
        assert picture is not None
        assert np.array_equal(shown(human._renderer._window), picture)
        human.step({EGO: action})
        array.step({EGO: action})
    human.close()


@pytest.mark.parametrize(("option", "colour"), [(Option.SSL, ORANGE), (Option.FFV, GREEN)])
def test_the_pictures_show_the_option_that_was_told_until_the_next_reset(
    option: Option, colour: tuple[int, int, int]
) -> None:
    env = StopLineEnv(render_mode="rgb_array")
    env.reset(seed=3)
    before = env.render()
    env.show_option(option)
    told = env.render()
    assert (told == colour).all(axis=-1).sum() > (before == colour).all(axis=-1).sum() + 1000
    env.show_option(-1)
    assert np.array_equal(env.render(), before)
    env.show_option(option)
    env.reset(seed=3)
    assert np.array_equal(env.render(), before)


def test_the_aec_view_is_told_the_option_too() -> None:
    env = two_stops_v0.env(render_mode="rgb_array")
    env.reset(seed=3)
    before = env.render()
    unwrapped: Any = env.unwrapped
    unwrapped.show_option(Option.FFV)
    assert not np.array_equal(np.asarray(env.render()), np.asarray(before))


@pytest.mark.parametrize("driver", ["nothing", None], ids=str)
def test_a_machine_without_a_screen_is_told_what_to_write(monkeypatch: pytest.MonkeyPatch, driver: str | None) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    if driver is not None:
        monkeypatch.setenv("SDL_VIDEODRIVER", driver)
    code = "from hhrl_envs import triad; triad('follow-v0').parallel_env(render_mode='human').reset(seed=1)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    last = done.stderr.splitlines()[-1]
    assert "InputError: no screen for render_mode 'human'" in last
    assert last.endswith("write 'rgb_array' instead")


def test_nothing_is_imported_before_it_is_needed() -> None:
    code = """if True:
        import sys
        from hhrl_envs import stop_line_v0
        env = stop_line_v0.parallel_env(render_mode="human")
        assert "pygame" not in sys.modules
        env.reset(seed=1)
        assert "pygame" in sys.modules
        env.close()
    """
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_a_window_that_opens_again_is_not_destroyed_with_the_one_before() -> None:
    frame = np.zeros((24, 96, 3), np.uint8)
    for _ in range(30):  # the address of the one before is taken again in about half of them
        window = Window("again", 10_000)
        window.show(frame)
        pygame.display.quit()
        window.show(frame)
        window.close()


def quit_and_begin_anew() -> None:
    pygame.quit()
    pygame.init()


@pytest.mark.parametrize("ended_by", [pygame.quit, pygame.display.quit, quit_and_begin_anew])
def test_pictures_and_windows_outlive_what_others_do_to_pygame(ended_by: Callable[[], None]) -> None:
    human, array = StopLineParallelEnv(render_mode="human"), StopLineParallelEnv(render_mode="rgb_array")
    for env in (human, array):
        env.reset(seed=3)
    before = array.render()
    ended_by()
    again = array.render()
    assert again is not None
    assert np.array_equal(again, np.asarray(before))
    human.step({EGO: 5})
    array.step({EGO: 5})
    picture = array.render()
    assert picture is not None
    assert np.array_equal(shown(window_of(human)), picture)
    ended_by()
    human.close()
