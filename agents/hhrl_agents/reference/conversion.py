"""From the parameters of a checkpoint to a torch module, and back, without a change of any number."""

from collections.abc import Mapping

import numpy as np
import torch
from torch import Tensor

from hhrl_agents.methods.method import Method
from hhrl_agents.policies.learned_agent import LearnedAgent
from hhrl_agents.reference.modules import PolicyModule
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats32
from hhrl_envs.errors import InputError

AnyParameters = Mapping[str, Tensor] | Mapping[str, Floats32]
"""The parameters of a checkpoint, name -> [1, in, out] or [in, out], a bias [1, 1, out] or [1, out]."""


def to_module(agent: LearnedAgent) -> PolicyModule:
    """Return the networks of a learned agent as a torch module, which shares no memory with the agent."""
    return module_of(agent.method, agent.scenario, agent.parameters)


def module_of(method: Method, scenario: Scenario, parameters: AnyParameters) -> PolicyModule:
    """Return the torch module of these parameters.

    Raises:
        InputError: if the method's networks have other parameters.
    """
    module = PolicyModule(method, scenario)
    wanted = {name: tuple(value.shape) for name, value in module.state_dict().items()}
    state = {name: _to_torch(name, value) for name, value in parameters.items()}
    given = {name: tuple(value.shape) for name, value in state.items()}
    wrong = sorted(name for name in wanted.keys() | given.keys() if wanted.get(name) != given.get(name))
    if wrong:
        raise InputError(
            f"parameter {wrong[0]} is {given.get(wrong[0], 'missing')} as a torch module has it, method {method.id!r} "
            f"asks for {wanted.get(wrong[0], 'no such parameter')}; give the parameters of this method's checkpoint"
        )
    module.load_state_dict(state)
    return module


def from_module(module: PolicyModule) -> dict[str, Floats32]:
    """Return a copy of the parameters of a torch module, as a checkpoint and `make_agent` have them."""
    return {name: _from_torch(name, value) for name, value in module.state_dict().items()}


def gradients_of(module: PolicyModule) -> dict[str, Floats32]:
    """Return the gradients of a module's parameters in the form of `from_module`; those that have one."""
    named = module.named_parameters()
    return {name: _from_torch(name, value.grad) for name, value in named if value.grad is not None}


def _to_torch(name: str, value: Tensor | Floats32) -> Tensor:
    """Return a copy of a checkpoint's parameter as torch has it: a weight [out, in], a bias [out]."""
    tensor = value.detach().cpu().clone() if isinstance(value, Tensor) else torch.tensor(value)
    matrix = tensor.reshape(-1, tensor.shape[-1])
    return matrix.T.contiguous() if name.endswith("weight") else matrix.flatten()


def _from_torch(name: str, value: Tensor) -> Floats32:
    """Return a copy of torch's parameter as a checkpoint has it: a weight [1, in, out], a bias [1, 1, out]."""
    array: Floats32 = value.detach().cpu().numpy()
    return np.array(array.T if name.endswith("weight") else array[None], order="C")[None]
