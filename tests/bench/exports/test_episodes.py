"""Rows of episodes: what the simulator says of them, from fresh rollouts and from evidence alike."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pyarrow import parquet

from hhrl_bench import evaluate
from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.store import Store
from hhrl_bench.exports.episodes import TEXTS, Run, episode_columns, full_brake
from hhrl_bench.exports.export import entry_runs
from hhrl_bench.exports.files import to_csv, to_frame, to_parquet
from hhrl_bench.leaderboard.entry import read_entry
from hhrl_envs import Outcome, Scenario, Simulator, get_scenario
from support import small_board
from support.hidden import SLIPPERY
from support.own_scenarios import forgotten_scenarios

PAIRS = (("rule-2", "stop-line-v0"), ("ddqn", "stop-line-v0"), ("rule-2", "platoon-v0"), ("rule-2", "adversary-v0"))


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    with small_board.resamples(99):
        yield small_board.publish(tmp_path_factory.mktemp("board"), PAIRS)


def runs(agent: str, task: str, episodes: int = small_board.EPISODES) -> list[Run]:
    return evaluate(agent, task, episodes).exported()


@pytest.mark.parametrize("scenario", [get_scenario("stop-line-erratic-v0"), SLIPPERY], ids=lambda scenario: scenario.id)
def test_severity_is_what_the_simulator_says_by_hand(scenario: Scenario) -> None:
    with forgotten_scenarios():
        (run,) = evaluate("rule-1", scenario, 12).exported()
        columns = episode_columns([run])
    crossed = [index for index, cause in enumerate(columns["cause"]) if cause == "not_stop"]
    assert crossed
    first = np.cumsum(run.trace.steps) - run.trace.steps
    for index in crossed:
        simulator = Simulator(scenario, 1)
        simulator.reset([columns["world_seed"][index]])
        for action in run.trace.actions[first[index] : first[index] + run.trace.steps[index], 0]:
            simulator.step(np.array([action]))
        position, speed, _ = simulator.vehicles(0)[0]
        friction = columns["friction"][index]
        assert friction == simulator.friction[0]
        stops = position - simulator.lines[0] + speed**2 / (2.0 * full_brake(scenario, friction))
        assert columns["overrun"][index] == pytest.approx(stops)
        assert columns["overrun"][index] > 0.0
    others = [value for index, value in enumerate(columns["overrun"]) if index not in crossed]
    assert others == [None] * len(others)
    hit = [cause == "collision" for cause in columns["cause"]]
    assert [speed is not None for speed in columns["impact_speed"]] == hit


def test_a_row_has_the_drivers_in_front_and_both_seeds() -> None:
    columns = episode_columns(runs("hybrid-hrl", "stop-line-v0", 4))
    simulator = Simulator("stop-line-v0", 4)
    simulator.reset(columns["world_seed"][:4])
    for row in range(4):
        fronts = simulator.profiles(row)
        assert columns["fronts"][row] == len(fronts)
        assert columns["profiles"][row] == ("+".join(str(one["family"]) for one in fronts) or "none")
        assert columns["profile"][row] == (fronts[0]["family"] if fronts else "none")
        assert columns["style"][row] == (fronts[0]["style"] if fronts else None)
    assert columns["training_seed"] == [seed for seed in range(5) for _ in range(4)]
    assert columns["episode"] == [0, 1, 2, 3] * 5
    assert columns["feasible"] == [True] * 20
    assert columns["friction"] == [1.0] * 20


def test_vehicles_that_agents_drive_have_no_family() -> None:
    columns = episode_columns(runs("rule-2", "adversary-v0"))
    assert set(columns["profile"]) == {"agent"}
    assert columns["profiles"][0].startswith("agent")


@pytest.mark.parametrize(("agent", "task"), PAIRS)
def test_rows_of_an_entry_are_those_of_fresh_rollouts(published: Path, agent: str, task: str) -> None:
    kept = entry_runs(read_entry(published), Store(published.parent), agent, task)
    assert to_csv(episode_columns(kept)) == to_csv(episode_columns(runs(agent, task)))


def test_the_first_episodes_of_an_entry_are_taken(published: Path) -> None:
    few = entry_runs(read_entry(published), Store(published.parent), "rule-2", "stop-line-v0", 2)
    assert episode_columns(few) == episode_columns(runs("rule-2", "stop-line-v0", 2))


def test_an_entry_has_no_other_agents_and_no_more_episodes(published: Path) -> None:
    board, store = read_entry(published), Store(published.parent)
    with pytest.raises(RecordError, match="the entry has no rule-3 on stop-line-v0; it has rule-2 on stop-line-v0"):
        entry_runs(board, store, "rule-3", "stop-line-v0")
    with pytest.raises(RecordError, match="the entry has 6 episodes of stop-line-v0, not 7; ask for fewer"):
        entry_runs(board, store, "rule-2", "stop-line-v0", 7)


def test_decisions_that_end_otherwise_are_refused() -> None:
    (run,) = runs("rule-2", "stop-line-v0")
    wrong = run.outcome.copy()
    wrong[3] = Outcome.TIMEOUT
    with pytest.raises(RecordError, match="rule-2 on stop-line-v0: episode 3 does not end as its evidence says"):
        episode_columns([run._replace(outcome=wrong)])


def test_files_say_the_same_twice_and_in_every_format() -> None:
    columns = episode_columns(runs("hybrid-hrl", "stop-line-v0", 3) + runs("rule-2", "stop-line-v0", 3))
    assert to_csv(columns) == to_csv(columns)
    assert to_parquet(columns) == to_parquet(columns)
    rows = list(csv.DictReader(io.StringIO(to_csv(columns).decode())))
    table = parquet.read_table(io.BytesIO(to_parquet(columns))).to_pydict()
    frame = to_frame(columns)
    assert [*rows[0]] == [*table] == [*frame.columns] == [*columns]
    for name, values in columns.items():
        assert table[name] == values
        assert [None if row[name] == "" else row[name] for row in rows] == [
            None if value is None else str(value) for value in values
        ]
        known = frame[name].notna()
        assert known.tolist() == [value is not None for value in values]
        assert frame[name][known].tolist() == [value for value in values if value is not None]
        assert name in TEXTS or frame[name].dtype != object
