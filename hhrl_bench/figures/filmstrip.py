"""An episode as one PNG: key frames, then speed and distance over time. Needs the ``render`` extra."""

from collections.abc import Sequence
from io import BytesIO
from itertools import pairwise
from math import ceil, nan

import numpy as np
from PIL import Image

from hhrl_bench.evaluation.results import Update, silent
from hhrl_envs import SUB_GOALS
from hhrl_envs.rendering.canvas import (
    BLUE,
    GREEN,
    GREY,
    INK,
    NAMED_COLOURS,
    ORANGE,
    PALE,
    PAPER,
    PURPLE,
    VERMILLION,
    Canvas,
    Colour,
    Point,
)
from hhrl_envs.rendering.picture import HEADER, OPTION_COLOURS, ROAD_ROWS, WIDTH, draw_header, picture
from hhrl_envs.rendering.snapshot import Snapshot

_COLOUR_WORDS = {ORANGE: "orange", GREEN: "green", BLUE: "blue", VERMILLION: "vermillion", PURPLE: "purple"}
_KEY_FRAMES = 6
_ROAD = ROAD_ROWS.stop - ROAD_ROWS.start
_CHART, _MARGIN = 190, 14
_HEIGHT = HEADER + _KEY_FRAMES * (_ROAD + 6) + 2 * _CHART + _MARGIN
_LEFT, _RIGHT, _TOP, _BOTTOM = 62, 24, 32, 26  # pixels kept free around the plotted area of a chart
_STEPS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)


class Chart:
    """A chart from 0 to ``x_max`` seconds and from 0 to ``y_max``, ``height`` pixels high from ``top`` downwards."""

    def __init__(self, canvas: Canvas, top: float, height: float, x_max: float, y_max: float) -> None:
        self._canvas = canvas
        self._left, self._width = float(_LEFT), float(canvas.width - _LEFT - _RIGHT)
        self._top, self._height = top + _TOP, height - _TOP - _BOTTOM
        self._x_max = x_max
        self._y_step = _tick(y_max, 4)
        self._y_max = self._y_step * max(ceil(y_max / self._y_step), 1)

    @property
    def bottom(self) -> float:
        """The pixel row of y = 0."""
        return self._top + self._height

    @property
    def legend(self) -> float:
        """The pixel row of the legend."""
        return self._top - 16

    def x(self, time: float) -> float:
        """Return the pixel column of a time in seconds."""
        return self._left + time / self._x_max * self._width

    def frame(self, unit: str, legend: Sequence[tuple[str, Colour]]) -> None:
        """Draw grid, tick labels and a legend of names in their colours."""
        for i in range(round(self._y_max / self._y_step) + 1):
            value = i * self._y_step
            x, y = self._point(0.0, value)
            self._canvas.rect(x, y - 0.5, self._width, 1, PALE)
            self._canvas.text(x - 8, y, f"{value:g}", 17, GREY, "r")
        step = _tick(self._x_max, 12)
        for i in range(int(self._x_max / step) + 1):
            self._canvas.text(self.x(i * step), self.bottom + 13, f"{i * step:g} s", 17, GREY, "c")
        left = self._left + self._canvas.text(self._left, self.legend, f"{unit}   ", 18, GREY)
        for name, colour in legend:
            self._canvas.rect(left, self.legend - 2, 18, 4, colour, radius=2)
            left += 44 + self._canvas.text(left + 24, self.legend, name, 18, INK)

    def line(self, points: Sequence[Point], colour: Colour, width: float = 2.0) -> None:
        """Draw a line through (time, value) points, broken where a value is NaN."""
        run: list[Point] = []
        for time, value in [*points, (0.0, float("nan"))]:
            if value == value:  # noqa: PLR0124  (false for NaN)
                run.append(self._point(time, value))
                continue
            if len(run) > 1:
                self._canvas.lines(run, colour, width)
            run = []

    def _point(self, time: float, value: float) -> Point:
        return self.x(time), self.bottom - value / self._y_max * self._height


def _tick(largest: float, at_most: int) -> float:
    """Return the smallest round step of which ``at_most`` reach ``largest``."""
    return next((step for step in _STEPS if step * at_most >= largest), _STEPS[-1])


