"""Agents made of torch modules."""

from typing import Any

import numpy as np
import pytest
import torch

from hhrl_agents import from_torch
from hhrl_envs import InputError

OBSERVATIONS = np.random.default_rng(0).normal(size=(5, 11)).astype(np.float32)


class Returning(torch.nn.Module):
    def __init__(self, answer: Any) -> None:
        super().__init__()
        self.answer = answer

    def forward(self, _: Any) -> Any:
        return self.answer


def test_a_module_takes_the_action_of_the_highest_value() -> None:
    module = torch.nn.Sequential(torch.nn.Linear(11, 6), torch.nn.Dropout(0.9))
    decision = from_torch(module, 6).act(OBSERVATIONS)
    assert not module.training
    assert decision.action.tolist() == module(torch.from_numpy(OBSERVATIONS)).argmax(1).tolist()
    assert decision.option.tolist() == [-1] * 5


def test_a_pair_is_options_and_actions() -> None:
    answer = (torch.eye(5)[:, :2], torch.arange(5))
    decision = from_torch(Returning(answer)).act(OBSERVATIONS)
    assert (decision.option.tolist(), decision.action.tolist()) == ([0, 1, 0, 0, 0], [0, 1, 2, 3, 4])


@pytest.mark.parametrize("answer", [torch.zeros(5, 3), torch.zeros(5), {"actions": 3}, None])
def test_other_answers_are_refused_in_one_line(answer: Any) -> None:
    with pytest.raises(InputError, match="let it return values of shape"):
        from_torch(Returning(answer), 6).act(OBSERVATIONS)
