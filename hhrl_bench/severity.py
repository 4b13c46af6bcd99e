"""How severe an episode got: impact speed, smallest gap and smallest time to collision, of the true motion."""

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.metrics import FloatArray
from hhrl_envs import Outcome

LONGEST_TTC = 10.0
"""Seconds; a longer time to collision counts as that: how much longer says nothing about danger."""


class Severity:
    """The worst so far of B episodes, in which a front vehicle is seen up to ``front_range`` metres away."""

    def __init__(self, rows: int, front_range: float) -> None:
        self._front_range = front_range
        self._impact_speed = np.full(rows, np.nan)
        self._gap, self._ttc = np.full((2, rows), np.inf)

    def add(
        self, road: FloatArray, closing: FloatArray, running: NDArray[np.bool_], outcomes: NDArray[np.int8]
    ) -> None:
        """Return nothing; add a step of the episodes that were ``running`` [B] before; outcomes [B] are those after it.

        road, closing: true free road to the front vehicle, and how fast it closes, [B] each.
        """
        gap = np.maximum(road, 0.0)
        seen = running & (gap < self._front_range)
        self._gap = np.where(seen, np.minimum(self._gap, gap), self._gap)
        nearing = seen & (closing > 0.0)
        ttc = np.divide(gap, closing, out=np.full_like(gap, np.inf), where=nearing)
        self._ttc = np.minimum(self._ttc, np.where(nearing, np.minimum(ttc, LONGEST_TTC), np.inf))
        hit = running & (outcomes == Outcome.COLLISION)
        self._impact_speed[hit] = closing[hit]

    def found(self) -> dict[str, FloatArray]:
        """Return the fields of :class:`hhrl_bench.episodes.EpisodeRecords`, float64 [B] each; NaN: there was none."""
        numbers = {"impact_speed": self._impact_speed, "smallest_gap": self._gap, "smallest_ttc": self._ttc}
        return {name: np.where(np.isfinite(values), values, np.nan) for name, values in numbers.items()}
