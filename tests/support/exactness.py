"""What must not depend on the processor, told by digests. As a script it prints them as JSON, a line each.

python -m support.exactness [--steps 20000] [--episodes 1000]    # `make exact` and `make exact-arm64` compare them
"""

import argparse
import hashlib
import json
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from numba.core.registry import cpu_target
from numpy.typing import NDArray

from hhrl_agents import METHODS
from hhrl_agents.training.learner import make_learner
from hhrl_bench.evaluation.loading import load_agents
from hhrl_bench.evaluation.paired_evaluation import play_task
from hhrl_bench.evaluation.sources import shipped_methods
from hhrl_bench.tasks.tasks import get_task
from hhrl_envs import SCENARIOS, get_scenario
from hhrl_envs.simulation.survey import trajectory_digest
from support.configs import with_values
from support.hidden import HIDDEN

SHORT = ("ddqn", "hybrid-hrl", "hybrid-hrl-plus", "pqn")
TRAINED = ("ddqn", "ddqn-per", "hrl-0", "hybrid-hrl", "hybrid-hrl-plus", "option-only", "rule-option", "pqn")
SHORT_STEPS = 3_000
SHORT_CONFIG: dict[str, Any] = {
    "hidden": (24, 17),  # neither fills whole vectors
    "n_envs": 8,
    "batch_size": 16,
    "replay_capacity": 2_000,
    "warmup": 200,
    "target_interval": 50,
    "rollout_steps": 10,
    "epochs": 2,
    "minibatches": 4,
}


def short_training(name: str, seed: int = 3) -> str:
    """Return the digest of the parameters that a short training of a small network of this method ends with."""
    return training(name, SHORT_STEPS, seed, SHORT_CONFIG)


def training(name: str, steps: int, seed: int = 0, values: dict[str, Any] | None = None) -> str:
    """Return the digest of the parameters that a training of this method ends with."""
    method = with_values(METHODS[name], values or {})
    worlds = np.arange(method.config.n_envs, dtype=np.uint64)
    learner = make_learner(method, get_scenario("stop-line-v0"), seed, worlds)
    list(learner.train(steps))
    parameters = learner.policy().parameters
    return _digest(parameters[key] for key in sorted(parameters))


def decisions(name: str, episodes: int) -> Iterator[tuple[str, str]]:
    """Yield the digest of what every shipped seed of a method decides in the first test episodes, with its name."""
    task = get_task("stop-line-v0")
    for loaded in load_agents(name, get_scenario(task.scenario)):
        played = play_task(loaded.agent, task, task.test.take(episodes))
        seed = loaded.training.seed if loaded.training else 0
        yield f"decisions of {name}, seed {seed}", _digest(played.trace)


def processor() -> list[str]:
    """Return the name and the features of the processor that kernels are compiled for."""
    _, name, features = cpu_target.target_context.codegen().magic_tuple()
    return [name, features]


def digests(steps: int, episodes: int) -> Iterator[tuple[str, str]]:
    """Yield the digests of all scenarios' trajectories, of what shipped policies decide, and of trainings."""
    for scenario in (*SCENARIOS.values(), *HIDDEN.values()):
        yield f"trajectories of {scenario.id}", trajectory_digest(scenario)
    for method in shipped_methods():
        yield from decisions(method, episodes)
    for method in TRAINED:
        yield f"{steps} steps of {method}", training(method, steps)


def _digest(arrays: Any) -> str:
    sha = hashlib.sha256()
    for array in arrays:
        whole: NDArray[Any] = np.ascontiguousarray(array)
        sha.update(whole.tobytes())
    return sha.hexdigest()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--episodes", type=int, default=1_000)
    asked = parser.parse_args()
    print(f"kernels for {processor()[0]}", file=sys.stderr)
    for told in digests(asked.steps, asked.episodes):
        print(json.dumps(told), flush=True)
