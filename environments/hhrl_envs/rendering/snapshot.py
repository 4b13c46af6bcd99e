"""One snapshot of one row: what a picture shows, copied out of the simulator."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.simulation.engine.layout import FAR
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.sub_goals import Option, Outcome, SubGoal


@dataclass(frozen=True)
class Snapshot:
    """What one picture shows; ``vehicles``, float64 [V, 3], is as ``Simulator.vehicles`` returns it.

    ``line`` is the position of the active stop-line in metres, None where there is none; the first ``agents`` of the
    vehicles are driven by agents.
    """

    scenario: Scenario
    vehicles: NDArray[np.float64]
    line: float | None
    time: float
    outcome: Outcome
    option: Option | None
    agents: int = 1

    def distance(self, goal: SubGoal) -> float | None:
        """Return the distance from the ego to what a sub-goal's target is on the road; None where there is none."""
        return {"stop-line": self.d_d, "front vehicle": self.d_f, None: None}[goal.target]

    @property
    def d_d(self) -> float | None:
        """The distance from the ego to the active stop-line in metres, negative past it, None where there is none."""
        return None if self.line is None else self.line - float(self.vehicles[0, 0])

    @property
    def d_f(self) -> float | None:
        """The free road to the front vehicle in metres, None where none is in sensor range."""
        if len(self.vehicles) < 2:
            return None
        gap = float(self.vehicles[1, 0] - self.vehicles[0, 0]) - self.scenario.vehicle.length
        return max(gap, 0.0) if gap <= self.scenario.sensor.front_range else None


def snapshot_of(simulator: Simulator, row: int = 0, option: int | None = None) -> Snapshot:
    """Return the present state of one row; ``option`` is the selected sub-goal, None or -1 for a flat agent."""
    scenario, line = simulator.scenario, float(simulator.lines[row])
    return Snapshot(
        scenario=scenario,
        vehicles=simulator.vehicles(row),
        line=line if line < FAR else None,
        time=float(simulator.steps[row]) * scenario.dt,
        outcome=Outcome(int(simulator.outcomes[row])),
        option=None if option is None or option < 0 else Option(option),
        agents=simulator.num_agents,
    )
