"""HighwayEnv made as alike as its settings allow: one lane, six vehicles, one tick of 0.1 s a step."""

import gymnasium
import pytest

from benchmarks.systems import System, random_actions

CONFIG = {"lanes_count": 1, "vehicles_count": 5, "simulation_frequency": 10, "policy_frequency": 10}


def highway_env(steps: int = 200) -> System:
    pytest.importorskip("highway_env", reason="HighwayEnv is not installed; install the extra [peers]")
    env: gymnasium.Env[object, int] = gymnasium.make("highway-fast-v0", config=CONFIG, disable_env_checker=True)
    assert isinstance(env.action_space, gymnasium.spaces.Discrete)
    actions = random_actions(int(env.action_space.n), steps).tolist()

    def run() -> None:
        for action in actions:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()

    return System("HighwayEnv, 6 vehicles", steps, lambda: env.reset(seed=0), run)
