"""Algorithm 3 as it reads beside the sum trees of the learner."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from hhrl_agents import METHODS
from hhrl_agents.reference.replay import HierarchicalReplay
from hhrl_agents.replay.hierarchical import PrioritisedSampler
from hhrl_agents.seeding import Purpose, generator

CAPACITY, STORED, BATCH = 200, 150, 16
LEVELS = ("option", "action")


@pytest.mark.parametrize("priority", ["clip", "shift"])
def test_draws_weights_and_priorities_are_those_of_the_sum_trees(priority: str) -> None:
    config = replace(METHODS["hybrid-hrl"].config, batch_size=BATCH, priority=priority)
    stream, copy = (generator(3, Purpose.REPLAY) for _ in range(2))
    trees = PrioritisedSampler(stream, len(LEVELS), CAPACITY, config, hierarchical=True)
    plain = HierarchicalReplay(CAPACITY, config)
    trees.added(np.arange(STORED))
    plain.added(torch.arange(STORED))
    rng, drawn = np.random.default_rng(0), set()
    for _ in range(30):
        draw = trees.draw(STORED)
        shares = torch.from_numpy((np.arange(BATCH) + copy.random((len(LEVELS), BATCH))) / BATCH)
        for level, share, first, weights in zip(LEVELS, shares, draw.firsts, draw.weights, strict=True):
            indices = plain.draw(level, share)
            assert np.array_equal(indices, draw.indices[first : first + BATCH])
            np.testing.assert_allclose(plain.weights(level, indices, STORED), weights, rtol=1e-5)
            drawn.add((level, *indices.tolist()))
        error_of = rng.normal(0.0, [[1.0], [3.0]], (len(LEVELS), CAPACITY))
        errors = error_of[:, draw.indices].astype(np.float32)  # a transition that is drawn twice errs alike
        trees.update(draw.indices, errors)
        own = {level: slice(first, first + BATCH) for level, first in zip(LEVELS, draw.firsts, strict=True)}
        drawn_by = {level: torch.from_numpy(draw.indices[part]) for level, part in own.items()}
        erred = {level: torch.from_numpy(row[own[level]]) for level, row in zip(LEVELS, errors, strict=True)}
        plain.update(drawn_by, erred)
    assert len(drawn) == 60
