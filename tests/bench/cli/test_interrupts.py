"""Ctrl-C ends every command, at whatever moment, in one line, with exit code 130, and with it all of its processes."""

import json
import os
import signal
import subprocess
import sys
import time
from itertools import cycle, islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from hhrl_bench.cli.interrupts import GRACE
from support import interrupted
from support.sweeps import environment, workers_of

PRESSES = int(os.environ.get("HHRL_PRESSES", "6"))
"""How often Ctrl-C is pressed in all; ``make interrupts`` does it more often."""

LIMIT = 5.0
"""Seconds within which a command ends."""

LINE = "hhrl-bench: interrupted; what was not finished was not written"
COMMANDS = {
    "evaluate": ("evaluate", "rule-4", "hybrid-hrl", "rule-plus", "--episodes", "100000"),
    "train": ("train", "hybrid-hrl", "--seeds", "0-2", "--out", "trained", "--resume"),
    "run": ("run", "--suite", "paper", "--workers", "2"),
}
PROGRESS = (" of ", "compiling", "suite ", "  ")
"""What a line has that says how far a command is."""


class Ended(NamedTuple):
    """How a command has ended: its exit code, the seconds it took after Ctrl-C, and its lines on stderr."""

    code: int
    seconds: float
    lines: list[str]


def heed() -> None:
    """Heed interrupts, which may be ignored where tests run in the background, and be passed on so."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def press(script: list[str], folder: Path, moment: float) -> Ended:
    """Return how a script ends if Ctrl-C is pressed so many seconds after it began to heed interrupts."""
    with subprocess.Popen(
        [sys.executable, *script],
        cwd=folder,
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=heed,  # noqa: PLW1509 - no thread of this process matters to what it does
    ) as process:
        assert process.stderr is not None
        assert process.stderr.readline() == f"{interrupted.HEEDING}\n"
        time.sleep(moment)
        pressed = time.monotonic()
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does it: the workers hear of it too
        try:
            _, said = process.communicate(timeout=10 * LIMIT)
        finally:
            process.kill()
    seconds = time.monotonic() - pressed
    while workers_of(process.pid) and time.monotonic() < pressed + LIMIT:
        time.sleep(0.05)
    assert not workers_of(process.pid)
    return Ended(process.returncode, seconds, said.splitlines())


def test_ctrl_c_at_random_moments_ends_each_command(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng(5)
    slowest = dict.fromkeys(COMMANDS, 0.0)
    for name in islice(cycle(COMMANDS), PRESSES):
        moment = rng.uniform(0.0, rng.choice([1.5, 8.0]))  # half of them while modules are imported
        ended = press([interrupted.__file__, *COMMANDS[name]], tmp_path, moment)
        said = [line for line in ended.lines if not any(words in line for words in PROGRESS)]
        where = f"{name} after {moment:.3f} s: {ended}"
        assert ended.code == 130, where
        assert len(said) == 1, where
        assert said[0].startswith(LINE), where
        assert ended.seconds < LIMIT, where
        slowest[name] = max(slowest[name], ended.seconds)
    for path in tmp_path.rglob("*.json"):
        json.loads(path.read_text())  # whole, if it is there
    with capfd.disabled():
        print("", *(f"{name} {seconds:.2f} s" for name, seconds in slowest.items()))


LOSING = {
    "a comparison of numpy's with a member of an enum": """
    array = np.zeros(3)
    while True:
        array == Outcome.SUCCESS""",
    "a finalizer": """
    class Slow:
        def __del__(self):
            time.sleep(0.05)
    while True:
        Slow()""",
    "code that takes every exception": """
    for _ in range(5):
        try:
            time.sleep(60)
        except BaseException:
            pass""",
    "what cleans up and does not end": """
    try:
        time.sleep(60)
    finally:
        while True:
            time.sleep(0.1)""",
    "a thread that goes on": """
    Thread(target=time.sleep, args=(60,)).start()
    time.sleep(60)""",
    "an error that is raised in its place": """
    try:
        time.sleep(60)
    except KeyboardInterrupt:
        raise RuntimeError""",
    "code that was put together at run time": """
    exec("time.sleep(60)")""",
}
PREFACE = f"""
import sys, time
from threading import Thread
import numpy as np
from hhrl_bench.cli.interrupts import leave_on_interrupt
from hhrl_envs import Outcome

