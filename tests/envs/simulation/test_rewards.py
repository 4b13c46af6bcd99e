"""Both readings of the unsafe terms: the one with a floor, which is built, and the printed one."""

import hashlib
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from hhrl_envs import Outcome, Reward, Scenario, Simulator, Vehicle, get_scenario, observation
from hhrl_envs.arrays import Floats
from hhrl_envs.simulation.constants import pack
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.compilation import kernel, unsigned
from hhrl_envs.simulation.rewards import MOST, TIME, TIMEOUT, UNSAFE, printed_exp, reward_as_read, unsafe_exp
from hhrl_envs.simulation.sensing import derive
from hhrl_envs.simulation.simulator import Results
from hhrl_envs.sub_goals import Option
from support.driving import traffic_actions
from support.reference import Facts, distances, rewards, unsafe_terms

MAIN = get_scenario("stop-line-v0")
Reading = Literal["floored", "printed"]
READINGS: tuple[Reading, ...] = ("floored", "printed")
EACH_READING = pytest.mark.parametrize("reading", READINGS)
CLOSE: dict[str, Any] = {"rtol": 1e-11, "atol": 1e-11}


def read(scenario: Scenario, reading: Reading) -> Scenario:
    """The scenario with this reading of the unsafe terms."""
    return replace(scenario, reward=replace(scenario.reward, unsafe=reading))


@kernel
def earn(m: Floats, c: Floats) -> None:
    """Write all that the agent in lane 0 of the record ``m`` earns for what it measures, and what follows from that."""
    derive(m, unsigned(0), c)
    reward_as_read(m, unsigned(0), c, unsigned(1))


def earned(scenario: Scenario, facts: Facts) -> Floats:
    """What an agent earns in a step that begins while it is running: the fields of its record, float64 [field]."""
    m = np.zeros(int(at.VEHICLE))
    measured = {"v_e": facts.v_e, "j_e": facts.j_e, "d_d": facts.d_d, "d_f": facts.d_f, "v_f": facts.v_f}
    for symbol, value in measured.items():
        m[at.measured(symbol)] = value
    m[at.LIVE], m[at.FRESH] = 1.0, float(facts.outcome)
    earn(m, pack(scenario))
    return m[:: at.STRIDE]


def of(fields: Floats, place: int) -> float:
    return float(fields[at.count_fields(place)])


SPEEDS = st.one_of(
    st.floats(0.0, 12.0), st.floats(0.0, 0.5), st.floats(0.0, 100.0), st.sampled_from([0.0, 5e-324, 1e-9])
)
TO_LINE = st.one_of(st.floats(-0.5, 0.5), st.floats(-20.0, 100.0), st.sampled_from([0.0, -0.0, -5e-324, -1e-12]))
GAPS = st.one_of(st.floats(0.0, 100.0), st.just(0.0))
ENDINGS = st.sampled_from([Outcome.RUNNING, Outcome.NOT_STOP, Outcome.COLLISION, Outcome.SUCCESS, Outcome.TIMEOUT])
FACTS = st.builds(Facts, v_e=SPEEDS, j_e=st.floats(-60.0, 60.0), d_d=TO_LINE, d_f=GAPS, v_f=SPEEDS, outcome=ENDINGS)


@EACH_READING
@settings(max_examples=400, deadline=None)
@given(facts=FACTS, max_decel=st.floats(0.1, 100.0), safe_gap=st.floats(0.1, 50.0))
def test_rewards_are_those_of_the_equations(reading: Reading, facts: Facts, max_decel: float, safe_gap: float) -> None:
    scenario = replace(
        MAIN,
        reward=Reward(safe_gap=safe_gap, unsafe=reading),
        vehicle=Vehicle(max_decel=max_decel),
        feasible_only=False,
    )
    fields, (task, option, action) = earned(scenario, facts), rewards(facts, scenario)
    terms = [-of(fields, at.UNSAFE[k]) for k in Option]
    np.testing.assert_allclose(terms, unsafe_terms(distances(facts, scenario), reading), **CLOSE)
    np.testing.assert_allclose(of(fields, at.TASK), task, **CLOSE)
    np.testing.assert_allclose([of(fields, at.OPTION[k]) for k in Option], option, **CLOSE)
    np.testing.assert_allclose([of(fields, at.ACTION[k]) for k in Option], action, **CLOSE)
    assert np.isfinite(fields).all()
    sr = sum(of(fields, place) for place in (at.TIME, at.TIMEOUT, at.SUCCESS))
    for k in Option:
        np.testing.assert_allclose(of(fields, at.OPTION[k]) + of(fields, at.ACTION[k]) - sr, task, **CLOSE)


