"""An episode as one PNG: key frames, then speed and distance over time. Needs the ``render`` extra."""

from collections.abc import Sequence
from io import BytesIO
from itertools import pairwise
from math import nan

import numpy as np
from PIL import Image

from hhrl_bench.chart import Chart
from hhrl_envs.rendering.canvas import BLUE, GREEN, GREY, NAMED_COLOURS, ORANGE, PALE, PAPER, Canvas
from hhrl_envs.rendering.moment import Moment
from hhrl_envs.rendering.picture import HEADER, OPTION_COLOURS, ROAD_ROWS, WIDTH, draw_header, picture

_KEY_FRAMES = 6
_ROAD = ROAD_ROWS.stop - ROAD_ROWS.start
_CHART, _MARGIN = 190, 14
_HEIGHT = HEADER + _KEY_FRAMES * (_ROAD + 6) + 2 * _CHART + _MARGIN


def png(moments: Sequence[Moment]) -> bytes:
    """Return the bytes of a PNG, 960 pixels wide, with evenly spaced key frames, the first and the last among them."""
    canvas = Canvas(WIDTH, _HEIGHT)
    draw_header(canvas, moments[-1])
    for place, step in enumerate(np.linspace(0, len(moments) - 1, _KEY_FRAMES).round().astype(int)):
        _draw_key_frame(canvas, moments[step], HEADER + place * (_ROAD + 6))
    _draw_speeds(canvas, moments, _HEIGHT - 2 * _CHART - _MARGIN)
    _draw_distances(canvas, moments, _HEIGHT - _CHART - _MARGIN)
    out = BytesIO()
    Image.fromarray(canvas.pixels()).save(out, "PNG", optimize=True)
    return out.getvalue()


def _draw_key_frame(canvas: Canvas, moment: Moment, top: int) -> None:
    canvas.image(picture(moment)[ROAD_ROWS], 0, top)
    canvas.rect(_MARGIN, top + 4, 72, 22, PAPER)
    canvas.text(_MARGIN, top + 15, f"{moment.time:.1f} s", 22)
    canvas.rect(0, top + _ROAD + 2, WIDTH, 1, PALE)


def _draw_speeds(canvas: Canvas, moments: Sequence[Moment], top: int) -> None:
    times, speeds = _times(moments), np.array([moment.vehicles[:, 1] for moment in moments])
    chart = Chart(canvas, top, _CHART, times[-1], float(np.nanmax(speeds)))
    chart.frame("m/s", (("ego", BLUE), ("front vehicles", GREY)))
    for fronts in speeds[:, :0:-1].T:
        chart.line(list(zip(times, fronts, strict=True)), GREY, 1)
    chart.line(list(zip(times, speeds[:, 0], strict=True)), BLUE, 2.5)


def _draw_distances(canvas: Canvas, moments: Sequence[Moment], top: int) -> None:
    times = _times(moments)
    gaps = [nan if moment.d_f is None else moment.d_f for moment in moments]
    to_line = [nan if moment.d_d is None else max(moment.d_d, 0.0) for moment in moments]
    chart = Chart(canvas, top, _CHART, times[-1], float(np.nanmax([*to_line, *gaps, 0.0])))
    chart.frame("m", (("d_d, to the stop-line", ORANGE), ("d_f, to the front vehicle", GREEN)))
    chart.line(list(zip(times, gaps, strict=True)), GREEN)
    chart.line(list(zip(times, to_line, strict=True)), ORANGE)
    if moments[0].option is not None:
        _draw_options(canvas, chart, moments)


def _draw_options(canvas: Canvas, chart: Chart, moments: Sequence[Moment]) -> None:
    """Draw a bar in the colour of the selected option along the time axis."""
    for now, after in pairwise(moments):
        if now.option is not None:
            left, right = chart.x(now.time), chart.x(after.time)
            canvas.rect(left, chart.bottom - 3, right - left, 6, OPTION_COLOURS[now.option])
    canvas.text(
        chart.x(moments[-1].time), chart.legend, "bar on the axis: the option, orange SSL, green FFV", 18, GREY, "r"
    )


def _times(moments: Sequence[Moment]) -> list[float]:
    return [moment.time for moment in moments]


_COLOURS = 128
_SAMPLE_EVERY = 10  # frames; the palette is chosen from these, the last one, and the named colours
_HOLD = 2500  # ms; how long the outcome stays on before the film starts anew


def gif(moments: Sequence[Moment]) -> bytes:
    """Return the bytes of a GIF with a frame for every moment; all share one palette, so that nothing flickers."""
    frames = [picture(moment) for moment in moments]
    swatches = [np.full((8, *frames[0].shape[1:]), colour, np.uint8) for colour in NAMED_COLOURS]
    sample = np.concatenate([*frames[::_SAMPLE_EVERY], frames[-1], *swatches])
    palette = Image.fromarray(sample).quantize(_COLOURS)
    images = [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    step = round(1000 * moments[0].scenario.dt)
    out = BytesIO()
    durations = [step] * (len(images) - 1) + [_HOLD]
    images[0].save(out, "GIF", save_all=True, append_images=images[1:], duration=durations, loop=0)
    return out.getvalue()
