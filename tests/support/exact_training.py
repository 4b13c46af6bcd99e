"""Short trainings told by the digests of what they learn. As a script it writes them, and its processor, as JSON."""

import hashlib
import json
from typing import Any

import numpy as np
from numba.core.registry import cpu_target

from hhrl_agents import METHODS
from hhrl_agents.training.learner import make_learner
from hhrl_envs import get_scenario
from support.configs import with_values

NAMES = ("ddqn", "hybrid-hrl", "hybrid-hrl-plus", "pqn")
STEPS = 3_000
CONFIG: dict[str, Any] = {
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


def digest(name: str, seed: int = 3) -> str:
    """Return the SHA-256 of the parameters that a short training of this method ends with."""
    method = with_values(METHODS[name], CONFIG)
    learner = make_learner(method, get_scenario("stop-line-v0"), seed, np.arange(8, dtype=np.uint64))
    list(learner.train(STEPS))
    parameters = learner.policy().parameters
    return hashlib.sha256(b"".join(parameters[key].tobytes() for key in sorted(parameters))).hexdigest()


def processor() -> list[str]:
    """Return the name and the features of the processor that kernels are compiled for."""
    _, name, features = cpu_target.target_context.codegen().magic_tuple()
    return [name, features]


if __name__ == "__main__":
    print(json.dumps({"processor": processor(), "digests": {name: digest(name) for name in NAMES}}))
