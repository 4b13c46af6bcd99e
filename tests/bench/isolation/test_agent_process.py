"""An agent in a process of its own is the same agent: it decides, and fails, as it would in this process."""

import gc
import sys
from pathlib import Path

import numpy as np
import pytest

from hhrl_agents import RULES, HierarchicalAgent
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.guarded_agent import AttentiveAgent, attend, attentive
from hhrl_bench.evaluation.loading import load_agent, load_agents
from hhrl_bench.evaluation.results import evaluate_agent
from hhrl_bench.isolation import agent_process
from hhrl_bench.isolation.agent_process import AgentProcess, allowed_seconds
from hhrl_bench.tasks.tasks import get_task
from hhrl_envs import get_scenario

TASK = get_task("stop-line-v0")
SCENARIO = get_scenario(TASK.scenario)

AGENTS = """
import sys
import tempfile
from pathlib import Path
import numpy as np
import hhrl_bench
from hhrl_agents import RULES, Decision

rule = RULES["rule-4"]

def learned(scenario):
    return hhrl_bench.load_agent("hybrid-hrl")

class Writing:
    def __init__(self, scenario):
        Path("notes.txt").write_text("in the scratch folder")
        with tempfile.NamedTemporaryFile() as file:
            assert Path(file.name).parent == Path.cwd()
        self.scenario = scenario
    def reset(self, mask):
        pass
    def act(self, observations):
        return Decision(np.full(len(observations), -1), np.full(len(observations), len(self.scenario.id)))
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with agents in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "agents.py").write_text(AGENTS)
    return tmp_path


def test_a_rule_and_its_levels_decide_the_same_apart() -> None:
    agent, rule = load_agent("agents:rule"), RULES["rule-4"](SCENARIO)
    assert isinstance(agent, HierarchicalAgent)
    assert isinstance(rule, HierarchicalAgent)
    assert attentive(agent) is None
    observations = np.random.default_rng(3).uniform(-1, 1, (40, 11)).astype(np.float32)
    for one in (agent, rule):
        one.reset(np.ones(40, np.bool_))
    for apart, here in zip(agent.act(observations), rule.act(observations), strict=True):
        np.testing.assert_array_equal(apart, here, strict=True)
    option = np.arange(40) % 2
    apart, here = (one.act_with_option(observations, option) for one in (agent, rule))
    np.testing.assert_array_equal(apart, here, strict=True)


def test_a_learned_agent_decides_and_attends_the_same_apart() -> None:
    here, apart = load_agent("hybrid-hrl"), load_agent("agents:learned")
    observations = np.random.default_rng(4).uniform(-1, 1, (40, 11)).astype(np.float32)
    option = np.arange(40) % 2
    for one in (here, apart):
        one.reset(np.ones(40, np.bool_))
    for ours, theirs in zip(here.act(observations), apart.act(observations), strict=True):
        np.testing.assert_array_equal(ours, theirs, strict=True)
    assert isinstance(here, AttentiveAgent)
    assert isinstance(apart, AttentiveAgent)
    weights, others = (attend(one, observations, option) for one in (here, apart))
    np.testing.assert_array_equal(weights, others, strict=True)


def test_an_agent_writes_into_a_folder_that_goes_with_it(folder: Path) -> None:
    agent = load_agent("agents:Writing")
    assert isinstance(agent, AgentProcess)
    process, scratch = agent._connection._process, agent._connection._folder
    assert [path.name for path in scratch.iterdir()] == ["notes.txt"]
    assert process.poll() is None
    del agent
    gc.collect()
    assert process.poll() == 0
    assert not scratch.exists()
    assert [path.name for path in folder.iterdir()] == ["agents.py"]


def test_an_answer_that_cannot_be_is_the_same_line_as_here() -> None:
    with pytest.raises(AgentError, match="agents:Writing: the agent's actions go from 12 to 12; return indices of"):
        evaluate_agent("agents:Writing", TASK, 2)


def test_an_agent_whose_process_has_ended_says_so() -> None:
    with load_agents("agents:rule", SCENARIO)[0] as loaded:
        pass
    with pytest.raises(AgentError, match="its process has ended; load the agent again"):
        loaded.agent.act(np.zeros((2, 11), np.float32))


def test_an_extension_is_loaded_there_too(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "of_mine.py").write_text("import hhrl_agents\nhhrl_agents.of_mine = 3\n")
    (folder / "asking.py").write_text("import hhrl_agents\nassert hhrl_agents.of_mine == 3\nfrom agents import rule\n")
    monkeypatch.setenv("HHRL_EXTENSIONS", str(folder / "of_mine.py"))
    with load_agents("asking:rule", SCENARIO)[0] as loaded:
        assert loaded.kind == "factory"


@pytest.mark.parametrize("said", ["soon", "0", "-1", "nan", "inf"])
def test_a_time_that_cannot_be_is_one_line(monkeypatch: pytest.MonkeyPatch, said: str) -> None:
    monkeypatch.setenv(agent_process.VARIABLE, said)
    with pytest.raises(AgentError, match=f"HHRL_AGENT_SECONDS is '{said}'; write a number of seconds, such as 120"):
        allowed_seconds()


def test_the_module_is_not_imported_here() -> None:
    with load_agents("agents:rule", SCENARIO)[0]:
        assert "agents" not in sys.modules
