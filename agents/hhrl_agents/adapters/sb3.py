"""Agents made of models of Stable-Baselines3, and of the zip files that it saves, which are read without a pickle.

A zip holds the weights, which torch reads as data alone, and settings in JSON. What JSON cannot say, the settings have
as pickles, with a description in words beside them. Standard policies are built anew from weights and words; for all
others the pickles would have to be loaded, which can run any code.
"""

import io
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol
from zipfile import BadZipFile, ZipFile

import numpy as np

from hhrl_agents.adapters.callables import as_decision
from hhrl_agents.adapters.torch_modules import from_torch
from hhrl_agents.agent import Agent, Decision
from hhrl_envs.arrays import Flags, Floats32
from hhrl_envs.errors import InputError, require
from hhrl_envs.observation import SIZE

if TYPE_CHECKING:
    import torch

LONGEST = 1 << 28
"""Most bytes that a file in a zip unpacks to."""

ACTIVATIONS = ("ELU", "GELU", "LeakyReLU", "Mish", "ReLU", "SELU", "SiLU", "Sigmoid", "Softplus", "Tanh")
"""The activations that a standard policy may have, by the names of torch's classes."""

_ACTOR, _VALUES = "mlp_extractor.policy_net", "q_net.q_net"
_STANDARD = {
    "stable_baselines3.common.policies": (_ACTOR, "Tanh", ("mlp_extractor.value_net", "value_net")),
    "stable_baselines3.dqn.policies": (_VALUES, "ReLU", ("q_net_target.q_net",)),
}
"""By the module of the policy's class: its layers, its default activation, and the weights that it does not act by."""

_PLAIN = (
    "net_arch", "activation_fn", "ortho_init", "optimizer_class", "optimizer_kwargs", "share_features_extractor",
    "normalize_images", "log_std_init",
)  # fmt: skip
"""The settings of a policy that leave it a standard one."""


class Model(Protocol):
    """A model of Stable-Baselines3 or sb3-contrib."""

    action_space: Any

    def predict(self, observation: Any, state: Any = ..., episode_start: Any = ..., deterministic: bool = ...) -> Any:
        """Return actions, and the states of a recurrent policy."""


def from_sb3(model: Model | str | Path, actions: int | None = None, *, trust: bool = False) -> Agent:
    """Return the greedy agent of a model of Stable-Baselines3, or of a zip that it has saved.

    Args:
        model: a model with discrete actions, a recurrent one too; or the path of a zip. Of a zip the standard policies
            of DQN, PPO and A2C are built anew without running any code of the file.
        actions: how many there are, so that a zip of another scenario is refused.
        trust: load a zip as Stable-Baselines3 does, which runs the code that is in it.

    Raises:
        InputError: for another model, or a zip that is none or would have to be trusted.
        MissingExtraError: without torch, or Stable-Baselines3 where a zip is trusted.
    """
    if isinstance(model, (str, Path)):
        path = Path(model)
        return from_sb3(_trusted(path)) if trust else from_torch(read_policy(path), actions, path.stem)
    if not hasattr(model, "predict") or getattr(getattr(model, "action_space", None), "n", None) is None:
        raise InputError(
            f"{type(model).__name__} with {getattr(model, 'action_space', 'no action space')} is no model of "
            "Stable-Baselines3 with discrete actions; train one on the discrete levels"
        )
    return PredictingAgent(model)


class PredictingAgent:
    """An agent that acts as its model predicts; ``name`` is that of the model's class."""

    def __init__(self, model: Model) -> None:
        self.name = type(model).__name__
        self._model, self._state, self._begins = model, None, np.ones(0, np.bool_)

    def reset(self, mask: Flags) -> None:
        """Forget the rows that start a new episode; see `Agent.reset`."""
        if len(mask) != len(self._begins):
            self._state, self._begins = None, np.ones(len(mask), np.bool_)
        self._begins |= mask

    def act(self, observations: Floats32) -> Decision:
        """Return the predicted actions, with no option (-1); see `Agent.act`."""
        actions, self._state = self._model.predict(
            observations, state=self._state, episode_start=self._begins, deterministic=True
        )
        self._begins = np.zeros(len(observations), np.bool_)
        return as_decision(actions)


def read_policy(path: Path) -> "torch.nn.Sequential":
    """Return the network by which the standard policy in a zip acts: float32 [B, elements] to values [B, actions].

    Raises:
        InputError: if it is no such zip, or its policy is not a standard one.
    """
    require("torch", "torch")
    data, weights = _settings(path), _weights(path)
    module = _described(data.get("policy_class")).get("__module__")
    if not isinstance(module, str) or module not in _STANDARD:
        raise _untrusted(path, f"its policy is of {module or 'an unknown module'}")
    layers, activation, idle = _STANDARD[module]
    acting = {name: value for name, value in weights.items() if not name.startswith(tuple(f"{one}." for one in idle))}
    if "log_std" in acting:
        raise InputError(f"{path} holds a policy of continuous actions; train one on the discrete levels")
    return _network(path, acting, layers, _activation(path, data.get("policy_kwargs"), activation))


