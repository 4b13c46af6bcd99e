"""The parameters of a seed: how they begin, where they lie, how targets follow, and Adam's steps."""

import numpy as np
import pytest
import torch

from hhrl_agents.networks.architectures import Architecture, Attended
from hhrl_agents.networks.parameters import TINY, Adam, Memory, ParameterSet, advance_powers, descend
from hhrl_agents.seeding import Purpose, generator
from hhrl_envs.arrays import Floats32
from hhrl_envs.simulation.engine.compilation import kernel

NETWORKS = {
    "option": Architecture(11, (8, 7), 2),
    "action": Architecture(11, (8, 7), 6, reads_option=True, attended=Attended.STATE),
}


def parameters(seed: int = 0) -> ParameterSet:
    return ParameterSet(NETWORKS, generator(seed, Purpose.INITIALISATION))


@kernel
def step(memory: Memory, gradient: Floats32, learning_rate: float, max_norm: float) -> None:
    advance_powers(memory.powers)
    memory.gradient[:] = gradient
    descend(memory, 0, gradient.size, learning_rate, max_norm)


def test_weights_are_uniform_by_their_fan_in_and_biases_zero() -> None:
    for name, value in parameters().snapshot().items():
        if name.endswith("bias"):
            assert not value.any()
        else:
            bound = value.shape[1] ** -0.5
            assert 0.5 * bound < np.abs(value).max() <= bound


def test_a_seed_alone_decides_how_they_begin() -> None:
    assert np.array_equal(parameters(3).online, parameters(3).online)
    assert not np.array_equal(parameters(3).online, parameters(4).online)


def test_a_level_has_its_part() -> None:
    made = parameters()
    first, last = made.parts["action"]
    assert made.parts["option"] == (0, first)
    assert last == len(made.online)
    made.online[first:last] = 7.0
    assert all((value == 7.0).all() == name.startswith("action.") for name, value in made.snapshot().items())


def test_what_is_taken_over_is_online_and_target() -> None:
    made, other = parameters(), parameters(1).snapshot()
    made.take_over({name: value for name, value in other.items() if name.startswith("option.")})
    assert np.array_equal(made.online, made.target)
    for name, value in made.snapshot().items():
        assert np.array_equal(value, other[name]) == (name.startswith("option.") or name.endswith("bias"))


@pytest.mark.parametrize("rate", [1.0, 0.25])
def test_a_target_moves_by_its_share(rate: float) -> None:
    made = parameters()
    made.online += np.float32(1.0)
    before = made.target.copy()
    made.move_target(rate)
    np.testing.assert_allclose(made.target, before + rate * (made.online - before), rtol=1e-6)
    assert np.array_equal(made.target, made.online) == (rate == 1.0)


def test_a_snapshot_does_not_change_later() -> None:
    made = parameters()
    snapshot = made.snapshot()
    kept = {name: value.copy() for name, value in snapshot.items()}
    made.online[:] = 0.0
    assert all(np.array_equal(value, kept[name]) for name, value in snapshot.items())


@pytest.mark.parametrize("size", [5, 16, 1000])
def test_steps_are_those_of_torch(size: int) -> None:
    rng = np.random.default_rng(size)
    online = rng.normal(size=size).astype(np.float32)
    theirs = torch.nn.Parameter(torch.from_numpy(online.copy()))
    optimiser, adam = torch.optim.Adam([theirs], betas=(0.9, 0.999), eps=1e-8), Adam(size)
    memory = Memory(online, online.copy(), adam.gradient, adam.mean, adam.variance, adam.powers)
    for count in range(100):
        gradient = (rng.normal(size=size) * 10.0 ** rng.integers(-3, 2)).astype(np.float32)
        theirs.grad = torch.from_numpy(gradient.copy())
        torch.nn.utils.clip_grad_norm_([theirs], 2.0)
        optimiser.param_groups[0]["lr"] = rate = 1e-2 / (1 + count)
        optimiser.step()
        step(memory, gradient, rate, 2.0)
    np.testing.assert_allclose(online, theirs.detach().numpy(), rtol=1e-4, atol=1e-6)


def test_tiny_averages_are_zero() -> None:
    adam, online = Adam(3), np.ones(3, np.float32)
    adam.mean[:] = adam.variance[:] = TINY
    memory = Memory(online, online.copy(), adam.gradient, adam.mean, adam.variance, adam.powers)
    step(memory, np.zeros(3, np.float32), 1e-3, 1.0)
    assert not adam.mean.any()
    assert not adam.variance.any()


def test_a_state_goes_on() -> None:
    adam, made = Adam(4), parameters()
    adam.mean[:], adam.powers[:] = 2.0, 0.5
    fresh, others = Adam(4), parameters(1)
    fresh.restore(adam.state())
    others.restore(made.state())
    assert (fresh.mean == 2.0).all()
    assert (fresh.powers == 0.5).all()
    assert np.array_equal(others.online, made.online)
