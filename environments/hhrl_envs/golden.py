"""Golden digests: a fingerprint of a scenario's full trajectories, to the last bit."""

import hashlib

import numpy as np

from hhrl_envs.compiled import Ints
from hhrl_envs.scenario import Scenario
from hhrl_envs.simulator import Simulator
from hhrl_envs.streams import stream, unit

ROWS, STEPS, HELD = 32, 400, 8


def trajectory_digest(scenario: Scenario) -> str:
    """Return the SHA-256 of all observations, reward terms, rewards and outcomes of fixed rows under fixed actions.

    32 rows (seeds 1000 to 1031) run for 400 steps with auto-reset; every row holds a random level for 8 steps. One bit
    of physics, reward or observation that differs gives another digest.
    """
    simulator = Simulator(scenario, ROWS)
    simulator.reset(np.arange(ROWS) + 1000)
    digest = hashlib.sha256()
    for step in range(STEPS):
        if step % HELD == 0:
            actions = _actions(step, scenario.num_actions)
        simulator.step(actions)
        for part in (simulator.observations, simulator.terms, simulator.rewards, simulator.reward_option):
            digest.update(np.ascontiguousarray(part).tobytes())
        digest.update(np.ascontiguousarray(simulator.reward_action).tobytes() + simulator.outcomes.tobytes())
        simulator.reset_done()
    return digest.hexdigest()


def _actions(step: int, levels: int) -> Ints:
    keys = (np.uint64(stream(np.uint64(row), step, 0, 0)) for row in range(ROWS))
    return np.array([int(unit(key, 0) * levels) for key in keys])
