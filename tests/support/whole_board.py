"""A leaderboard that holds everything a leaderboard can, for tests of pages and tables."""

import json
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from hhrl_bench.leaderboard.efficiency import efficiency
from hhrl_bench.leaderboard.record import LeaderboardRecord, MethodRecord
from hhrl_bench.suites.study import suite_study
from hhrl_bench.suites.suites import ScoreSuite
from support.trainings import training
from support.transfers import study

AGENTS = ("rule-1", "rule-2", "rule-4")


@cache
def whole_board(named: str = "rule-2") -> LeaderboardRecord:
    """Return three rules on two tasks beside made-up learning; Rule 2 and a method are ``named`` so."""
    suite = ScoreSuite("tiny", agents=AGENTS, tasks=("stop-line-v0", "stop-line-wet-v0"), episodes=20)
    with TemporaryDirectory() as folder:
        scored = suite_study(suite, Path(folder))
        board = scored.leaderboard(list(scored.run()))
    trainings = (training([(0.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.25, 0.5)]), training([(0.0, 0.0, 0.0, 0.0)], "pqn"))
    rows = tuple(row for row in study().rows if row.target == "two-stops-v0")
    learning = {
        "methods": (MethodRecord(id="ddqn", config_hash="abc", config={"net": {"hidden": [64, 32]}, "rate": 0.125}),),
        "trainings": trainings,
        "trainings_sha256": tuple(one.digest() for one in trainings),
        "efficiency": tuple(efficiency(one, np.random.default_rng(0)) for one in trainings),
        "transfer": study().model_copy(update={"rows": rows}),
    }
    data = json.loads(board.model_copy(update=learning).model_dump_json())
    names = {"rule-2": named, "ddqn": named}
    return LeaderboardRecord.model_validate_json(json.dumps(_renamed(data, names)))


def _renamed(data: Any, names: dict[str, str]) -> Any:
    if isinstance(data, dict):
        return {key: _renamed(value, names) for key, value in data.items()}
    if isinstance(data, list):
        return [_renamed(value, names) for value in data]
    return names.get(data, data) if isinstance(data, str) else data
