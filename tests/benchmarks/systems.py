"""What the benchmarks measure: this package's views, and the native vector environment that they are held against.

A round of a system starts from the same seed and takes the same actions every time, so that all rounds are the same
work and the quickest is the one that the machine disturbed least.
"""

from collections.abc import Callable
from dataclasses import dataclass

import gymnasium
import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

from hhrl_envs import Simulator, get_scenario
from hhrl_envs.worlds import stop_line_v0

Compare = Callable[..., None]
Report = Callable[..., None]
SCENARIO = get_scenario("stop-line-v0")
TWO_EPISODES = 2 * (SCENARIO.horizon + 1)  # both to the time limit, each with the reset that follows
STRONG_BRAKES = 2
ACTIONS = {0: "", STRONG_BRAKES: " without strong brakes"}


@dataclass(frozen=True)
class System:
    """``run`` takes ``steps`` environment steps from where ``prepare``, which is not timed, leaves off."""

    name: str
    steps: int
    prepare: Callable[[], object]
    run: Callable[[], None]


def random_actions(count: int, *shape: int, lowest: int = 0) -> NDArray[np.int64]:
    actions: NDArray[np.int64] = np.random.default_rng(0).integers(lowest, count, shape)
    return actions


def parallel_env(lowest: int = 0, steps: int = 10_000) -> System:
    env = stop_line_v0.parallel_env()
    actions = random_actions(SCENARIO.num_actions, steps, lowest=lowest).tolist()

    def run() -> None:
        for action in actions:
            env.step(dict.fromkeys(env.agents, action))
            if not env.agents:
                env.reset()

    return System(f"PettingZoo env{ACTIONS[lowest]}", steps, lambda: env.reset(seed=0), run)


def vector_env(lowest: int = 0) -> System:
    return _vector_env("hhrl_envs/StopLine-v0", f"vector env, 1,024 rows{ACTIONS[lowest]}", lowest)


def cartpole() -> System:
    return _vector_env("CartPole-v1", "CartPole-v1, 1,024 rows", lowest=0)


def _vector_env(env_id: str, name: str, lowest: int, rows: int = 1024, steps: int = TWO_EPISODES) -> System:
    envs: VectorEnv[object, object, object] = gymnasium.make_vec(
        env_id, num_envs=rows, vectorization_mode="vector_entry_point"
    )
    assert isinstance(envs.single_action_space, gymnasium.spaces.Discrete)
    actions = random_actions(int(envs.single_action_space.n), steps, rows, lowest=lowest)

    def run() -> None:
        for action in actions:
            envs.step(action)

    return System(name, rows * steps, lambda: envs.reset(seed=0), run)


def simulator(threads: int, rows: int = 16_384, steps: int = 200) -> System:
    core = Simulator(SCENARIO, rows, threads=threads)
    actions = random_actions(SCENARIO.num_actions, steps, rows, lowest=STRONG_BRAKES)

    def run() -> None:
        for action in actions:
            core.step(action, autoreset=True)

    return System(
        f"simulator, {rows:,} rows, threads: {threads}", rows * steps, lambda: core.reset(np.arange(rows)), run
    )
