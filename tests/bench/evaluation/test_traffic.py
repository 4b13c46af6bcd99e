"""Worlds of several agents: who drives, what counts as success, what is counted besides."""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("torch")

from hhrl_agents import RULES
from hhrl_agents.policies import checkpoints
from hhrl_agents.training.drivers import Drivers
from hhrl_bench import evaluate
from hhrl_bench.errors import UnknownTaskError
from hhrl_bench.evaluation.episodes import TrafficRecords
from hhrl_bench.evaluation.loading import load_agent
from hhrl_bench.evaluation.paired_evaluation import evaluation_drivers, load_opponent, play, training_drivers
from hhrl_bench.evaluation.records import EvaluationRecord
from hhrl_bench.evaluation.results import count_traffic, summarise_traffic
from hhrl_bench.figures.watch import record
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.tasks.tasks import SCRIPTED, get_task
from hhrl_bench.training.train import Plan, get_method, train
from hhrl_envs import Outcome, Simulator, get_scenario
from support.command_line import invoke
from support.small_training import small_methods

PLATOON, ADVERSARY = get_task("platoon-v0"), get_task("adversary-v0")
EPISODES = 40


def traffic_records(agent: str, task: str, opponent: str | None = None) -> TrafficRecords:
    chosen = get_task(task).against(opponent)
    records = evaluate(load_agent(agent, chosen), chosen, EPISODES).records
    assert isinstance(records, TrafficRecords)
    return records


def test_who_drives_says_the_task() -> None:
    assert evaluation_drivers(PLATOON) == training_drivers(PLATOON) == Drivers((0, 1, 2, 3))
    assert evaluation_drivers(get_task("stop-line-v0")) == training_drivers(get_task("stop-line-v0")) == Drivers()
    scored, learned = evaluation_drivers(ADVERSARY), training_drivers(ADVERSARY)
    assert (scored.slots, [*scored.others], learned.slots, [*learned.others]) == ((0,), [1], (1,), [0])
    assert evaluation_drivers(ADVERSARY.against(SCRIPTED)) == Drivers()
    assert load_opponent(ADVERSARY.against(SCRIPTED)) is None


def test_a_shared_policy_succeeds_where_every_vehicle_does() -> None:
    records = traffic_records("rule-4", "platoon-v0")
    simulator, rule = Simulator("platoon-v0", EPISODES, learned_fronts=3), RULES["rule-4"](get_scenario("platoon-v0"))
    simulator.reset(PLATOON.test.take(EPISODES))
    returns = np.zeros(EPISODES)
    while (simulator.agent_outcomes == Outcome.RUNNING).any():
        seen = [simulator.of_agent(agent).observations for agent in range(4)]
        simulator.step(np.stack([rule.act(own).action for own in seen], axis=1))
        returns += simulator.rewards
    np.testing.assert_array_equal(records.outcomes, simulator.agent_outcomes)
    np.testing.assert_array_equal(records.steps, simulator.steps)
    np.testing.assert_allclose(records.return_task, returns, atol=1e-9)
    stopped = (records.outcomes == Outcome.SUCCESS).all(axis=1)
    np.testing.assert_array_equal(records.outcome == Outcome.SUCCESS, stopped)
    assert stopped.any()


def test_the_worst_outcome_of_the_vehicles_counts() -> None:
    """Everybody always follows: nobody stops at the line, and some collide."""
    records = traffic_records("rule-1", "platoon-v0")
    collided = (records.outcomes == Outcome.COLLISION).any(axis=1)
    crossed = (records.outcomes == Outcome.NOT_STOP).any(axis=1)
    np.testing.assert_array_equal(records.outcome == Outcome.COLLISION, collided)
    np.testing.assert_array_equal(records.outcome == Outcome.NOT_STOP, crossed & ~collided)
    assert (crossed & ~collided).any()


def test_an_opponent_drives_the_front_vehicle_of_the_same_worlds() -> None:
    careful, slow = (traffic_records("rule-plus", "adversary-v0", opponent) for opponent in ("rule-4", "rule-2"))
    np.testing.assert_array_equal(careful.seed, slow.seed)
    assert careful.outcomes.shape == (EPISODES, 2)
    assert not np.array_equal(careful.steps, slow.steps)
    scripted = traffic_records("rule-plus", "adversary-v0", SCRIPTED)
    assert scripted.outcomes.shape == (EPISODES, 1)
    assert scripted.feasible.all()


