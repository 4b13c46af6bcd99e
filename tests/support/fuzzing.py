"""Fuzzing: hostile input given to everything that reads some, while it is watched what that does.

As a script, ``python -m support.fuzzing 100000``, it does so for as many inputs, and says what it has found; with a
seed and names of attacks, ``python -m support.fuzzing 200000 0 scenario``, only in these ways and from this seed on.
"""

import io
import json
import os
import shutil
import sys
import tempfile
import time
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import torch

from hhrl_agents.adapters.sb3 import read_policy
from hhrl_agents.methods.method import Method
from hhrl_agents.policies.checkpoint_file import METADATA_KEY, SHIPPED, read_metadata
from hhrl_bench import provenance
from hhrl_bench.evaluation.evidence import unpack
from hhrl_bench.evaluation.loading import load_agents, training_record
from hhrl_bench.evaluation.replay import replay
from hhrl_bench.evaluation.store import Store, read
from hhrl_bench.leaderboard.entry import check_spelling, read_entry
from hhrl_bench.leaderboard.entry_files import INDEX
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.leaderboard.record import method_records
from hhrl_bench.publishing import publication
from hhrl_bench.suites.files import find_suite
from hhrl_bench.suites.units import keep_outcome
from hhrl_bench.tasks.seeds import parse_seeds
from hhrl_bench.training import saved_state
from hhrl_bench.training import train as training
from hhrl_bench.training.learning_curves import read_outcomes
from hhrl_bench.training.run_directory import RunDirectory, failed_seeds
from hhrl_bench.verification.verify import verify
from hhrl_envs import get_scenario, read_scenario, scenario_from_json, scenario_to_json
from hhrl_envs.errors import InputError
from support import hostile, small_board, small_training, worlds
from support.hostile import Rng, require_one_line

SCENARIO = get_scenario("stop-line-v0")
TRAP = "from pathlib import Path\nPath('sprung').touch()\n"
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
DEEDS = {"os.system", "os.exec", "os.posix_spawn", "os.fork", "subprocess.Popen", "socket.connect", "exec", "compile"}
CHANGES = {"os.remove", "os.rename", "os.mkdir", "os.rmdir", "os.link", "os.symlink", "os.truncate", "os.chmod"}


class Watch:
    """What the process does while it is watched: files written outside a folder, code run, processes begun."""

    def __init__(self) -> None:
        self.folder: Path | None = None
        self.deeds: list[str] = []
        sys.addaudithook(self._hear)

    @contextmanager
    def over(self, folder: Path) -> Iterator[None]:
        """Return a context in which only files in the folder may be written, and nothing executed."""
        self.folder = folder
        try:
            yield
        finally:
            self.folder = None

    def _hear(self, event: str, args: tuple[Any, ...]) -> None:
        if self.folder is None:
            return
        if event in DEEDS:
            self.deeds.append(f"{event} {args!r:.200}")
        writes = event == "open" and isinstance(args[2], int) and args[2] & WRITING
        if (writes or event in CHANGES) and not str(args[0]).startswith(str(self.folder)):
            self.deeds.append(f"{event} {args!r:.200}")


class Sandbox(NamedTuple):
    """A folder with one whole file of every kind that is read, and a module that must not be imported beside it."""

    folder: Path
    board: Path
    run: Path


Attack = Callable[[Sandbox, Rng], None]


def make_sandbox(folder: Path) -> Sandbox:
    """Return a sandbox in a folder."""
    board = small_board.publish(folder / "board", small_board.PAIRS[:1])
    verified = publication.VerifiedEntry(read_entry(board), publication.verified_now(Level.SCHEMA, Level.SCHEMA))
    publication.write_index(board.parent, {board.name: verified})
    run = folder / "run"
    with small_training.small_methods(), unchecked():
        plan = small_training.plan(run, seeds=(0,))
        reports = training.train(plan)
        next(reports), next(reports)
        reports.close()  # type: ignore[attr-defined]
        shutil.copy(RunDirectory(run).state((0,)), run / "state")
        list(training.train(plan, resume=True))
        shutil.copy(run / "state", RunDirectory(run).state((0,)))
    worlds.compile_kernels()
    (folder / "trap.py").write_text(TRAP)
    (folder / "zips").mkdir()
    (folder / "zips" / "whole.zip").write_bytes(model_zip())
    read_policy(folder / "zips" / "whole.zip")  # what torch imports for it is there from now on
    return Sandbox(folder, board, run)


CHECKPOINT = SHIPPED / "follow-only" / "seed-0.safetensors"


def attack_checkpoint(sandbox: Sandbox, rng: Rng) -> None:
    path = sandbox.folder / "fuzzed.safetensors"
    path.write_bytes(hostile.change_tensors(CHECKPOINT.read_bytes(), rng, METADATA_KEY))
    load_agents(path, SCENARIO)


