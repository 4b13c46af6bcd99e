"""Agents made of functions, and what outputs of networks choose."""

from typing import Any

import numpy as np
import pytest

from hhrl_agents import Agent, HierarchicalAgent, from_callable
from hhrl_agents.adapters.callables import choices
from hhrl_envs import InputError
from hhrl_envs.arrays import Flags

OBSERVATIONS = np.zeros((3, 11), np.float32)


def test_actions_alone_are_a_flat_decision() -> None:
    agent = from_callable(lambda observations: np.arange(len(observations)))
    agent.reset(np.ones(3, np.bool_))
    decision = agent.act(OBSERVATIONS)
    assert decision.option.tolist() == [-1, -1, -1]
    assert decision.action.tolist() == [0, 1, 2]
    assert isinstance(agent, Agent)
    assert not isinstance(agent, HierarchicalAgent)


def test_a_pair_is_a_hierarchical_decision_and_an_option_can_be_held() -> None:
    begun: list[Flags] = []
    agent = from_callable(lambda seen: ([1] * len(seen), [2] * len(seen)), lambda _, option: option + 3, begun.append)
    agent.reset(np.array([True, False, True]))
    decision = agent.act(OBSERVATIONS)
    assert (decision.option.tolist(), decision.action.tolist()) == ([1, 1, 1], [2, 2, 2])
    assert isinstance(agent, HierarchicalAgent)
    assert agent.act_with_option(OBSERVATIONS, np.array([0, 1, 0])).tolist() == [3, 4, 3]
    assert [mask.tolist() for mask in begun] == [[True, False, True]]


@pytest.mark.parametrize(
    ("output", "chosen"),
    [
        (np.array([[0.0, 1.0], [2.0, 2.0]]), [1, 0]),
        (np.array([3, 1], np.int32), [3, 1]),
        (np.array([[3], [1]]), [3, 1]),
    ],
)
def test_values_and_choices_are_read(output: Any, chosen: list[int]) -> None:
    assert choices(output, 2).tolist() == chosen


@pytest.mark.parametrize(
    "output", [np.zeros(2), np.zeros((2, 1)), np.zeros((3, 4)), np.zeros(3, np.int64), "no", None, np.zeros((2, 5))]
)
def test_other_outputs_are_refused_in_one_line(output: Any) -> None:
    with pytest.raises(InputError, match=r"let it return values of shape \(2, 4\), or integers of shape \(2,\)"):
        choices(output, 2, 4)
