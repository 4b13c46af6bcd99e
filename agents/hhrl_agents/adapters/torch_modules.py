"""Agents made of torch modules."""

from typing import TYPE_CHECKING, Any

from hhrl_agents.adapters.callables import FunctionAgent, choices
from hhrl_agents.agent import Agent
from hhrl_envs.arrays import Floats32, Ints
from hhrl_envs.errors import require

if TYPE_CHECKING:
    import torch


def from_torch(module: "torch.nn.Module", actions: int | None = None, name: str | None = None) -> Agent:
    """Return the greedy agent of a torch module, which is put into evaluation mode.

    Args:
        module: takes observations, float32 [B, elements], on the device of its parameters. It returns values or logits,
            float [B, actions], or actions, int [B]; of a hierarchical policy a pair, that of the options first.
        actions: how many there are, so that a network of another scenario is refused.
        name: what tables call the agent; by default as the module's class is called.

    Raises:
        MissingExtraError: without torch.
    """
    require("torch", "torch")
    import torch  # noqa: PLC0415

    module.eval()
    device = next((parameter.device for parameter in module.parameters()), torch.device("cpu"))

    def act(observations: Floats32) -> Ints | tuple[Ints, Ints]:
        with torch.no_grad():
            output: Any = module(torch.from_numpy(observations).to(device))
        rows = len(observations)
        if isinstance(output, tuple) and len(output) == 2:
            return choices(_array(output[0]), rows), choices(_array(output[1]), rows, actions)
        return choices(_array(output), rows, actions)

    return FunctionAgent(act, name=name or type(module).__name__)


def _array(output: Any) -> Any:
    """Return a tensor as an array; anything else as it is, for it to be refused."""
    return output.cpu().numpy() if hasattr(output, "cpu") else output
