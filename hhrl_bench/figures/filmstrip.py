"""An episode as one PNG: key frames, then speed and distance over time. Needs the ``render`` extra."""

from collections.abc import Sequence
from io import BytesIO
from itertools import pairwise
from math import nan

import numpy as np
from PIL import Image

from hhrl_bench.chart import Chart
from hhrl_envs import SUB_GOALS
from hhrl_envs.rendering.canvas import (
    BLUE,
    GREEN,
    GREY,
    NAMED_COLOURS,
    ORANGE,
    PALE,
    PAPER,
    PURPLE,
    VERMILLION,
    Canvas,
)
from hhrl_envs.rendering.picture import HEADER, OPTION_COLOURS, ROAD_ROWS, WIDTH, draw_header, picture
from hhrl_envs.rendering.snapshot import Snapshot

_COLOUR_WORDS = {ORANGE: "orange", GREEN: "green", BLUE: "blue", VERMILLION: "vermillion", PURPLE: "purple"}
_KEY_FRAMES = 6
_ROAD = ROAD_ROWS.stop - ROAD_ROWS.start
_CHART, _MARGIN = 190, 14
_HEIGHT = HEADER + _KEY_FRAMES * (_ROAD + 6) + 2 * _CHART + _MARGIN


def png(snapshots: Sequence[Snapshot]) -> bytes:
    """Return the bytes of a PNG, 960 pixels wide, with evenly spaced key frames, the first and the last among them."""
    canvas = Canvas(WIDTH, _HEIGHT)
    draw_header(canvas, snapshots[-1])
    for place, step in enumerate(np.linspace(0, len(snapshots) - 1, _KEY_FRAMES).round().astype(int)):
        _draw_key_frame(canvas, snapshots[step], HEADER + place * (_ROAD + 6))
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
    told = ", ".join(f"{_COLOUR_WORDS[goal.colour]} {goal.spelling}" for goal in SUB_GOALS)
    canvas.text(chart.x(snapshots[-1].time), chart.legend, f"bar on the axis: the option, {told}", 18, GREY, "r")


def _times(snapshots: Sequence[Snapshot]) -> list[float]:
    return [snapshot.time for snapshot in snapshots]


_COLOURS = 128
_SAMPLE_EVERY = 10  # frames; the palette is chosen from these, the last one, and the named colours
_HOLD = 2500  # ms; how long the outcome stays on before the film starts anew


def gif(snapshots: Sequence[Snapshot]) -> bytes:
    """Return the bytes of a GIF with a frame for every snapshot; all share one palette, so that nothing flickers."""
    frames = [picture(snapshot) for snapshot in snapshots]
    swatches = [np.full((8, *frames[0].shape[1:]), colour, np.uint8) for colour in NAMED_COLOURS]
    sample = np.concatenate([*frames[::_SAMPLE_EVERY], frames[-1], *swatches])
    palette = Image.fromarray(sample).quantize(_COLOURS)
    images = [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    step = round(1000 * snapshots[0].scenario.dt)
    out = BytesIO()
    durations = [step] * (len(images) - 1) + [_HOLD]
    images[0].save(out, "GIF", save_all=True, append_images=images[1:], duration=durations, loop=0)
    return out.getvalue()
