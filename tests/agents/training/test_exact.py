"""What a training learns does not depend on the processor: kernels for the plainest one give the same bits."""

import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from support.exactness import SHORT, processor, short_training

PLAIN = ["x86-64", ""]
TESTS = Path(__file__).parents[2]
CODE = """
import json
from support.exactness import SHORT, processor, short_training
print(json.dumps({"processor": processor(), "digests": {name: short_training(name) for name in SHORT}}))
"""


@pytest.mark.skipif(platform.machine() not in {"x86_64", "AMD64"}, reason="compiles for an x86-64 processor")
def test_kernels_for_another_processor_learn_the_same_bits(tmp_path: Path) -> None:
    name, features = PLAIN
    plain = {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": features, "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", CODE]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, **plain}, cwd=TESTS)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["processor"] == PLAIN
    assert processor() != PLAIN
    assert told["digests"] == {method: short_training(method) for method in SHORT}


@pytest.mark.parametrize("name", SHORT)
def test_another_seed_learns_other_bits(name: str) -> None:
    assert short_training(name, seed=4) != short_training(name)
