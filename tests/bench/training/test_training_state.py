"""A training that is stopped at any moment and resumed leaves the files of one that was not."""

import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.atomic_files import OutputError
from hhrl_bench.training import saved_state
from hhrl_bench.training import train as training
from support import small_training
from support.command_line import invoke
from support.small_training import STEPS, contents, killed_at, plan, small_methods

SHORT, LONG = 400, 4000


@pytest.fixture(scope="module", autouse=True)
def small() -> Iterator[None]:
    with small_methods() as patch:
        patch.setattr(saved_state, "COST_SHARE", 0)
        yield


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that nobody has stopped."""
    folder = tmp_path_factory.mktemp("whole")
    list(training.train(plan(folder)))
    return folder


def stopped(folder: Path, seeds: tuple[int, ...] = (0, 2)) -> Path:
    """Leave a run behind that was stopped at its second report."""
    reports = training.train(plan(folder, seeds))
    next(reports), next(reports)
    reports.close()  # type: ignore[attr-defined]
    return folder


def train_until_kill(folder: Path, write: int, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Return whether a training was killed right after it has put its n-th file in place."""
    return killed_at(write, lambda: list(training.train(plan(folder, env_steps=SHORT), resume=True)), monkeypatch)


def test_a_kill_after_any_write_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    list(training.train(plan(tmp_path / "whole", env_steps=SHORT)))
    writes = itertools.count()
    while train_until_kill(folder := tmp_path / str(write := next(writes)), write, monkeypatch):
        list(training.train(plan(folder, env_steps=SHORT), resume=True))
        assert contents(folder) == contents(tmp_path / "whole"), write
    assert write > 10


def test_a_process_killed_twice_and_resumed_writes_the_same_files(tmp_path: Path) -> None:
    list(training.train(plan(tmp_path / "whole", env_steps=LONG)))
    script = [sys.executable, small_training.__file__, "train", "ddqn", "--seeds", "0,2", "--env-steps", str(LONG)]
    command = [*script, "--out", str(tmp_path / "killed"), "--resume"]
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    rng = np.random.default_rng(0)
    for reports in (1, 2):
        with subprocess.Popen(
            command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, env=paths
        ) as process:
            assert process.stderr is not None
            for _ in itertools.islice((line for line in process.stderr if " of " in line), reports):
                pass
            time.sleep(0.02 * rng.random())
            process.kill()
        assert process.returncode == -signal.SIGKILL, "the training was over before it was killed; make it longer"
    assert list((tmp_path / "killed").glob("state-seeds-0,2.safetensors"))
    list(training.train(plan(tmp_path / "killed", env_steps=LONG), resume=True))
    assert contents(tmp_path / "killed") == contents(tmp_path / "whole")


def test_a_learner_without_a_state_starts_again(whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(DoubleDQNLearner, "state", lambda _: None)
    stopped(tmp_path)
    list(training.train(plan(tmp_path), resume=True))
    assert contents(tmp_path) == contents(whole)


def test_a_stopped_training_is_not_started_again_by_accident(tmp_path: Path) -> None:
    before = contents(stopped(tmp_path))
    for seeds, hint in (((0, 2), "add --resume to continue"), ((2, 3), "add --seeds 0,2 --resume to continue")):
        for resume in (False, seeds != (0, 2)):
            with pytest.raises(OutputError, match=hint):
                next(training.train(plan(tmp_path, seeds), resume=resume))
    assert contents(tmp_path) == before


def test_a_finished_training_says_so(whole: Path) -> None:
    before = contents(whole)
    said = invoke("train", "ddqn", "--seeds", "0,2", "--env-steps", str(STEPS), "--out", str(whole), "--resume")
    assert (said.exit_code, said.stdout) == (0, f"{whole}\n")
    assert said.stderr == f"hhrl-bench: {whole} holds seeds 0,2 already, their training is finished\n"
    longer = invoke("train", "ddqn", "--seeds", "0,2", "--env-steps", "5000", "--out", str(whole), "--resume")
    assert longer.exit_code == 2
    assert "seed 0 has left no state there" in longer.stderr
    assert contents(whole) == before


@pytest.mark.parametrize("damage", ["short", "empty", "flipped", "other", "checkpoint"])
def test_a_state_that_cannot_be_resumed_is_refused_in_one_line(whole: Path, tmp_path: Path, damage: str) -> None:
    path = stopped(tmp_path) / "state-seeds-0,2.safetensors"
    data = path.read_bytes()
    if damage == "other":
        (stopped(tmp_path / "other", (0, 3)) / "state-seeds-0,3.safetensors").rename(path)
    else:
        flipped = data[:-500] + bytes([data[-500] ^ 1]) + data[-499:]
        checkpoint = (whole / "seed-0.safetensors").read_bytes()
        path.write_bytes({"short": data[:-7], "empty": b"", "flipped": flipped, "checkpoint": checkpoint}[damage])
    before = contents(tmp_path)
    said = invoke("train", "ddqn", "--seeds", "0,2", "--env-steps", str(STEPS), "--out", str(tmp_path), "--resume")
    assert said.exit_code == 2
    assert said.stderr.startswith(f"hhrl-bench: cannot resume: {path} is ")
    assert said.stderr.count("\n") == 1
    assert contents(tmp_path) == before


def test_fragments_of_a_kill_are_removed(whole: Path, tmp_path: Path) -> None:
    fragment = stopped(tmp_path) / ".state-seeds-0,2.safetensors.0123abcd.hhrl.tmp"
    fragment.write_bytes(b"half")
    list(training.train(plan(tmp_path), resume=True))
    assert contents(tmp_path) == contents(whole)


def test_an_interrupt_says_how_to_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(training, "train", interrupted)
    said = invoke("train", "ddqn", "--out", str(tmp_path))
    assert said.exit_code == 130
    assert said.stderr == (
        "hhrl-bench: interrupted; what was not finished was not written; "
        "the same command with --resume goes on from the last saved state\n"
    )


def test_the_same_seeds_are_not_trained_twice_at_once(tmp_path: Path) -> None:
    options = ("--env-steps", "1000000", "--out", str(tmp_path))
    script = [sys.executable, small_training.__file__, "train", "ddqn", "--seeds", "0,2", *options]
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(script, stderr=subprocess.PIPE, env=paths, text=True) as process:
        assert process.stderr is not None
        next(line for line in process.stderr if " of " in line)
        process.send_signal(signal.SIGSTOP)
        for seeds in ("2", "1-2"):
            said = invoke(
                "train", "ddqn", "--seeds", seeds, "--env-steps", "1000000", "--out", str(tmp_path), "--resume"
            )
            assert said.exit_code == 2
            assert said.stderr == (
                f"hhrl-bench: another training of seed 2 works in {tmp_path}; wait until it has ended, or name another "
                "folder with --out\n"
            )
        beside = training.train(plan(tmp_path, (1,), env_steps=1_000_000))
        next(beside)
        assert sorted(path.name for path in tmp_path.glob("*.lock")) == [f"seed-{seed}.lock" for seed in range(3)]
        del beside
        process.kill()
    going_on = training.train(plan(tmp_path, env_steps=1_000_000), resume=True)
    next(going_on)
    del going_on
    assert not list(tmp_path.glob("*.lock"))
