"""A tally of the episodes that are being played: what every step adds to their records."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.evaluation.episodes import EpisodeRecords, TrafficRecords
from hhrl_bench.evaluation.metrics import FloatArray
from hhrl_bench.evaluation.rollout import Stage
from hhrl_bench.tasks.seeds import UInt64Array
from hhrl_envs import Outcome
from hhrl_envs.simulation import rewards

_BY_WEIGHT = np.array([Outcome.COLLISION, Outcome.NOT_STOP, Outcome.REAR_ENDED, Outcome.TIMEOUT, Outcome.FOILED])


class Tally:
    """Sums over the steps of the running episodes of all vehicles that the agent on a stage drives."""

    def __init__(self, stage: Stage) -> None:
        vehicles = len(stage.results.outcomes)
        self._stage, self._vehicles = stage, np.arange(vehicles)
        self._task, self._option, self._action, self._unsafe = np.zeros((4, vehicles))
        self._unsmooth = np.zeros(vehicles, np.int32)
        self._severity = Severity(stage.simulator.num_rows, stage.simulator.scenario.sensor.front_range)

    def add(self, option: NDArray[np.int64], running: NDArray[np.bool_]) -> None:
        """Return nothing; add a step of these options [B slots], for the vehicles that were running before it."""
        results, simulator = self._stage.results, self._stage.simulator
        terms, selected = results.terms, np.maximum(option, 0)
        hierarchical = np.where(option >= 0, 0.0, np.nan)
        self._task += np.where(running, results.rewards, 0.0)
        self._option += np.where(running, results.reward_option[self._vehicles, selected] + hierarchical, 0.0)
        self._action += np.where(running, results.reward_action[self._vehicles, selected] + hierarchical, 0.0)
        self._unsmooth += running & (terms[:, rewards.UNSMOOTH] < 0.0)
        self._unsafe -= np.where(running, terms[:, rewards.UNSAFE_SSL] + terms[:, rewards.UNSAFE_FFV], 0.0)
        first, rows = self._stage.slots[0], slice(None, None, len(self._stage.slots))
        self._severity.add(*simulator.ahead(first), running[rows], results.outcomes[rows])

    def records(self, seeds: UInt64Array) -> EpisodeRecords:
        """Return the records of the episodes, which are over, of worlds ``seeds`` uint64 [B]."""
        simulator = self._stage.simulator
        outcomes = self._stage.results.outcomes.reshape(len(seeds), -1)
        first = slice(None, None, outcomes.shape[1])
        common: dict[str, Any] = {
            "seed": seeds.copy(),
            "outcome": _worst(outcomes),
            "steps": simulator.steps.astype(np.int32),
            "return_task": self._task[first],
            "return_option": self._option[first],
            "return_action": self._action[first],
            "unsmooth": self._unsmooth[first],
            "unsafe": self._unsafe[first],
            **self._severity.found(),
        }
        if not simulator.scenario.learned_fronts:
            return EpisodeRecords(**common)
        return TrafficRecords(**common, feasible=simulator.feasible, outcomes=simulator.agent_outcomes)


def _worst(outcomes: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return the outcome that counts for vehicles with these, int8 [N], [N, slots]: SUCCESS if all have succeeded."""
    found = (outcomes[:, None, :] == _BY_WEIGHT[:, None]).any(axis=2)
    worst = np.where(found.any(axis=1), _BY_WEIGHT[found.argmax(axis=1)], Outcome.SUCCESS)
    return worst.astype(np.int8)


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
        """Return the fields of ``EpisodeRecords``, float64 [B] each; NaN: there was none."""
        numbers = {"impact_speed": self._impact_speed, "smallest_gap": self._gap, "smallest_ttc": self._ttc}
        return {name: np.where(np.isfinite(values), values, np.nan) for name, values in numbers.items()}
