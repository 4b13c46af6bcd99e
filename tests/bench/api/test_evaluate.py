"""What ``hhrl_bench.evaluate`` returns: the command line's table and record, rows, failures, pictures and files."""

import importlib.util
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray
from PIL import Image

from hhrl_agents import ORACLES, RULES, Decision, from_callable
from hhrl_agents.atomic_files import OutputError
from hhrl_bench import Evaluation, evaluate, load_agent
from hhrl_bench.errors import AgentError, SeedError
from hhrl_bench.evaluation.records import EvaluationRecord
from hhrl_envs import Option, Outcome, errors, get_scenario
from hhrl_envs.arrays import Flags, Floats32
from hhrl_envs.errors import InputError, MissingExtraError
from support.command_line import invoke

EPISODES = 24


class Idle:
    """A flat agent that neither brakes nor throttles."""

    def reset(self, mask: Flags) -> None:
        pass

    def act(self, observations: Floats32) -> Decision:
        rows = len(observations)
        return Decision(np.full(rows, -1), np.full(rows, 3))


@pytest.fixture(scope="module")
def several() -> Evaluation:
    return evaluate(["rule-2", "hybrid-hrl"], "stop-line-v0", episodes=EPISODES)


@pytest.fixture(scope="module")
def rule_2() -> Evaluation:
    return evaluate("rule-2", episodes=EPISODES)


def stand(observations: Floats32) -> NDArray[np.int64]:
    return np.zeros(len(observations), np.int64)


