import numpy as np
import pytest
import torch
from torch import Tensor

from hhrl_agents.networks.parameters import TINY, TINY_EVERY, Adam

PARTS = (slice(0, 5), slice(5, 12))
SEEDS, SIZE = 3, 12


def numbers(rng: np.random.Generator, scale: float = 1.0) -> Tensor:
    return torch.from_numpy(rng.normal(0.0, scale, (SEEDS, SIZE)).astype(np.float32))


def test_every_step_is_torch_s_with_each_part_of_each_seed_clipped() -> None:
    rng, max_norm = np.random.default_rng(0), 2.0
    parameters = numbers(rng)
    ours = Adam(parameters, PARTS, max_norm)
    alone = [[parameters[e, part].clone().requires_grad_() for part in PARTS] for e in range(SEEDS)]
    theirs = torch.optim.Adam([part for parts in alone for part in parts], lr=1.0)
    for step in range(250):
        gradient, rate = numbers(rng, scale=0.1 * 10 ** (step % 3)), 0.01 / (1 + step)
        for e, parts in enumerate(alone):
            for leaf, part in zip(parts, PARTS, strict=True):
                leaf.grad = gradient[e, part].clone()
                torch.nn.utils.clip_grad_norm_([leaf], max_norm)
        theirs.param_groups[0]["lr"] = rate
        theirs.step()
        ours.step(gradient, rate)
        for e, parts in enumerate(alone):
            expected = torch.cat(parts).detach()
            np.testing.assert_allclose(parameters[e], expected, rtol=1e-5, atol=1e-6)
            clipped = torch.cat([leaf.grad for leaf in parts if leaf.grad is not None])
            np.testing.assert_allclose(gradient[e], clipped, rtol=1e-5, atol=1e-7)


def test_a_seed_s_large_gradient_leaves_the_others_alone() -> None:
    gradient = torch.full((SEEDS, SIZE), 0.1)
    gradient[1, :5] = 100.0
    Adam(torch.zeros(SEEDS, SIZE), PARTS, max_norm=2.0).step(gradient, 0.1)
    assert gradient[1, :5].norm().item() == pytest.approx(2.0, rel=1e-5)
    assert (gradient[1, 5:] == torch.tensor(0.1)).all()
    assert (gradient[[0, 2]] == torch.tensor(0.1)).all()


def test_tiny_averages_become_zero_and_the_steps_stay_the_same() -> None:
    rng = np.random.default_rng(1)
    parameters, first = numbers(rng), numbers(rng)
    ours, leaf = Adam(parameters, [slice(0, SIZE)], max_norm=1e9), parameters.clone().requires_grad_()
    theirs = torch.optim.Adam([leaf], lr=0.01)
    for step in range(10 * TINY_EVERY + 1):
        gradient = first.clone() if step == 0 else torch.zeros_like(first)
        leaf.grad = gradient.clone()
        theirs.step()
        ours.step(gradient, 0.01)
    kept = theirs.state[leaf]["exp_avg"]
    assert ((kept != 0.0) & (kept.abs() < TINY)).any()
    assert not ours.mean.any()
    assert (ours.variance > 0.0).all()
    np.testing.assert_allclose(parameters, leaf.detach(), rtol=1e-6, atol=1e-6)


def test_averages_that_count_are_kept() -> None:
    ours = Adam(torch.zeros(1, 2), [slice(0, 2)], max_norm=1.0)
    ours.mean[:] = torch.tensor([[2.0 * TINY, 0.5 * TINY]])
    ours.step(torch.zeros(1, 2), 0.1)
    assert ours.mean[0, 0].item() == pytest.approx(1.8 * TINY)
    assert ours.mean[0, 1].item() == 0.0