def attack_metadata(sandbox: Sandbox, rng: Rng) -> None:
    store = Store(sandbox.folder / "fuzzed")
    sha256 = store.add_checkpoint(hostile.change_tensors(CHECKPOINT.read_bytes(), rng, METADATA_KEY))
    try:
        metadata = store.checkpoint_metadata(sha256)
    finally:
        store.checkpoint(sha256).unlink()
    training_record(metadata, sandbox.folder)
    method_records([metadata])


def attack_entry(sandbox: Sandbox, rng: Rng) -> None:
    path = sandbox.board.with_name("fuzzed.json")
    path.write_bytes(hostile.change_json(sandbox.board.read_bytes(), rng))
    board = read_entry(path)
    list(check_spelling(path, board))
    for finding in verify(board, Store(path.parent), Level.RECOMPUTED):
        require_one_line(str(finding))


def attack_index(sandbox: Sandbox, rng: Rng) -> None:
    path = sandbox.board.with_name(INDEX)
    whole = path.read_bytes()
    try:
        path.write_bytes(hostile.change_json(whole, rng))
        for finding in publication.check_index(path.parent):
            require_one_line(str(finding))
    finally:
        path.write_bytes(whole)


def attack_evidence(sandbox: Sandbox, rng: Rng) -> None:
    (path,) = (sandbox.board.parent / "evidence").iterdir()
    if rng.random() < 0.2:
        _with_changed(path, hostile.change_bytes, rng, lambda: read(path))
    kept, task = unpack(hostile.change_arrays(read(path), rng)), small_training.TASK
    replay([kept], task, task.test.take(small_board.EPISODES))


def attack_curves(sandbox: Sandbox, rng: Rng) -> None:
    _with_changed(sandbox.run / "curve-seed-0.jsonl", hostile.change_lines, rng, lambda: read_outcomes(sandbox.run))


def attack_config(sandbox: Sandbox, rng: Rng) -> None:
    def read() -> None:
        read_outcomes(sandbox.run)
        RunDirectory(sandbox.run).require_config({})

    _with_changed(sandbox.run / "config.json", hostile.change_json, rng, read)


def attack_provenance(sandbox: Sandbox, rng: Rng) -> None:
    directory = RunDirectory(sandbox.run)
    _with_changed(directory.provenance((0,)), hostile.change_json, rng, lambda: directory.seconds(0))


def attack_state(sandbox: Sandbox, rng: Rng) -> None:
    def resume() -> None:
        with small_training.small_methods():
            list(training.train(small_training.plan(sandbox.run, seeds=(0,)), resume=True))

    before = small_training.contents(sandbox.run)
    try:
        _with_changed(RunDirectory(sandbox.run).state((0,)), _change_state, rng, resume)
    finally:
        for name, data in before.items():
            (sandbox.run / name).write_bytes(data)


def _change_state(data: bytes, rng: Rng) -> bytes:
    return hostile.change_tensors(data, rng, saved_state.STATE_FORMAT)


def attack_outcome(sandbox: Sandbox, rng: Rng) -> None:
    path = sandbox.folder / "board" / "rule-2" / "stop-line-v0" / f"result-{small_board.EPISODES}.json"
    outcome = small_board.outcome(path)
    read = lambda: keep_outcome(path, lambda: outcome, "rule-2", small_training.TASK, Store(sandbox.folder / "board"))  # noqa: E731
    _with_changed(path, hostile.change_json, rng, read)


def attack_name(_: Sandbox, rng: Rng) -> None:
    name = hostile.agent_name(rng)
    for parse in (parse_seeds, lambda text: load_agents(text, SCENARIO)):
        try:
            parse(name)
        except InputError as error:
            require_one_line(str(error))


def attack_scenario(_: Sandbox, rng: Rng) -> None:
    worlds.run(worlds.draw_scenario(rng), rng)


def attack_scenario_file(sandbox: Sandbox, rng: Rng) -> None:
    path = sandbox.folder / "fuzzed.json"
    path.write_bytes(hostile.change_json(scenario_to_json(SCENARIO).encode(), rng))
    scenario = read_scenario(path)
    assert scenario_from_json(scenario_to_json(scenario)).spec_hash == scenario.spec_hash


def attack_suite_file(sandbox: Sandbox, rng: Rng) -> None:
    path = sandbox.folder / "suite.json"
    path.write_bytes(hostile.change_json(json.dumps(SUITE).encode(), rng))
    find_suite(str(path))


