"""A tally of the episodes that are being played: what every step adds to their records."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.episodes import EpisodeRecords, TrafficRecords
from hhrl_bench.seeds import UInt64Array
from hhrl_bench.severity import Severity
from hhrl_bench.stage import Stage
from hhrl_envs import Outcome, rewards

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
