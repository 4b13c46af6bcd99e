"""Users' agents that mean harm, or are careless: whatever one does, it spoils its own row alone."""

import os
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import pytest

from hhrl_bench.evaluation.records import EvaluationRecord, ResultRecord
from hhrl_bench.evaluation.results import evaluate_agent
from hhrl_bench.isolation import agent_process, landlock
from hhrl_bench.tasks.tasks import get_task
from support.command_line import invoke

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="only Linux bounds memory and hands over orphans")

TASK, EPISODES = get_task("stop-line-v0"), 3

AGENTS = """
import gc, os, signal, sys, time
from pathlib import Path
import numpy as np
from hhrl_agents import Decision

class Coasting:
    def __init__(self, scenario):
        self.folder = Path.cwd()
        self.action = 3
    def reset(self, mask):
        pass
    def deed(self):
        pass
    def act(self, observations):
        self.deed()
        return Decision(np.full(len(observations), -1), np.full(len(observations), self.action))

class Meddling(Coasting):
    def __init__(self, scenario):
        super().__init__(scenario)
        from hhrl_agents.rules import paper_rules
        from hhrl_envs import Simulator
        paper_rules.RuleAgent.act = Coasting.act
        Simulator.step = lambda *_: None
        np.random.seed(0)
        np.add = np.subtract
        if any(isinstance(one, Simulator) for one in gc.get_objects()):
            self.action = 0
        frame = sys._getframe()
        while frame := frame.f_back:
            if "simulator" in frame.f_locals or "seeds" in frame.f_locals:
                self.action = 0
        if list(self.folder.iterdir()):
            self.action = 0
        os.chdir("/")
        print("a line that is no result", flush=True)
        os.write(1, b"nor is this\\n")
        prevented = int(Path(__file__).with_name("landlock").read_text())
        paths = [*Path(__file__).parent.rglob("*"), Path(__file__).with_name("new")]
        for path in paths if prevented >= 1 else ():
            for meddle in (lambda: path.write_text("spoilt"), path.unlink, lambda: path.rename("/tmp/moved-away")):
                try:
                    meddle()
                except OSError:
                    pass
        processes = os.getppid(), int(Path(__file__).with_name("harness").read_text())
        for process in processes if prevented >= 6 else ():
            for meddle in (lambda: os.kill(process, signal.SIGKILL), lambda: open(f"/proc/{process}/mem", "r+b")):
                try:
                    meddle()
                except OSError:
                    pass
    def deed(self):
        if os.fork():
            os.wait()

class Orphaning(Coasting):
    def __init__(self, scenario):
        super().__init__(scenario)
        if os.fork() == 0:
            os.setsid()
            if os.fork() == 0:
                os.execlp("sleep", "sleep", "86317")
            os._exit(0)

class Leaving(Coasting):
    def deed(self):
        os._exit(3)

class Dying(Coasting):
    def deed(self):
        os.kill(os.getpid(), signal.SIGKILL)

class Raising(Coasting):
    def deed(self):
        raise KeyboardInterrupt

class Hanging(Coasting):
    def deed(self):
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        time.sleep(1000.0)

class Greedy(Coasting):
    def deed(self):
        kept = []
        while True:
            kept.append(np.empty(1 << 24))

class Muddling(Coasting):
    def deed(self):
        for descriptor in range(3, 20):
            try:
                os.write(descriptor, b"x" * 20)
            except OSError:
                pass
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with the agents in it, an answer's time cut short and little memory."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(agent_process.VARIABLE, "3")
    monkeypatch.setattr(agent_process, "physical_memory", lambda: 2 << 30)
    (tmp_path / "scratch").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "scratch"))
    (tmp_path / "agents.py").write_text(AGENTS)
    (tmp_path / "harness").write_text(str(os.getpid()))
    (tmp_path / "landlock").write_text(str(landlock.version()))
    return tmp_path


def content(folder: Path) -> Mapping[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def sleepers() -> list[str]:
    """Return the processes that an agent has left."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            found += [str(path)] * (path.read_bytes() == b"sleep\x0086317\x00")
        except OSError:
            continue
    return found


def evaluated(*agents: str) -> tuple[Mapping[str, ResultRecord], str]:
    """Return the results that one command gives, by agent, and what it says on stderr."""
    ended = invoke("evaluate", *agents, "--episodes", str(EPISODES), "--json")
    record = EvaluationRecord.model_validate_json(ended.stdout)
    return {result.agent: result for result in record.results}, ended.stderr


def test_hostile_agents_spoil_their_own_rows_alone(folder: Path) -> None:
    alone = evaluate_agent("rule-4", TASK, EPISODES)
    before = content(folder)
    failing = {
        "Leaving": "the agent's act ended its process with exit code 3",
        "Dying": "the agent's act ended as its process was killed by signal 9; is there enough memory?",
        "Raising": "the agent's process raised KeyboardInterrupt",
        "Hanging": "the agent's act took longer than 3 s; set HHRL_AGENT_SECONDS to allow more",
        "Greedy": "the agent's act raised",
        "Muddling": "the agent has written into the pipe of its process; let it write to stdout or stderr",
    }
    names = [f"agents:{name}" for name in ("Meddling", "Orphaning", *failing)]
    results, said = evaluated(*names, "rule-4")
    coasting, _ = evaluated("agents:Coasting")
    assert results["rule-4"] == alone == evaluate_agent("rule-4", TASK, EPISODES)
    assert list(results) == ["agents:Meddling", "agents:Orphaning", "rule-4"]
    assert results["agents:Meddling"].runs == results["agents:Orphaning"].runs == coasting["agents:Coasting"].runs
    for name, reason in failing.items():
        assert f"hhrl-bench: agents:{name}: {reason}" in said
    assert "a line that is no result" in said
    assert "nor is this" in said
    assert sleepers() == []
    assert list((folder / "scratch").iterdir()) == []
    assert content(folder) == before
