"""Ways to drive that the tests share."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hhrl_envs import Simulator, observation


def random_actions(seed: int, steps: int, rows: int, levels: int) -> NDArray[np.int64]:
    """Actions [steps, rows] that are held for a while, so that vehicles get somewhere."""
    rng = np.random.default_rng(seed)
    fresh = rng.integers(0, levels, (steps, rows))
    keep = rng.random((steps, rows)) < 0.9
    for t in range(1, steps):
        fresh[t] = np.where(keep[t], fresh[t - 1], fresh[t])
    return fresh


def careful_actions(simulator: Simulator, agent: int = 0) -> NDArray[np.int64]:
    """A driver who mostly reaches the line: brakes for whatever is nearest, else rolls on at walking pace or faster."""
    si = observation.to_si(simulator.of_agent(agent).observations)
    room = np.minimum(si[:, observation.D_D] - 1.0, si[:, observation.D_F] - 6.0)
    wanted = np.sqrt(np.maximum(2.0 * 1.5 * room, 0.0))
    target = np.clip((wanted - si[:, observation.V_E]) / 0.5, -6.0, 2.0)
    levels = np.array(simulator.scenario.vehicle.levels)
    nearest: NDArray[np.int64] = np.abs(levels[None, :] - target[:, None]).argmin(axis=1)
    return nearest


def traffic_actions(simulator: Simulator, seed: int, steps: int) -> Iterator[NDArray[np.int64]]:
    """Actions [rows, agents] of all agents: in every fourth row an agent does this and that, else it is careful."""
    rows, agents, levels = simulator.num_rows, simulator.num_agents, simulator.scenario.num_actions
    wild = [random_actions(seed + agent, steps, rows, levels) for agent in range(agents)]
    turn = (np.arange(rows)[:, None] + np.arange(agents)) % 4 == 0
    for step in range(steps):
        careful = np.stack([careful_actions(simulator, agent) for agent in range(agents)], axis=1)
        yield np.where(turn, np.stack([one[step] for one in wild], axis=1), careful)


def states(simulator: Simulator) -> NDArray[np.float64]:
    """Position, speed and acceleration of all vehicles of all rows, [rows, vehicles, 3], NaN where there is none."""
    return np.stack([simulator.vehicles(row) for row in range(simulator.num_rows)])
