"""Trained networks as ONNX files, which ONNX Runtime and others evaluate without torch and without this package."""

import json
import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
import onnxruntime
import torch
from onnx import ModelProto

from hhrl_agents.agent import Decision
from hhrl_agents.atomic_files import require_writable, write_atomically
from hhrl_agents.policies.checkpoint_file import METADATA_KEY
from hhrl_agents.policies.checkpoints import load
from hhrl_agents.policies.learned_agent import LearnedAgent, make_agent
from hhrl_agents.policies.observation_memory import Traces
from hhrl_agents.reference.conversion import to_module
from hhrl_agents.reference.modules import PolicyModule
from hhrl_envs.arrays import Flags, Floats32, Ints
from hhrl_envs.errors import InputError
from hhrl_envs.observation import SIZE

TOLERANCE = 1e-4
"""How far a value of the file may lie from torch's, as a share of the larger of the value and 1."""

_STEPS, _ROWS = 8, 512


class Parity(NamedTuple):
    """What an ONNX file gives beside the agent it was made of.

    states: random states that both were asked for; equal: states in which they decided alike; ties: the others in which
    two choices are too close to call, within the tolerance; difference: the largest difference of a value from torch's,
    as a share of the larger of the value and 1.
    """

    states: int
    equal: int
    ties: int
    difference: float


def export_onnx(agent: LearnedAgent | Path, path: Path) -> Parity:
    """Write the networks of the levels that an agent has learned to an ONNX file, and return how equal they are.

    The input "features" is float32 [batch, features], the observation first, then its traces. The outputs
    "option_values" and "action_values" are float32 [batch, choices], those of the levels that are learned; the agent
    takes the first of the highest ones. The action values are those of the best option. Where a rule gives the
    option, it is a second input, "option", int64 [batch]. A level that is given has no network and is not in the file.
    The file's metadata are the checkpoint's.

    agent: the agent, or the path of its checkpoint.

    Raises:
        InputError: if the file decides otherwise than the agent in a random state that is no tie, or a value differs by
            more than `TOLERANCE`; nothing is written then.
        OutputError: if it cannot be written.
    """
    require_writable(path)
    agent = agent if isinstance(agent, LearnedAgent) else load(agent)
    module = to_module(agent).eval()
    content = _model(module, agent).SerializeToString()
    parity = parity_of(content, agent, module)
    if parity.equal + parity.ties < parity.states or not parity.difference <= TOLERANCE:
        raise InputError(
            f"nothing is written, the ONNX file of method {agent.method.id!r} would differ from it: {parity.equal} of "
            f"{parity.states} decisions are equal, {parity.ties} ties, values within {parity.difference:.1e}; report it"
        )
    write_atomically(path, content)
    return parity


def parity_of(content: bytes, agent: LearnedAgent, module: PolicyModule) -> Parity:
    """Return how equal the ONNX file of this content is to the agent in random episodes, and to its module's values."""
    session = onnxruntime.InferenceSession(content, providers=["CPUExecutionProvider"])
    rng, memory = np.random.default_rng(0), Traces(agent.method.config.memory)
    agent = make_agent(agent.method, agent.scenario, agent.parameters, {})  # what the given one remembers, it keeps
    agent.reset(np.ones(_ROWS, np.bool_))
    equal = ties = 0
    difference = 0.0
    for _ in range(_STEPS):
        observations = rng.normal(size=(_ROWS, SIZE)).astype(np.float32)
        features, decision = memory.observe(observations), agent.act(observations)
        inputs: dict[str, Floats32 | Ints] = {"features": features}
        if _option_is_given(module):
            inputs["option"] = decision.option
        found = dict(zip(_outputs(module), session.run(None, inputs), strict=True))
        wanted = _values(module, *inputs.values())
        tied = np.any([_tied(values) for values in wanted.values()], axis=0)
        alike = np.all([_chosen(decision, name) == found[name].argmax(1) for name in found], axis=0)
        equal, ties = equal + int(alike.sum()), ties + int((tied & ~alike).sum())
        difference = max(difference, *(_difference(found[name], wanted[name]) for name in found))
    return Parity(_STEPS * _ROWS, equal, ties, difference)


def _model(module: PolicyModule, agent: LearnedAgent) -> ModelProto:
    """Return the ONNX model of a module, with the agent's metadata, and without where in which file it was made."""
    features = torch.zeros(2, agent.method.config.features)
    inputs = {
        "features": features,
        **({"option": torch.zeros(2, dtype=torch.int64)} if _option_is_given(module) else {}),
    }
    batch = torch.export.Dim("batch")
    with _quiet():
        program = torch.onnx.export(
            module,
            tuple(inputs.values()),
            input_names=list(inputs),
            output_names=_outputs(module),
            dynamic_shapes=tuple({0: batch} for _ in inputs),
            dynamo=True,
            verbose=False,
        )
    assert program is not None
    model: ModelProto = program.model_proto
    for noted in (model.graph, *model.graph.node, *model.graph.value_info, *model.graph.input, *model.graph.output):
        del noted.metadata_props[:]
    del model.metadata_props[:]
    model.metadata_props.add(key=METADATA_KEY, value=json.dumps(agent.metadata, sort_keys=True))
    return model


@contextmanager
def _quiet() -> Iterator[None]:
    """Return a context in which torch's exporter says nothing of what it calls itself and of what is not installed."""
    logger = logging.getLogger("torch.onnx")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings(action="ignore"):
            yield
    finally:
        logger.setLevel(level)


def _outputs(module: PolicyModule) -> list[str]:
    return [f"{level}_values" for level in module.method.levels]


def _option_is_given(module: PolicyModule) -> bool:
    return module.method.hierarchical and "option" not in module.method.levels


@torch.no_grad()
def _values(module: PolicyModule, *inputs: Floats32 | Ints) -> dict[str, Floats32]:
    """Return torch's values of every level that is learned."""
    values = module(*map(torch.from_numpy, inputs))
    each = values if isinstance(values, tuple) else (values,)
    return dict(zip(_outputs(module), (one.numpy() for one in each), strict=True))


def _chosen(decision: Decision, output: str) -> Ints:
    return decision.option if output == "option_values" else decision.action


def _tied(values: Floats32) -> Flags:
    second, best = np.sort(values, axis=1)[:, -2:].T
    tied: Flags = best - second <= 2 * TOLERANCE * np.maximum(np.abs(best), 1.0)
    return tied


def _difference(found: Floats32, wanted: Floats32) -> float:
    """Return the largest difference, infinite where one of both is finite alone."""
    if not np.array_equal(np.isfinite(found), np.isfinite(wanted)):
        return float("inf")
    present = np.isfinite(wanted)
    gap = np.abs(found[present] - wanted[present]) / np.maximum(np.abs(wanted[present]), 1.0)
    return float(gap.max())
