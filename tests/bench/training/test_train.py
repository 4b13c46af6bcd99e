"""Training, end to end on a tiny budget: run directories, the choice of checkpoints, and what they can be played in."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hhrl_agents.atomic_files import OutputError
from hhrl_agents.methods.method import Method
from hhrl_agents.policies.learned_agent import LearnedAgent
from hhrl_agents.training.learner import make_learner
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.loading import load_agents
from hhrl_bench.evaluation.paired_evaluation import play as really_play
from hhrl_bench.evaluation.records import EvaluationRecord
from hhrl_bench.tasks.tasks import get_task
from hhrl_bench.training import train as training
from hhrl_bench.training.saved_state import SeedRun
from hhrl_envs import Scenario, get_scenario
from support.command_line import invoke

TASK = get_task("stop-line-v0")
SCENARIO = get_scenario(TASK.scenario)
STEPS = 2400  # past the warm-up, so that gradient steps are taken
FILES = {
    "config.json",
    "provenance-seeds-0,2.json",
    *(
        f"{name}"
        for k in (0, 2)
        for name in (f"curve-seed-{k}.jsonl", f"seed-{k}.safetensors", f"seed-{k}.final.safetensors")
    ),
}


def plan(folder: Path, method: str = "ddqn", seeds: tuple[int, ...] = (0, 2)) -> training.Plan:
    return training.Plan(training.get_method(method), TASK, seeds, STEPS, folder)


@pytest.fixture(scope="module", autouse=True)
def small_validation() -> Any:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(training, "VALIDATION_EPISODES", 16)
        yield


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run of two seeds of the flat method."""
    folder = tmp_path_factory.mktemp("runs") / "ddqn"
    list(training.train(plan(folder)))
    return folder


def test_the_command_trains_and_its_run_can_be_evaluated(tmp_path: Path) -> None:
    folder = tmp_path / "runs" / "hybrid-hrl"
    trained = invoke("train", "hybrid-hrl", "--seeds", "0,2", "--env-steps", str(STEPS), "--out", str(folder))
    assert trained.exit_code == 0, trained.stderr
    assert trained.stdout == f"{folder}\n"
    assert "2,400 of 2,400 validation success" in trained.stderr
    assert {path.name for path in folder.iterdir()} == FILES | {f"end-state-seed-{k}.safetensors" for k in (0, 2)}
    evaluated = invoke("evaluate", str(folder), "--episodes", "25", "--json")
    result = EvaluationRecord.model_validate_json(evaluated.stdout).results[0]
    assert (result.kind, result.seeds) == ("learned", (0, 2))
    assert result.metrics.success.interval == "bootstrap-seeds"
    assert (result.metrics.steps.n, result.metrics.return_option.n) == (2, 2)
    for record in result.runs:
        assert record.training is not None
        assert record.training.method == "hybrid-hrl"
        assert record.training.budget == STEPS
        assert record.training.env_steps in {0, STEPS}  # whichever validation chose
        assert record.training.exact
        command = f"hhrl-bench train hybrid-hrl --task stop-line-v0 --seeds {record.training.seed} --env-steps 2400"
        assert record.training.command == command


@pytest.mark.parametrize(
    ("method", "task"),
    [("ppo", "stop-line-v0"), ("option-only", "option-only-v0"), ("hybrid-hrl-plus", "stop-line-noisy-v0")],
)
def test_other_methods_are_trained_and_evaluated_by_the_same_commands(method: str, task: str, tmp_path: Path) -> None:
    folder = tmp_path / method
    trained = invoke("train", method, "--task", task, "--seeds", "0", "--env-steps", "640", "--out", str(folder))
    assert trained.exit_code == 0, trained.stderr
    evaluated = invoke("evaluate", str(folder), "--task", task, "--episodes", "25", "--json")
    record = EvaluationRecord.model_validate_json(evaluated.stdout).results[0].runs[0].training
    assert record is not None
    assert (record.method, record.budget, record.exact) == (method, 640, method != "ppo")
    said = invoke("evaluate", str(folder), "--task", task, "--episodes", "25").stdout
    assert ("the same training gives other policies on other machines" in " ".join(said.split())) == (method == "ppo")
    (last,) = load_agents(folder / "seed-0.final.safetensors", get_scenario(get_task(task).scenario))
    assert last.training is not None
    assert last.training.env_steps == 640


