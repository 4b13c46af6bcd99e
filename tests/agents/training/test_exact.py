"""What a training learns does not depend on the processor: kernels for the plainest one give the same bits."""

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from support.exact_training import NAMES, digest, processor

PLAIN = ["x86-64", ""]
TESTS = Path(__file__).parents[2]


@pytest.mark.skipif(platform.machine() not in {"x86_64", "AMD64"}, reason="compiles for an x86-64 processor")
def test_kernels_for_another_processor_learn_the_same_bits(tmp_path: Path) -> None:
    name, features = PLAIN
    plain = {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": features, "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-m", "support.exact_training"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **plain}, cwd=TESTS)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["processor"] == PLAIN
    assert processor() != PLAIN
    assert told["digests"] == {method: digest(method) for method in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_another_seed_learns_other_bits(name: str) -> None:
    assert digest(name, seed=4) != digest(name)
