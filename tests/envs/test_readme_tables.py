"""The tables of the environments' page say what the code says."""

import re
from pathlib import Path

import numpy as np
import pytest

from hhrl_envs import SCENARIOS, SUB_GOALS, Goal, Option, Outcome, Reward, Road, Scenario, Vehicle, observation
from hhrl_envs.scenario.profiles import PARAMETERS, ProfileFamily
from hhrl_envs.scenario.registry import SUMMARIES
from hhrl_envs.simulation import rewards, sub_goal_kernels
from hhrl_envs.simulation.engine import layout
from hhrl_envs.simulation.survey import feasible_share
from hhrl_envs.worlds.driver_families import HELD_OUT_FAMILIES, TRAIN_FAMILIES

PAGE = (Path(__file__).parents[2] / "environments" / "README.md").read_text()


def table(heading: str) -> list[list[str]]:
    """The rows of the first table under a heading, header first and without the rule below it."""
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    rows = re.findall(r"^\| (.*) \|$", section, re.MULTILINE)
    return [[cell.strip() for cell in row.split(" | ")] for row in rows]


def span(families: tuple[ProfileFamily, ...], name: str) -> str:
    low = min(getattr(family, name)[0] for family in families)
    high = max(getattr(family, name)[1] for family in families)
    return f"{low:g} to {high:g}" if low < high else f"{low:g}"


def number(text: str) -> float:
    top, _, bottom = text.partition("/")
    return float(top) / float(bottom or 1)


def test_observation_table() -> None:
    header, *rows = table("What an agent sees")
    assert header == ["index", "symbol", "unit", "scale", "clip", "meaning"]
    assert [int(row[0]) for row in rows] == list(range(observation.SIZE))
    assert tuple(row[1] for row in rows) == observation.SYMBOLS
    assert tuple(row[2] for row in rows) == observation.UNITS
    assert np.array_equal([number(row[3]) for row in rows], observation.SCALES)
    assert [(row[4], row[5]) for row in rows] == [(element.clip, element.meaning) for element in observation.ELEMENTS]
    ratios = [rows[observation.place(goal.ratio)][4] for goal in SUB_GOALS]
    assert ratios == [f"[{sub_goal_kernels.RATIO_LOW:g}, {sub_goal_kernels.RATIO_HIGH:g}]"] * len(SUB_GOALS)
    assert f"floored at {sub_goal_kernels.MIN_STOPPING_DISTANCE:g} m" in rows[observation.DC_RATIO][5]
    assert f"a_max is {Vehicle().max_decel:g} m/s^2 and d_0 is {Reward().safe_gap:g} m." in PAGE


def test_observation_docstring_holds_the_same_table() -> None:
    lines = [f"| {' | '.join(row)} |" for row in table("What an agent sees")]
    assert all(line in str(observation.__doc__) for line in lines)


def test_action_table() -> None:
    actions, levels = table("What an agent does")
    assert [int(cell) for cell in actions[1:]] == list(range(len(Vehicle().levels)))
    assert tuple(float(cell) for cell in levels[1:]) == Vehicle().levels
    assert f"tau of {Vehicle().lag:g} s, a jerk of at most j_max = {Vehicle().jerk_limit:g} m/s^3" in PAGE


def test_reward_table() -> None:
    _, *rows = table("What it earns")
    reward = Reward()
    assert [row[0] for row in rows] == [str(column) for column in range(layout.TERMS_SIZE)]
    assert tuple(row[1] for row in rows) == rewards.TERMS
    failures = [(goal.failure.name, f"the failure of {goal.spelling}") for goal in SUB_GOALS]
    assert [(rows[column][1], rows[column][3].split(", ")[1]) for column in rewards.FAILURE] == failures
    sigmas = ", ".join(f"{getattr(reward, f'sigma_{i}'):g}" for i in range(1, 5))
    assert f"sigma = ({sigmas})" in PAGE
    assert rows[rewards.UNSMOOTH][3] == f"abs(j_e) > {reward.jerk_threshold:g} m/s^3"
    floor = f"{sub_goal_kernels.MIN_STOPPING_DISTANCE:g} m"
    assert (
        rows[rewards.UNSAFE[Option.SSL]][2] == f"-exp(min(-d_dc/max(d_ds, {floor}), {-sub_goal_kernels.RATIO_LOW:g}))"
    )
    assert f"the exponent is bounded at {rewards.MOST:g} alone" in PAGE
    assert rows[rewards.TIMEOUT][2] == f"-{reward.timeout_scale:g} d_d^2"


def test_outcome_table() -> None:
    _, *rows = table("How an episode ends")
    assert [(int(row[0]), row[1]) for row in rows] == [(int(outcome), outcome.name) for outcome in Outcome]
    assert [row[1] for row in rows if row[2] == "is truncated"] == ["TIMEOUT"]
    assert f"(v_e < {Road().stop_speed:g} m/s) within {Road().stop_zone:g} m before" in PAGE


def test_profile_table() -> None:
    _, *rows = table("How front vehicles drive")
    expected = [
        [name, unit, span(TRAIN_FAMILIES, name), span(HELD_OUT_FAMILIES, name)] for name, unit in PARAMETERS.items()
    ]
    assert [row[:4] for row in rows] == expected


def facts(scenario: Scenario) -> list[str]:
    counts = np.flatnonzero(scenario.traffic.count_shares)
    fronts = f"{counts[0]} to {counts[-1]}" if len(counts) > 1 else str(counts[0])
    seconds = f"{scenario.horizon * scenario.dt:g}"
    feasible = f"{feasible_share(scenario):.2%}"
    return [scenario.id, Goal(scenario.goal).name.lower(), fronts, str(len(scenario.road.lines)), seconds, feasible]


@pytest.mark.parametrize("scenario_id", SCENARIOS)
def test_scenario_table_has_a_row_for_every_scenario(scenario_id: str) -> None:
    rows = {row[0]: row for row in table("Scenarios")[1:]}
    assert rows.get(scenario_id, [])[:6] == facts(SCENARIOS[scenario_id])
    assert rows[scenario_id][6] == SUMMARIES[scenario_id]


def test_scenario_table_has_no_other_rows() -> None:
    assert [row[0] for row in table("Scenarios")[1:]] == list(SCENARIOS)