def test_curves_are_json_lines_with_validation(run: Path) -> None:
    for seed in (0, 2):
        rows = [json.loads(line) for line in (run / f"curve-seed-{seed}.jsonl").read_text().splitlines()]
        assert [row["env_steps"] for row in rows] == [0, STEPS]
        assert (rows[0]["updates"], rows[0]["losses"], rows[0]["episodes"]) == (0, {}, {})
        assert rows[-1]["updates"] > 0
        assert rows[-1]["losses"]["action"] > 0
        rates = [rows[-1]["validation"][key] for key in ("collision", "not_stop", "timeout", "success")]
        assert sum(rates) == pytest.approx(1.0)


def test_the_same_training_again_learns_the_same(run: Path, tmp_path: Path) -> None:
    list(training.train(plan(tmp_path)))
    for path in run.iterdir():
        if not path.name.startswith("provenance"):
            assert (tmp_path / path.name).read_bytes() == path.read_bytes()


def test_a_flat_method_shows_no_option_and_action_reward(run: Path) -> None:
    said = invoke("evaluate", str(run), "--episodes", "10").stdout
    assert "bootstrap over the 2 training seeds." in said
    assert said.count("\N{EN DASH}") == 2


def test_training_never_sees_a_world_of_validation_or_test(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    learned, validated = [], []

    def watched(method: Method, world: Scenario, seed: int, world_seeds: Any, *others: Any) -> Any:
        learned.append(world_seeds)
        return make_learner(method, world, seed, world_seeds, *others)

    def play(agent: LearnedAgent, scenario: Scenario, seeds: np.ndarray[Any, Any], **kwargs: Any) -> Any:
        validated.append(seeds)
        return really_play(agent, scenario, seeds, **kwargs)

    monkeypatch.setattr(training, "make_learner", watched)
    monkeypatch.setattr(training, "play", play)
    list(training.train(plan(tmp_path)))
    worlds = np.concatenate(learned)
    assert len(np.unique(worlds)) == worlds.size
    assert TASK.train.start <= worlds.min()
    assert worlds.max() < TASK.train.start + TASK.train.size
    assert len(validated) == 2 * 2
    for seeds in validated:
        assert seeds.tolist() == [TASK.validation.start + i for i in range(16)]


def test_a_seed_learns_the_same_whatever_is_trained_beside_it(run: Path, tmp_path: Path) -> None:
    list(training.train(plan(tmp_path, seeds=(2,))))
    for name in ("curve-seed-2.jsonl", "seed-2.final.safetensors"):
        assert (tmp_path / name).stat().st_size > 0
    alone, beside = (load_agents(folder / "seed-2.final.safetensors", SCENARIO)[0].agent for folder in (tmp_path, run))
    assert isinstance(alone, LearnedAgent)
    assert isinstance(beside, LearnedAgent)
    assert all(np.array_equal(value, beside.parameters[name]) for name, value in alone.parameters.items())


@pytest.mark.parametrize(
    ("reports", "best"),
    [
        ([(0.5, 0.2, 1.0), (0.6, 0.4, 0.0)], 1),
        ([(0.6, 0.2, 1.0), (0.6, 0.1, 0.0)], 1),
        ([(0.6, 0.2, 1.0), (0.6, 0.2, 2.0), (0.5, 0.0, 9.0)], 1),
        ([(0.6, 0.2, 1.0), (0.6, 0.2, 1.0)], 0),
    ],
)
def test_the_best_policy_has_more_successes_then_fewer_collisions_then_more_reward(
    reports: Sequence[tuple[float, float, float]], best: int
) -> None:
    seed_run = SeedRun(0)
    for success, collision, reward in reports:
        row = {"validation": {"success": success, "collision": collision, "return_task": reward}}
        assert seed_run.add(row) == (seed_run.best == len(seed_run.curve) - 1)
    assert seed_run.best == best
    assert len(seed_run.curve) == len(reports)


def test_a_run_directory_keeps_what_it_holds(run: Path) -> None:
    before = {path.name: path.read_bytes() for path in run.iterdir()}
    for other, said in (
        (plan(run, seeds=(1, 2)), "holds seed 2 already"),
        (replace(plan(run, seeds=(7,)), env_steps=STEPS + 1), "holds a run of another configuration"),
        (plan(run, method="hybrid-hrl", seeds=(7,)), "holds a run of another configuration"),
    ):
        with pytest.raises(OutputError, match=said):
            next(training.train(other))
    assert {path.name: path.read_bytes() for path in run.iterdir()} == before


def test_a_checkpoint_plays_in_another_scenario(run: Path) -> None:
    other = replace(SCENARIO, id="stop-line-other-v0", horizon=300)
    assert [loaded.training.seed for loaded in load_agents(run, other) if loaded.training] == [0, 2]


def test_a_checkpoint_of_another_version_of_the_scenario_is_refused_with_both_hashes(run: Path) -> None:
    changed = replace(SCENARIO, horizon=300)
    with pytest.raises(AgentError) as caught:
        load_agents(run / "seed-0.safetensors", changed)
    assert SCENARIO.spec_hash in str(caught.value)
    assert changed.spec_hash in str(caught.value)


def test_a_checkpoint_that_names_another_scenario_than_its_hash_is_refused(run: Path, tmp_path: Path) -> None:
    forged = (run / "seed-0.safetensors").read_bytes().replace(b"stop-line-v0", b"two-stops-v0")
    (tmp_path / "forged.safetensors").write_bytes(forged)
    with pytest.raises(AgentError, match="another version of two-stops-v0"):
        load_agents(tmp_path / "forged.safetensors", SCENARIO)


def test_a_checkpoint_of_another_interface_is_refused(run: Path) -> None:
    changed = replace(SCENARIO, id="other-v0", vehicle=replace(SCENARIO.vehicle, levels=(-4.0, 0.0, 2.0)))
    with pytest.raises(AgentError, match="interface hash"):
        load_agents(run, changed)


@pytest.mark.parametrize("size", [0, 7, 8, 100, -1])
def test_a_truncated_checkpoint_is_refused_in_one_line(run: Path, tmp_path: Path, size: int) -> None:
    path = tmp_path / "short.safetensors"
    path.write_bytes((run / "seed-0.safetensors").read_bytes()[:size])
    result = invoke("evaluate", str(path))
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "short.safetensors" in result.stderr


def test_a_checkpoint_that_lies_about_its_training_is_refused(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (loaded, _) = load_agents(run, SCENARIO)
    assert isinstance(loaded.agent, LearnedAgent)
    monkeypatch.setitem(loaded.agent.metadata, "seed", "seven")
    monkeypatch.setattr("hhrl_agents.policies.checkpoints.load", lambda _: loaded.agent)
    with pytest.raises(AgentError, match="seed: write a valid integer"):
        load_agents(run / "seed-0.safetensors", SCENARIO)


def test_the_engine_torch_trains_and_says_so(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    trained = invoke("train", "ddqn", "--engine", "torch", "--env-steps", str(STEPS), "--out", str(folder))
    assert trained.exit_code == 0, trained.stderr
    assert json.loads((folder / "config.json").read_text())["engine"] == "torch"
    (last,) = load_agents(folder / "seed-0.final.safetensors", SCENARIO)
    assert last.training is not None
    assert str(last.training.command).endswith("--env-steps 2400 --engine torch --device cpu")
    assert not last.training.exact


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--engine", "jax"], "engine is 'jax'; write compiled or torch"),
        (["--device", "cuda"], "device is 'cuda'; write cpu, or the engine torch too"),
        (["--engine", "torch", "--device", "nowhere"], "torch cannot compute on device 'nowhere'; write cpu, or cuda"),
    ],
)
def test_an_engine_or_device_that_there_is_not_is_one_line(options: list[str], said: str, tmp_path: Path) -> None:
    refused = invoke("train", "ddqn", *options, "--out", str(tmp_path / "run"))
    assert refused.exit_code == 2
    assert f"hhrl-bench: {said}" in refused.stderr
    assert refused.stderr.count("\n") == 1
    assert not (tmp_path / "run").exists()
