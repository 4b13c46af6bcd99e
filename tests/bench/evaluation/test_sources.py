"""What the name of an agent stands for: shipped seeds, files, folders and lists of them, factories with seeds."""

from pathlib import Path

import numpy as np
import pytest

from hhrl_agents.policies.checkpoint_file import SHIPPED
from hhrl_bench.evaluation.loading import load_agents, require_playable
from hhrl_bench.evaluation.results import evaluate_agent
from hhrl_bench.evaluation.sources import named_seeds, policy_files, runs_apart, shipped_checkpoints
from hhrl_bench.tasks.tasks import get_task
from hhrl_envs import InputError, get_scenario

TASK, SCENARIO = get_task("stop-line-v0"), get_scenario("stop-line-v0")

SEEDED = """
import numpy as np

class Seeded:
    def __init__(self, scenario, seed):
        self.action = 2 + seed
    def reset(self, mask):
        pass
    def act(self, observations):
        return np.full(len(observations), self.action)

def plain(scenario):
    return Seeded(scenario, 0)
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a module, and a folder of files."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "seeded.py").write_text(SEEDED)
    (tmp_path / "models").mkdir()
    for name in ("run_10.zip", "run_2.zip", "notes.txt"):
        (tmp_path / "models" / name).touch()
    return tmp_path


def test_seeds_that_come_with_the_package_have_names() -> None:
    assert named_seeds("hybrid-hrl:3") == ("hybrid-hrl", (3,))
    assert named_seeds("rule-4:3") is None
    assert shipped_checkpoints("ddqn:0-1,4") == [SHIPPED / "ddqn" / f"seed-{seed}.safetensors" for seed in (0, 1, 4)]
    assert [one.training.seed for one in load_agents("ddqn:4,2", SCENARIO) if one.training] == [2, 4]
    assert evaluate_agent("hybrid-hrl:3", TASK, 5).seeds == (3,)


def test_a_folder_a_list_and_a_file_are_files_in_the_order_of_their_numbers(folder: Path) -> None:
    models = folder / "models"
    wanted = [str(models / "run_2.zip"), str(models / "run_10.zip")]
    assert runs_apart("models") == wanted
    assert runs_apart("models/run_10.zip,models/run_2.zip") == wanted[::-1]
    assert runs_apart("models/run_2.zip") == wanted[:1]
    assert runs_apart(str(SHIPPED / "ddqn")) == []
    (folder / "a,b.zip").touch()
    assert policy_files("a,b.zip") == [Path("a,b.zip")]
    assert policy_files("") == []


def test_files_of_other_libraries_run_apart(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setattr("hhrl_bench.evaluation.loading.AgentProcess", lambda _, source, __: asked.append(source))
    for loaded in load_agents("models", SCENARIO):
        assert loaded.kind == "factory"
        _ = loaded.agent
    assert asked == [str(folder / "models" / name) for name in ("run_2.zip", "run_10.zip")]


def test_a_factory_has_the_seeds_behind_the_at() -> None:
    assert runs_apart("seeded:Seeded@0-1,7") == [f"seeded:Seeded@{seed}" for seed in (0, 1, 7)]
    assert runs_apart("seeded:plain") == ["seeded:plain"]
    result = evaluate_agent("seeded:Seeded@0,3", TASK, 4)
    assert (result.kind, len(result.runs), result.metrics.steps.interval) == ("factory", 2, "bootstrap-seeds")
    assert result.runs[0].metrics.steps != result.runs[1].metrics.steps


def test_a_process_begins_when_its_seed_is_asked_for() -> None:
    first, second = load_agents("seeded:Seeded@0-1", SCENARIO)
    assert "agent" in first.__dict__
    assert "agent" not in second.__dict__
    with second:
        assert second.agent.act(np.zeros((2, 11), np.float32)).action.tolist() == [3, 3]
    with first:
        pass


def test_a_bare_array_is_a_flat_decision() -> None:
    with load_agents("seeded:plain", SCENARIO)[0] as loaded:
        decision = loaded.agent.act(np.zeros((3, 11), np.float32))
    assert (decision.option.tolist(), decision.action.tolist()) == ([-1] * 3, [2] * 3)


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("ddqn:9", "no seed 9 of ddqn comes with the package; write seeds of 0-4"),
        ("ddqn:3-1", "seeds '3-1' hold the falling range 3-1; write 1-3"),
        ("models/run_2.zip,models/run_3.zip", "lists models/run_3.zip, which is not there"),
        ("models/run_2.zip,models/run_2.zip", "lists a file twice"),
        ("models/run_2.zip,models/notes.txt", "holds files of several kinds, .txt, .zip; name files of one of them"),
        ("nowhere.zip", "there is no file nowhere.zip; name the file of a policy that is there"),
        ("nowhere.safetensors", "there is no file nowhere.safetensors"),
        ("seeded:plain@", "cannot read seeds ''"),
        ("seeded:plain@x", "cannot read seeds 'x'"),
        ("seeded:plain@0-200", "has 201 training seeds; name at most 100"),
        ("seeded:plain@0-1", "let it take the scenario and the training seed"),
        ("seeded:Seeded", "let it take the scenario alone"),
        ("models/run_2.zip", "run_2.zip"),
        ("nowhere:make@0-3", "cannot import 'nowhere'"),
        ("hybrid_hrl", "unknown agent 'hybrid_hrl', did you mean hybrid-hrl; write the file of a policy"),
    ],
)
def test_what_names_none_is_said_in_one_line(source: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        load_agents(source, SCENARIO)
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_checkpoints_in_a_list_are_seeds_of_one_training() -> None:
    first, second, other = (
        str(SHIPPED / name / f"seed-{seed}.safetensors") for name, seed in (("ddqn", 3), ("ddqn", 1), ("hybrid-hrl", 2))
    )
    assert [one.training.seed for one in load_agents(f"{first},{second}", SCENARIO) if one.training] == [1, 3]
    with pytest.raises(InputError, match="holds no training seeds of one method; name different seeds"):
        load_agents(f"{first},{other}", SCENARIO)


def test_what_is_plainly_not_there_is_said_before_anything_is_run() -> None:
    require_playable(["models", "seeded:Seeded@0-1", "ddqn:1"], TASK)
    for absent in ("nowhere.zip", "nowhere:make@0-1", "ddqn:9"):
        with pytest.raises(InputError):
            require_playable(["models", absent], TASK)
