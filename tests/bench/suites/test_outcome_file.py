"""A finished unit is read again as long as nothing about it has changed, and else made anew."""

from collections.abc import Callable
from pathlib import Path

import pytest

from hhrl_bench.evaluation.records import ResultRecord, TimedResult
from hhrl_bench.evaluation.results import evaluate_agent
from hhrl_bench.evaluation.store import Store
from hhrl_bench.suites import units
from hhrl_bench.suites.units import keep_outcome
from hhrl_bench.tasks.tasks import get_task

TASK = get_task("stop-line-v0")


class Unit:
    """A unit that counts how often it was done."""

    def __init__(self, folder: Path, agent: str) -> None:
        self.store, self.path, self.agent, self.times = Store(folder), folder / "deep" / "result-3.json", agent, 0

    def run(self) -> ResultRecord:
        return keep_outcome(self.path, self._make, self.agent, TASK, self.store).result

    def _make(self) -> TimedResult:
        self.times += 1
        return TimedResult(result=evaluate_agent(self.agent, TASK, 3, store=self.store), seconds=1.0)


@pytest.fixture
def unit(tmp_path: Path) -> Unit:
    return Unit(tmp_path, "rule-2")


def test_what_was_done_is_read(unit: Unit) -> None:
    first = unit.run()
    assert (unit.run(), unit.times) == (first, 1)


def forget(unit: Unit) -> None:
    unit.path.unlink()


def lose_evidence(unit: Unit) -> None:
    next(unit.store.folder.glob("evidence/*")).unlink()


def damage_evidence(unit: Unit) -> None:
    next(unit.store.folder.glob("evidence/*")).write_bytes(b"")


def damage(unit: Unit) -> None:
    unit.path.write_text(unit.path.read_text()[:-10])


def change_task(unit: Unit) -> None:
    unit.path.write_text(unit.path.read_text().replace('"stop-line-v0"', '"stop-line-v1"'))


@pytest.mark.parametrize("change", [forget, lose_evidence, damage_evidence, damage, change_task])
def test_what_is_missing_or_damaged_is_made_anew(unit: Unit, change: Callable[[Unit], None]) -> None:
    first = unit.run()
    change(unit)
    assert (unit.run(), unit.times) == (first, 2)
    assert (unit.run(), unit.times) == (first, 2)


def test_other_code_makes_it_anew(unit: Unit, monkeypatch: pytest.MonkeyPatch) -> None:
    first = unit.run()
    monkeypatch.setattr(units, "code_sha256", lambda: "0" * 64)
    assert (unit.run(), unit.times) == (first, 2)


def test_another_checkpoint_or_none_in_the_store_makes_it_anew(tmp_path: Path) -> None:
    checkpoints = pytest.importorskip("hhrl_agents.policies.checkpoints")
    from hhrl_agents.policies.checkpoint_file import SHIPPED  # noqa: PLC0415

    path = tmp_path / "seed-0.safetensors"
    path.write_bytes((SHIPPED / "follow-only" / "seed-0.safetensors").read_bytes())
    unit = Unit(tmp_path, str(path))
    first = unit.run()
    assert unit.times == len({unit.run().runs[0].checkpoint_sha256}) == 1
    next(unit.store.folder.glob("checkpoints/*")).unlink()
    assert (unit.run(), unit.times) == (first, 2)
    checkpoints.save(path, checkpoints.load(path), {"note": "another"})
    assert unit.run() != first
    assert unit.times == 3


def test_ones_own_code_is_always_scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = "import hhrl_agents\n\n\ndef make(scenario):\n    return hhrl_agents.RULES['rule-3'](scenario)\n"
    (tmp_path / "own_rule_of_mine.py").write_text(source)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    unit = Unit(tmp_path, "own_rule_of_mine:make")
    assert unit.run() == unit.run()
    assert unit.times == 2
