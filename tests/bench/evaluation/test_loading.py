"""Agents by name, and users' factories: what cannot be loaded is said in one line."""

import sys
from pathlib import Path

import numpy as np
import pytest

from hhrl_agents import METHODS, RULES
from hhrl_bench.errors import AgentError, UnknownTaskError
from hhrl_bench.evaluation.loading import load_agent, load_agents
from hhrl_bench.evaluation.sources import shipped_methods
from hhrl_envs import get_scenario
from support.own_agents import COASTING

SCENARIO = get_scenario("stop-line-v0")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a module of a factory in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "coasting.py").write_text(COASTING)
    return tmp_path


def refused(source: str) -> str:
    with pytest.raises(AgentError) as caught:
        load_agents(source, SCENARIO)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    return message


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_is_one_agent_without_a_seed(rule: str) -> None:
    (loaded,) = load_agents(rule, SCENARIO)
    assert (loaded.kind, loaded.sha256, loaded.training) == ("rule", None, None)


def test_a_factory_in_the_current_folder_is_called_with_the_scenario(folder: Path) -> None:
    (loaded,) = load_agents("coasting:Coasting", SCENARIO)
    with loaded:
        assert loaded.kind == "factory"
        assert loaded.agent.act(np.zeros((2, 11), np.float32)).action.tolist() == [SCENARIO.num_actions - 3] * 2
    assert str(folder) not in sys.path
    assert "coasting" not in sys.modules


def test_an_unknown_agent_is_told_which_there_are() -> None:
    message = refused("rule-7")
    assert "unknown agent 'rule-7'" in message
    for name in [*RULES, *shipped_methods()]:
        assert name in message


def test_what_was_meant_is_asked_and_a_file_of_python_is_told_its_module(tmp_path: Path) -> None:
    assert "unknown agent 'hybrid_hrl', did you mean hybrid-hrl; write" in refused("hybrid_hrl")
    assert "did you mean" not in refused("somebody-else")
    path = tmp_path / "my_agent.py"
    for _ in range(2):
        assert refused(str(path)).endswith("is a file of Python; write module:factory, such as my_agent:make_agent")
        path.touch()


def test_a_method_without_shipped_seeds_is_told_how_to_train_it() -> None:
    method = next(method for method in METHODS if method not in shipped_methods())
    assert refused(method).endswith(f"train it: hhrl-bench train {method}")


def test_a_folder_without_checkpoints(tmp_path: Path) -> None:
    assert "holds no seed-<k>.safetensors" in refused(str(tmp_path))


def test_a_file_that_is_no_checkpoint(tmp_path: Path) -> None:
    path = tmp_path / "agent.safetensors"
    path.write_bytes(b"\x08\x00\x00\x00\x00\x00\x00\x00{}      ")
    with pytest.raises(ValueError, match=r"agent\.safetensors") as caught:
        load_agents(path, SCENARIO)
    assert len(str(caught.value).splitlines()) == 1


def test_load_agent_knows_tasks_by_their_ids() -> None:
    assert load_agent("rule-1", "stop-line-v0").act is not None
    with pytest.raises(UnknownTaskError):
        load_agent("rule-1", "stop-line-v9")


def test_a_factory_that_leaves_is_an_error_and_what_it_prints_is_no_result(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "leaving.py").write_text("import sys\nprint('hello')\ndef make(scenario):\n    sys.exit(5)\n")
    assert "SystemExit: 5" in refused("leaving:make")
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err == "hello\n"
