"""A command that fails leaves no folder that it has made, neither an empty one nor a half filled one."""

import shutil
from pathlib import Path

import pytest

from support.command_line import invoke

PUBLISHED = Path(__file__).parents[3] / "leaderboards"
BROKEN = "def make(scenario):\n    raise ValueError('broken')\n"


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("broken.py").write_text(BROKEN)
    return tmp_path


@pytest.mark.parametrize(
    "words",
    [
        ("evaluate", "broken:make", "--episodes", "1", "--per-episode", "new/newer/a.csv"),
        ("watch", "broken:make", "--out", "new/newer/a.png"),
        ("watch", "rule-4", "--episode", "2000000000", "--out", "new/newer/a.gif"),
        ("analyse", "broken:make", "--out", "new/newer"),
        ("analyse", "rule-4", "--task", "platoon-v0", "--out", "new/newer"),
        ("export", "rule-4", "--onnx", "new/newer/a.onnx"),
        ("run", "--agent", "broken:make", "--work", "new/newer", "--workers", "1"),
        ("run", "--agent", "broken:make", "--work", "new/newer", "--out", "other/a.json", "--workers", "1"),
        ("transfer", "--source", "hybrid-hrl", "--target", "option-only-v0", "--seeds", "7", "--out", "new/newer"),
        ("train", "ddqn", "--engine", "torch", "--device", "nowhere", "--out", "new/newer"),
        ("train", "adversary", "--task", "stop-line-v0", "--engine", "jax", "--out", "new/newer"),
        ("calibrate", "--episodes", "0", "--out", "new/newer"),
        ("tune", "rule-tuned", "--task", "solo-stop-v0", "--env-steps", "1000", "--out", "new/newer/a.json"),
        ("report", "nowhere.json", "--out", "new/newer/a.html"),
        ("figures", "nowhere.json", "--out", "new/newer"),
    ],
    ids=" ".join,
)
def test_nothing_is_left_of_a_command_that_fails(words: tuple[str, ...], here: Path) -> None:
    said = invoke(*words)
    assert said.exit_code in {1, 2}
    assert [path.name for path in here.iterdir() if path.name != "__pycache__"] == ["broken.py"], said.stderr


def test_figures_of_an_entry_whose_files_are_missing_are_all_or_none(here: Path) -> None:
    shutil.copy(PUBLISHED / "quick.json", here)
    said = invoke("figures", "quick.json")
    assert (said.exit_code, "cannot read evidence" in said.stderr) == (2, True)
    assert not Path("quick").exists()
