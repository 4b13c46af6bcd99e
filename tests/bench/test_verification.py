"""Verification: whatever is changed in an entry or its files is found, and the place is named."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("torch")

from hhrl_bench import leaderboard
from hhrl_bench.differences import Finding
from hhrl_bench.level import Level
from hhrl_bench.store import Store
from hhrl_bench.verification import verify
from hhrl_envs.errors import InputError
from support import small_board
from support.mutations import Place, at, leaves, other, put, spelt

LEVELS = (Level.RECOMPUTED, Level.REPLAYED)

UNPROVABLE = {
    "suite": "a name of the entry's own; to submit it, its tasks and agents have to be that suite's",
    "provenance": "what may differ between two runs: the clock, the machine, the versions",
}
"""What nothing else in an entry says, and so nothing can prove."""


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_board.publish(tmp_path_factory.mktemp("board"))


@pytest.fixture(scope="module")
def data(published: Path) -> Any:
    return json.loads(published.read_text())


@pytest.fixture
def path(published: Path, tmp_path: Path) -> Path:
    """The path of a copy of the entry, with its files."""
    shutil.copytree(published.parent, tmp_path / "copy")
    return tmp_path / "copy" / published.name


def findings(path: Path, level: Level = Level.REPLAYED) -> list[Finding]:
    return list(verify(leaderboard.read(path), Store(path.parent), level))


def complaint(path: Path) -> str:
    """Return what is said first of an entry that does not hold; nothing if it is taken to hold."""
    try:
        for level in LEVELS:
            if found := findings(path, level):
                return "\n".join(map(str, found))
    except InputError as error:
        return str(error)
    return ""


def names(said: str, place: Place) -> bool:
    """Return whether a complaint names a place, or that of a number that was computed from it, in the same part."""
    return any(line.startswith(_parts(place)) for line in said.splitlines()) or spelt(place) in said


def _parts(place: Place) -> tuple[str, ...]:
    top = str(place[0])
    if top == "results":
        return (f"results[{place[1]}]",)
    return {"trainings": ("trainings", "efficiency"), "transfer": ("transfer",)}.get(top, (top,))


@pytest.mark.parametrize("level", Level)
def test_what_was_published_holds(published: Path, level: Level) -> None:
    assert findings(published, level) == []
    assert list(leaderboard.respelt(published, leaderboard.read(published))) == []
