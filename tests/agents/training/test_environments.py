"""Environments of several agents against a simulator that is stepped by hand."""

from dataclasses import replace

import numpy as np
import pytest

from hhrl_agents import METHODS, RULES
from hhrl_agents.agent import NO_ACTION
from hhrl_agents.methods.method import Method
from hhrl_agents.policies.observation_memory import Traces
from hhrl_agents.replay.buffer import Transitions
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.environments import Environments
from hhrl_envs import InputError, Outcome, Simulator, get_scenario
from hhrl_envs.arrays import Flags
from hhrl_envs.simulation.rewards import TIMEOUT, UNSMOOTH

N_ENVS, STEPS = 12, 700
SLOTS = {"platoon-v0": (0, 1, 2, 3), "adversary-v0": (1,)}
EACH_SCENARIO = pytest.mark.parametrize("scenario", SLOTS)


def method() -> Method:
    base = METHODS["ddqn-plus"]
    return replace(base, config=replace(base.config, n_envs=N_ENVS))


def drivers_of(scenario: str) -> Drivers:
    if scenario == "platoon-v0":
        return Drivers(SLOTS[scenario])
    return Drivers(SLOTS[scenario], {0: RULES["rule-plus"](get_scenario(scenario))})


def made(scenario: str) -> Environments:
    return Environments(method(), get_scenario(scenario), np.arange(N_ENVS, dtype=np.uint64), drivers_of(scenario))


def driven(environments: Environments, steps: int = STEPS) -> list[tuple[Transitions, Flags]]:
    """Steps in which every vehicle drives at random, but for a brake now and then that lets some of them stop."""
    rng, played = np.random.default_rng(1), []
    for _ in range(steps):
        state = environments.features
        near = state[:, 9] * 64 < 4.0
        crowded = state[:, 6] * 64 < 2.0
        wild = rng.integers(0, 6, near.shape)
        careful = np.where(near | crowded, 1, 4)
        actions = np.where(rng.random(near.shape) < 0.15, wild, careful)
        played.append(environments.step(np.full_like(actions, -1), actions))
    return played


@EACH_SCENARIO
def test_transitions_are_those_of_the_worlds_driven_by_hand(scenario: str) -> None:
    environments, slots = made(scenario), SLOTS[scenario]
    config, drivers, rows = method().config, drivers_of(scenario), N_ENVS
    simulator = Simulator(scenario, rows, learned_fronts=1 if scenario == "adversary-v0" else 3)
    simulator.reset(np.arange(rows))
    traces = [Traces(config.memory) for _ in slots]
    seen = [
        trace.observe(simulator.of_agent(slot).observations.copy()) for trace, slot in zip(traces, slots, strict=True)
    ]
    ended, waits = np.zeros((rows, len(slots)), np.bool_), 0
    for step, over in driven(environments):
        given = step.actions.reshape(rows, len(slots))
        np.testing.assert_array_equal(given == NO_ACTION, ended)
        waits += int(ended.sum())
        actions = np.where(given == NO_ACTION, 0, given)
        ego = [] if slots[0] == 0 else [drivers.others[0].act(simulator.observations.copy()).action[:, None]]
        simulator.step(np.concatenate([*ego, actions], axis=1))
        before = ended
        ended = np.stack([simulator.of_agent(slot).outcomes != Outcome.RUNNING for slot in slots], axis=1)
        np.testing.assert_array_equal(over.reshape(rows, -1), ended)
        for k, slot in enumerate(slots):
            own, live = simulator.of_agent(slot), ~before[:, k]
            task = own.rewards - own.terms[:, TIMEOUT] - (1 - config.jerk_weight) * own.terms[:, UNSMOOTH]
            goes_on = (own.outcomes == Outcome.RUNNING) | (own.outcomes == Outcome.TIMEOUT)
            rewards = step.rewards.reshape(rows, len(slots), 2)[live, k]
            np.testing.assert_allclose(rewards, np.stack([task, task], 1)[live] * config.reward_scale, atol=1e-12)
            discounts = step.discounts.reshape(rows, -1)[live, k]
            np.testing.assert_array_equal(discounts, np.where(goes_on, config.gamma, 0.0)[live])
            np.testing.assert_array_equal(step.observations.reshape(rows, len(slots), -1)[:, k], seen[k])
            seen[k] = traces[k].observe(own.observations.copy())
            np.testing.assert_array_equal(step.next_observations.reshape(rows, len(slots), -1)[:, k], seen[k])
        begun: Flags = np.all(ended, axis=1, keepdims=False)
        simulator.next_episode(begun)
        for k, slot in enumerate(slots):
            traces[k].begin(begun)
            seen[k] = traces[k].observe(simulator.of_agent(slot).observations.copy(), begun)
        ended = ended & ~begun[:, None]
    assert waits > 0 or len(slots) == 1


@EACH_SCENARIO
def test_every_vehicle_s_episode_is_counted_once(scenario: str) -> None:
    environments = made(scenario)
    played = driven(environments)
    running = np.stack([step.actions != NO_ACTION for step, _ in played])
    ended = np.stack([over for _, over in played]) & running
    np.testing.assert_array_equal(environments.outcome_counts.sum(), ended.sum())
    assert environments.outcome_counts.sum() > 2 * environments.width
    environments.clear_counts()
    assert not environments.outcome_counts.any()


def test_environments_step_the_same_beside_others() -> None:
    alone, beside, other = (made("platoon-v0") for _ in range(3))
    rng = np.random.default_rng(0)
    choices = rng.integers(2, 6, (200, 2, alone.width))
    expected = [alone.step(actions, actions)[0] for actions, _ in choices]
    for (actions, others), step in zip(choices, expected, strict=True):
        other.step(others, others)
        for part, same in zip(beside.step(actions, actions)[0], step, strict=True):
            np.testing.assert_array_equal(part, same)


def test_worlds_of_another_shape_are_refused() -> None:
    with pytest.raises(InputError, match=r"world_seeds have shape \(1, 4\); write \(12,\)"):
        Environments(method(), get_scenario("stop-line-v0"), np.zeros((1, 4), np.uint64), EGO_ALONE)
