"""Steps a second of the simulator and its views, next to Gymnasium's native vectorised CartPole in the same run.

Absolute figures drift with the machine; the ratio is what to quote. Actions are random, but without the two strongest
brakes, which would keep the ego from ever reaching anything: episodes end, and beginning the next ones is in the price.
"""

from collections.abc import Callable
from time import perf_counter

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray
from pytest_benchmark.fixture import BenchmarkFixture

from hhrl_envs import Simulator, get_scenario, stop_line_v0

ROWS, STEPS = 1024, 200
SCENARIO = get_scenario("stop-line-v0")
OURS, CARTPOLE = "hhrl_envs/StopLine-v0", "CartPole-v1"
LOWEST = {OURS: 2, CARTPOLE: 0}
COUNTS = {OURS: SCENARIO.num_actions, CARTPOLE: 2}
Run = Callable[[], None]


def random_actions(env_id: str, count: int, *rows: int) -> NDArray[np.int64]:
    actions: NDArray[np.int64] = np.random.default_rng(0).integers(LOWEST[env_id], COUNTS[env_id], (count, *rows))
    return actions


def simulator() -> Run:
    core = Simulator(SCENARIO, ROWS)
    core.reset(np.arange(ROWS, dtype=np.uint64))
    actions = random_actions(OURS, STEPS, ROWS)

    def run() -> None:
        for step in range(STEPS):
            core.step(actions[step])
            core.reset_done()

    return run


def vector_env(env_id: str) -> Run:
    envs: VectorEnv[object, object, object] = gymnasium.make_vec(
        env_id, num_envs=ROWS, vectorization_mode="vector_entry_point"
    )
    envs.reset(seed=0)
    actions = random_actions(env_id, STEPS, ROWS)

    def run() -> None:
        for action in actions:
            envs.step(action)

    return run


def parallel_env() -> Run:
    env = stop_line_v0.parallel_env()
    env.reset(seed=0)
    actions = random_actions(OURS, STEPS * 10).tolist()

    def run() -> None:
        for action in actions:
            env.step(dict.fromkeys(env.agents, action))
            if not env.agents:
                env.reset()

    return run


SYSTEMS: dict[str, tuple[Callable[[], Run], int]] = {
    "simulator, 1024 rows": (simulator, ROWS * STEPS),
    "vector env, 1024 rows": (lambda: vector_env(OURS), ROWS * STEPS),
    "CartPole-v1 vector env, 1024 rows": (lambda: vector_env(CARTPOLE), ROWS * STEPS),
    "PettingZoo parallel env, 1 row": (parallel_env, STEPS * 10),
}


@pytest.mark.parametrize("system", SYSTEMS)
def test_environment_steps_a_second(benchmark: BenchmarkFixture, system: str) -> None:
    make, env_steps = SYSTEMS[system]
    run = make()
    benchmark.extra_info["env_steps"] = env_steps
    benchmark(run)


def test_ratio_to_native_cartpole(capsys: pytest.CaptureFixture[str]) -> None:
    ours, theirs = vector_env(OURS), vector_env(CARTPOLE)
    seconds = np.array([[_seconds(run) for run in (ours, theirs)] for _ in range(30)]).min(axis=0)
    ratio = seconds[1] / seconds[0]
    with capsys.disabled():
        rates = ROWS * STEPS / seconds / 1e6
        print(f"\nvector env {rates[0]:.1f}, CartPole-v1 {rates[1]:.1f} million env-steps/s: ratio {ratio:.2f}")


def _seconds(run: Run) -> float:
    started = perf_counter()
    run()
    return perf_counter() - started