def _network(path: Path, weights: dict[str, Any], layers: str, activation: str) -> "torch.nn.Sequential":
    """Return the layers in their order, with an activation between them, without any weight left over."""
    from torch import nn  # noqa: PLC0415

    numbers = sorted({int(match[1]) for name in weights if (match := re.match(rf"{re.escape(layers)}\.(\d+)\.", name))})
    names = [f"{layers}.{number}" for number in numbers] + (["action_net"] if layers == _ACTOR else [])
    expected = {f"{name}.{part}" for name in names for part in ("weight", "bias")}
    if not names or expected != weights.keys() or numbers != list(range(0, 2 * len(numbers), 2)):
        other = sorted(expected ^ weights.keys())
        raise _untrusted(path, f"its policy is no plain MLP ({other[0] if other else 'layers between the layers'})")
    modules: list[nn.Module] = []
    width = SIZE
    for name in names:
        weight, bias = weights[f"{name}.weight"].float(), weights[f"{name}.bias"].float()
        if weight.ndim != 2 or weight.shape[1] != width or bias.shape != weight.shape[:1]:
            raise InputError(
                f"{path} has a layer {name} of shape {tuple(weight.shape)} where {width} numbers go in; a policy reads "
                f"observations of {SIZE} elements, so put wrappers into a factory of your own"
            )
        width = len(weight)
        linear = nn.Linear(weight.shape[1], weight.shape[0], device="meta")
        linear.load_state_dict({"weight": weight, "bias": bias}, assign=True)
        modules += [linear, getattr(nn, activation)()]
    return nn.Sequential(*modules[:-1])


def _activation(path: Path, settings: Any, default: str) -> str:
    """Return the activation that the settings of a policy say, which have to be those of a standard one."""
    given = {name: value for name, value in _described(settings).items() if not name.startswith(":")}
    other = sorted(given.keys() - set(_PLAIN))
    if other:
        raise _untrusted(path, f"its policy has the setting {other[0]}")
    said = str(given.get("activation_fn", default))
    found = re.fullmatch(r"(?:<class 'torch\.nn\.modules\.activation\.)?(\w+)(?:'>)?", said)
    if found is None or found[1] not in ACTIVATIONS:
        raise _untrusted(path, f"its activation is {said}")
    return found[1]


def _settings(path: Path) -> Mapping[str, Any]:
    try:
        data = json.loads(_member(path, "data"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} holds no settings in JSON; name a zip that Stable-Baselines3 has saved") from error
    return _described(data)


def _weights(path: Path) -> dict[str, Any]:
    """Return the tensors of the policy, read as data: torch refuses all else."""
    import torch  # noqa: PLC0415

    try:
        weights = torch.load(io.BytesIO(_member(path, "policy.pth")), map_location="cpu", weights_only=True)
    except Exception as error:  # its errors have no common class of their own
        raise InputError(f"{path} holds weights that torch does not read as data; save the model again") from error
    if not isinstance(weights, dict) or not all(isinstance(one, torch.Tensor) for one in weights.values()):
        raise InputError(f"{path} holds other weights than tensors; save the model again")
    return weights


def _member(path: Path, name: str) -> bytes:
    try:
        with ZipFile(path) as archive, archive.open(name) as file:
            content = file.read(LONGEST + 1)
    except (OSError, KeyError, BadZipFile, RuntimeError, NotImplementedError) as error:
        raise InputError(f"cannot load {path}: {error}; name a zip that Stable-Baselines3 has saved") from error
    if len(content) > LONGEST:
        raise InputError(f"{path} holds more than {LONGEST:,} bytes of {name}")
    return content


def _described(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _untrusted(path: Path, why: str) -> InputError:
    return InputError(
        f"{path} would have to be loaded by running code that is in it, as {why}; if you trust the file, add --trust, "
        "or trust=True in Python"
    )


def _trusted(path: Path) -> Model:
    """Return the model as Stable-Baselines3 loads it, with whatever code is in the zip."""
    require("stable_baselines3", "sb3")
    import stable_baselines3  # noqa: PLC0415

    data = _settings(path)
    known = {"exploration_fraction": "DQN", "clip_range": "PPO", "gae_lambda": "A2C"}
    name = next((name for key, name in known.items() if key in data), None)
    if name is None or "sb3_contrib" in str(_described(data.get("policy_class")).get("__module__")):
        raise InputError(
            f"{path} is of no DQN, PPO or A2C; load it in a factory of your own and return from_sb3(model)"
        )
    try:
        model: Model = getattr(stable_baselines3, name).load(path, device="cpu")
    except Exception as error:  # whatever the code in the file raises
        raise InputError(f"cannot load {path} as {name}: {type(error).__name__}: {error}") from error
    return model
