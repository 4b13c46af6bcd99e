"""A suite of trainings end to end on a tiny budget: its leaderboard, how that is shown and drawn, and stopping."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from pydantic import ValidationError

pytest.importorskip("torch")

from hhrl_bench.leaderboard.entry import read_entry, write_entry
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.suites.study import suite_study
from hhrl_bench.suites.suites import SUITES, TrainingSuite
from hhrl_bench.tasks.tasks import TASKS
from hhrl_bench.training import train as training
from hhrl_bench.training.learning_curves import TRAINING_OUTCOMES
from support.command_line import invoke
from support.small_training import STEPS, small_methods

SUITE = TrainingSuite("tiny", (("follow-only", "red-light-v0"), ("option-only", "option-only-v0")), (0, 2), 5)


@pytest.fixture(scope="module", autouse=True)
def small() -> Iterator[None]:
    with small_methods() as patch:
        patch.setattr(
            "hhrl_bench.tasks.tasks.TASKS", {name: replace(task, env_steps=STEPS) for name, task in TASKS.items()}
        )
        patch.setattr("hhrl_bench.suites.suites.SUITES", {"tiny": SUITE})
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished run of the suite: tiny.json, and its trainings in work."""
    folder = tmp_path_factory.mktemp("suite")
    said = invoke(*command(folder))
    assert said.exit_code == 0, said.stderr
    assert invoke("leaderboard", "show", str(folder / "tiny.json")).stdout == said.stdout
    assert "follow-only on red-light-v0, seeds 0,2, 600 env steps" in said.stdout
    return folder


@pytest.fixture(scope="module")
def board(folder: Path) -> LeaderboardRecord:
    return read_entry(folder / "tiny.json")


def command(folder: Path) -> list[str]:
    paths = ["--out", str(folder / "tiny.json"), "--work", str(folder / "work")]
    return ["run", "--suite", "tiny", *paths, "--workers", "1"]


def test_the_leaderboard_holds_how_the_episodes_of_every_training_ended(board: LeaderboardRecord) -> None:
    assert [(one.method, one.task) for one in board.trainings] == list(SUITE.pairs)
    assert [(result.agent, result.task, result.seeds) for result in board.results] == [
        (method, task, SUITE.seeds) for method, task in SUITE.pairs
    ]
    for one in board.trainings:
        assert one.seeds == SUITE.seeds
        assert one.env_steps == (0, 200, 400, 600)
        assert all(one.training.array(outcome).shape == (2, 4) for outcome in TRAINING_OUTCOMES)
        tested = sum(one.testing.array(outcome) for outcome in TRAINING_OUTCOMES)
        assert tested == pytest.approx(1.0)


def test_its_run_directories_hold_the_same_curves(folder: Path, board: LeaderboardRecord) -> None:
    for one in board.trainings:
        path = folder / "work" / one.method / one.task / "curve-seed-2.jsonl"
        curve = [json.loads(line) for line in path.read_text().splitlines()]
        assert one.testing.collision[1] == tuple(row["validation"]["collision"] for row in curve)


def test_a_stopped_suite_goes_on_to_the_same_leaderboard(board: LeaderboardRecord, tmp_path: Path) -> None:
    study = suite_study(SUITE, tmp_path)
    running = study.run()
    next(running)
    running.close()  # type: ignore[attr-defined]
    again = study.leaderboard(list(study.run()))
    assert again.model_dump_json(exclude={"provenance"}) == board.model_dump_json(exclude={"provenance"})


def test_a_finished_suite_is_not_done_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = (folder / "tiny.json").read_bytes()
    monkeypatch.setattr(training, "make_learner", lambda *_: pytest.fail("trained"))
    said = invoke(*command(folder))
    assert (said.exit_code, "holds the same results already" in said.stderr) == (0, True)
    assert (folder / "tiny.json").read_bytes() == before


def test_its_figure_is_drawn_from_the_leaderboard_alone(folder: Path, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    path = tmp_path / "moved.json"
    path.write_bytes((folder / "tiny.json").read_bytes())
    said = invoke("figures", str(path))
    assert said.exit_code == 0, said.stderr
    assert {file.name for file in (tmp_path / "moved").iterdir()} == {
        "training-outcomes.svg",
        "training-outcomes.png",
    }


def test_a_leaderboard_with_nothing_to_draw_is_one_line(board: LeaderboardRecord, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    path = tmp_path / "bare.json"
    write_entry(board.model_copy(update={"trainings": ()}), path)
    said = invoke("figures", str(path), "--out", str(tmp_path / "new"))
    assert (said.exit_code, said.stdout) == (2, "")
    assert said.stderr == "hhrl-bench: the leaderboard of tiny has one agent a task and no curves: nothing to draw\n"
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("place", "change", "said"),
    [
        (1, {"method": "follow-only", "task": "red-light-v0"}, "follow-only has two trainings on red-light-v0"),
        (0, {"task": "two-stops-v0"}, "follow-only has a training on two-stops-v0, which is not among the tasks"),
        (0, {"seeds": [0]}, "one share a seed and report"),
    ],
)
def test_trainings_that_do_not_fit_their_leaderboard_are_refused(
    board: LeaderboardRecord, place: int, change: dict[str, object], said: str
) -> None:
    data = json.loads(board.model_dump_json())
    data["trainings"][place] |= change
    with pytest.raises(ValidationError, match=said):
        LeaderboardRecord.model_validate_json(json.dumps(data))


def test_the_registered_suite_is_the_papers_three_trainings() -> None:
    suite = SUITES["trainings"]
    _, seeds, trainings = suite.stages(Path("runs"))
    names = ["follow-only on red-light-v0", "option-only on option-only-v0", "hybrid-hrl on stop-line-v0"]
    assert [unit.name for unit in trainings] == names
    assert [unit.name for unit in seeds] == [f"{name}, seed {seed}" for name in names for seed in range(10)]
    assert list(suite.curves(Path("runs")).trainings) == list(trainings)