def test_counts_and_shares_are_those_of_the_records() -> None:
    records = traffic_records("rule-3", "adversary-v0", "rule-1")
    counts, share = count_traffic(records), summarise_traffic([records])
    assert counts is not None
    assert share is not None
    stopped = records.outcome == Outcome.SUCCESS
    assert (counts.feasible, counts.success_feasible) == (records.feasible.sum(), (stopped & records.feasible).sum())
    assert [sum(own.values()) for own in counts.vehicles] == [EPISODES] * 2
    assert counts.vehicles[0].get("success", 0) == stopped.sum()
    assert share.feasible.mean == counts.feasible / EPISODES
    assert share.success_feasible.mean == pytest.approx(counts.success_feasible / counts.feasible)
    assert (share.feasible.n, share.success_feasible.n) == (EPISODES, counts.feasible)


def test_nothing_is_counted_where_the_ego_is_alone_and_nothing_feasible_is_null() -> None:
    alone = evaluate("rule-4", "stop-line-v0", 5).records
    assert count_traffic(alone) is None
    assert summarise_traffic([alone]) is None
    records = traffic_records("rule-4", "adversary-v0", "rule-1")
    records.feasible[:] = False
    share = summarise_traffic([records])
    assert share is not None
    assert (share.feasible.mean, share.success_feasible.mean) == (0.0, None)


@pytest.mark.parametrize("task", ["platoon-v0", "adversary-v0"])
def test_a_film_shows_the_evaluated_episode(task: str) -> None:
    agent, chosen, index = load_agent("rule-4", task), get_task(task), 3
    snapshots = record(agent, chosen, index)
    records = evaluate(agent, chosen, 10).records
    assert isinstance(records, TrafficRecords)
    assert snapshots[-1].outcome == records.outcomes[index, 0]
    assert len(snapshots) - 1 == records.steps[index]
    assert snapshots[0].agents == records.outcomes.shape[1]


def test_an_analysis_is_of_the_ego_alone() -> None:
    line = invoke("analyse", "rule-4", "--task", "platoon-v0").stderr
    assert "platoon-v0 has several agents; analyse one in a task of the ego alone" in line
    assert issubclass(UnknownTaskError, ValueError)


@pytest.mark.parametrize("task", [PLATOON, ADVERSARY], ids=lambda task: task.id)
def test_a_training_validates_in_the_cast_it_trains_in(task: object, tmp_path: Path) -> None:
    assert task in (PLATOON, ADVERSARY)
    chosen = PLATOON if task == PLATOON else ADVERSARY
    with small_methods():
        *_, last = train(Plan(get_method("ddqn"), chosen, (0,), 600, tmp_path))
    final = checkpoints.load(tmp_path / "seed-0.final.safetensors")
    worlds = chosen.validation.take(16)
    again = play(final, get_scenario(chosen.scenario), worlds, rows=16, drivers=training_drivers(chosen)).records
    assert last.success == ((again.outcome == Outcome.SUCCESS).mean(),)
    assert json.loads((tmp_path / "config.json").read_text()).get("ego") == chosen.ego


def test_the_command_line_scores_against_an_opponent() -> None:
    done = invoke("evaluate", "rule-4", "--task", "adversary-v0", "--opponent", "rule-1", "--episodes", "20", "--json")
    record = EvaluationRecord.model_validate_json(done.stdout)
    assert record.task.opponent is not None
    assert record.task.opponent.agent == "rule-1"
    assert record.provenance.command.endswith("--opponent rule-1")
    assert record.results[0].traffic is not None
    table = invoke("evaluate", "rule-4", "--task", "adversary-v0", "--opponent", "rule-1", "--episodes", "20").stdout
    assert "The front vehicle is driven by rule-1." in table
    assert "of the episodes were feasible, and" in table
    alone = invoke("evaluate", "rule-4", "--task", "adversary-v0", "--opponent", "scripted", "--episodes", "20").stdout
    assert "The front vehicle is scripted." in alone
    shared = invoke("evaluate", "rule-4", "--task", "platoon-v0", "--episodes", "20", "--json")
    assert EvaluationRecord.model_validate_json(shared.stdout).task.shared
    refused = invoke("evaluate", "rule-4", "--opponent", "rule-1")
    assert (refused.exit_code, "stop-line-v0 has no opponent" in refused.stderr) == (2, True)


def test_robustness_is_a_row_an_agent_or_a_leaderboard() -> None:
    board = LeaderboardRecord.model_validate_json(
        invoke("robustness", "rule-4", "rule-1", "--episodes", "20", "--json").stdout
    )
    assert [task.id for task in board.tasks] == ["stop-line-v0", "stop-line-heldout-v0", "adversary-v0"]
    assert {(result.agent, result.task) for result in board.results} == {
        (agent, task.id) for agent in ("rule-4", "rule-1") for task in board.tasks
    }
    opponent = board.tasks[2].opponent
    assert opponent is not None
    assert opponent.checkpoint_sha256 is not None
    printed = invoke("robustness", "rule-4", "--episodes", "20").stdout
    assert "feasible" in printed
    assert "behind adversary" in printed
