"""Pictures: their shape, what they show, and that they need neither a display nor more than the extra."""

import subprocess
import sys

import numpy as np
import pytest
from numpy.typing import NDArray

from hhrl_envs import SCENARIOS, Option, Outcome, Simulator, errors, get_scenario
from hhrl_envs.rendering import canvas
from hhrl_envs.rendering.picture import OPTION_COLOURS, OUTCOME_COLOURS, picture
from hhrl_envs.rendering.renderer import Renderer, draw_row
from hhrl_envs.rendering.snapshot import Snapshot, snapshot_of

SCENARIO = get_scenario("stop-line-v0")
ABSENT = (np.nan, np.nan, np.nan)


def snapshot(
    *vehicles: tuple[float, float, float], outcome: Outcome = Outcome.RUNNING, option: Option | None = None
) -> Snapshot:
    return Snapshot(SCENARIO, np.array(vehicles), line=0.0, time=1.0, outcome=outcome, option=option)


def count(frame: NDArray[np.uint8], colour: canvas.Colour) -> int:
    return int((frame == np.array(colour, np.uint8)).all(axis=-1).sum())


def test_frame_of_a_simulator_has_the_documented_shape_and_repeats() -> None:
    simulator = Simulator(SCENARIO, 2)
    simulator.reset(np.array([3, 4], np.uint64))
    frame = draw_row(simulator, row=1, option=int(Option.FFV))
    assert frame.shape == (240, 960, 3)
    assert frame.dtype == np.uint8
    assert np.array_equal(frame, draw_row(simulator, row=1, option=int(Option.FFV)))
    assert not np.array_equal(frame, draw_row(simulator, row=0, option=int(Option.FFV)))


def test_snapshot_measures_what_the_observation_says() -> None:
    simulator = Simulator(SCENARIO, 64)
    simulator.reset(np.arange(64, dtype=np.uint64))
    for row in range(64):
        now = snapshot_of(simulator, row, option=-1)
        assert now.option is None
        assert now.d_d == pytest.approx(float(simulator.observations[row, 8]) * 64, abs=1e-4)
        expected = float(simulator.observations[row, 3]) * 64
        assert (SCENARIO.sensor.front_range if now.d_f is None else now.d_f) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("option", Option)
def test_selected_option_is_highlighted(option: Option) -> None:
    vehicles = ((-60.0, 8.0, 0.0), (-30.0, 5.0, 0.0))
    colour = OPTION_COLOURS[option]
    selected, flat = (count(picture(snapshot(*vehicles, option=chosen)), colour) for chosen in (option, None))
    assert selected > 5 * flat + 500


def test_braking_lights_both_lamps_of_a_vehicle() -> None:
    cruising = count(picture(snapshot((-60.0, 8.0, 0.0))), canvas.VERMILLION)
    braking = count(picture(snapshot((-60.0, 8.0, -2.0))), canvas.VERMILLION)
    assert cruising == 0
    assert braking > 10


def test_absent_and_distant_vehicles_are_not_drawn() -> None:
    alone = picture(snapshot((-60.0, 8.0, 0.0)))
    assert np.array_equal(alone, picture(snapshot((-60.0, 8.0, 0.0), ABSENT)))
    assert np.array_equal(alone, picture(snapshot((-60.0, 8.0, 0.0), (500.0, 8.0, 0.0))))


@pytest.mark.parametrize("outcome", [outcome for outcome in Outcome if outcome is not Outcome.RUNNING])
def test_outcome_fills_the_header(outcome: Outcome) -> None:
    header = picture(snapshot((-1.0, 0.0, 0.0), outcome=outcome))[:30]
    assert count(header, OUTCOME_COLOURS[outcome]) > 0.8 * header.shape[0] * header.shape[1]


def test_vehicles_keep_their_scale() -> None:
    frame = picture(snapshot((-60.0, 8.0, 0.0)))
    middle = frame[88]
    blue = np.flatnonzero((middle == np.array(canvas.BLUE, np.uint8)).all(axis=-1))
    assert blue[-1] - blue[0] == pytest.approx(SCENARIO.vehicle.length * 960 / 112, abs=4)


def test_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(errors, "find_spec", lambda _: None)
    with pytest.raises(errors.MissingExtraError, match=r"pip install -e '.\[render\]'"):
        Renderer(Simulator(SCENARIO, 1), "rgb_array")
    with pytest.raises(errors.MissingExtraError, match=r"pip install -e '.\[render\]'"):
        draw_row(Simulator(SCENARIO, 1))


def test_rendering_opens_no_display_and_is_imported_on_demand_only() -> None:
    code = """if True:
        import sys, numpy as np
        from hhrl_envs import Simulator, get_scenario
        from hhrl_envs.rendering.renderer import draw_row
        assert "pygame" not in sys.modules
        simulator = Simulator(get_scenario("stop-line-v0"), 1)
        simulator.reset(np.zeros(1, np.uint64))
        draw_row(simulator)
        import pygame
        assert not pygame.display.get_init()
    """
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize("scenario_id", SCENARIOS)
def test_every_scenario_keeps_the_ego_in_view_on_its_whole_way(scenario_id: str) -> None:
    simulator = Simulator(SCENARIOS[scenario_id], 1)
    simulator.reset(np.array([3], np.uint64))
    throttle = np.array([SCENARIOS[scenario_id].num_actions - 2])
    frames = []
    while simulator.outcomes[0] == Outcome.RUNNING:
        frames.append(draw_row(simulator))
        for _ in range(5):
            simulator.step(throttle)
    assert len(frames) > 3
    assert all(count(frame[60:110], canvas.BLUE) > 200 for frame in frames)


def test_signal_turns_from_red_to_green() -> None:
    scenario = get_scenario("red-light-v0")
    vehicles = np.array([(-40.0, 8.0, 0.0)])
    lamps = []
    for line in (0.0, None):
        frame = picture(Snapshot(scenario, vehicles, line, time=1.0, outcome=Outcome.RUNNING, option=None))
        lamps.append([count(frame[134:156], colour) for colour in (canvas.VERMILLION, canvas.GREEN)])
    (red, no_green), (no_red, green) = lamps
    assert min(red, green) > 50
    assert no_green == no_red == 0


@pytest.mark.parametrize(("scenario_id", "pills"), [("follow-v0", 1), ("solo-stop-v0", 1), ("stop-line-v0", 2)])
def test_only_options_of_the_scenario_are_offered(scenario_id: str, pills: int) -> None:
    scenario = get_scenario(scenario_id)
    frame = picture(Snapshot(scenario, np.array([(-60.0, 8.0, 0.0)]), None, 1.0, Outcome.RUNNING, None))
    offered = count(frame[170:], canvas.PALE)
    full = count(picture(snapshot((-60.0, 8.0, 0.0)))[170:], canvas.PALE) / 2
    assert offered == pytest.approx(pills * full, rel=0.05)
