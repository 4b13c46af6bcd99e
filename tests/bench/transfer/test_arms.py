"""The arms of a transfer, and where each makes sense."""

from typing import get_args

import pytest

from hhrl_agents import METHODS
from hhrl_agents.methods.method import Method
from hhrl_bench.tasks.tasks import TASKS, Task, get_task
from hhrl_bench.transfer.transfer import ARMS, CONTROL, ArmName, sensible_arms, target_method
from hhrl_envs import get_scenario

ALL = ("zero-shot", "frozen-action", "fine-tune", "scratch")
WHOLE = ("zero-shot", "fine-tune", "scratch")
LEARNED = [method for method in METHODS.values() if method.algorithm == "double-dqn"]


def test_every_arm_is_registered_under_its_own_name() -> None:
    assert tuple(ARMS) == tuple(arm.id for arm in ARMS.values()) == get_args(ArmName)
    assert set(ARMS[CONTROL].carries) == set(ARMS[CONTROL].fixed) == set()
    for arm in ARMS.values():
        assert set(arm.fixed) <= set(arm.carries) <= {"option", "action"}
        assert arm.summary


@pytest.mark.parametrize(
    ("method", "task", "arms"),
    [
        ("hybrid-hrl", "two-stops-v0", ALL),
        ("hrl-0", "red-light-v0", ALL),
        ("hybrid-hrl", "follow-v0", WHOLE),  # one option: none to learn anew
        ("hybrid-hrl", "solo-stop-v0", WHOLE),
        ("hybrid-hrl", "option-only-v0", WHOLE),  # the action level is given
        ("ddqn", "two-stops-v0", WHOLE),
        ("ddqn", "option-only-v0", ()),
        ("ddqn", "adversary-v0", ()),
        ("rule-option", "two-stops-v0", WHOLE),
        ("option-only", "two-stops-v0", WHOLE),
    ],
)
def test_arms_that_reuse_nothing_or_learn_nothing_make_no_sense(method: str, task: str, arms: tuple[str, ...]) -> None:
    assert tuple(arm.id for arm in sensible_arms(METHODS[method], get_task(task))) == arms


@pytest.mark.parametrize("task", TASKS.values(), ids=TASKS)
@pytest.mark.parametrize("method", LEARNED, ids=lambda method: method.id)
def test_every_sensible_arm_reuses_something_and_the_control_nothing(method: Method, task: Task) -> None:
    arms = sensible_arms(method, task)
    assert bool(arms) == (task.ego is None and (not task.given_actions or "option" in method.levels))
    for arm in arms:
        own = target_method(method, task, 1000)
        assert bool(set(arm.carries) & set(own.levels)) == (arm.id != CONTROL)
        assert set(own.levels) - set(arm.fixed)


def test_in_a_target_that_gives_actions_a_method_learns_options_alone() -> None:
    for name in ("hybrid-hrl", "hybrid-hrl-plus", "hrl-0"):
        method, target = METHODS[name], get_task("option-only-v0")
        own = target_method(method, target, 1000)
        assert own.levels == ("option",)
        assert own.config.memory == method.config.memory
        assert target_method(method, get_task("two-stops-v0"), 1000).levels == method.levels


def test_a_target_is_reported_on_often_whatever_its_budget() -> None:
    method = METHODS["ddqn"]
    for steps, every in ((1, 1), (10, 1), (2_000, 100), (100_000, 5_000)):
        assert target_method(method, get_task("two-stops-v0"), steps).config.report_every == every
    assert get_scenario("two-stops-v0").option_mask == (True, True)
