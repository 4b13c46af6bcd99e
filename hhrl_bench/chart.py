"""A line chart over time on a canvas. Needs the ``render`` extra."""

from collections.abc import Sequence
from math import ceil

from hhrl_envs.rendering.canvas import GREY, INK, PALE, Canvas, Colour, Point

_LEFT, _RIGHT, _TOP, _BOTTOM = 62, 24, 32, 26  # pixels kept free around the plotted area
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
