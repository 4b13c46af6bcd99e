"""Trackers: the curves, read back with the trackers' own readers."""

import importlib.util
import json
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("torch")
pytest.importorskip("tensorboard")

from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from hhrl_bench.training import train as training
from hhrl_bench.training.trackers import scalars
from hhrl_envs import errors
from support.command_line import invoke
from support.small_training import plan, small_methods


@pytest.fixture(scope="module", autouse=True)
def small() -> Iterator[None]:
    with small_methods():
        yield


def read(folder: Path, seed: int) -> EventAccumulator:
    accumulator = EventAccumulator(str(folder / "tensorboard" / f"seed-{seed}"))
    accumulator.Reload()
    return accumulator


def test_a_resumed_training_s_events_are_its_curves_once(tmp_path: Path) -> None:
    reports = training.train(plan(tmp_path, method="hybrid-hrl"), track=["tensorboard"])
    next(reports), next(reports)
    reports.close()  # type: ignore[attr-defined]
    time.sleep(1.1)  # event files are ordered by the second they begin in
    list(training.train(plan(tmp_path, method="hybrid-hrl"), resume=True, track=["tensorboard"]))
    for seed in (0, 2):
        events = read(tmp_path, seed)
        rows = [json.loads(line) for line in (tmp_path / f"curve-seed-{seed}.jsonl").read_text().splitlines()]
        for tag, group, name in (
            ("loss/option", "losses", "option"),
            ("loss/action", "losses", "action"),
            ("validation/success", "validation", "success"),
            ("validation/return_task", "validation", "return_task"),
        ):
            points = [(point.step, point.value) for point in events.Scalars(tag)]
            said = [(row["env_steps"], row[group][name]) for row in rows if name in row[group]]
            assert [step for step, _ in said] == ([] if group == "losses" else [0]) + [200, 400, 600]
            assert [step for step, _ in points] == [step for step, _ in said]
            assert [value for _, value in points] == pytest.approx([value for _, value in said])


def test_a_row_s_numbers_have_tags_and_missing_ones_none() -> None:
    row = {
        "env_steps": 7,
        "losses": {"option": None, "action": 2.0},
        "episodes": {"success": 3, "collision": 1},
        "validation": {"success": 0.5, "return_option": None},
    }
    tags = {"loss/action": 2.0, "training/success": 0.75, "training/collision": 0.25, "validation/success": 0.5}
    assert scalars(row) == tags
    assert scalars({**row, "episodes": {}, "validation": None}) == {"loss/action": 2.0}


@pytest.mark.parametrize(
    ("missing", "extra", "words"),
    [
        ("tensorboard", "tensorboard", ["ddqn", "--track", "tensorboard"]),
        ("wandb", "wandb", ["ddqn", "--track", "wandb"]),
        ("mlflow", "mlflow", ["ddqn", "--track", "tensorboard", "--track", "mlflow"]),
        ("stable_baselines3", "sb3", ["ppo"]),
    ],
)
def test_without_the_extra_one_line_names_it_and_no_folder_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, missing: str, extra: str, words: list[str]
) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(errors, "find_spec", lambda name: None if name == missing else found(name))
    said = invoke("train", *words, "--out", str(tmp_path / "run"))
    assert said.exit_code == 2
    assert f"pip install -e '.[{extra}]'" in said.stderr
    assert said.stderr.count("\n") == 1
    assert not (tmp_path / "run").exists()


def test_an_unknown_tracker_is_refused_in_a_line(tmp_path: Path) -> None:
    said = invoke("train", "ddqn", "--track", "paper", "--out", str(tmp_path / "run"))
    assert (said.exit_code, said.stderr) == (
        2,
        "hhrl-bench: the tracker is 'paper'; write one of tensorboard, wandb, mlflow\n",
    )
    assert not (tmp_path / "run").exists()
