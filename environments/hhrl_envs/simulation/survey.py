"""What holds for a scenario as a whole: its share of feasible worlds, and a digest of its trajectories."""

import hashlib
from dataclasses import replace

import numpy as np

from hhrl_envs.arrays import Ints
from hhrl_envs.scenario.registry import as_count, as_scenario
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.simulation.engine.compilation import kernel, unsigned
from hhrl_envs.simulation.engine.random_streams import stream, unit
from hhrl_envs.simulation.simulator import Simulator

ROWS, STEPS, HELD = 32, 400, 8


def feasible_share(scenario: Scenario | str, worlds: int = 10_000) -> float:
    """Return the share of drawn worlds in which some ego can succeed, of seeds 0, 1, 2, ...

    Scenarios with ``feasible_only`` reject the others at reset; here they count. Front vehicles are scripted.
    """
    simulator = Simulator(replace(as_scenario(scenario), feasible_only=False), as_count(worlds, "worlds"))
    simulator.reset(np.arange(worlds))
    return float(simulator.feasible.mean())


def trajectory_digest(scenario: Scenario) -> str:
    """Return the SHA-256 of all observations, reward terms, rewards and outcomes of fixed rows under fixed actions.

    32 rows (seeds 1000 to 1031) run for 400 steps with auto-reset; every agent holds a random level for 8 steps. The
    scenario's own number of front vehicles are agents too. One bit of what is handed out that differs gives another
    digest; observations are float32, so a smaller change of the physics may take longer to show.
    """
    simulator = Simulator(scenario, ROWS, learned_fronts=scenario.learned_fronts or 0)
    simulator.reset(np.arange(ROWS) + 1000)
    digest = hashlib.sha256()
    for step in range(STEPS):
        if step % HELD == 0:
            actions = _actions(step, scenario.num_actions, simulator.num_agents)
        simulator.step(actions)
        for agent in range(simulator.num_agents):
            results = simulator.of_agent(agent)
            parts = (results.observations, simulator.terms, results.rewards, results.reward_option)
            for part in (*parts, results.reward_action, results.outcomes):
                digest.update(np.ascontiguousarray(part).tobytes())
        simulator.reset_done()
    return digest.hexdigest()


def _actions(step: int, levels: int, agents: int) -> Ints:
    """Return levels, int64 [ROWS], or [ROWS, agents] for several agents."""
    drawn = _draw(step, levels, agents)
    return drawn[:, 0] if agents == 1 else drawn


@kernel
def _draw(step: int, levels: int, agents: int) -> Ints:
    drawn = np.empty((ROWS, agents), np.int64)
    for row in range(ROWS):
        for agent in range(agents):
            key = stream(unsigned(row), unsigned(step), unsigned(agent), unsigned(0))
            drawn[row, agent] = int(unit(key, unsigned(0)) * levels)
    return drawn
