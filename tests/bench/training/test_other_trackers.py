"""Trackers that need other versions of packages, read back with their own readers; ``make interop`` runs this."""

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hhrl_bench.training import train as training
from support.small_training import plan, small_methods

SEEDS = (0, 2)
BLOCK, FULL, LAST = 2**15, 1, 4


@pytest.fixture(scope="module", autouse=True)
def small() -> Iterator[None]:
    with small_methods():
        yield


def trained(folder: Path, tracker: str) -> None:
    """Train two seeds in two parts, so that the curves of the first part are written twice."""
    reports = training.train(plan(folder, SEEDS), track=[tracker])
    next(reports), next(reports)
    reports.close()  # type: ignore[attr-defined]
    list(training.train(plan(folder, SEEDS), resume=True, track=[tracker]))


def curve(folder: Path, seed: int) -> list[tuple[int, float]]:
    rows = [json.loads(line) for line in (folder / f"curve-seed-{seed}.jsonl").read_text().splitlines()]
    return [(row["env_steps"], row["validation"]["success"]) for row in rows]


def records_of(file: Path) -> Iterator[bytes]:
    """Yield the records of a file of offline runs: a header of 7 bytes, then LevelDB's log format."""
    data, place, parts = file.read_bytes(), 7, b""
    assert data.startswith(b":W&B")
    while place < len(data):
        if BLOCK - place % BLOCK < 7:
            place += BLOCK - place % BLOCK
            continue
        _, length, kind = struct.unpack_from("<IHB", data, place)
        parts += data[place + 7 : place + 7 + length]
        place += 7 + length
        if kind in {FULL, LAST}:
            yield parts
            parts = b""


def test_wandb_has_the_curves_once_and_offline(tmp_path: Path) -> None:
    proto = pytest.importorskip("wandb.proto.wandb_internal_pb2")
    trained(tmp_path / "run", "wandb")
    for seed in SEEDS:
        (file,) = (tmp_path / "run" / "wandb" / f"seed-{seed}").rglob("*.wandb")
        points, names = [], set()
        for data in records_of(file):
            record: Any = proto.Record()
            record.ParseFromString(data)
            if record.HasField("run"):
                names.add((record.run.project, record.run.display_name))
            items = {item.key or "/".join(item.nested_key): json.loads(item.value_json) for item in record.history.item}
            if items:
                points.append((items["_step"], items["validation/success"]))
        assert points == curve(tmp_path / "run", seed)
        assert names == {("hhrl-bench", f"run seed {seed}")}


def test_mlflow_has_the_curves_once(tmp_path: Path) -> None:
    mlflow = pytest.importorskip("mlflow")
    trained(tmp_path / "run", "mlflow")
    client = mlflow.MlflowClient(tracking_uri=f"sqlite:///{tmp_path}/run/mlflow.db")
    experiment = client.get_experiment_by_name("hhrl-bench")
    runs = {run.data.params["seed"]: run for run in client.search_runs([experiment.experiment_id])}
    assert {run.data.params["method"] for run in runs.values()} == {"ddqn"}
    assert {run.info.status for run in runs.values()} == {"FINISHED"}
    assert sorted(runs) == [str(seed) for seed in SEEDS]
    for seed in SEEDS:
        history = client.get_metric_history(runs[str(seed)].info.run_id, "validation/success")
        assert [(one.step, one.value) for one in history] == curve(tmp_path / "run", seed)
