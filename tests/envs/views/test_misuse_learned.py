"""Every misuse of learned front vehicles and of continuous actions is one line that says what to write instead."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from hhrl_envs import Adversary, InputError, Outcome, Simulator, get_scenario, triad
from hhrl_envs.views.gym_env import StopLineEnv, StopLineVectorEnv
from hhrl_envs.views.parallel_env import EGO, StopLineParallelEnv
from hhrl_envs.worlds import platoon_v0
from support.misuse import refused

MAIN = get_scenario("stop-line-v0")
PEDALS: list[Any] = [
    np.nan, np.inf, -np.inf, 1.0000001, -1.5, 2, "0.5", True, None, {}, [], [0.1, 0.2], [[0.1, 0.2], 0.3], 2**70, 0.5j,
    np.array([np.nan], np.float32), np.array([-1.001]), np.array(["0.1"]),
]  # fmt: skip


@pytest.mark.parametrize("count", [-1, 5, 1.0, "2", True, np.nan], ids=repr)
def test_numbers_of_learned_fronts(count: Any) -> None:
    for make in (partial(StopLineParallelEnv, "stop-line-v0"), triad("stop-line-v0").env, triad(MAIN).raw_env):
        refused(partial(make, learned_fronts=count), f"learned_fronts is {count!r}; write ")
    if not isinstance(count, (float, str, bool)):
        refused(
            partial(Simulator, MAIN, 2, learned_fronts=count),
            "write an integer from 0 to 4 for scenario 'stop-line-v0'",
        )


@pytest.mark.parametrize("scenario_id", ["follow-v0", "solo-stop-v0"])
def test_scenarios_without_learned_fronts(scenario_id: str) -> None:
    said = f"learned_fronts is 1; write 0 for scenario '{scenario_id}': "
    refused(partial(StopLineParallelEnv, scenario_id, learned_fronts=1), said)
    refused(partial(Simulator, get_scenario(scenario_id), 3, learned_fronts=1), said)
    refused(partial(replace, get_scenario(scenario_id), learned_fronts=1), said)


def test_scenarios_that_contradict_themselves() -> None:
    for wrong in ({"learned_fronts": None}, {"learned_fronts": 2}, {"road": replace(MAIN.road, lines=(0.0, 60.0))}):
        refused(partial(replace, get_scenario("adversary-v0"), **wrong), "adversary is", "learned_fronts=1")
    for name in ("hardest_brake", "patience"):
        refused(partial(Adversary, **{name: -1.0}), f"{name} is -1.0; write ")


def test_front_vehicles_that_are_never_drawn_cannot_be_learned() -> None:
    seldom = replace(MAIN, traffic=replace(MAIN.traffic, count_shares=(0.5, 0.5, 0.0, 0.0)))
    refused(partial(Simulator, seldom, 2, learned_fronts=2), "learned_fronts is 2; write an integer from 0 to 1")
    simulator = Simulator(seldom, 40, learned_fronts=1)
    simulator.reset(np.arange(40))
    assert all(len(simulator.profiles(row)) == 1 for row in range(40))


@pytest.mark.parametrize("shape", [(3,), (2,), (3, 2), (2, 3), (3, 3, 1), (9,), ()], ids=str)
@pytest.mark.parametrize("kind", [np.int64, np.float64])
def test_shapes_of_actions_for_several_agents(shape: tuple[int, ...], kind: type) -> None:
    simulator = Simulator(MAIN, 3, learned_fronts=2)
    simulator.reset(np.arange(3))
    before = simulator.steps
    refused(
        lambda: simulator.step(np.zeros(shape, kind)),
        "actions are",
        "write integers (levels) or floats (m/s^2) of shape (3, 3)",
    )
    assert (simulator.steps == before).all()


@pytest.mark.parametrize("wrong", [6, -1, 2.5, -6.1, np.nan, np.inf])
def test_actions_of_one_agent_among_several(wrong: float) -> None:
    simulator, clean = (Simulator(MAIN, 130, learned_fronts=2) for _ in range(2))
    for each in (simulator, clean):
        each.reset(np.arange(130))
    actions = np.full((130, 3), 1 if isinstance(wrong, int) else 1.0)
    spoiled = actions.copy()
    spoiled[129, 2] = wrong
    refused(lambda: simulator.step(spoiled), f"{wrong}", "write")
    simulator.step(actions)
    clean.step(actions)
    assert simulator.arrays.all_observations.tobytes() == clean.arrays.all_observations.tobytes()


def test_actions_for_an_agent_that_is_missing_or_never_was_one() -> None:
    env = platoon_v0.parallel_env()
    env.reset(seed=3)
    everyone = dict.fromkeys(env.possible_agents, 5)
    while len(env.agents) == len(everyone):
        env.step(everyone)
    assert env.agents
    left = [agent for agent in everyone if agent not in env.agents]
    stranger = {**everyone, "front_9": 5}
    allowed = f"write a dict with one action for each of {env.agents}"
    before = env.state()
    refused(lambda: env.step(stranger), f"actions for {list(stranger)}", allowed)
    some = env.agents[1:]
    refused(lambda: env.step(dict.fromkeys([*some, left[0]], 5)), allowed)
    refused(lambda: env.step(dict.fromkeys(some, 5)), allowed)
    refused(lambda: env.step({}), allowed)
    assert (env.state() == before).all()
    refused(lambda: env.step(dict.fromkeys(env.agents, 17)), f"action of '{env.agents[0]}' is 17")


@pytest.mark.parametrize("action", PEDALS, ids=repr)
def test_continuous_actions(action: Any) -> None:
    parallel = StopLineParallelEnv(learned_fronts=1, continuous_actions=True)
    single, vector = StopLineEnv(continuous_actions=True), StopLineVectorEnv(2, continuous_actions=True)
    for env in (parallel, single, vector):
        env.reset(seed=1)
    allowed = "write one number from -1 (full brake) to 1 (full throttle)"
    refused(lambda: parallel.step({EGO: 0.5, "front_1": action}), f"action of 'front_1' is {action!r}", allowed)
    refused(lambda: single.step(action), f"action of 'ego' is {action!r}", allowed)
    refused(lambda: vector.step([[0.5], action]), "write ")  # type: ignore[arg-type]
    assert parallel.simulator.steps[0] == single.parallel.simulator.steps[0] == vector.simulator.steps[0] == 0


def test_a_batch_of_continuous_actions_has_one_column() -> None:
    vector = StopLineVectorEnv(2, continuous_actions=True)
    vector.reset(seed=1)
    for wrong in (np.zeros(2), np.zeros((2, 2)), np.zeros((1, 1)), np.zeros((2, 1), np.int64)):
        refused(partial(vector.step, wrong), "actions are", "write floats of shape (2, 1)")
    assert vector.step(np.full((2, 1), -1.0, np.float32))[4]["outcome"].tolist() == [Outcome.RUNNING] * 2


@pytest.mark.parametrize("view", [StopLineParallelEnv, StopLineEnv, StopLineVectorEnv])
def test_continuous_actions_are_wanted_or_not(view: Callable[..., object]) -> None:
    with pytest.raises(InputError, match="continuous_actions is 'no'"):
        view(continuous_actions="no")


def test_actions_of_agents_that_have_left_are_not_read() -> None:
    one, all_along = platoon_v0.parallel_env(), platoon_v0.parallel_env()
    for env in (one, all_along):
        env.reset(seed=3)
    steps = 0
    while one.agents:
        left = dict.fromkeys(set(one.possible_agents) - set(one.agents), "anything")
        action = 4 if steps % 7 else 1
        told = all_along.step({**dict.fromkeys(all_along.agents, action), **left})
        expected = one.step(dict.fromkeys(one.agents, action))
        assert told[1:4] == expected[1:4]
        assert all((told[0][agent] == expected[0][agent]).all() for agent in expected[0])
        steps += bool(left) + 1
    assert steps > one.simulator.steps[0], "nobody left before the others"
    refused(lambda: all_along.step({"ego": 0}), "the episode is over; call reset() first")
