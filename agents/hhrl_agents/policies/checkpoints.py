"""Checkpoints: one safetensors file an agent; nothing in it can execute code.

Its header holds the metadata as one JSON object, so that the same agent gives the same bytes.
"""

import json
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as to_bytes
from torch import Tensor

import hhrl_agents
from hhrl_agents.atomic_files import write_atomically
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.value_networks import FFV, frozen_shapes, method_shapes
from hhrl_agents.policies.learned_agent import LearnedAgent, make_agent
from hhrl_envs import Scenario, get_scenario
from hhrl_envs.errors import InputError

FORMAT = "hhrl-checkpoint"
FORMAT_VERSION = 1
REQUIRED = (
    "method",
    "config",
    "config_hash",
    "scenario",
    "spec_hash",
    "interface_hash",
    "seed",
    "env_steps",
    "versions",
)
"""Metadata without which no checkpoint is accepted; see `hhrl_agents.policies.learned_agent.describe`."""


class CheckpointError(InputError):
    """A checkpoint that is missing, damaged, foreign or of another interface."""


def save(path: Path, agent: LearnedAgent, metadata: Mapping[str, Any] | None = None) -> None:
    """Return nothing; write the agent to `path`, whole or not at all.

    metadata: JSON data to keep beside the agent's own, which it may not replace.

    Raises:
        OutputError: if it cannot be written; what stood at `path` is then still there.
    """
    entries = {**(metadata or {}), **agent.metadata, "format_version": FORMAT_VERSION}
    header = {FORMAT: json.dumps(entries, sort_keys=True, allow_nan=False)}
    write_atomically(path, to_bytes(agent.parameters, header))


def load(path: Path) -> LearnedAgent:
    """Return the agent stored at `path`, with its metadata.

    Raises:
        CheckpointError: if there is none, or anything about it is not as `save` writes it.
    """
    header, parameters = _read(Path(path))
    try:
        metadata = _metadata(header)
        method, scenario = _method(metadata), get_scenario(metadata["scenario"])
        _require_interface(metadata, scenario)
        _require_parameters(parameters, method, scenario)
    except (TypeError, ValueError, RecursionError) as error:
        raise CheckpointError(f"cannot load checkpoint {path}: {error}") from error
    return make_agent(method, scenario, parameters, metadata)


def _read(path: Path) -> tuple[dict[str, str], dict[str, Tensor]]:
    if not path.is_file():
        raise CheckpointError(f"cannot load checkpoint {path}: there is no such file")
    try:
        with safe_open(path, framework="pt") as file:
            return file.metadata() or {}, {name: file.get_tensor(name).clone() for name in file.keys()}  # noqa: SIM118
    except (SafetensorError, OSError) as error:
        raise CheckpointError(
            f"cannot load checkpoint {path}: not a whole safetensors file ({error}); "
            "name one that hhrl-bench train has written"
        ) from error


def _metadata(header: Mapping[str, str]) -> dict[str, Any]:
    if FORMAT not in header:
        raise InputError("a safetensors file, but none that this package has written")
    metadata: dict[str, Any] = dict(json.loads(header[FORMAT]))
    if metadata.get("format_version") != FORMAT_VERSION:
        raise InputError(f"format version {metadata.get('format_version')}; this version reads {FORMAT_VERSION}")
    missing = [key for key in REQUIRED if key not in metadata]
    if missing:
        raise InputError(f"its metadata lack {', '.join(missing)}")
    if not isinstance(metadata["seed"], int):
        raise InputError(f"its seed is {metadata['seed']!r}, no whole number")
    return metadata


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


def _require_parameters(parameters: Mapping[str, Tensor], method: Method, scenario: Scenario) -> None:
    shapes = method_shapes(method, scenario.num_actions) | frozen_shapes(method, scenario.num_actions)
    expected = {name: (1, *shape) for name, shape in shapes.items()}
    if expected != {name: tuple(value.shape) for name, value in parameters.items()}:
        raise InputError("its parameters have other names or shapes than its config asks for")
    for name, value in parameters.items():
        if value.dtype != torch.float32 or not isfinite(value.sum().item()):
            raise InputError(f"parameter {name} holds other than finite float32 numbers")


SHIPPED = Path(hhrl_agents.__file__).parent / "trained"
"""The folder of the trained policies that come with the package."""
FROZEN_SEED = 0


def frozen_parameters(method: Method) -> dict[str, Tensor]:
    """Return what the method uses without learning it: its FFV policy's parameters, behind `ffv.`; empty without one.

    They are those of training seed 0, whatever seeds are trained with them.

    Raises:
        InputError: if no such policy comes with the package, or one of another config.
    """
    if method.ffv is None:
        return {}
    path = SHIPPED / method.ffv.id / f"seed-{FROZEN_SEED}.safetensors"
    trained = load(path)
    if trained.method != method.ffv:
        raise InputError(
            f"method {method.id!r} follows with {method.ffv.id!r}, but {path} has another config; train that again"
        )
    return {FFV + name: value for name, value in trained.parameters.items()}
