"""Transfer end to end on a tiny budget: arms, their curves and checkpoints, resuming, and what is refused."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from hhrl_agents.atomic_files import OutputError
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.learned_agent import LearnedAgent
from hhrl_bench.errors import AgentError, CurveError
from hhrl_bench.evaluation.paired_evaluation import play
from hhrl_bench.evaluation.records import TimedResult
from hhrl_bench.execution.unit import Unit
from hhrl_bench.leaderboard.entry import read_entry
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.suites.study import suite_study, transfer_study
from hhrl_bench.suites.suites import TransferSuite
from hhrl_bench.tasks.tasks import get_task
from hhrl_bench.training import train as training
from hhrl_bench.training.reuse import load_source
from hhrl_bench.training.run_directory import RunDirectory
from hhrl_bench.transfer.summary import recompute
from hhrl_bench.transfer.transfer import Transfer
from hhrl_envs import Option, get_scenario
from support.command_line import invoke
from support.small_training import plan, small_methods

SEEDS = (0, 2)
STEPS = 400
TARGET = get_task("stop-line-wet-v0")


@pytest.fixture(scope="module", autouse=True)
def small() -> Iterator[None]:
    with small_methods() as patch:
        patch.setattr("hhrl_bench.transfer.transfer.REPORTS", 4)
        yield


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run of two seeds of Hybrid HRL."""
    folder = tmp_path_factory.mktemp("source")
    list(training.train(plan(folder, SEEDS, "hybrid-hrl")))
    return folder