def command():
    print({interrupted.HEEDING!r}, file=sys.stderr, flush=True)"""


@pytest.mark.parametrize("body", LOSING.values(), ids=LOSING)
def test_an_interrupt_is_not_lost_in(body: str, tmp_path: Path) -> None:
    ended = press(["-c", f"{PREFACE}{body}\n\nleave_on_interrupt(command)\n"], tmp_path, 0.2)
    assert (ended.code, ended.lines) == (130, [LINE])
    assert ended.seconds < GRACE + 1.0


def test_a_pool_that_cannot_be_closed_ends_with_its_workers_and_without_a_word(tmp_path: Path) -> None:
    body = """
    from pathlib import Path
    from hhrl_bench.execution.pools import LocalPool
    from support.scripted_units import ScriptedUnit
    LocalPool(1).begin(ScriptedUnit("unit", Path(), "hangs"))
    try:
        time.sleep(60)
    finally:
        time.sleep(60)"""
    ended = press(["-c", f"{PREFACE}{body}\n\nleave_on_interrupt(command)\n"], tmp_path, 3.0)
    assert (ended.code, ended.lines) == (130, [LINE])
    assert ended.seconds < GRACE + 1.0


def test_what_cleans_up_is_not_disturbed(tmp_path: Path) -> None:
    body = """
    try:
        time.sleep(60)
    finally:
        for _ in range(10):
            time.sleep(0.1)
        print("cleaned", file=sys.stderr)"""
    ended = press(["-c", f"{PREFACE}{body}\n\nleave_on_interrupt(command)\n"], tmp_path, 0.2)
    assert (ended.code, ended.lines) == (130, ["cleaned", LINE])


def test_a_command_that_is_not_interrupted_ends_as_it_would() -> None:
    for body, code in (("pass", 0), ("sys.exit(2)", 2), ("raise KeyError", 1)):
        script = f"{PREFACE}\n    {body}\n\nleave_on_interrupt(command)\n"
        done = subprocess.run([sys.executable, "-c", script], env=environment(), capture_output=True, check=False)
        assert done.returncode == code
        assert (b"KeyError" in done.stderr) == (code == 1)


def test_interrupts_that_are_ignored_are_ignored_further(tmp_path: Path) -> None:
    ignoring = "import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)"
    ended = press(["-c", f"{ignoring}{PREFACE}\n    time.sleep(0.5)\n\nleave_on_interrupt(command)\n"], tmp_path, 0.2)
    assert (ended.code, ended.lines) == (0, [])


EARLY = """
import signal
import sys

signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background has it ignored

class Pressing:
    def find_spec(self, name, path=None, target=None):
        if name == "{}":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Pressing())
from hhrl_bench.cli import main
main()
"""


@pytest.mark.parametrize("moment", ["hhrl_bench.cli.interrupts", "hhrl_bench.cli.app"])
def test_ctrl_c_is_said_in_one_line_while_the_first_modules_are_imported(moment: str, tmp_path: Path) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", EARLY.format(moment)],
        cwd=tmp_path,
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, "", f"{LINE}\n")


def test_no_more_than_a_few_quick_modules_are_imported_before_ctrl_c_is_heeded(tmp_path: Path) -> None:
    code = "import sys; before = {*sys.modules}; import hhrl_bench; print(sorted({*sys.modules} - before))"
    ended = subprocess.run(
        [sys.executable, "-S", "-c", code], cwd=tmp_path, env=environment(), capture_output=True, text=True, check=False
    )
    assert ended.stdout == "['hhrl_bench']\n"