def png(snapshots: Sequence[Snapshot], update: Update = silent) -> bytes:
    """Return the bytes of a PNG, 960 pixels wide, with evenly spaced key frames, the first and the last among them.

    ``update`` hears how many of them are drawn.
    """
    canvas = Canvas(WIDTH, _HEIGHT)
    draw_header(canvas, snapshots[-1])
    for place, step in enumerate(np.linspace(0, len(snapshots) - 1, _KEY_FRAMES).round().astype(int)):
        _draw_key_frame(canvas, snapshots[step], HEADER + place * (_ROAD + 6))
        update(place + 1, _KEY_FRAMES, "")
    _draw_speeds(canvas, snapshots, _HEIGHT - 2 * _CHART - _MARGIN)
    _draw_distances(canvas, snapshots, _HEIGHT - _CHART - _MARGIN)
    out = BytesIO()
    Image.fromarray(canvas.pixels()).save(out, "PNG", optimize=True)
    return out.getvalue()


def _draw_key_frame(canvas: Canvas, snapshot: Snapshot, top: int) -> None:
    canvas.image(picture(snapshot)[ROAD_ROWS], 0, top)
    canvas.rect(_MARGIN, top + 4, 72, 22, PAPER)
    canvas.text(_MARGIN, top + 15, f"{snapshot.time:.1f} s", 22)
    canvas.rect(0, top + _ROAD + 2, WIDTH, 1, PALE)


def _draw_speeds(canvas: Canvas, snapshots: Sequence[Snapshot], top: int) -> None:
    times, speeds = _times(snapshots), np.array([snapshot.vehicles[:, 1] for snapshot in snapshots])
    chart = Chart(canvas, top, _CHART, times[-1], float(np.nanmax(speeds)))
    chart.frame("m/s", (("ego", BLUE), ("front vehicles", GREY)))
    for fronts in speeds[:, :0:-1].T:
        chart.line(list(zip(times, fronts, strict=True)), GREY, 1)
    chart.line(list(zip(times, speeds[:, 0], strict=True)), BLUE, 2.5)


def _draw_distances(canvas: Canvas, snapshots: Sequence[Snapshot], top: int) -> None:
    times = _times(snapshots)
    gaps = [nan if snapshot.d_f is None else snapshot.d_f for snapshot in snapshots]
    to_line = [nan if snapshot.d_d is None else max(snapshot.d_d, 0.0) for snapshot in snapshots]
    chart = Chart(canvas, top, _CHART, times[-1], float(np.nanmax([*to_line, *gaps, 0.0])))
    chart.frame("m", (("d_d, to the stop-line", ORANGE), ("d_f, to the front vehicle", GREEN)))
    chart.line(list(zip(times, gaps, strict=True)), GREEN)
    chart.line(list(zip(times, to_line, strict=True)), ORANGE)
    if snapshots[0].option is not None:
        _draw_options(canvas, chart, snapshots)


def _draw_options(canvas: Canvas, chart: Chart, snapshots: Sequence[Snapshot]) -> None:
    """Draw a bar in the colour of the selected option along the time axis."""
    for now, after in pairwise(snapshots):
        if now.option is not None:
            left, right = chart.x(now.time), chart.x(after.time)
            canvas.rect(left, chart.bottom - 3, right - left, 6, OPTION_COLOURS[now.option])
    colours = ", ".join(f"{_COLOUR_WORDS[goal.colour]} {goal.spelling}" for goal in SUB_GOALS)
    canvas.text(chart.x(snapshots[-1].time), chart.legend, f"bar on the axis: the option, {colours}", 18, GREY, "r")


def _times(snapshots: Sequence[Snapshot]) -> list[float]:
    return [snapshot.time for snapshot in snapshots]


_COLOURS = 128
_SAMPLE_EVERY = 10  # frames; the palette is chosen from these, the last one, and the named colours
_HOLD = 2500  # ms; how long the outcome stays on before the film starts anew


def gif(snapshots: Sequence[Snapshot], update: Update = silent) -> bytes:
    """Return the bytes of a GIF with a frame for every snapshot; all share one palette, so that nothing flickers.

    ``update`` hears how many of them are drawn.
    """
    frames = []
    for snapshot in snapshots:
        frames.append(picture(snapshot))
        update(len(frames), len(snapshots), "")
    swatches = [np.full((8, *frames[0].shape[1:]), colour, np.uint8) for colour in NAMED_COLOURS]
    sample = np.concatenate([*frames[::_SAMPLE_EVERY], frames[-1], *swatches])
    palette = Image.fromarray(sample).quantize(_COLOURS)
    images = [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    step = round(1000 * snapshots[0].scenario.dt)
    out = BytesIO()
    durations = [step] * (len(images) - 1) + [_HOLD]
    images[0].save(out, "GIF", save_all=True, append_images=images[1:], duration=durations, loop=0)
    return out.getvalue()
