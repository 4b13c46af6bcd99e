"""From a checkpoint to a torch module and back."""

from pathlib import Path

import numpy as np
import pytest
import torch

from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_agents.policies.learned_agent import make_agent
from hhrl_agents.reference.conversion import from_module, gradients_of, module_of, to_module
from hhrl_envs import get_scenario
from hhrl_envs.errors import InputError
from support.kinds import KINDS, method_of, parameters_of

MAIN = get_scenario("stop-line-v0")


@pytest.mark.parametrize("kind", KINDS)
def test_there_and_back_changes_no_bit(kind: str) -> None:
    method = method_of(kind)
    parameters = parameters_of(method, MAIN, seed=0)
    back = from_module(module_of(method, MAIN, parameters))
    assert back.keys() == parameters.keys()
    for name, value in parameters.items():
        assert back[name].dtype == np.float32
        assert back[name].flags.c_contiguous
        assert np.array_equal(back[name], value)


def test_a_checkpoint_comes_back_byte_for_byte(tmp_path: Path) -> None:
    path = SHIPPED / "hybrid-hrl" / "seed-0.safetensors"
    agent = checkpoints.load(path)
    again = make_agent(agent.method, agent.scenario, from_module(to_module(agent)), agent.metadata)
    for name, one in (("before", agent), ("after", again)):
        checkpoints.save(tmp_path / name, one)
    assert (tmp_path / "before").read_bytes() == (tmp_path / "after").read_bytes()


def test_arrays_and_tensors_with_and_without_an_axis_of_seeds_are_alike() -> None:
    method = method_of("attention")
    parameters = parameters_of(method, MAIN, seed=0)
    forms = (
        {name: value[0] for name, value in parameters.items()},
        {name: torch.from_numpy(value) for name, value in parameters.items()},
    )
    for form in forms:
        back = from_module(module_of(method, MAIN, form))
        assert all(np.array_equal(back[name], value) for name, value in parameters.items())


def test_a_module_shares_no_memory() -> None:
    method = method_of("flat")
    parameters = parameters_of(method, MAIN, seed=0)
    before = {name: value.copy() for name, value in parameters.items()}
    module = module_of(method, MAIN, parameters)
    back = from_module(module)
    with torch.no_grad():
        for parameter in module.parameters():
            parameter.add_(1.0)
    for name, value in before.items():
        assert np.array_equal(parameters[name], value)
        assert np.array_equal(back[name], value)


def test_gradients_have_the_form_of_parameters() -> None:
    method = method_of("flat")
    module = module_of(method, MAIN, parameters_of(method, MAIN, seed=0))
    assert not gradients_of(module)
    features = torch.ones(3, method.config.features)
    module.action_values(features)[:, 2].sum().backward()  # type: ignore[no-untyped-call]
    gradients = gradients_of(module)
    assert {name: value.shape for name, value in gradients.items()} == {
        name: value.shape for name, value in from_module(module).items()
    }
    np.testing.assert_array_equal(gradients["action.2.bias"], [[[0.0, 0.0, 3.0, 0.0, 0.0, 0.0]]])
    assert (gradients["action.2.weight"][0, :, [0, 1, 3, 4, 5]] == 0.0).all()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda parameters: parameters.pop("action.0.bias"), r"parameter action\.0\.bias is missing"),
        (lambda parameters: parameters.update(more=np.zeros((1, 1, 2), np.float32)), "asks for no such parameter"),
        (lambda parameters: parameters.update({"action.0.bias": np.zeros((2, 1, 16), np.float32)}), r"is \(32,\)"),
    ],
)
def test_parameters_of_another_method_are_refused(change: object, said: str) -> None:
    method = method_of("flat")
    parameters = parameters_of(method, MAIN, seed=0)
    assert callable(change)
    change(parameters)
    with pytest.raises(InputError, match=said):
        module_of(method, MAIN, parameters)
