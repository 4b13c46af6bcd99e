"""The published leaderboards speak of the worlds and the checkpoints of this very version."""

import hashlib
from pathlib import Path

import pytest

from hhrl_bench import leaderboard
from hhrl_bench.loading import SHIPPED
from hhrl_envs import get_scenario

FOLDER = Path(__file__).parents[2] / "leaderboards"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.json")), ids=lambda path: path.stem)
def test_a_published_leaderboard_is_of_this_version(path: Path) -> None:
    board = leaderboard.read(path)
    for task in board.tasks:
        assert task.spec_hash == get_scenario(task.scenario).spec_hash
    shipped = {hashlib.sha256(file.read_bytes()).hexdigest() for file in SHIPPED.rglob("*.safetensors")}
    learned = {run.checkpoint_sha256 for result in board.results if result.kind == "learned" for run in result.runs}
    assert learned == shipped