def attack_zip(sandbox: Sandbox, rng: Rng) -> None:
    path = sandbox.folder / "zips" / "fuzzed.zip"
    content = model_zip(rng)
    path.write_bytes(hostile.change_bytes(content, rng) if rng.random() < 0.3 else content)
    read_policy(path)


SUITE = {"id": "my-suite", "tasks": ["solo-stop-v0", "stop-line-v0"], "agents": ["rule-4", "mine:make"], "episodes": 9}


def model_zip(rng: Rng | None = None) -> bytes:
    """Return a zip as Stable-Baselines3 writes it of a small DQN; with a generator, one of its files is changed."""
    weights, file = io.BytesIO(), io.BytesIO()
    torch.save({"q_net.q_net.0.weight": torch.zeros(6, 11), "q_net.q_net.0.bias": torch.zeros(6)}, weights)
    data = {"policy_class": {"__module__": "stable_baselines3.dqn.policies"}, "policy_kwargs": {"net_arch": []}}
    settings, tensors = json.dumps(data).encode(), weights.getvalue()
    if rng is not None and rng.random() < 0.5:
        settings = hostile.change_json(settings, rng)
    elif rng is not None:
        tensors = hostile.change_bytes(tensors, rng)
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("data", settings)
        archive.writestr("policy.pth", tensors)
    return file.getvalue()


def attack_folder(sandbox: Sandbox, rng: Rng) -> None:
    names = (
        "seed-x.failed.json",
        "seed-1e9.failed.json",
        "seed-.safetensors",
        "curve-seed-9999999999.jsonl",
        "seed-\n",
    )
    folder = sandbox.folder / "odd"
    folder.mkdir(exist_ok=True)
    path = folder / str(rng.choice(names))
    path.write_bytes(rng.bytes(4))
    failed_seeds(folder)
    read_outcomes(folder)


ATTACKS: Mapping[str, Attack] = {
    name.removeprefix("attack_"): attack for name, attack in list(globals().items()) if name.startswith("attack_")
}


def _with_changed(path: Path, change: Callable[[bytes, Rng], bytes], rng: Rng, read: Callable[[], object]) -> None:
    whole = path.read_bytes()
    try:
        path.write_bytes(change(whole, rng))
        read()
    finally:
        path.write_bytes(whole)


@contextmanager
def unchecked() -> Iterator[None]:
    """Return a context in which hashes of settings and of states agree, as those of a forger do."""
    with pytest.MonkeyPatch.context() as patch:
        known = read_metadata(CHECKPOINT)["config_hash"]
        patch.setattr(Method, "config_hash", property(lambda _: known))
        patch.setattr(saved_state, "_checksum", lambda *_: "0")
        patch.setattr(provenance, "git_commit", lambda _: None)  # asks git, which is a process
        yield


@contextmanager
def quick_statistics() -> Iterator[None]:
    """Return a context in which intervals take no time."""
    with small_board.resamples(9):
        yield


WATCH = Watch()


def fuzz(sandbox: Sandbox, name: str, seed: int) -> str:
    """Return how an attack ended, drawn by a seed: "taken" or the kind of the error; anything else fails."""
    deeds = len(WATCH.deeds)
    with WATCH.over(sandbox.folder):
        try:
            ATTACKS[name](sandbox, np.random.default_rng([seed, *name.encode()]))
            ended = "taken"
        except InputError as error:
            require_one_line(str(error))
            ended = type(error).__name__
    assert WATCH.deeds[deeds:] == []
    assert not (sandbox.folder / "sprung").exists()
    return ended


def main(count: int, seed: int, names: Sequence[str]) -> int:
    """Return how many of ``count`` attacks of these names have failed; say so, and how the others ended."""
    folder = Path(tempfile.mkdtemp())
    failures, ended, seconds = 0, Counter[tuple[str, str]](), dict.fromkeys(names, 0.0)
    with quick_statistics(), unchecked():
        sandbox = make_sandbox(folder)
        os.chdir(folder)
        for index in range(count):
            name = names[index % len(names)]
            started = time.perf_counter()
            try:
                ended[name, fuzz(sandbox, name, seed + index)] += 1
            except Exception as error:  # noqa: BLE001 - it is what is looked for
                failures += 1
                print(f"{name} {seed + index}: {type(error).__name__}: {error!s:.300}", flush=True)
            seconds[name] += time.perf_counter() - started
    for (name, how), times in sorted(ended.items()):
        print(f"{name}: {how} {times:,}")
    print(", ".join(f"{name} {1000 * total / (count / len(names)):.1f} ms" for name, total in seconds.items()))
    print(f"{count:,} attacks, {failures:,} failed")
    shutil.rmtree(folder)
    return failures


if __name__ == "__main__":
    sys.exit(bool(main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0, sys.argv[3:] or list(ATTACKS))))