def test_it_is_what_the_command_line_prints(several: Evaluation, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    words = ("evaluate", "rule-2", "hybrid-hrl", "--episodes", str(EPISODES))
    printed = [line.rstrip() for line in invoke(*words, columns=160).stdout.splitlines()]
    assert str(several).splitlines() == repr(several).splitlines() == printed
    record = EvaluationRecord.model_validate_json(invoke(*words, "--json").stdout)
    assert several.results == record.results
    assert several.task_record == record.task


def test_a_terminal_s_width_is_heeded(several: Evaluation, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    assert max(map(len, str(several).splitlines())) <= 60
    assert "| hybrid-hrl |" in several._repr_markdown_()
    assert several._repr_markdown_().startswith(f"### stop-line-v0, {EPISODES} test episodes")


def test_one_agent_of_several_is_the_same_alone(several: Evaluation, rule_2: Evaluation) -> None:
    assert several.agents == tuple(several) == ("rule-2", "hybrid-hrl")
    assert several["rule-2"].result == rule_2.result
    assert [run.seed for run in several["hybrid-hrl"].runs] == [0, 1, 2, 3, 4]
    with pytest.raises(InputError, match=r"choose one: evaluation\['rule-2'\]"):
        several.records  # noqa: B018
    with pytest.raises(AttributeError, match="5 training seeds"):
        several["hybrid-hrl"].outcome  # noqa: B018
    with pytest.raises(AgentError, match="no agent 'rule-3'; it has rule-2, hybrid-hrl"):
        several["rule-3"]


def test_the_records_of_a_single_policy_are_attributes(rule_2: Evaluation) -> None:
    assert len(rule_2) == len(rule_2.outcome) == EPISODES
    assert rule_2.steps is rule_2.records.steps
    assert rule_2.digest() == rule_2.records.digest()
    assert np.mean(rule_2.outcome == Outcome.SUCCESS) == np.mean(rule_2.success) == rule_2.result.metrics.success.mean
    assert not hasattr(rule_2, "nothing")


def test_agents_are_names_paths_and_objects() -> None:
    rule = RULES["rule-4"](get_scenario("stop-line-v0"))
    several = evaluate({"mine": Idle(), "given": rule, "named": "rule-4"}, episodes=5)
    assert several.agents == ("mine", "given", "named")
    assert [one.kind for one in several.results] == ["factory", "rule", "rule"]
    assert several["given"].records.digest() == several["named"].records.digest()
    function = evaluate(from_callable(stand), episodes=5)
    assert [(one.agent, one.kind) for one in function.results] == [("stand", "factory")]
    assert [one.kind for one in evaluate(ORACLES["oracle"](get_scenario("stop-line-v0")), episodes=5).results] == [
        "oracle"
    ]
    learned = load_agent("hybrid-hrl")
    alone = evaluate(learned, episodes=5)
    assert alone.agents == ("hybrid-hrl",)
    assert alone.runs[0].record.training is not None
    assert alone.runs[0].seed == 0
    assert evaluate(rule, episodes=5, option=Option.SSL).result.option == "stop"


@pytest.mark.parametrize(
    ("agents", "said"),
    [
        (["rule-4", "rule-4"], "two agents are called 'rule-4'; give them names"),
        ([], "no agent is given"),
        ([7], "int is no agent"),
        ({"x": None}, "None is no agent"),
        (["rule-4", stand], "stand is no agent; give what it makes"),
        (
            {"x": ["rule-4"]},
            "list is no agent; to give one agent several training seeds, name the folder of their files",
        ),
        ("rule-9", "unknown agent 'rule-9'"),
    ],
)
def test_what_is_no_agent_is_said_in_a_line(agents: object, said: str) -> None:
    with pytest.raises(AgentError, match=said):
        evaluate(agents, episodes=2)  # type: ignore[arg-type]


def test_an_agent_in_a_process_stays_the_caller_s(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "idle_agent.py").write_text(
        "import numpy as np\nclass Idle:\n    def __init__(self, scenario): pass\n    def reset(self, mask): pass\n"
        "    def act(self, seen): return np.full(len(seen), -1), np.full(len(seen), 3)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    agent = load_agent("idle_agent:Idle")
    first, again = (evaluate({"idle": agent}, episodes=3).records.digest() for _ in range(2))
    assert first == again == evaluate(Idle(), episodes=3).records.digest()


def test_rows_and_metrics_as_frames(several: Evaluation) -> None:
    frame = several.to_frame()
    assert len(frame) == 6 * EPISODES
    assert frame["training_seed"].isna().sum() == EPISODES
    rule = frame[frame["agent"] == "rule-2"]
    assert rule["world_seed"].tolist() == several["rule-2"].seed.tolist()
    assert (rule["outcome"] == "success").mean() == several.results[0].metrics.success.mean
    assert rule["impact_speed"].mean() == pytest.approx(several.results[0].metrics.impact_speed.mean)
    metrics = several.to_frame("metrics").set_index(["agent", "metric"])
    assert isinstance(metrics, pd.DataFrame)
    assert metrics.loc[("hybrid-hrl", "success"), "low"] == several.results[1].metrics.success.low


def test_failures_are_counted_by_cause_and_by_the_driver_in_front(several: Evaluation) -> None:
    failures, frame = several.failures(), several["rule-2"].to_frame()
    groups = {group.name: {row.name: row.cells for row in group.rows} for group in failures.table.groups}
    headings = [column.line for column in failures.table.columns]
    assert headings[:3] == ["episodes", "failed", "collision"]
    failed = frame[frame["cause"].notna()]
    for name, cells in groups["rule-2"].items():
        part = frame if name == "all" else frame[frame["profile"] == name]
        lost = failed if name == "all" else failed[failed["profile"] == name]
        assert cells[0].value == f"{len(part)}"
        assert cells[1].value == f"{len(lost) / len(part):.1%}"
        assert cells[1].bounds is not None
        assert cells[2].value == f"{(lost['cause'] == 'collision').sum()}"
    assert set(groups["rule-2"]) == {"all", *frame["profile"]}
    assert groups["hybrid-hrl"]["all"][0].value == f"{5 * EPISODES}"
    assert groups["hybrid-hrl"]["all"][1].bounds is None
    assert groups["rule-2"]["all"][-2].value == f"{failed['impact_speed'].mean():.2f}"
    assert "profile in front" in str(failures)
    assert several["rule-2"].failed() == failed["episode"].tolist()
    assert "smallest" in str(several.worst_cases())
    assert all(part in str(several.scores()) for part in ("progress", "comfort", "margin"))


def test_an_episode_is_watched_as_it_was_played(several: Evaluation, tmp_path: Path) -> None:
    episode = several.failed("rule-2")[0]
    picture = several.watch(episode, agent="rule-2")
    assert invoke("watch", "rule-2", "--episode", str(episode), "--out", str(tmp_path / "a.png")).exit_code == 0
    with Image.open(tmp_path / "a.png") as drawn:
        assert np.array_equal(np.asarray(drawn), np.asarray(picture))
    shortest = int(several["rule-2"].steps.argmin())
    moving = several.watch(shortest, tmp_path / "b.gif", agent="rule-2")
    assert moving.n_frames == several["rule-2"].steps[shortest] + 1  # type: ignore[attr-defined]
    assert (tmp_path / "b.gif").exists()
    of_a_seed, of_another = (several.watch(0, agent="hybrid-hrl", run=run) for run in (2, 3))
    assert not np.array_equal(np.asarray(of_a_seed), np.asarray(of_another))


def test_what_was_not_played_is_not_watched(rule_2: Evaluation, tmp_path: Path) -> None:
    with pytest.raises(SeedError, match=f"episode {EPISODES} was not played; write 0 to {EPISODES - 1}"):
        rule_2.watch(EPISODES)
    with pytest.raises(SeedError, match="rule-2 has no run 1; write 0 to 0"):
        rule_2.watch(0, run=1)
    with pytest.raises(OutputError, match=r"ends in \.gif or \.png"):
        rule_2.watch(0, tmp_path / "film.mp4")


def test_files_are_as_the_command_writes_them(rule_2: Evaluation, tmp_path: Path) -> None:
    assert rule_2.export(tmp_path / "a.csv") == [str(tmp_path / "a.csv")]
    words = ("export", "rule-2", "--episodes", str(EPISODES), "--to", str(tmp_path / "b.csv"))
    assert invoke(*words).exit_code == 0
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    with pytest.raises(InputError, match=r"the file to export to is 'a.xlsx'; write a name that ends in .csv"):
        rule_2.export(tmp_path / "a.xlsx")


@pytest.mark.parametrize(("missing", "extra"), [("pandas", "data"), ("pyarrow", "data"), ("h5py", "minari")])
def test_a_missing_extra_is_named(
    rule_2: Evaluation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, missing: str, extra: str
) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(errors, "find_spec", lambda name: None if name == missing else found(name))
    needs = {"pandas": rule_2.to_frame, "pyarrow": lambda: rule_2.export(tmp_path / "new" / "a.parquet")}
    with pytest.raises(MissingExtraError, match=f"the extra '{extra}' of hhrl-bench"):
        needs.get(missing, lambda: rule_2.export(tmp_path / "new"))()
    assert not list(tmp_path.iterdir())
