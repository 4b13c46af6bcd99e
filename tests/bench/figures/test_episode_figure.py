"""The typical episode is the median success, and its figure is drawn from a checkpoint or a rule."""

from pathlib import Path

import numpy as np
import pytest

from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_bench.errors import SeedError
from hhrl_bench.figures.episode import save_episode, typical_episode
from hhrl_envs import Outcome


def typical(steps: list[int], outcomes: list[Outcome]) -> int:
    return typical_episode(np.array(outcomes, np.int8), np.array(steps, np.int32))


def test_the_typical_episode_is_the_success_of_median_length() -> None:
    won, lost = Outcome.SUCCESS, Outcome.COLLISION
    assert typical([30, 100, 20, 50, 40], [won, lost, won, won, lost]) == 0
    assert typical([30, 30, 20, 50], [won] * 4) == 0
    assert typical([30, 10, 20], [lost] * 3) == 2


@pytest.mark.parametrize(
    ("source", "name"),
    [("rule-plus", "episode-rule-plus"), (SHIPPED / "hybrid-hrl" / "seed-1.safetensors", "episode-hybrid-hrl")],
)
def test_equal_episodes_give_equal_files(tmp_path: Path, source: str | Path, name: str) -> None:
    pytest.importorskip("torch")
    first = save_episode(source, "stop-line-v0", 3, tmp_path / "first")
    again = save_episode(source, "stop-line-v0", 3, tmp_path / "again")
    assert [path.name for path in first] == [f"{name}-stop-line-v0.svg", f"{name}-stop-line-v0.png"]
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in again]


def test_an_episode_that_is_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SeedError):
        save_episode("rule-plus", "stop-line-v0", -1, tmp_path)
    assert not [*tmp_path.iterdir()]
