"""The first compilation of a process is said, so that nobody takes it for a hang."""

import subprocess
import sys

KERNEL = """
import numba
from hhrl_bench.cli.console import announce_compiling
announce_compiling()
announce_compiling()

numba.njit(lambda x: x + 1)(1)
numba.njit(lambda x: x + 2)(1)
"""


def test_the_first_compilation_of_a_process_is_said_once() -> None:
    ended = subprocess.run([sys.executable, "-c", KERNEL], capture_output=True, text=True, check=True)
    assert ended.stderr == "hhrl-bench: compiling the simulator, a few seconds, once\n"
