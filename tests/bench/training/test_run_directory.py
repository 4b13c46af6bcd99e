"""A run directory: what is not its own is left out, what is damaged is said in one line."""

import json
from pathlib import Path

import pytest

from hhrl_agents.atomic_files import OutputError
from hhrl_bench.provenance import provenance
from hhrl_bench.training.run_directory import RunDirectory, failed_seeds


def test_failed_seeds_are_those_of_its_own_files(tmp_path: Path) -> None:
    names = ("seed-3", "seed-12", "seed-x", "seed-", "seed-1e3", "seed-99999999999", "seed-4\n", "other-5")
    for name in names:
        (tmp_path / f"{name}.failed.json").touch()
    assert failed_seeds(tmp_path) == [3, 12]


def test_the_seconds_are_those_of_the_provenance(tmp_path: Path) -> None:
    directory, path = RunDirectory(tmp_path), RunDirectory(tmp_path).provenance((1,))
    assert directory.seconds(1) == 0.0
    path.write_text(provenance("train it", {"a": 1.5, "b": 2.0}).model_dump_json())
    assert directory.seconds(1) == 3.5
    assert directory.seconds(0) == 0.0


@pytest.mark.parametrize("seconds", [{"a": -1}, {"a": "x"}, {"a": float("inf")}, {"a": None}, [1.0], None, 10**400])
def test_a_provenance_that_is_none_has_no_seconds(tmp_path: Path, seconds: object) -> None:
    directory = RunDirectory(tmp_path)
    data = json.loads(provenance("train it", {"a": 1.5}).model_dump_json())
    directory.provenance((0,)).write_text(json.dumps({**data, "wall_seconds": seconds}))
    assert directory.seconds(0) == 0.0


def test_a_config_is_the_same_whatever_the_order_of_its_keys(tmp_path: Path) -> None:
    directory = RunDirectory(tmp_path)
    (tmp_path / "config.json").write_text('{"b": [1, 2], "a": 0.1}')
    directory.require_config({"a": 0.1, "b": (1, 2)})
    for damaged in ('{"b": [1, 2], "a": 0.2}', "{", "[" * 100_000, "\xff"):
        (tmp_path / "config.json").write_text(damaged)
        with pytest.raises(OutputError, match="holds a run of another configuration"):
            directory.require_config({"a": 0.1, "b": (1, 2)})
