"""What a picture shows and where: header, road, vehicles, the two distances, and the read-out."""

from math import inf, isnan

import numpy as np
from numpy.typing import NDArray

from hhrl_envs.rendering.canvas import (
    BLUE,
    GREEN,
    GREY,
    INK,
    PALE,
    PURPLE,
    VERMILLION,
    WHITE,
    Canvas,
    Colour,
    mix,
)
from hhrl_envs.rendering.snapshot import Snapshot
from hhrl_envs.scenario.scenario import Goal
from hhrl_envs.sub_goals import STATE_ORDER, SUB_GOALS, Option, Outcome

WIDTH, HEIGHT, HEADER = 960, 240, 34
ROAD_ROWS = slice(36, 160)
"""The rows of a picture that show the road and the distances, without header and read-out."""

OPTION_COLOURS: dict[Option, Colour] = {goal.option: goal.colour for goal in SUB_GOALS}
OUTCOME_NAMES = {
    Outcome.RUNNING: "running",
    Outcome.SUCCESS: "SUCCESS",
    Outcome.TIMEOUT: "TIMEOUT",
    Outcome.REAR_ENDED: "REAR-ENDED",
    Outcome.FOILED: "FOILED",
    **{goal.failure: goal.failure_title for goal in SUB_GOALS},
}
OUTCOME_COLOURS: dict[Outcome, Colour] = {
    Outcome.RUNNING: GREY,
    Outcome.SUCCESS: GREEN,
    Outcome.TIMEOUT: GREY,
    Outcome.REAR_ENDED: VERMILLION,
    Outcome.FOILED: PURPLE,
    **{goal.failure: goal.failure_colour for goal in SUB_GOALS},
}

_GOAL_OF = {goal.target: goal for goal in SUB_GOALS if goal.target is not None}
_VIEW = 112.0  # m from the left edge to the right one
_SCALE = WIDTH / _VIEW  # pixels a metre, along and across the road
_LANE, _SHOULDER, _CAR = 3.8, 1.0, 1.9  # m across
_ROAD_Y = 88.0  # the middle of the lane
_ASPHALT = (74, 81, 92)
_BRAKING = -0.3  # m/s^2; brake lights are on below it


def picture(snapshot: Snapshot) -> NDArray[np.uint8]:
    """Return the snapshot's picture, uint8 [HEIGHT, WIDTH, 3]."""
    canvas = Canvas(WIDTH, HEIGHT)
    _draw_road(canvas, snapshot)
    for slot in reversed(range(len(snapshot.vehicles))):
        _draw_vehicle(canvas, snapshot, slot)
    _draw_speeds(canvas, snapshot)
    _draw_distances(canvas, snapshot)
    draw_header(canvas, snapshot)
    _draw_read_out(canvas, snapshot)
    return canvas.pixels()


def draw_header(canvas: Canvas, snapshot: Snapshot) -> None:
    """Draw the strip at the top: the scenario and, at the end, how the episode ended."""
    ended = snapshot.outcome is not Outcome.RUNNING
    canvas.rect(0, 0, WIDTH, HEADER, OUTCOME_COLOURS[snapshot.outcome] if ended else INK)
    canvas.text(14, HEADER / 2, snapshot.scenario.id, 19, WHITE)
    if ended:
        canvas.text(WIDTH / 2, HEADER / 2, OUTCOME_NAMES[snapshot.outcome], 26, WHITE, "c")


def _x(snapshot: Snapshot, position: float) -> float:
    """Return the pixel column of a position: ego and active line are in view, and the road stands still if it can."""
    ego, lines = float(snapshot.vehicles[0, 0]), snapshot.scenario.road.lines
    ahead = snapshot.line if snapshot.line is not None else lines[-1] if lines else inf
    left = max(min(ego - 21.0, ahead - 97.0), ego - (0.6 if snapshot.line is None else 0.9) * _VIEW)
    return (position - left) * _SCALE


def _draw_road(canvas: Canvas, snapshot: Snapshot) -> None:
    half = _LANE / 2 * _SCALE
    edge = half + _SHOULDER * _SCALE
    canvas.rect(0, _ROAD_Y - edge, WIDTH, 2 * edge, _ASPHALT)
    for y in (_ROAD_Y - half, _ROAD_Y + half):
        canvas.rect(0, y - 0.75, WIDTH, 1.5, PALE)
    for metres in range(-500, 1000, 10):
        canvas.rect(_x(snapshot, metres), _ROAD_Y + edge - 4, 1, 4, PALE)
    for line in snapshot.scenario.road.lines:
        _draw_line(canvas, snapshot, line, half)
    if snapshot.scenario.goal is Goal.PASS:
        end = _x(snapshot, snapshot.scenario.route_end)
        canvas.rect(end, _ROAD_Y - half, 2, 2 * half, GREEN)
        canvas.text(end + 8, 144, "end of route", 18, GREY)