@pytest.fixture(scope="module")
def moved(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished transfer of it to two targets, one of which gives the actions."""
    folder = tmp_path_factory.mktemp("transfer")
    targets = ("--target", "stop-line-wet-v0", "--target", "option-only-v0")
    said = invoke("transfer", "--source", str(source), *targets, *small_options(folder))
    assert said.exit_code == 0, said.stderr
    assert "stop-line-wet-v0" in said.stdout
    assert "21 of 21" in said.stderr, "seven arms of two seeds, trained and then scored"
    return folder


def small_options(folder: Path) -> list[str]:
    return ["--env-steps", str(STEPS), "--episodes", "10", "--out", str(folder), "--workers", "1"]


def policy(path: Path) -> LearnedAgent:
    return checkpoints.load(path)


def level(agent: LearnedAgent, name: str) -> bytes:
    values = [value for key, value in sorted(agent.parameters.items()) if key.startswith(f"{name}.")]
    return b"".join(value.tobytes() for value in values)


def run_of(moved: Path, arm: str, target: str = "stop-line-wet-v0") -> RunDirectory:
    return RunDirectory(moved / "hybrid-hrl" / target / arm)


def test_every_arm_begins_and_ends_as_it_says(source: Path, moved: Path) -> None:
    for seed in SEEDS:
        given = policy(source / f"seed-{seed}.safetensors")
        last = {arm: policy(run_of(moved, arm).final(seed)) for arm in ("frozen-action", "fine-tune", "scratch")}
        zero = policy(run_of(moved, "zero-shot").best(seed))
        assert level(zero, "option") == level(given, "option")
        assert level(zero, "action") == level(given, "action") == level(last["frozen-action"], "action")
        assert level(last["frozen-action"], "option") != level(given, "option")
        assert level(last["fine-tune"], "action") != level(given, "action") != level(last["scratch"], "action")


def test_curves_begin_at_step_0_and_share_their_reports(moved: Path) -> None:
    board = read_entry(moved / "transfer.json")
    assert board.transfer is not None
    rows = {(row.target, row.arm): row for row in board.transfer.rows}
    assert {arm for target, arm in rows if target == "stop-line-wet-v0"} == {
        "zero-shot", "frozen-action", "fine-tune", "scratch",
    }  # fmt: skip
    assert {arm for target, arm in rows if target == "option-only-v0"} == {"zero-shot", "fine-tune", "scratch"}
    for row in rows.values():
        assert (row.method, row.source, row.seeds) == ("hybrid-hrl", "stop-line-v0", SEEDS)
        assert row.env_steps == tuple(range(0, STEPS + 1, STEPS // 4))
    for seed_curve, fine_tuned in zip(
        rows["stop-line-wet-v0", "zero-shot"].success, rows["stop-line-wet-v0", "fine-tune"].success, strict=True
    ):
        assert set(seed_curve) == {fine_tuned[0]}
    assert recompute(board.transfer) == board.transfer


def test_results_are_of_the_chosen_checkpoints_in_the_target(moved: Path) -> None:
    board = read_entry(moved / "transfer.json")
    assert [(result.task, result.agent) for result in board.results][:4] == [
        ("stop-line-wet-v0", f"hybrid-hrl {arm}") for arm in ("zero-shot", "frozen-action", "fine-tune", "scratch")
    ]
    for result in board.results:
        assert result.seeds == SEEDS
        steps = {run.training.budget for run in result.runs if run.training}
        assert steps == ({None} if "zero-shot" in result.agent else {STEPS})


def test_in_a_target_with_one_sub_goal_zero_shot_holds_it(source: Path, tmp_path: Path) -> None:
    target = get_task("solo-stop-v0")
    one = Transfer(str(source), target, SEEDS, STEPS, tmp_path)
    list(training.train(one.plan("zero-shot", one.load())))
    agent = policy(RunDirectory(one.folder_of("zero-shot")).best(0))
    scenario = get_scenario(target.scenario)
    records = play(agent, scenario, target.test.take(8), rows=8).records
    held = play(policy(source / "seed-0.safetensors"), scenario, target.test.take(8), option=Option.SSL, rows=8).records
    assert records.digest() == held.digest()


def test_a_stopped_transfer_goes_on_to_the_same_leaderboard(source: Path, moved: Path, tmp_path: Path) -> None:
    study = transfer_study(str(source), ["stop-line-wet-v0", "option-only-v0"], SEEDS, STEPS, 10, tmp_path)
    running = study.run()
    next(running), next(running)
    running.close()  # type: ignore[attr-defined]
    arm = study.curves.transfers[0].plan("fine-tune", study.curves.transfers[0].load())
    reports = training.train(replace(arm, seeds=SEEDS[:1]), resume=True)
    next(reports), next(reports), next(reports)
    reports.close()  # type: ignore[attr-defined]
    again = study.leaderboard(list(study.run()))
    whole = read_entry(moved / "transfer.json")
    assert same(again) == same(whole)


def test_a_finished_transfer_is_not_done_again(source: Path, moved: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = (moved / "transfer.json").read_bytes()
    monkeypatch.setattr("hhrl_bench.suites.units.evaluate_agent", lambda *_: pytest.fail("played"))
    monkeypatch.setattr(training, "make_learner", lambda *_: pytest.fail("trained"))
    targets = ("--target", "stop-line-wet-v0", "--target", "option-only-v0")
    said = invoke("transfer", "--source", str(source), *targets, *small_options(moved))
    assert said.exit_code == 0, said.stderr
    assert "holds the same results already" in said.stderr
    assert (moved / "transfer.json").read_bytes() == before


def test_an_outcome_that_was_damaged_is_made_again(source: Path, moved: Path) -> None:
    path = run_of(moved, "zero-shot").folder / "result-10.json"
    before = json.loads(path.read_text())["outcome"]["result"]
    path.write_text(path.read_text()[:100])
    (done,) = (
        unit.run() for unit in units_of(source, moved) if unit.name == "hybrid-hrl zero-shot on stop-line-wet-v0"
    )
    assert isinstance(done, TimedResult)
    assert json.loads(path.read_text())["outcome"]["result"] == json.loads(done.result.model_dump_json()) == before


def units_of(source: Path, folder: Path) -> list[Unit]:
    study = transfer_study(str(source), ["stop-line-wet-v0", "option-only-v0"], SEEDS, STEPS, 10, folder)
    return [unit for stage in study.stages for unit in stage]


def same(board: LeaderboardRecord) -> str:
    """A leaderboard without what may differ: its provenance."""
    return board.model_dump_json(exclude={"provenance"})


def test_a_run_of_another_source_is_not_gone_on_with(moved: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    list(training.train(plan(other, SEEDS, "hybrid-hrl", env_steps=500)))
    one = Transfer(str(other), TARGET, SEEDS, STEPS, moved / "hybrid-hrl" / TARGET.id)
    for arm in ("zero-shot", "frozen-action", "fine-tune"):
        with pytest.raises(OutputError, match="holds a run of another configuration"):
            list(training.train(one.plan(arm, one.load()), resume=True))
    assert not list(training.train(one.plan("scratch", one.load()), resume=True)), "it takes nothing over"
    said = invoke("transfer", "--source", str(other), "--target", TARGET.id, *small_options(moved))
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1), "said before anything is done"
    assert "holds a run of another configuration" in said.stderr


def test_a_suite_trains_its_sources_first(tmp_path: Path) -> None:
    suite = TransferSuite(
        "tiny", ("ddqn", "hrl-0"), "stop-line-v0", ("stop-line-wet-v0", "option-only-v0"), (0,), 200, 5
    )
    study = suite_study(suite, tmp_path)
    sources = ["ddqn on stop-line-v0", "hrl-0 on stop-line-v0"]
    arms = [
        *(f"ddqn {arm} on stop-line-wet-v0" for arm in ("zero-shot", "fine-tune", "scratch")),
        *(f"hrl-0 {arm} on stop-line-wet-v0" for arm in ("zero-shot", "frozen-action", "fine-tune", "scratch")),
        *(f"hrl-0 {arm} on option-only-v0" for arm in ("zero-shot", "fine-tune", "scratch")),
    ]
    assert [[unit.name for unit in stage] for stage in study.stages] == [
        [f"{name}, seed 0" for name in sources],
        [*sources, *(f"{name}, seed 0" for name in arms)],
        arms,
    ]
    assert [transfer.source for transfer in study.curves.transfers] == [
        str(tmp_path / method / "source") for method in ("ddqn", "hrl-0", "hrl-0")
    ]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--source", "nowhere", "--target", "stop-line-wet-v0"], "unknown agent 'nowhere'"),
        (
            ["--source", "rule-4", "--target", "stop-line-wet-v0"],
            "rule-4 is not trained, so nothing can be transferred",
        ),
        (["--source", "ddqn", "--target", "nowhere"], "unknown task 'nowhere'"),
        (
            ["--source", "ddqn", "--target", "option-only-v0"],
            "nothing of ddqn can be reused in a training on option-only-v0",
        ),
        (
            ["--source", "ddqn", "--target", "stop-line-wet-v0", "--seeds", "3-7"],
            "ddqn has no seed 5; write seeds of 0-4",
        ),
        (
            ["--source", "ddqn", "--target", "stop-line-wet-v0", "--env-steps", "0"],
            "Input should be greater than or equal to 1",
        ),
        (["--source", "ddqn", "--target", "stop-line-wet-v0", "--episodes", "0"], "cannot take 0 test seeds"),
        (
            ["--source", "ddqn", "--target", "stop-line-wet-v0", "--target", "stop-line-wet-v0"],
            "target 'stop-line-wet-v0' is named twice",
        ),
        (["--source", "ddqn"], "Missing option '--target'"),
        (["--target", "stop-line-wet-v0"], "Missing option '--source'"),
    ],
)
def test_a_transfer_that_cannot_be_is_one_line(arguments: list[str], said: str, tmp_path: Path) -> None:
    result = invoke("transfer", *arguments, "--out", str(tmp_path / "new"))
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert said in result.stderr
    assert not (tmp_path / "new").exists()


def test_a_target_of_another_interface_is_refused(source: Path) -> None:
    from dataclasses import replace  # noqa: PLC0415

    scenario = get_scenario("stop-line-wet-v0")
    other = replace(scenario, id="other-v0", vehicle=replace(scenario.vehicle, levels=(-4.0, 0.0, 2.0)))
    with pytest.raises(AgentError, match="its interface hash is"):
        load_source(str(source), other)


def test_a_source_that_always_begins_from_nothing_is_refused(tmp_path: Path) -> None:
    list(training.train(plan(tmp_path, (0,), "pqn", env_steps=200)))
    with pytest.raises(AgentError, match="is trained by pqn, which always begins from nothing"):
        load_source(str(tmp_path), get_scenario("stop-line-wet-v0"))


def test_an_arm_that_makes_no_sense_is_told_which_do(source: Path, tmp_path: Path) -> None:
    one = Transfer(str(source), get_task("solo-stop-v0"), SEEDS, STEPS, tmp_path)
    with pytest.raises(AgentError, match="write one of: zero-shot, fine-tune, scratch"):
        one.plan("frozen-action", one.load())


def test_a_seed_that_failed_succeeds_no_more(tmp_path: Path) -> None:
    from hhrl_bench.transfer.summary import _arm_curves  # noqa: PLC0415

    run = RunDirectory(tmp_path)
    (tmp_path / "config.json").write_text(json.dumps({"method": {"id": "ddqn"}, "task": "stop-line-v0"}))
    half, whole = ({"success": rate, "timeout": 0.0, "not_stop": 0.0, "collision": 0.0} for rate in (0.5, 1.0))
    run.write_curve(0, [{"env_steps": k, "episodes": {}, "validation": half} for k in (0, 10, 20)])
    rows = ((0, whole), (10, None))
    run.write_curve(1, [{"env_steps": k, "episodes": {}, "validation": rates} for k, rates in rows])
    curves = _arm_curves(tmp_path, (0, 1))
    assert curves.env_steps == (0, 10, 20)
    assert curves.success == ((0.5, 0.5, 0.5), (1.0, 0.0, 0.0))
    with pytest.raises(CurveError, match="cannot read the learning curve"):
        _arm_curves(tmp_path, (0, 2))
