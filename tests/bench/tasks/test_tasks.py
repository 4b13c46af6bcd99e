"""Tasks follow the scenarios that are registered, at the time of the look-up."""

from dataclasses import replace

import pytest

from hhrl_bench.errors import UnknownTaskError
from hhrl_bench.tasks.tasks import TASKS, Task, get_task
from hhrl_envs import SCENARIOS

OWN = replace(SCENARIOS["stop-line-v0"], id="my-road-v0")


@pytest.fixture
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hhrl_bench.tasks.tasks.SCENARIOS", {**SCENARIOS, OWN.id: OWN})


@pytest.mark.usefixtures("registered")
def test_a_scenario_that_is_registered_later_is_a_task() -> None:
    assert get_task("my-road-v0") == TASKS["my-road-v0"] == Task("my-road-v0", "my-road-v0", env_steps=1_000_000)
    alone = [scenario.id for scenario in SCENARIOS.values() if not scenario.learned_fronts]
    assert list(TASKS) == [*alone, "my-road-v0", "option-only-v0", "platoon-v0", "adversary-v0"]
    assert len(TASKS) == len(SCENARIOS) + 2


def test_a_scenario_that_is_not_registered_is_none() -> None:
    assert "my-road-v0" not in TASKS
    with pytest.raises(UnknownTaskError, match="unknown task 'my-road-v0'; known tasks: stop-line-v0"):
        get_task("my-road-v0")