def _draw_line(canvas: Canvas, snapshot: Snapshot, line: float, half: float) -> None:
    x, zone = _x(snapshot, line), snapshot.scenario.road.stop_zone * _SCALE
    active = line == snapshot.line
    if active:
        goal = _GOAL_OF["stop-line"]
        colour = mix(goal.colour, _ASPHALT, 0.95 if snapshot.option is goal.option else 0.35)
        canvas.rect(x - zone, _ROAD_Y - half + 2, zone, 2 * half - 4, colour)
    canvas.rect(x, _ROAD_Y - half, 0.5 * _SCALE, 2 * half, WHITE if active else GREY)
    name = "stop-line"
    if snapshot.scenario.signal is not None:
        name = "red light" if active else "green light"
        canvas.rect(x + 8, 138, 12, 12, VERMILLION if active else GREEN, radius=6)
        x += 18
    canvas.text(x + 8, 144, name, 18, GREY)


def _draw_vehicle(canvas: Canvas, snapshot: Snapshot, slot: int) -> None:
    accel, length = float(snapshot.vehicles[slot, 2]), snapshot.scenario.vehicle.length * _SCALE
    front = _x(snapshot, float(snapshot.vehicles[slot, 0]))
    if isnan(front) or front < 0 or front - length > WIDTH:
        return
    goal = _GOAL_OF["front vehicle"]
    if slot == 1 and snapshot.option is goal.option:
        y, width = _ROAD_Y - _CAR / 2 * _SCALE - 4, _CAR * _SCALE + 8
        canvas.rect(front - length - 4, y, length + 8, width, goal.colour, radius=8)
    colour = BLUE if slot == 0 else mix(BLUE, PALE, 0.45) if slot < snapshot.agents else PALE
    _draw_car(canvas, front, length, colour, braking=accel < _BRAKING)


def _draw_speeds(canvas: Canvas, snapshot: Snapshot) -> None:
    """Write every vehicle's speed above it, or beside that of the vehicle behind where they are too near."""
    edge, y = _x(snapshot, float(snapshot.vehicles[0, 0])), _ROAD_Y - 37
    canvas.text(edge, y, f"ego {snapshot.vehicles[0, 1]:.1f} m/s", 18, BLUE, "r")
    for slot in range(1, len(snapshot.vehicles)):
        rear = _x(snapshot, float(snapshot.vehicles[slot, 0]) - snapshot.scenario.vehicle.length)
        if isnan(rear) or rear > WIDTH:
            return
        name = f"front_{slot} " if slot < snapshot.agents else ""
        left = max(rear, edge + 8)
        edge = left + canvas.text(left, y, f"{name}{snapshot.vehicles[slot, 1]:.1f}", 18, INK)


def _draw_car(canvas: Canvas, front: float, length: float, colour: Colour, braking: bool) -> None:
    width = _CAR * _SCALE
    rear, top = front - length, _ROAD_Y - width / 2
    canvas.rect(rear, top, length, width, colour, radius=0.3 * width)
    glass = mix(INK, colour, 0.75)
    canvas.rect(rear + 0.16 * length, top + 2.5, 0.1 * length, width - 5, glass, radius=2)
    canvas.rect(rear + 0.58 * length, top + 2, 0.14 * length, width - 4, glass, radius=2)
    for side in (top + 2, top + width - 5):
        canvas.rect(front - 3.5, side, 2.5, 3, WHITE, radius=1)
        if braking:
            canvas.rect(rear - 2, side - 1, 5, 5, VERMILLION, radius=1)


def _draw_distances(canvas: Canvas, snapshot: Snapshot) -> None:
    ego = _x(snapshot, float(snapshot.vehicles[0, 0]))
    for row, goal in enumerate(STATE_ORDER):
        y, distance, selected = 123 + 21 * row, snapshot.distance(goal), snapshot.option is goal.option
        colour = goal.colour if selected else GREY
        if distance is None or distance < 0.0:
            continue
        end = min(ego + distance * _SCALE, float(WIDTH))
        canvas.lines([(ego, y), (end, y)], colour, 2.5 if selected else 1)
        for x in (ego, end):
            canvas.lines([(x, y - 5), (x, y + 5)], colour, 2.5 if selected else 1)
        canvas.text(ego - 8, y, f"{goal.distance}  {distance:.1f} m", 18, INK if selected else GREY, "r")


def _draw_read_out(canvas: Canvas, snapshot: Snapshot) -> None:
    _, speed, accel = (float(value) for value in snapshot.vehicles[0])
    tiles = (
        ("time", f"{snapshot.time:.1f} s"),
        ("speed", f"{speed:.1f} m/s"),
        ("acceleration", f"{accel:+.1f} m/s²"),
        *((f"to {target}  {goal.distance}", _metres(snapshot.distance(goal))) for target, goal in _GOAL_OF.items()),
    )
    for column, (name, value) in enumerate(tiles):
        x = 14 + column * 125.0
        canvas.text(x, 182, name, 16, GREY)
        canvas.text(x, 208, value, 28)
    offered = [goal for goal, exists in zip(SUB_GOALS, snapshot.scenario.option_mask, strict=True) if exists]
    pitch = 62 / max(len(offered), 2)
    for row, goal in enumerate(offered):
        y, selected = 172 + pitch * row, snapshot.option is goal.option
        canvas.rect(WIDTH - 240, y, 226, pitch - 5, goal.colour if selected else PALE, radius=(pitch - 5) / 2)
        words = f"{goal.spelling}: {goal.title}"
        canvas.text(WIDTH - 127, y + (pitch - 5) / 2, words, 19, INK if selected else GREY, "c")


def _metres(distance: float | None) -> str:
    return "none" if distance is None else f"{distance:.1f} m"
