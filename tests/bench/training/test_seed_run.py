"""A seed that diverges fails by itself: the others go on, and the run says which failed."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_bench.training import train as training
from hhrl_bench.training.train import find_fault
from support.command_line import invoke
from support.small_training import STEPS, contents, plan, small_methods


@pytest.fixture(scope="module", autouse=True)
def small() -> Iterator[None]:
    with small_methods():
        yield


class Sick(DoubleDQNLearner):
    """A learner whose seed 2 is not finite after its second report begins."""

    def train(self, env_steps: int, schedule_steps: int | None = None) -> Iterator[Any]:
        for progress in super().train(env_steps, schedule_steps):
            yield progress
            self.parameters.online[:] = np.nan if self.seed == 2 else self.parameters.online


def trained(folder: Path) -> dict[str, bytes]:
    """Return the files of a run directory but for the states at the end, which hold the seconds that it took."""
    return {name: data for name, data in contents(folder).items() if not name.startswith("end-state")}


@pytest.fixture
def sick(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setattr(training, "make_learner", Sick)
    said = invoke("train", "ddqn", "--seeds", "0,2", "--env-steps", str(STEPS), "--out", str(tmp_path / "run"))
    assert said.exit_code == 1
    assert said.stderr.splitlines()[-1] == (f"hhrl-bench: seeds that failed: 2; see {tmp_path}/run/seed-2.failed.json")
    return tmp_path / "run"


def test_a_seed_that_diverges_is_reported_and_the_other_undisturbed(sick: Path, tmp_path: Path) -> None:
    failed = json.loads((sick / "seed-2.failed.json").read_text())
    rows = [json.loads(line) for line in (sick / "curve-seed-2.jsonl").read_text().splitlines()]
    assert (failed["seed"], failed["env_steps"]) == (2, 400)
    assert failed["reason"] == rows[-1]["failed"] == "its parameters are not finite"
    assert failed["last_finite_report"] == rows[1]
    assert [row["env_steps"] for row in rows] == [0, 200, 400]
    assert not list(sick.glob("seed-2*.safetensors"))
    list(training.train(plan(tmp_path / "sound"), extendable=True))
    sound = trained(tmp_path / "sound")
    assert {name: data for name, data in sound.items() if "seed-2" not in name} == {
        name: data for name, data in trained(sick).items() if "seed-2" not in name
    }


def test_the_seeds_that_are_left_are_scored(sick: Path) -> None:
    said = invoke("evaluate", str(sick), "--episodes", "5", "--json")
    assert said.exit_code == 0
    (run,) = json.loads(said.stdout)["results"][0]["runs"]
    assert run["training"]["seed"] == 0
    assert "seeds that failed: 2" in said.stderr


def test_a_training_ends_when_every_seed_has_failed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(training, "make_learner", Sick)
    reports = list(training.train(plan(tmp_path, seeds=(2,))))
    assert [report.env_steps for report in reports] == [0, 200, 400]
    assert math.isnan(reports[-1].success[0])
    assert set(contents(tmp_path)) == {"config.json", "curve-seed-2.jsonl", "seed-2.failed.json"}


def test_a_failure_survives_a_resume(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, sick: Path) -> None:
    monkeypatch.setattr("hhrl_bench.training.saved_state.COST_SHARE", 0)  # save at every report
    reports = training.train(plan(tmp_path), extendable=True)
    next(reports), next(reports), next(reports)
    reports.close()  # type: ignore[attr-defined]
    list(training.train(plan(tmp_path), resume=True, extendable=True))
    assert trained(tmp_path) == trained(sick)


@pytest.mark.parametrize(
    ("loss", "finite", "updated", "fault"),
    [
        (1.0, True, True, None),
        (math.nan, True, False, None),
        (math.nan, True, True, "its action loss is not finite"),
        (math.inf, True, True, "its action loss is not finite"),
        (1.0, False, True, "its parameters are not finite"),
    ],
)
def test_a_fault_is_found_in_losses_and_parameters(loss: float, finite: bool, updated: bool, fault: str | None) -> None:
    assert find_fault({"action": loss}, finite, updated) == fault