@pytest.mark.parametrize(
    ("speed", "d_d", "floored", "printed"),
    [
        (6.0, 1.5, np.exp(0.5), np.exp(0.5)),  # d_ds is 3 m: both are the printed term
        (1.2, 0.06, np.exp(0.12), np.exp(0.5)),  # d_ds is 0.12 m, less than the floor
        (1e-9, 0.0, 1.0, np.e),
        (6.0, -3.0, np.e, np.exp(2.0)),  # past the line the floor does not bind, the bound does
        (0.6, -0.03, np.exp(0.12), np.exp(2.0)),
        (0.0, -0.03, np.exp(0.06), np.exp(32.0)),  # d_ds is 0
        (0.0, 0.0, 0.0, 0.0),
    ],
)
def test_where_the_readings_differ(speed: float, d_d: float, floored: float, printed: float) -> None:
    facts = Facts(speed, 0.0, d_d, 50.0, 5.0, Outcome.RUNNING)
    terms = [-of(earned(read(MAIN, reading), facts), at.UNSAFE[Option.SSL]) for reading in READINGS]
    np.testing.assert_allclose(terms, [floored, printed], rtol=1e-9)


@kernel
def exps(x: Floats) -> Floats:
    """Both exponentials, float64 [2, n]."""
    both = np.empty((2, x.size))
    for place in range(x.size):
        both[0, place], both[1, place] = unsafe_exp(x[place]), printed_exp(x[place])
    return both


def test_the_exponentials_are_exact_to_the_last_bits() -> None:
    x = np.linspace(0.0, 1.0, 2001)
    short, long = exps(x)
    np.testing.assert_allclose(short, np.exp(x), rtol=2e-15)
    assert long.tobytes() == short.tobytes()
    x = np.linspace(1.0, MOST, 62_001)
    np.testing.assert_allclose(exps(x)[1], np.exp(x), rtol=1e-13)
    assert np.isfinite(np.float32(exps(np.array([MOST]))[1, 0]) ** 2)


def test_the_exponentials_are_the_same_bits_everywhere() -> None:
    found = hashlib.sha256(exps(np.arange(8193) / 256.0)[1].tobytes()).hexdigest()
    assert found == "d01f0bca2c7223195e09cee83c61b27d9b8d2e58745d89f5960768a5416d55a5"


def arrays(results: Results) -> list[NDArray[Any]]:
    return list(results._asdict().values())


@pytest.mark.parametrize(("scenario_id", "fronts"), [("stop-line-wet-v0", 0), ("stop-line-v0", 2), ("two-stops-v0", 0)])
def test_a_row_alone_earns_the_same_bits(scenario_id: str, fronts: int) -> None:
    scenario, rows = read(get_scenario(scenario_id), "printed"), at.LANES + 3
    together = Simulator(scenario, rows, learned_fronts=fronts)
    alone = {row: Simulator(scenario, 1, learned_fronts=fronts) for row in (0, 100, rows - 1)}
    together.reset(np.arange(rows))
    for row, one in alone.items():
        one.reset([row])
    for chosen in traffic_actions(together, 3, 150):
        actions = chosen if fronts else chosen[:, 0]
        together.step(actions, autoreset=True)
        for row, one in alone.items():
            one.step(actions[row : row + 1], autoreset=True)
            for agent in range(1 + fronts):
                whole, single = together.of_agent(agent), one.of_agent(agent)
                assert [array[row].tobytes() for array in arrays(whole)] == [
                    array[0].tobytes() for array in arrays(single)
                ]


@pytest.mark.parametrize(("scenario_id", "fronts"), [("stop-line-v0", 0), ("stop-line-wet-v0", 2), ("red-light-v0", 0)])
def test_a_reading_changes_the_terms_of_the_line_alone(scenario_id: str, fronts: int) -> None:
    rows, changed = 400, 0
    floored, printed = (
        Simulator(read(get_scenario(scenario_id), one), rows, learned_fronts=fronts) for one in READINGS
    )
    floored.reset(np.arange(rows))
    printed.reset(np.arange(rows))
    for chosen in traffic_actions(floored, 5, 250):
        actions = chosen if fronts else chosen[:, 0]
        floored.step(actions, autoreset=True)
        printed.step(actions, autoreset=True)
        for agent in range(1 + fronts):
            ours, theirs = floored.of_agent(agent), printed.of_agent(agent)
            assert ours.observations.tobytes() == theirs.observations.tobytes()
            assert ours.outcomes.tobytes() == theirs.outcomes.tobytes()
            differ = ours.terms != theirs.terms
            assert not np.delete(differ, UNSAFE[Option.SSL], axis=1).any()
            si = observation.to_si(ours.observations)
            slow, past = si[:, observation.V_E] < np.sqrt(2.0 * 6.0 * 0.5) + 1e-5, si[:, observation.D_D] < 0.0
            assert (slow | past)[differ[:, UNSAFE[Option.SSL]]].all()
            sr = theirs.terms[:, [TIME, TIMEOUT, TIMEOUT + 1]].sum(axis=1)
            both = theirs.reward_option + theirs.reward_action - sr[:, None]
            np.testing.assert_allclose(both, theirs.rewards[:, None].repeat(2, axis=1), **CLOSE)
            changed += differ.sum()
    assert changed > 10
