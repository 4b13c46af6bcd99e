"""Files that hold another library's policy, by their endings."""

from collections.abc import Callable, Mapping
from pathlib import Path

from hhrl_agents.agent import Agent


def read_agent(path: Path, actions: int, *, trust: bool = False) -> Agent:
    """Return the agent in a file that ends in one of ``ENDINGS``; ``trust`` runs the code in it where it needs that.

    Raises:
        InputError: if it is none, or not one of that many actions.
    """
    return ENDINGS[path.suffix](path, actions, trust)


def _sb3(path: Path, actions: int, trust: bool) -> Agent:
    from hhrl_agents.adapters.sb3 import from_sb3  # noqa: PLC0415

    return from_sb3(path, actions, trust=trust)


def _onnx(path: Path, actions: int, _: bool) -> Agent:
    from hhrl_agents.adapters.onnx_files import from_onnx  # noqa: PLC0415

    return from_onnx(path, actions=actions)


ENDINGS: Mapping[str, Callable[[Path, int, bool], Agent]] = {".zip": _sb3, ".onnx": _onnx}
"""What reads a file, by its ending: a zip of Stable-Baselines3, an ONNX file."""
