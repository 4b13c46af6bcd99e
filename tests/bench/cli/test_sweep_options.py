"""The options that say who does the units: what contradicts itself or is not there is one line."""

from pathlib import Path

import pytest

from hhrl_bench.suites.suites import ScoreSuite
from support.command_line import invoke

TINY = ScoreSuite("quick", agents=("rule-2",), tasks=("stop-line-v0",), episodes=5)


@pytest.fixture(autouse=True)
def _tiny(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("hhrl_bench.suites.suites.SUITES", {"quick": TINY})
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--address", "127.0.0.1:6379"], "an --address is that of a Ray cluster; add --executor ray"),
        (["--executor", "ray", "--workers", "2"], "leave --workers out"),
        (["--executor", "slurm"], "'slurm' is not one of 'local', 'ray'"),
        (["--unit-timeout", "0"], "'--unit-timeout': Input should be greater than or equal to 0.01"),
        (["--unit-timeout", "nan"], "'--unit-timeout'"),
        (["--workers", "0"], "'--workers': Input should be greater than or equal to 1"),
    ],
)
def test_what_contradicts_itself_is_one_line(options: list[str], said: str) -> None:
    done = invoke("run", *options)
    assert (done.exit_code, done.stdout) == (2, "")
    assert len(done.stderr.splitlines()) == 1
    assert said in done.stderr


def test_a_missing_extra_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hhrl_envs.errors.find_spec", lambda _: None)
    done = invoke("run", "--executor", "ray")
    assert (done.exit_code, done.stdout) == (2, "")
    assert "pip install -e '.[ray]'" in done.stderr


def test_the_executor_is_provenance_and_a_worker_of_one_can_be_timed(tmp_path: Path) -> None:
    done = invoke("run", "--workers", "1", "--unit-timeout", "10", "--out", "a.json")
    assert done.exit_code == 0, done.stderr
    assert '"executor": "local"' in (tmp_path / "a.json").read_text()
    assert (tmp_path / "runs" / "quick" / "progress" / "study.json").exists()
