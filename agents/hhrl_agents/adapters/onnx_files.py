"""Agents made of ONNX files, which ONNX Runtime evaluates in one thread."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from hhrl_agents.adapters.callables import choices
from hhrl_agents.agent import NO_OPTION, Agent, Decision
from hhrl_agents.policies.checkpoint_file import METADATA_KEY
from hhrl_agents.policies.observation_memory import Traces
from hhrl_envs.arrays import Flags, Floats32
from hhrl_envs.errors import InputError, require
from hhrl_envs.observation import SIZE

LEVELS = ("option_values", "action_values")
"""The outputs of a hierarchical policy; see `hhrl_agents.reference.onnx.export_onnx`."""


def from_onnx(path: str | Path, output: str | None = None, actions: int | None = None) -> Agent:
    """Return the greedy agent of an ONNX file.

    The model has one input, float32 [batch, elements], whose batch is free or 1. Its outputs are values or logits,
    float [batch, actions], or actions, int [batch]. With outputs "option_values" and "action_values" it is
    hierarchical; else its ``output``, by default "action_values" or the first, is that of a flat agent. A file that
    `hhrl-bench export` has written remembers what its agent does. ``actions`` is how many there are, so that a network
    of another scenario is refused.

    Raises:
        MissingExtraError: without onnxruntime.
        InputError: if there is no such file, or its inputs and outputs are others.
    """
    require("onnxruntime", "onnx")
    path = Path(path)
    if not path.is_file():
        raise InputError(f"cannot load {path}: there is no such file")
    session = _session(path)
    names = [one.name for one in session.get_outputs()]
    if output is not None and output not in names:
        raise InputError(f"{path} has no output {output!r}; write one of: {', '.join(names)}")
    if output is None and set(LEVELS) <= set(names):
        return OnnxAgent(path, session, LEVELS, actions)
    chosen = output or (LEVELS[1] if LEVELS[1] in names else names[0])
    return OnnxAgent(path, session, (chosen,), actions)


class OnnxAgent:
    """The agent of a session, whose ``outputs`` are those of the action level, or of both; ``name`` is the file's."""

    def __init__(self, path: Path, session: Any, outputs: Sequence[str], actions: int | None) -> None:
        self.name = path.stem
        self._session, self._outputs, self._actions = session, list(outputs), actions
        rates = _memory(path, session.get_modelmeta().custom_metadata_map)
        self._memory = Traces(rates)
        inputs = session.get_inputs()
        if len(inputs) != 1 or inputs[0].type != "tensor(float)" or len(inputs[0].shape) != 2:
            said = ", ".join(f"{one.name}: {one.type} {one.shape}" for one in inputs)
            raise InputError(f"{path} has the inputs {said}; export a model with one input, float32 [batch, {SIZE}]")
        batch, width = inputs[0].shape
        features = SIZE * (1 + len(rates))
        if (isinstance(width, int) and width != features) or (isinstance(batch, int) and batch != 1):
            raise InputError(
                f"{path} takes {inputs[0].shape}; export a model that takes [batch, {features}], the batch free or 1"
            )
        self._input, self._single = inputs[0].name, batch == 1

    def reset(self, mask: Flags) -> None:
        """Forget the rows that start a new episode; see `Agent.reset`."""
        self._memory.begin(mask)

    def act(self, observations: Floats32) -> Decision:
        """Return the greedy decisions; see `Agent.act`."""
        features, rows = self._memory.observe(observations), len(observations)
        *options, actions = self._run(features)
        option = choices(options[0], rows) if options else np.full(rows, NO_OPTION)
        return Decision(option, choices(actions, rows, self._actions))

    def _run(self, features: Floats32) -> list[Any]:
        if not self._single:
            return list(self._session.run(self._outputs, {self._input: features}))
        each = [self._session.run(self._outputs, {self._input: row}) for row in features[:, None]]
        return [np.concatenate(values) for values in zip(*each, strict=True)]


def _session(path: Path) -> Any:
    import onnxruntime  # noqa: PLC0415

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4
    try:
        return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    except Exception as error:  # its errors have no common class of their own
        raise InputError(f"cannot load {path}: {error}; name an ONNX file that ONNX Runtime reads") from error


def _memory(path: Path, metadata: Mapping[str, str]) -> Sequence[float]:
    """Return the rates of the traces that a file of ours asks for; none for others."""
    if METADATA_KEY not in metadata:
        return ()
    try:
        return [float(rate) for rate in json.loads(metadata[METADATA_KEY])["config"]["config"]["memory"]]
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise InputError(f"{path} does not say what its agent remembers; export it again") from error
