import numpy as np
import torch

from hhrl_agents.networks import MLP, mlp_shapes
from hhrl_agents.parameters import ParameterStack
from hhrl_agents.seeding import Purpose, generators

SHAPES = mlp_shapes(11, 8, 3)


def stack_of(*seeds: int) -> ParameterStack:
    return ParameterStack(SHAPES, generators(seeds, Purpose.INITIALISATION))


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


def test_online_and_flat_are_the_same_memory_and_the_target_is_not() -> None:
    stack = stack_of(0, 1)
    before = {name: value.clone() for name, value in stack.both.items()}
    with torch.no_grad():
        stack.flat.add_(1.0)
    for name, value in before.items():
        assert torch.equal(stack.online[name], stack.both[name][:2])
        assert torch.equal(stack.both[name][:2], value[:2] + 1.0)
        assert torch.equal(stack.both[name][2:], value[2:])
    stack.copy_to_target()
    for name in before:
        assert torch.equal(stack.both[name][2:], stack.online[name])


def losses_of(stack: ParameterStack, inputs: torch.Tensor) -> torch.Tensor:
    return MLP(stack.online)(inputs).square().sum((1, 2))


def test_gradients_are_those_of_each_seed_alone() -> None:
    inputs = torch.from_numpy(np.random.default_rng(0).normal(size=(2, 5, 11)).astype(np.float32))
    stacked = stack_of(3, 6)
    stacked.set_gradients(losses_of(stacked, inputs), max_norm=1e9)
    for e, seed in enumerate((3, 6)):
        alone = stack_of(seed)
        parts = torch.autograd.grad(losses_of(alone, inputs[e : e + 1]).sum(), list(alone.online.values()))
        flat = torch.cat([part.flatten() for part in parts])
        assert stacked.flat.grad is not None
        np.testing.assert_allclose(stacked.flat.grad[e], flat, rtol=1e-4, atol=1e-6)


def test_each_seed_s_gradient_is_clipped_by_itself() -> None:
    inputs = torch.from_numpy(np.random.default_rng(0).normal(size=(2, 5, 11)).astype(np.float32))
    inputs[1] *= 100.0
    free, clipped = stack_of(3, 6), stack_of(3, 6)
    free.set_gradients(losses_of(free, inputs), max_norm=1e9)
    assert free.flat.grad is not None
    norms = free.flat.grad.norm(dim=1)
    bound = 2.0 * norms[0].item()
    assert norms[1] > bound
    clipped.set_gradients(losses_of(clipped, inputs), max_norm=bound)
    assert clipped.flat.grad is not None
    assert torch.equal(clipped.flat.grad[0], free.flat.grad[0])
    np.testing.assert_allclose(clipped.flat.grad[1].norm(), bound, rtol=1e-4)
    np.testing.assert_allclose(clipped.flat.grad[1] / bound, free.flat.grad[1] / norms[1], rtol=1e-3, atol=1e-6)


def test_a_snapshot_keeps_what_was() -> None:
    stack = stack_of(3, 6)
    taken = stack.snapshot(1)
    before = stack.online["0.weight"][1].clone()
    with torch.no_grad():
        stack.flat.add_(1.0)
    assert torch.equal(taken["0.weight"], before[None])
    assert all(value.is_contiguous() and not value.requires_grad for value in taken.values())
