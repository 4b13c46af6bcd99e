"""``hhrl-bench analyse``: tables, JSON, and files that are whole and equal for equal analyses."""

from pathlib import Path

import matplotlib as mpl
import pytest
from PIL import Image

from hhrl_bench.analysis import analyse
from hhrl_bench.analysis.records import AnalysisRecord
from hhrl_bench.figures import analysis
from hhrl_envs import errors
from support.command_line import invoke

QUICK = ("--episodes", "20", "--task", "stop-line-paper-v0")
NAMES = ("attention-episode", "attention-plane", "level-rewards", "option-usage")


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What ``analyse`` writes of an agent that has everything."""
    folder = tmp_path_factory.mktemp("analysis") / "new"
    result = invoke("analyse", "hybrid-hrl", *QUICK, "--episode", "2", "--out", str(folder))
    assert result.exit_code == 0, result.stderr
    return folder


def test_files_are_the_record_and_four_figures(folder: Path) -> None:
    figures = [f"{name}.{suffix}" for name in NAMES for suffix in ("png", "svg")]
    assert [*files(folder)] == ["analysis.json", *figures]
    record = AnalysisRecord.model_validate_json((folder / "analysis.json").read_text())
    assert (record.agent, record.task.episodes, record.episode.number) == ("hybrid-hrl", 20, 2)
    assert record.training is not None
    assert record.training.seed == 0
    for path in folder.glob("*.png"):
        with Image.open(path) as image:
            assert image.width >= 900
            assert len(image.convert("L").histogram()) == 256


def test_json_is_the_record_and_nothing_else(folder: Path) -> None:
    result = invoke("analyse", "hybrid-hrl", *QUICK, "--episode", "2", "--json")
    assert result.stdout == (folder / "analysis.json").read_text()


def test_tables_say_options_places_rewards_and_attention() -> None:
    result = invoke("analyse", "hybrid-hrl", *QUICK, columns=80)
    assert result.exit_code == 0, result.stderr
    words = ("training seed 0", "20 test episodes", "switches", "out of range", "r^option", "d_dc/d_ds", "follow")
    assert all(word in result.stdout for word in words)
    assert max(map(len, result.stdout.splitlines())) <= 80
    assert "…" not in result.stdout


def test_a_line_says_what_an_agent_lacks() -> None:
    flat, rule = (invoke("analyse", agent, *QUICK).stdout for agent in ("ddqn", "rule-4"))
    assert "The agent is flat: it has no options" in flat
    assert "r^task" in flat
    assert "The agent is flat" not in rule
    assert flat.count("No attention: ") == rule.count("No attention: ") == 1


def test_a_flat_agents_files_leave_no_option_usage_of_another(tmp_path: Path) -> None:
    (tmp_path / "option-usage.png").write_text("of another agent")
    result = invoke("analyse", "ddqn", *QUICK, "--out", str(tmp_path))
    assert result.exit_code == 0, result.stderr
    assert {path.stem for path in tmp_path.iterdir()} == {"analysis", *NAMES[:3]}
    assert "option-usage" not in result.stderr


def test_equal_analyses_give_equal_files_whatever_the_users_settings(tmp_path: Path) -> None:
    record = analyse.analyse("ddqn", "stop-line-paper-v0", episodes=20)
    first, again = tmp_path / "first", tmp_path / "again"
    analysis.require_folder(first)
    analysis.write(record, first)
    with mpl.rc_context({"font.size": 20.0, "axes.grid": True, "svg.fonttype": "none"}):
        before = dict(mpl.rcParams)
        analysis.require_folder(again)
        analysis.write(record, again)
        assert dict(mpl.rcParams) == before
    assert files(first) == files(again)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "Missing argument 'AGENT'"),
        (("rule-9",), "unknown agent 'rule-9'"),
        (("rule-1", "--task", "x"), "unknown task 'x'"),
        (("rule-1", "--episodes", "0"), "ask for 1 to 10000"),
        (("rule-1", "--episode", "-1"), "'--episode'"),
        (("rule-1", "--episode", "1000000000"), "run past the range"),
    ],
)
def test_bad_usage_is_one_line_and_exit_code_2(arguments: tuple[str, ...], said: str) -> None:
    result = invoke("analyse", *arguments)
    assert (result.exit_code, result.stdout) == (2, "")
    assert said in result.stderr
    assert result.stderr.count("\n") == 1


def test_what_cannot_be_written_is_refused_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hhrl_bench.analysis.analyse.analyse", lambda *_: pytest.fail("analysed"))
    file = tmp_path / "file"
    file.write_text("before")
    result = invoke("analyse", "rule-1", "--out", str(file))
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "cannot write" in result.stderr
    assert file.read_text() == "before"
    monkeypatch.setattr(errors, "find_spec", lambda _: None)
    result = invoke("analyse", "rule-1", "--out", str(tmp_path / "new"))
    assert result.exit_code == 2
    assert "pip install -e '.[report]'" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
