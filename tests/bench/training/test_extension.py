"""A finished training that is extended leaves the files of one that was longer from the start, or is refused."""

import itertools
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from hhrl_bench.evaluation.loading import load_agents
from hhrl_bench.training import train as training
from hhrl_envs import get_scenario
from support.command_line import invoke
from support.small_training import STEPS, contents, killed_at, plan, small_methods

LONGER = 2 * STEPS
KEPT = {"end-state-seed-0.safetensors", "end-state-seed-2.safetensors"}


@pytest.fixture(scope="module", autouse=True)
def small() -> Iterator[None]:
    with small_methods():
        yield


def trained(folder: Path, *words: str, method: str = "ddqn", seeds: str = "0,2", steps: int = STEPS) -> str:
    """Return what a training that succeeds says on stderr."""
    said = invoke("train", method, "--seeds", seeds, "--env-steps", str(steps), "--out", str(folder), *words)
    assert said.exit_code == 0, said.stderr
    return said.stderr


def refused(folder: Path, *words: str, seeds: str = "0,2", steps: int = LONGER) -> str:
    """Return the line of an extension that is refused, and leaves the folder as it is."""
    before = contents(folder)
    said = invoke(
        "train", "ddqn", "--seeds", seeds, "--env-steps", str(steps), "--out", str(folder), "--resume", *words
    )
    assert (said.exit_code, said.stdout) == (2, ""), said.stderr
    assert contents(folder) == before
    return said.stderr.splitlines()[-1]


def policies(folder: Path) -> dict[str, bytes]:
    """Return the files of a run but for the states that it has left, which hold the seconds it took."""
    return {name: data for name, data in contents(folder).items() if name not in KEPT}


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("short")
    trained(folder)
    return folder


def copied(folder: Path, to: Path) -> Path:
    to.mkdir()
    for name, data in contents(folder).items():
        (to / name).write_bytes(data)
    return to


@pytest.mark.parametrize("method", ["hybrid-hrl", "pqn"])
def test_it_leaves_the_files_of_a_training_that_was_longer_from_the_start(tmp_path: Path, method: str) -> None:
    trained(tmp_path / "whole", "--schedule-steps", str(STEPS), method=method, steps=LONGER)
    trained(tmp_path / "extended", method=method)
    assert {path.name for path in (tmp_path / "extended").iterdir()} >= KEPT
    trained(tmp_path / "extended", "--resume", method=method, steps=LONGER)
    assert policies(tmp_path / "extended") == policies(tmp_path / "whole")
    (one, _) = load_agents(tmp_path / "extended", get_scenario("stop-line-v0"))
    assert one.training is not None
    assert one.training.budget == LONGER
    assert str(one.training.command).endswith(f"--env-steps {LONGER} --schedule-steps {STEPS}")


def test_it_can_be_extended_again_and_by_seeds_of_several_commands(tmp_path: Path) -> None:
    trained(tmp_path / "whole", "--schedule-steps", str(STEPS), steps=LONGER + 200)
    for seed in ("0", "2"):
        trained(tmp_path / "extended", seeds=seed)
    for steps in (LONGER, LONGER + 200):
        trained(tmp_path / "extended", "--resume", steps=steps)
    assert policies(tmp_path / "extended") == policies(tmp_path / "whole")
    assert "their training is finished" in trained(tmp_path / "extended", "--resume", steps=LONGER + 200)


def test_a_kill_after_any_write_changes_nothing(short: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    longer = replace(plan(tmp_path / "whole", env_steps=LONGER), schedule_steps=STEPS)
    list(training.train(longer, extendable=True))
    for write in itertools.count():
        own = replace(longer, folder=copied(short, tmp_path / str(write)))
        if not killed(own, write, monkeypatch):
            break
        list(training.train(own, resume=True, extendable=True))
        assert policies(own.folder) == policies(longer.folder), write
    assert write > 10


def killed(own: training.Plan, write: int, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Return whether an extension was killed right after it has put its n-th file in place."""
    return killed_at(write, lambda: list(training.train(own, resume=True, extendable=True)), monkeypatch)


def test_what_cannot_be_extended_is_refused_in_one_line(short: Path, tmp_path: Path) -> None:
    folder = copied(short, tmp_path / "run")
    assert "holds seed 2 too" in refused(folder, seeds="0")
    assert "ask for more to go on with it" in refused(folder, steps=STEPS - 200)
    assert "change over 600 steps; leave out --schedule-steps" in refused(folder, "--schedule-steps", "900")
    assert "of another configuration" in refused(folder, "--task", "stop-line-wet-v0")
    (folder / "end-state-seed-2.safetensors").unlink()
    assert "seed 2 has left no state there; a training of 1,200 steps has to begin anew" in refused(folder)
    trained(tmp_path / "odd", steps=500)
    assert "it ended at 500 steps, and a longer training reports every 200 steps" in refused(tmp_path / "odd")


def test_an_unfinished_training_is_finished_first(tmp_path: Path) -> None:
    reports = training.train(plan(tmp_path), extendable=True)
    next(reports)
    reports.close()  # type: ignore[attr-defined]
    assert f"its training is not finished; finish it first, by the same command with --env-steps {STEPS}" in refused(
        tmp_path
    )


def test_trainings_of_suites_leave_no_states(tmp_path: Path) -> None:
    list(training.train(plan(tmp_path)))
    assert not KEPT & {path.name for path in tmp_path.iterdir()}


def test_the_span_of_the_schedules_is_told(tmp_path: Path) -> None:
    trained(tmp_path, "--schedule-steps", "300")
    assert json.loads((tmp_path / "config.json").read_text())["schedule_steps"] == 300
    trained(tmp_path / "same", "--schedule-steps", str(STEPS))
    assert "schedule_steps" not in json.loads((tmp_path / "same" / "config.json").read_text())
