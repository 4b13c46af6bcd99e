"""Watching: the drawn episode is the evaluated one, and files are whole or absent."""

import re
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hhrl_agents import RULES, Agent, Decision
from hhrl_agents.atomic_files import OutputError
from hhrl_bench import evaluate
from hhrl_bench.errors import SeedError
from hhrl_bench.figures import filmstrip
from hhrl_bench.figures.watch import record, watch
from hhrl_bench.tasks.tasks import Task, get_task
from hhrl_envs import InputError, Option, Outcome, errors, get_scenario
from hhrl_envs.rendering.canvas import BLUE, GREEN, GREY, ORANGE, Canvas, Colour
from support.command_line import invoke

TASK = get_task("stop-line-v0")


class Coasting:
    """A flat agent that holds the level nearest to no acceleration."""

    def reset(self, mask: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> None:
        pass

    def act(self, observations: np.ndarray[tuple[int, int], np.dtype[np.float32]]) -> Decision:
        level = int(np.abs(get_scenario(TASK.scenario).vehicle.levels).argmin())
        return Decision(np.full(len(observations), -1), np.full(len(observations), level))


class Unplayable(Coasting):
    """An agent that must not be asked."""

    def act(self, observations: np.ndarray[tuple[int, int], np.dtype[np.float32]]) -> Decision:
        raise AssertionError("played before the request was checked")


def rule(name: str) -> Agent:
    return RULES[name](get_scenario(TASK.scenario))


def count(image: Image.Image, colour: Colour) -> int:
    return int((np.asarray(image.convert("RGB")) == np.array(colour, np.uint8)).all(axis=-1).sum())


@pytest.mark.parametrize("name", ["rule-1", "rule-2", "rule-4"])
def test_recorded_episode_is_the_evaluated_one(name: str) -> None:
    records = evaluate(rule(name), TASK, episodes=4)
    for episode in range(4):
        snapshots = record(rule(name), TASK, episode)
        assert int(snapshots[-1].outcome) == records.outcome[episode]
        assert len(snapshots) == records.steps[episode] + 1
        assert all(snapshot.outcome is Outcome.RUNNING for snapshot in snapshots[:-1])
        assert [round(snapshot.time / 0.1) for snapshot in snapshots] == list(range(len(snapshots)))


def test_episode_of_a_later_batch_is_the_evaluated_one() -> None:
    records = evaluate(rule("rule-3"), TASK, episodes=503)
    snapshots = record(rule("rule-3"), TASK, 502)
    assert (int(snapshots[-1].outcome), len(snapshots) - 1) == (records.outcome[502], records.steps[502])


def test_gif_shows_every_step_in_real_time(tmp_path: Path) -> None:
    out = tmp_path / "film.gif"
    outcome = watch(rule("rule-2"), TASK, out, episode=0)
    snapshots = record(rule("rule-2"), TASK, 0)
    assert outcome is snapshots[-1].outcome
    with Image.open(out) as film:
        durations = []
        for frame in range(film.n_frames):  # type: ignore[attr-defined]
            film.seek(frame)
            durations.append(film.info["duration"])
        assert film.size == (960, 240)
    assert len(durations) == len(snapshots)
    assert set(durations[:-1]) == {100}
    assert durations[-1] > 1000
    assert [path.name for path in tmp_path.iterdir()] == ["film.gif"]


def test_png_holds_key_frames_and_both_charts(tmp_path: Path) -> None:
    out = tmp_path / "new" / "strip.PNG"
    watch(rule("rule-4"), TASK, out, episode=3)
    with Image.open(out) as strip:
        assert strip.format == "PNG"
        frames, charts = strip.crop((0, 0, 960, 800)), strip.crop((0, 820, 960, strip.height))
        assert count(frames, BLUE) > 6 * 200
        assert min(count(charts, colour) for colour in (BLUE, ORANGE, GREEN)) > 500


def test_flat_agents_have_no_option_to_show(tmp_path: Path) -> None:
    snapshots = record(Coasting(), TASK, 0)
    assert {snapshot.option for snapshot in snapshots} == {None}
    watch(Coasting(), TASK, tmp_path / "strip.png")
    assert (tmp_path / "strip.png").stat().st_size > 0


def test_held_option_is_selected_throughout() -> None:
    assert {snapshot.option for snapshot in record(rule("rule-4"), TASK, 0, Option.SSL)} == {Option.SSL}


def test_a_scenario_without_a_task_is_watched_too(tmp_path: Path) -> None:
    out = tmp_path / "strip.png"
    assert invoke("watch", "rule-4", "--task", "platoon-v0", "--out", str(out)).exit_code == 0
    assert out.stat().st_size > 0


@pytest.mark.parametrize("name", ["film.mp4", "film", "film.gif.txt"])
def test_other_suffixes_are_refused_before_playing(tmp_path: Path, name: str) -> None:
    with pytest.raises(OutputError, match=r"ends in \.gif or \.png"):
        watch(Unplayable(), TASK, tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_folder_in_the_place_of_the_file_is_refused_before_playing(tmp_path: Path) -> None:
    (tmp_path / "film.gif").mkdir()
    with pytest.raises(OutputError, match="not a file"):
        watch(Unplayable(), TASK, tmp_path / "film.gif")


@pytest.mark.parametrize("episode", [-1, 10**9])
def test_episodes_outside_the_test_range_are_refused(tmp_path: Path, episode: int) -> None:
    with pytest.raises(SeedError):
        watch(rule("rule-1"), TASK, tmp_path / "film.gif", episode)
    assert not list(tmp_path.iterdir())


def test_missing_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(errors, "find_spec", lambda _: None)
    said = "the extra 'render' of hhrl-bench brings it; in a checkout: pip install -e '.[render]'"
    with pytest.raises(InputError, match=re.escape(said)):
        watch(Unplayable(), TASK, tmp_path / "film.gif")


def test_chart_line_breaks_where_a_value_is_missing() -> None:
    whole, broken = Canvas(400, 200), Canvas(400, 200)
    filmstrip.Chart(whole, 0, 200, 10.0, 5.0).line([(0.0, 1.0), (5.0, 1.0), (10.0, 1.0)], GREY)
    filmstrip.Chart(broken, 0, 200, 10.0, 5.0).line(
        [(0.0, 1.0), (2.0, 1.0), (5.0, float("nan")), (8.0, 1.0), (10.0, 1.0)], GREY
    )
    inks = [int((canvas.pixels() == np.array(GREY, np.uint8)).all(axis=-1).sum()) for canvas in (whole, broken)]
    assert inks[1] == pytest.approx(0.4 * inks[0], rel=0.05)


def test_strip_of_a_world_without_a_line() -> None:
    snapshots = record(rule("rule-4"), Task("follow", scenario="follow-v0", env_steps=1), 0)
    assert {snapshot.d_d for snapshot in snapshots} == {None}
    with Image.open(BytesIO(filmstrip.png(snapshots))) as drawn:
        assert count(drawn.crop((0, 820, 960, drawn.height)), GREEN) > 500
