import numpy as np
import pytest
import torch

from hhrl_agents.networks.architectures import Architecture
from hhrl_agents.networks.parameters import ParameterStack
from hhrl_agents.seeding import Purpose, generators

LAYERS = Architecture(11, (8,), 3).shapes()
SHAPES = {f"{level}.{name}": shape for level in ("option", "action") for name, shape in LAYERS.items()}


def stack_of(*seeds: int) -> ParameterStack:
    return ParameterStack(SHAPES, generators(seeds, Purpose.INITIALISATION), torch.device("cpu"))


def test_a_seed_starts_the_same_whoever_is_stacked_with_it() -> None:
    alone, stacked = stack_of(4), stack_of(9, 4)
    for name in SHAPES:
        assert torch.equal(alone.online[name][0], stacked.online[name][1])
        assert not name.endswith("weight") or not torch.equal(stacked.online[name][0], stacked.online[name][1])


def test_weights_start_within_their_bound_and_biases_at_zero() -> None:
    stack = stack_of(0, 1, 2)
    for name, (fan_in, _) in SHAPES.items():
        largest = stack.online[name].abs().max().item()
        assert largest == 0.0 if name.endswith("bias") else 0.5 < largest * np.sqrt(fan_in) <= 1.0


def test_views_are_the_flat_memory_in_the_order_of_the_shapes() -> None:
    stack = stack_of(0, 1)
    for flat, views in ((stack.flat, stack.online), (stack.gradient, stack.gradients)):
        flat.copy_(torch.arange(flat.numel()).view_as(flat))
        assert list(views) == list(SHAPES)
        for e in range(2):
            joined = torch.cat([view[e].flatten() for view in views.values()])
            assert torch.equal(joined, flat[e])
        assert all(view.shape == (2, *SHAPES[name]) for name, view in views.items())


def test_online_and_flat_are_the_same_memory_and_the_target_is_not() -> None:
    stack = stack_of(0, 1)
    before = {name: value.clone() for name, value in stack.both.items()}
    stack.flat.add_(1.0)
    for name, value in before.items():
        assert torch.equal(stack.online[name], stack.both[name][:2])
        assert torch.equal(stack.both[name][:2], value[:2] + 1.0)
        assert torch.equal(stack.both[name][2:], value[2:])
    stack.move_target(1.0)
    for name in before:
        assert torch.equal(stack.both[name][2:], stack.online[name])


def test_a_target_moves_by_its_rate() -> None:
    stack = stack_of(0, 1)
    stack.flat.add_(1.0)
    expected = 0.9 * stack.flat_target + 0.1 * stack.flat
    stack.move_target(0.1)
    np.testing.assert_allclose(stack.flat_target, expected, rtol=1e-6, atol=1e-7)
    assert (stack.flat - stack.flat_target).mean().item() == pytest.approx(0.9, rel=1e-5)


def test_a_part_holds_the_parameters_of_its_name_and_no_others() -> None:
    stack = stack_of(0, 1)
    option, action = stack.part("option."), stack.part("action.")
    assert (option.start, option.stop, action.stop) == (0, action.start, stack.flat.shape[1])
    stack.flat[:, action] = 7.0
    for name, value in stack.online.items():
        assert (value == 7.0).all() == name.startswith("action.")


def test_a_snapshot_keeps_what_was() -> None:
    stack = stack_of(3, 6)
    taken = stack.snapshot(1)
    before = {name: value[1:].clone() for name, value in stack.online.items()}
    stack.flat.add_(1.0)
    assert taken.keys() == SHAPES.keys()
    for name, value in taken.items():
        np.testing.assert_array_equal(value, before[name])
        assert value.dtype == np.float32
        assert value.flags.c_contiguous
        assert value.flags.owndata
