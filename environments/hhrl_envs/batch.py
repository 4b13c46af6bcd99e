"""The arrays of a batch of rows, bundled for the compiled kernels."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hhrl_envs import layout, observation
from hhrl_envs.compiled import Codes, Floats, Floats32, Ints, Keys
from hhrl_envs.scenario import Scenario

SEED, EPISODE = range(2)
TARGET, LIVE = range(2)


class Batch(NamedTuple):
    """What a batch remembers from step to step, and the scenario's numbers.

    Attributes:
        state: float64 [STATE_SIZE, slot, row]; profile: float64 [PROFILE_SIZE, slot, row]; rows: float64 [ROW_SIZE,
        row]. keys: uint64 [2, row], seed and episode; steps: int64 [row]; feasible: bool [row].
        measured: float64 [MEASURED_SIZE, agent, row]; history: float64 [delay + 1, BASE_SIZE, agent, row], empty if
        sensors are perfect. scratch: float64 [2, row], fresh: int8 [agent, row]: work space of a step.
        levels: float64 [action]; c: the scenario's constants; counts, families: its tables for drawing worlds.
    """

    state: Floats
    profile: Floats
    rows: Floats
    keys: Keys
    steps: Ints
    feasible: NDArray[np.bool_]
    measured: Floats
    history: Floats
    scratch: Floats
    fresh: Codes
    levels: Floats
    c: Floats
    counts: Floats
    families: Floats


class Results(NamedTuple):
    """What a step hands out.

    Attributes:
        ended: int8 [agent, row], outcomes; rewards: float64 [RESULTS_SIZE, agent, row]; observations: float32 [11,
        agent, row].
    """

    ended: Codes
    rewards: Floats
    observations: Floats32

    def copied(self) -> "Results":
        """Return a copy, so that what was handed out never changes."""
        return Results(self.ended.copy(), self.rewards.copy(), self.observations.copy())


def new_batch(scenario: Scenario, agents: int, rows: int) -> Batch:
    """Return the arrays of a batch whose rows have no episode yet."""
    slots = scenario.num_vehicles + 1
    delay = 0 if scenario.sensor.perfect else scenario.sensor.delay + 1
    return Batch(
        state=np.zeros((layout.STATE_SIZE, slots, rows)),
        profile=np.ones((layout.PROFILE_SIZE, slots, rows)),
        rows=np.zeros((layout.ROW_SIZE, rows)),
        keys=np.zeros((2, rows), np.uint64),
        steps=np.zeros(rows, np.int64),
        feasible=np.zeros(rows, np.bool_),
        measured=np.zeros((layout.MEASURED_SIZE, agents, rows)),
        history=np.zeros((delay, layout.BASE_SIZE, agents, rows)),
        scratch=np.zeros((2, rows)),
        fresh=np.zeros((agents, rows), np.int8),
        levels=np.array(scenario.vehicle.levels),
        c=scenario.constants(),
        counts=scenario.cumulative_counts(),
        families=scenario.family_table(),
    )


def new_results(agents: int, rows: int) -> Results:
    """Return empty arrays for what a step hands out."""
    return Results(
        np.empty((agents, rows), np.int8),
        np.empty((layout.RESULTS_SIZE, agents, rows)),
        np.empty((observation.SIZE, agents, rows), np.float32),
    )
