"""Recordings of episodes with learned front vehicles, for tests that look at whole trajectories."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hhrl_envs import Outcome, Scenario, Simulator, get_scenario
from support.driving import states, traffic_actions

LEARNED = (
    ("stop-line-v0", 2), ("stop-line-dense-v0", 4), ("stop-line-erratic-v0", 3), ("stop-line-wet-v0", 2),
    ("stop-line-noisy-v0", 2), ("stop-and-go-v0", 1), ("two-stops-v0", 2), ("red-light-v0", 3), ("platoon-v0", 3),
    ("adversary-v0", 1), ("adversary-v0", 3),
)  # fmt: skip
"""Scenarios and their numbers of learned front vehicles."""


@dataclass(frozen=True)
class Recording:
    """One episode in each of R rows, T steps long, with frame 0 at its beginning.

    ``vehicles`` are [T + 1, R, vehicle, (position, speed, acceleration)], the results of the A agents are
    [T + 1, A, R, ...] and ``feasible`` and ``steps`` are [T + 1, R].
    """

    scenario: Scenario
    profiles: list[list[dict[str, float | str]]]
    vehicles: NDArray[np.float64]
    observations: NDArray[np.float32]
    rewards: NDArray[np.float64]
    reward_option: NDArray[np.float64]
    reward_action: NDArray[np.float64]
    outcomes: NDArray[np.int8]
    terms: NDArray[np.float64]
    feasible: NDArray[np.bool_]
    steps: NDArray[np.int64]

    @property
    def agents(self) -> int:
        return int(self.outcomes.shape[1])

    @property
    def frames(self) -> int:
        return len(self.outcomes)

    def ends(self) -> NDArray[np.int64]:
        """The frame in which each agent's episode ended, [A, R]; every one has."""
        frames: NDArray[np.int64] = (self.outcomes != Outcome.RUNNING).argmax(axis=0)
        return frames

    def gaps(self) -> NDArray[np.float64]:
        """Free road from each vehicle to the next, [T + 1, R, vehicle - 1], NaN where there is none."""
        x = self.vehicles[:, :, :, 0]
        gaps: NDArray[np.float64] = x[:, :, 1:] - self.scenario.vehicle.length - x[:, :, :-1]
        return gaps


def frame_of(simulator: Simulator) -> tuple[NDArray[Any], ...]:
    results = [simulator.of_agent(agent) for agent in range(simulator.num_agents)]
    own = [np.stack([result[part] for result in results]) for part in range(len(results[0]))]
    return (states(simulator), *own, simulator.feasible, simulator.steps)


@cache
def recorded(scenario_id: str, fronts: int, rows: int = 24) -> Recording:
    """Drive the rows until every agent's episode has ended, and a second longer."""
    scenario = get_scenario(scenario_id)
    simulator = Simulator(scenario, rows, learned_fronts=fronts)
    simulator.reset(np.arange(rows) + 31)
    profiles = [simulator.profiles(row) for row in range(rows)]
    frames = [frame_of(simulator)]
    after = 10
    for actions in traffic_actions(simulator, 5, scenario.horizon + after):
        simulator.step(actions)
        frames.append(frame_of(simulator))
        after -= bool((frames[-1][5] != Outcome.RUNNING).all())
        if after == 0:
            break
    parts: list[Any] = [np.stack(part) for part in zip(*frames, strict=True)]
    return Recording(scenario, profiles, *parts)
