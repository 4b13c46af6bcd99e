"""An anti-aliased canvas on pygame surfaces: no display, no window, no fonts but the one that pygame brings."""

import os
from collections.abc import Sequence
from functools import cache
from typing import Literal

import numpy as np
import pygame
from numpy.typing import NDArray

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")  # before the import: pygame would print a greeting

Colour = tuple[int, int, int]
Point = tuple[float, float]

# Okabe and Ito's palette, distinguishable with every kind of colour vision, and greys
BLUE, GREEN = (0, 114, 178), (0, 158, 115)
ORANGE, VERMILLION, PURPLE = (230, 159, 0), (213, 94, 0), (150, 82, 122)
INK, GREY, PALE, PAPER, WHITE = (28, 34, 43), (107, 116, 128), (208, 213, 219), (246, 246, 243), (255, 255, 255)
NAMED_COLOURS = (BLUE, GREEN, ORANGE, VERMILLION, PURPLE, INK, GREY, PALE, PAPER, WHITE)

_OVERSAMPLING = 2


def mix(colour: Colour, other: Colour, share: float) -> Colour:
    """Return ``share`` of the first colour over the other."""
    r, g, b = (round(share * one + (1.0 - share) * two) for one, two in zip(colour, other, strict=True))
    return r, g, b


@cache
def _font(size: float) -> pygame.font.Font:
    pygame.font.init()
    return pygame.font.Font(None, round(size * _OVERSAMPLING))


def _written(words: str, size: float, colour: Colour) -> pygame.Surface:
    """Return a line of text as a picture."""
    try:
        return _font(size).render(words, True, colour)
    except pygame.error:  # somebody else in this process has called pygame.quit(), which ends every font
        _font.cache_clear()
        return _font(size).render(words, True, colour)


class Canvas:
    """A picture of ``width`` x ``height`` pixels; every coordinate is in pixels, x to the right and y downwards."""

    def __init__(self, width: int, height: int, background: Colour = PAPER) -> None:
        self.width, self.height = width, height
        self._surface = pygame.Surface((width * _OVERSAMPLING, height * _OVERSAMPLING), depth=32)
        self._surface.fill(background)

    def rect(self, x: float, y: float, width: float, height: float, colour: Colour, radius: float = 0.0) -> None:
        """Fill a rectangle with rounded corners."""
        left, top, right, bottom = (round(v * _OVERSAMPLING) for v in (x, y, x + width, y + height))
        area = pygame.Rect(left, top, max(right - left, 1), max(bottom - top, 1))
        pygame.draw.rect(self._surface, colour, area, border_radius=round(radius * _OVERSAMPLING))

    def polygon(self, points: Sequence[Point], colour: Colour) -> None:
        """Fill a polygon."""
        pygame.draw.polygon(self._surface, colour, self._scaled(points))

    def lines(self, points: Sequence[Point], colour: Colour, width: float = 1.0) -> None:
        """Draw a line through two or more points."""
        pygame.draw.lines(self._surface, colour, False, self._scaled(points), round(width * _OVERSAMPLING))

    def text(
        self, x: float, y: float, words: str, size: float, colour: Colour = INK, align: Literal["l", "c", "r"] = "l"
    ) -> float:
        """Return the width of one line of text, written with its vertical middle at ``y``."""
        image = _written(words, size, colour)
        width = image.get_width() / _OVERSAMPLING
        left = x - {"l": 0.0, "c": 0.5, "r": 1.0}[align] * width
        self._surface.blit(image, (round(left * _OVERSAMPLING), round(y * _OVERSAMPLING - image.get_height() / 2)))
        return width

    def image(self, pixels: NDArray[np.uint8], x: int, y: int) -> None:
        """Place a picture, uint8 [H, W, 3], with its top left corner at (x, y)."""
        size = (pixels.shape[1] * _OVERSAMPLING, pixels.shape[0] * _OVERSAMPLING)
        picture = pygame.surfarray.make_surface(pixels.swapaxes(0, 1))
        self._surface.blit(pygame.transform.scale(picture, size), (x * _OVERSAMPLING, y * _OVERSAMPLING))

    def pixels(self) -> NDArray[np.uint8]:
        """Return the picture, uint8 [height, width, 3]."""
        small = pygame.transform.smoothscale(self._surface, (self.width, self.height))
        return np.ascontiguousarray(pygame.surfarray.array3d(small).swapaxes(0, 1))

    @staticmethod
    def _scaled(points: Sequence[Point]) -> list[Point]:
        return [(x * _OVERSAMPLING, y * _OVERSAMPLING) for x, y in points]
