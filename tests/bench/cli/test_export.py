"""The command ``export``: what it writes and says, and what it refuses in one line."""

import csv
from pathlib import Path

import minari
import numpy as np
import onnxruntime
import pytest
from pyarrow import parquet

from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_bench.evaluation.loading import load_agent
from hhrl_envs.observation import SIZE
from support.command_line import invoke

ENTRY = Path(__file__).parents[3] / "leaderboards" / "quick.json"


def test_an_exported_agent_decides_as_it_does_here(tmp_path: Path) -> None:
    path = tmp_path / "new" / "agent.onnx"
    result = invoke("export", "hybrid-hrl", "--onnx", str(path))
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith(f"{path}: option and action values of hybrid-hrl, training seed 0\n")
    assert "decides alike in 4,096 of 4,096 random states (0 ties); values differ by at most" in result.stdout
    assert [one.name for one in path.parent.iterdir()] == ["agent.onnx"]
    states = np.random.default_rng(1).normal(size=(64, SIZE)).astype(np.float32)
    options, actions = onnxruntime.InferenceSession(path).run(None, {"features": states})
    decision = load_agent("hybrid-hrl").act(states)
    assert (options.argmax(1) == decision.option).all()
    assert (actions.argmax(1) == decision.action).all()


def test_one_level_is_said_to_be_one(tmp_path: Path) -> None:
    checkpoint = SHIPPED / "follow-only" / "seed-0.safetensors"
    result = invoke("export", str(checkpoint), "--onnx", str(tmp_path / "agent.onnx"))
    assert result.exit_code == 0, result.output
    assert "action values of follow-only, training seed 0\n" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("rule-4",), "agent 'rule-4' has no networks to write; name a learned one"),
        (("hybird-hrl",), "unknown agent 'hybird-hrl', did you mean hybrid-hrl"),
        (("pqn",), "no trained pqn comes with the package"),
        (("nowhere.safetensors",), "there is no file nowhere.safetensors"),
        (("ddqn", "--task", "nothing-v0"), "nothing-v0"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_a_line(
    arguments: tuple[str, ...], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = invoke("export", *arguments, "--onnx", "agent.onnx")
    assert (result.exit_code, result.stdout) == (2, "")
    assert len(result.stderr.splitlines()) == 1
    assert said in result.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("place", [".", "file/agent.onnx"])
def test_a_place_that_cannot_be_written_is_refused_in_a_line(
    place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("in the way")
    result = invoke("export", "ddqn", "--onnx", place)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("hhrl-bench: cannot write ")
    assert len(result.stderr.splitlines()) == 1


def test_what_to_write_has_to_be_named() -> None:
    result = invoke("export", "ddqn")
    assert result.exit_code == 2
    assert "name what to write: --to FILE_OR_FOLDER, or --onnx FILE" in result.stderr


def test_an_entry_s_episodes_are_those_that_are_run(tmp_path: Path) -> None:
    for name, words in (("run", ()), ("kept", ("--entry", str(ENTRY)))):
        done = invoke("export", "rule-2", "--episodes", "30", "--to", str(tmp_path / f"{name}.csv"), *words)
        assert (done.exit_code, done.stdout) == (0, f"{tmp_path / name}.csv\n")
    rows = list(csv.DictReader((tmp_path / "kept.csv").read_text().splitlines()))
    assert (tmp_path / "run.csv").read_text() == (tmp_path / "kept.csv").read_text()
    assert [row["episode"] for row in rows] == [str(index) for index in range(30)]
    assert {row["cause"] for row in rows} == {"collision", ""}


@pytest.mark.parametrize("words", [("--to", "a.parquet"), ("--to", "a.data", "--format", "parquet")])
def test_a_parquet_file_is_known_by_its_name_or_by_the_format(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    task = ("--task", "adversary-v0", "--opponent", "scripted")
    assert invoke("export", "rule-4", *task, "--episodes", "3", *words).exit_code == 0
    assert parquet.read_table(words[1]).to_pydict()["agent"] == ["rule-4"] * 3


def test_a_folder_becomes_one_of_minari_s_datasets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    done = invoke("export", "rule-4", "--entry", str(ENTRY), "--episodes", "4", "--to", str(tmp_path))
    assert (done.exit_code, done.stdout) == (0, "hhrl/stop-line-v0/rule-4-v0\n")
    assert f"MINARI_DATASETS_PATH={tmp_path}" in done.stderr
    assert minari.load_dataset(done.stdout.strip()).total_episodes == 4


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--to", "a.xlsx"), "the file to export to is 'a.xlsx'; write a name that ends in .csv or .parquet"),
        (("--to", "a.csv", "--format", "json"), "the format is 'json'; write csv, parquet or minari"),
        (("--to", "file/a.csv"), "cannot write file/a.csv"),
        (("--to", "file", "--format", "minari"), "cannot write file: it is not a folder"),
        (("--to", "a.csv", "--onnx", "a.onnx"), "it says nothing to --onnx; leave one out"),
        (("--to", "a.csv", "--entry", str(ENTRY), "--option", "stop"), "it says nothing to --entry; leave one out"),
        (("--to", "a.csv", "--entry", str(ENTRY), "--task", "solo-stop-v0"), "the entry has no rule-4 on solo-stop-v0"),
        (("--to", "a.csv", "--episodes", "0"), "cannot take 0 test seeds"),
        (("--to", "a.csv", "--entry", "nowhere.json"), "nowhere.json"),
    ],
)
def test_what_cannot_be_written_is_refused_in_a_line(
    words: tuple[str, ...], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("in the way")
    result = invoke("export", "rule-4", *words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert said in " ".join(result.stderr.replace("\u2502", " ").split())
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
