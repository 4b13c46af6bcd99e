"""Seeds of an entry, trained again from what it says of them, leave the same checkpoints, or are named."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from hhrl_bench.evaluation.records import RunRecord
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.suites.study import suite_study
from hhrl_bench.suites.suites import Suite, TrainingSuite, TransferSuite
from hhrl_bench.tasks.tasks import TASKS
from hhrl_bench.training.train import Plan, Report
from hhrl_bench.verification import retrained
from hhrl_bench.verification.retrained import retrain, trained_seeds
from hhrl_bench.verification.verify import verify
from support.small_training import STEPS, small_methods

SEEDS = (0, 1)
TRAININGS = TrainingSuite("tiny", (("ddqn", "stop-line-v0"), ("hybrid-hrl", "stop-line-v0")), SEEDS, 5)
REUSE = TransferSuite("moved", ("hybrid-hrl",), "stop-line-v0", ("stop-line-wet-v0", "option-only-v0"), (0,), 200, 5)


@pytest.fixture(scope="module", autouse=True)
def small() -> Iterator[None]:
    with small_methods() as patch:
        patch.setattr("hhrl_bench.transfer.transfer.REPORTS", 2)
        patch.setattr(
            "hhrl_bench.tasks.tasks.TASKS", {name: replace(task, env_steps=STEPS) for name, task in TASKS.items()}
        )
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("suites")


def board_of(suite: Suite, folder: Path) -> LeaderboardRecord:
    study = suite_study(suite, folder)
    return study.leaderboard(list(study.run()))


@pytest.fixture(scope="module")
def board(folder: Path) -> LeaderboardRecord:
    return board_of(TRAININGS, folder)


def with_run(board: LeaderboardRecord, result: int, number: int, run: RunRecord) -> LeaderboardRecord:
    """Return the entry with another run."""
    runs = [*board.results[result].runs]
    runs[number] = run
    results = [*board.results]
    results[result] = results[result].model_copy(update={"runs": tuple(runs)})
    return board.model_copy(update={"results": tuple(results)})


def test_the_seeds_of_an_entry_leave_the_same_checkpoints(board: LeaderboardRecord, folder: Path) -> None:
    assert len(trained_seeds(board)) == 4
    heard: list[tuple[int, int, str]] = []
    assert list(retrain(board, Store(folder), lambda *said: heard.append(said))) == []
    assert [(done, total) for done, total, _ in heard if done == total] == [(STEPS, STEPS)] * 4
    assert heard[-1][2].startswith("train hybrid-hrl on stop-line-v0, seed 1: validation success ")
    assert list(verify(board, Store(folder), Level.RETRAINED, sample=1)) == []


def test_every_trained_arm_of_a_transfer_is_trained_again_and_its_source_before_it(tmp_path: Path) -> None:
    moved = board_of(REUSE, tmp_path)
    arms = [one.training.arm for one in trained_seeds(moved)]
    assert arms == [None, "zero-shot", "frozen-action", "fine-tune", "scratch", "zero-shot", "fine-tune", "scratch"]
    assert list(retrain(moved, Store(tmp_path))) == []
    sourceless = moved.model_copy(update={"results": moved.results[1:]})
    said = {finding.place: finding.said for finding in retrain(sourceless, Store(tmp_path))}
    assert list(said) == [f"results[{arm}].runs[0]" for arm in (0, 1, 2, 4, 5)]
    assert all("is not among the results" in problem for problem in said.values())


def test_another_checkpoint_or_another_training_is_found(board: LeaderboardRecord, folder: Path) -> None:
    run = board.results[1].runs[1]
    assert run.training is not None
    other = with_run(board, 1, 1, run.model_copy(update={"checkpoint_sha256": "0" * 64}))
    (finding,) = retrain(other, Store(folder))
    assert finding.place == "results[1].runs[1].checkpoint_sha256"
    assert finding.said == f"trained again, seed 1 leaves {run.checkpoint_sha256}"
    for change, problem in (
        ({"seed": 7}, "trained again, seed 7 leaves"),
        ({"budget": STEPS // 2}, "trained again, seed 1 leaves"),
        ({"config_hash": "other"}, "cannot be trained again: this version's hybrid-hrl has other settings"),
        ({"method": "unheard-of"}, "cannot be trained again: unknown method 'unheard-of'"),
        ({"task": "unheard-of"}, "cannot be trained again: unknown task 'unheard-of'"),
    ):
        changed = run.model_copy(update={"training": run.training.model_copy(update=dict(change))})
        (finding,) = retrain(with_run(board, 1, 1, changed), Store(folder))
        assert finding.place.startswith("results[1].runs[1]")
        assert finding.said.startswith(problem)


def test_a_curve_is_held_to_its_training_whatever_else_was_scored_of_it(board: LeaderboardRecord, folder: Path) -> None:
    first = board.results[0]
    copied = first.model_copy(update={"agent": "copy"})
    curve = board.trainings[0]
    rates = (tuple(1.0 - (rate or 0.0) for rate in curve.testing.success[0]), *curve.testing.success[1:])
    forged = curve.model_copy(update={"testing": curve.testing.model_copy(update={"success": rates})})
    other = board.model_copy(update={"results": (copied, first), "trainings": (forged,)})
    assert [one.result for one in trained_seeds(other)] == [0, 0]
    assert "trainings[0].testing.success[0]" in next(iter(retrain(other, Store(folder)))).place


def test_what_a_training_says_of_itself_is_what_it_says_again(tmp_path: Path) -> None:
    moved = board_of(REUSE, tmp_path)
    for index, change in ((0, {"env_steps": 16}), (3, {"command": "hhrl-bench train hybrid-hrl"})):
        run = moved.results[index].runs[0]
        assert run.training is not None
        changed = with_run(moved, index, 0, run.model_copy(update={"training": run.training.model_copy(update=change)}))
        places = [finding.place for finding in retrain(changed, Store(tmp_path))]
        assert places == [f"results[{index}].runs[0].training.{next(iter(change))}"]


def test_what_is_not_exact_is_left_out(board: LeaderboardRecord, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = board.results[1].runs[1]
    assert run.training is not None
    inexact = run.model_copy(update={"training": run.training.model_copy(update={"exact": False})})
    other = with_run(board, 1, 1, inexact.model_copy(update={"checkpoint_sha256": "0" * 64}))
    assert list(retrain(other, Store(folder))) == []
    monkeypatch.setattr(retrained, "train", lambda _: pytest.fail("trained"))
    with pytest.raises(pytest.fail.Exception):
        list(retrain(other, Store(folder), sample=3))


@pytest.mark.parametrize("sample", [1, 2, 9])
def test_so_many_are_drawn_by_the_seed(
    board: LeaderboardRecord, folder: Path, sample: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    again: list[str] = []

    def train(plan: Plan) -> Iterator[Report]:
        again.append(f"{plan.method.id} {plan.seeds[0]}")
        return iter(())

    monkeypatch.setattr(retrained, "train", train)
    drawn = []
    for seed in (0, 0, 1, 2, 3):
        assert len(list(retrain(board, Store(folder), sample=sample, seed=seed))) == min(sample, 4)
        drawn.append(again.copy())
        again.clear()
    assert drawn[0] == drawn[1]
    assert len({*map(tuple, drawn)}) > 1 or sample == 9
