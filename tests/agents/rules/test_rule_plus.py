from dataclasses import replace

import numpy as np
import pytest

from hhrl_agents import RULES, Agent
from hhrl_agents.rules.rule_plus import RulePlus
from hhrl_agents.rules.tuning import Tuning
from hhrl_envs import Option, Outcome, Scenario, Simulator, get_scenario
from hhrl_envs import observation as obs
from hhrl_envs.simulation.rewards import UNSAFE

MAIN = get_scenario("stop-line-v0")
ALONE = replace(MAIN, id="alone", traffic=replace(MAIN.traffic, count_shares=(1.0,)))
EPISODES = 500


def observation(**si: float) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    """An empty road 50 m before the line at 8 m/s, with the given elements changed."""
    usual = {"V_E": 8.0, "D_F": MAIN.sensor.front_range, "V_F": MAIN.road.speed_limit, "D_D": 50.0}
    row = np.zeros((1, obs.SIZE), np.float32)
    for name, value in (usual | si).items():
        row[0, getattr(obs, name)] = value
    return row * obs.SCALES


def accel(agent: Agent, **si: float) -> float:
    """The level that the agent chooses, as an acceleration."""
    return MAIN.vehicle.levels[int(agent.act(observation(**si)).action[0])]


def drive(agent: Agent, scenario: Scenario) -> tuple[Simulator, float, float]:
    """The simulator after one episode in each of `EPISODES` worlds, the mean return, the sum of unsafe terms."""
    simulator = Simulator(scenario, EPISODES)
    simulator.reset(np.arange(EPISODES) + 7_000)
    agent.reset(np.ones(EPISODES, np.bool_))
    total = unsafe = 0.0
    while (simulator.outcomes == Outcome.RUNNING).any():
        simulator.step(agent.act(simulator.observations).action)
        total += simulator.rewards.mean()
        unsafe += simulator.terms[:, UNSAFE].sum()
    return simulator, total, unsafe


@pytest.mark.parametrize(
    ("d_d", "d_f", "v_f", "option"),
    [(20.0, 90.0, 8.0, Option.SSL), (60.0, 12.0, 4.0, Option.FFV), (20.0, 12.0, 0.0, Option.FFV)],
)
def test_the_option_is_the_one_that_binds(d_d: float, d_f: float, v_f: float, option: Option) -> None:
    agent, seen = RulePlus(MAIN), observation(D_D=d_d, D_F=d_f, V_F=v_f)
    decision = agent.act(seen)
    actions = [int(agent.act_with_option(seen, np.full(1, each))[0]) for each in Option]
    assert decision.option == option
    assert decision.action == min(actions)


def test_it_looks_one_actuator_lag_ahead() -> None:
    agent = RulePlus(MAIN)
    assert accel(agent, D_D=18.0, A_E=2.0) < accel(agent, D_D=18.0, A_E=-3.0)
    assert accel(agent, D_F=18.0, V_F=8.0, A_F=-6.0) < accel(agent, D_F=18.0, V_F=8.0)


def test_a_longer_headway_brakes_earlier() -> None:
    near = {"D_F": 16.0, "V_F": 8.0}
    assert accel(RulePlus(MAIN, Tuning(headway=2.5)), **near) < accel(RulePlus(MAIN, Tuning(headway=0.8)), **near)


def test_it_is_a_strong_rule_on_the_main_task() -> None:
    simulator, gain, unsafe = drive(RulePlus(MAIN), MAIN)
    _, rival_gain, _ = drive(RULES["rule-4"](MAIN), MAIN)
    assert (simulator.outcomes == Outcome.SUCCESS).all()
    assert gain > rival_gain + 5.0
    assert unsafe == 0.0


def test_it_stops_alone_on_the_road() -> None:
    simulator, _, unsafe = drive(RulePlus(ALONE), ALONE)
    assert (simulator.outcomes == Outcome.SUCCESS).all()
    assert unsafe == 0.0
    assert RulePlus(ALONE).act(observation(D_F=1.0, V_F=0.0)).option == Option.SSL
