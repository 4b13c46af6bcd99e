"""Checkpoints: save a learned agent to one file, and load it again; see `hhrl_agents.policies.checkpoint_file`."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from safetensors import SafetensorError
from safetensors.numpy import load_file
from safetensors.numpy import save as to_bytes

from hhrl_agents.atomic_files import write_atomically
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import FROZEN, Parameters, frozen_shapes, method_shapes
from hhrl_agents.policies import checkpoint_file
from hhrl_agents.policies.checkpoint_file import METADATA_KEY, CheckpointError, read_metadata
from hhrl_agents.policies.learned_agent import LearnedAgent, make_agent
from hhrl_envs import SCENARIOS, Scenario, get_scenario
from hhrl_envs.errors import InputError

_VERSION = 1
_REQUIRED = (
    "method",
    "config",
    "config_hash",
    "scenario",
    "spec_hash",
    "interface_hash",
    "seed",
    "env_steps",
    "exact",
)
"""Metadata without which no checkpoint is accepted; see `hhrl_agents.policies.learned_agent.agent_metadata`."""


def save(path: Path, agent: LearnedAgent, metadata: Mapping[str, Any] | None = None) -> None:
    """Write the agent to `path`, whole or not at all.

    metadata: JSON data to keep beside the agent's own, which it may not replace.

    Raises:
        OutputError: if it cannot be written; what stood at `path` is then still there.
    """
    entries = {**(metadata or {}), **agent.metadata, "format_version": _VERSION}
    header = {METADATA_KEY: json.dumps(entries, sort_keys=True, allow_nan=False)}
    write_atomically(path, to_bytes(agent.parameters, header))


def load(path: Path) -> LearnedAgent:
    """Return the agent stored at `path`, with its metadata.

    Raises:
        CheckpointError: if there is none, or anything about it is not as `save` writes it.
    """
    path = Path(path)
    if not path.is_file():
        raise CheckpointError(f"cannot load checkpoint {path}: there is no such file")
    try:
        metadata = read_metadata(path)
        parameters = load_file(path)
        _require_known(metadata)
        method, scenario = _method(metadata), _scenario(metadata["scenario"])
        _require_interface(metadata, scenario)
        _require_parameters(parameters, method, scenario)
    except (SafetensorError, OSError, TypeError, ValueError, RecursionError) as error:
        raise CheckpointError(f"cannot load checkpoint {path}: {error}") from error
    return make_agent(method, scenario, parameters, metadata)


def _require_known(metadata: Mapping[str, Any]) -> None:
    if metadata.get("format_version") != _VERSION:
        raise InputError(f"format version {metadata.get('format_version')}; this version reads {_VERSION}")
    missing = [key for key in _REQUIRED if key not in metadata]
    if missing:
        raise InputError(f"its metadata lack {', '.join(missing)}")
    if not isinstance(metadata["seed"], int):
        raise InputError(f"its seed is {metadata['seed']!r}, no whole number")


def _scenario(scenario_id: str) -> Scenario:
    if scenario_id not in SCENARIOS:
        raise InputError(f"unknown scenario {scenario_id!r}; it was trained there, so register that scenario first")
    return get_scenario(scenario_id)


def _method(metadata: Mapping[str, Any]) -> Method:
    method = Method.from_data(metadata["method"], metadata["config"])
    if method.config_hash != metadata["config_hash"]:
        raise InputError("its config does not have the config hash it states")
    return method


def _require_interface(metadata: Mapping[str, Any], scenario: Scenario) -> None:
    if metadata["interface_hash"] != scenario.interface_hash:
        raise InputError(
            f"made for another interface of {scenario.id}: observation, options or actions differ; train it again"
        )


def _require_parameters(parameters: Parameters, method: Method, scenario: Scenario) -> None:
    shapes = method_shapes(method, scenario.num_actions) | frozen_shapes(method, scenario.num_actions)
    expected = {name: (1, *shape) for name, shape in shapes.items()}
    if expected != {name: tuple(value.shape) for name, value in parameters.items()}:
        raise InputError("its parameters have other names or shapes than its config asks for")
    for name, value in parameters.items():
        if value.dtype != np.float32 or not np.isfinite(value).all():
            raise InputError(f"parameter {name} holds other than finite float32 numbers")


FROZEN_SEED = 0
"""The training seed of the shipped policies that other methods use without learning them."""


def frozen_parameters(method: Method) -> Parameters:
    """Return what the method uses without learning it: its FFV policy's parameters, behind `ffv.`; empty without one.

    They are those of one training seed, `FROZEN_SEED`, whatever seeds are trained with them.

    Raises:
        InputError: if no such policy comes with the package, or one of another config.
    """
    if method.ffv is None:
        return {}
    path = checkpoint_file.SHIPPED / method.ffv.id / f"seed-{FROZEN_SEED}.safetensors"
    trained = load(path)
    if trained.method != method.ffv:
        raise InputError(
            f"method {method.id!r} follows with {method.ffv.id!r}, but {path} has another config; train that again"
        )
    return {FROZEN + name: value for name, value in trained.parameters.items()}
