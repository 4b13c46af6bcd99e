"""Agents made of ONNX files of others: they decide by their first output, or by the one that is named."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hhrl_agents import from_onnx
from hhrl_envs import InputError
from hhrl_envs.arrays import Floats32

onnx = pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")

WEIGHTS = np.random.default_rng(1).normal(size=(11, 6)).astype(np.float32)


def states(rows: int, seed: int = 0) -> Floats32:
    return np.random.default_rng(seed).normal(size=(rows, 11)).astype(np.float32)


def write(path: Path, shape: list[Any], *outputs: tuple[str, str], metadata: str | None = None) -> Path:
    """Write a model whose outputs are values, chosen actions or a state's value, of a linear network."""
    helper, kinds = onnx.helper, {"values": 1, "chosen": 7, "worth": 1}
    weights = np.resize(WEIGHTS, (shape[-1] or 11, 6))
    nodes = [helper.make_node("MatMul", ["seen", "weights"], ["all"])]
    for name, kind in outputs:
        if kind == "values":
            nodes.append(helper.make_node("Identity", ["all"], [name]))
        elif kind == "chosen":
            nodes.append(helper.make_node("ArgMax", ["all"], [name], axis=1, keepdims=0))
        else:
            nodes.append(helper.make_node("ReduceMax", ["all"], [name], axes=[1], keepdims=1))
    graph = helper.make_graph(
        nodes, "policy", [helper.make_tensor_value_info("seen", 1, shape)],
        [helper.make_tensor_value_info(name, kinds[kind], None) for name, kind in outputs],
        [onnx.numpy_helper.from_array(weights, "weights")],
    )  # fmt: skip
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    if metadata is not None:
        helper.set_model_props(model, {"hhrl-checkpoint": metadata})
    path.write_bytes(model.SerializeToString())
    return path


@pytest.mark.parametrize("shape", [["batch", 11], [1, 11], [None, None]])
@pytest.mark.parametrize("kind", ["values", "chosen"])
def test_values_or_actions_of_any_batch_or_of_single_rows(shape: list[Any], kind: str, tmp_path: Path) -> None:
    agent = from_onnx(write(tmp_path / "a.onnx", shape, ("out", kind), ("worth", "worth")), actions=6)
    agent.reset(np.ones(7, np.bool_))
    decision = agent.act(states(7))
    assert decision.action.tolist() == (states(7) @ WEIGHTS).argmax(1).tolist()
    assert decision.option.tolist() == [-1] * 7


def test_the_output_can_be_named(tmp_path: Path) -> None:
    path = write(tmp_path / "a.onnx", ["batch", 11], ("worth", "worth"), ("values", "values"))
    assert from_onnx(path, "values").act(states(3)).action.shape == (3,)
    with pytest.raises(InputError, match="let it return values of shape"):
        from_onnx(path).act(states(3))
    with pytest.raises(InputError, match=r"a\.onnx has no output 'actions'; write one of: worth, values"):
        from_onnx(path, "actions")


@pytest.mark.parametrize(
    ("shape", "metadata", "said"),
    [
        (["batch", 12], None, r"takes \['batch', 12\]; export a model that takes \[batch, 11\], the batch free or 1"),
        ([4, 11], None, r"takes \[4, 11\]; export"),
        (["batch", 3, 11], None, "has the inputs seen: tensor"),
        (["batch", 11], "{}", "does not say what its agent remembers"),
        (["batch", 11], "[", "does not say what its agent remembers"),
    ],
)
def test_another_model_is_refused_in_one_line(
    shape: list[Any], metadata: str | None, said: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=said):
        from_onnx(write(tmp_path / "a.onnx", shape, ("values", "values"), metadata=metadata))


def test_a_file_that_is_none_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "a.onnx"
    with pytest.raises(InputError, match="there is no such file"):
        from_onnx(path)
    path.write_bytes(b"no model")
    with pytest.raises(InputError, match=r"cannot load .*; name an ONNX file that ONNX Runtime reads") as caught:
        from_onnx(path)
    assert len(str(caught.value).splitlines()) == 1
