"""The command line, end to end: exit codes, one line an error, JSON alone on stdout, no half-written file."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, TextIO

import pytest

import hhrl_bench
from hhrl_agents import METHODS, ORACLES, RULES
from hhrl_bench import evaluate
from hhrl_bench.evaluation.loading import load_agent
from hhrl_bench.evaluation.records import EvaluationRecord
from hhrl_bench.evaluation.sources import shipped_methods
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.suites import suites, units
from hhrl_bench.suites.suites import SUITES, ScoreSuite
from hhrl_bench.tasks.tasks import TASKS
from support.command_line import invoke

ROOT = Path(hhrl_bench.__file__).parent.parent


def done(*arguments: str) -> str:
    """Return stdout of a command that must succeed."""
    result = invoke(*arguments)
    assert result.exit_code == 0, result.stderr
    return result.stdout


def refused(*arguments: str) -> str:
    """Return the one line of a command that must be refused."""
    result = invoke(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    *progress, line = result.stderr.splitlines()
    assert line.startswith("hhrl-bench: ")
    assert "Traceback" not in result.stderr
    assert not [said for said in progress if " of " not in said]
    return line


def process(
    *arguments: str, folder: Path, code: str | None = None, stdout: int | TextIO = subprocess.PIPE
) -> subprocess.CompletedProcess[str]:
    start = ["-c", code, *arguments] if code else ["-m", "hhrl_bench", *arguments]
    search = os.pathsep.join(str(path) for path in (ROOT, *map(Path, filter(None, sys.path))))
    return subprocess.run(
        [sys.executable, *start],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": search, "OMP_NUM_THREADS": "1"},
        stdout=stdout,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
        timeout=120,
    )


@pytest.fixture
def tiny(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> ScoreSuite:
    """A suite that takes no time, in place of the quick one, in a folder of its own to work in."""
    monkeypatch.chdir(tmp_path_factory.mktemp("work"))
    small = ScoreSuite("quick", agents=("rule-2", "rule-4"), tasks=("stop-line-v0",), episodes=20)
    monkeypatch.setattr(suites, "SUITES", {"quick": small})
    return small


def test_evaluate_prints_the_nine_columns_and_the_papers_rows() -> None:
    said = done("evaluate", "rule-2", "--task", "stop-line-paper-v0", "--episodes", "40")
    for word in ("r^o", "r^a", "step", "unsmooth", "unsafe", "collision", "not stop", "timeout", "success"):
        assert word in said
    for word in (
        "rule-2",
        "stop-line-paper-v0, 40 test episodes",
        "Hybrid HRL",
        "Wilson",
        "43.52",
        " 112 ",
        " 89% ",
        "81.4, 93.7",
    ):
        assert word in said


def test_evaluate_prints_json_alone_on_stdout() -> None:
    text = done("evaluate", "rule-2", "--episodes", "40", "--json")
    record = EvaluationRecord.model_validate_json(text)
    assert record.task.episodes == 40
    assert record.provenance.command == "hhrl-bench evaluate rule-2 --task stop-line-v0 --episodes 40"
    assert record.results[0].runs[0].episodes_sha256 == evaluate("rule-2", episodes=40).records.digest()


def test_several_agents_share_one_record_and_one_table() -> None:
    record = EvaluationRecord.model_validate_json(done("evaluate", "rule-2", "rule-4", "--episodes", "20", "--json"))
    alone = EvaluationRecord.model_validate_json(done("evaluate", "rule-4", "--episodes", "20", "--json"))
    assert [result.agent for result in record.results] == ["rule-2", "rule-4"]
    assert record.results[1:] == alone.results
    assert record.provenance.command == "hhrl-bench evaluate rule-2 rule-4 --task stop-line-v0 --episodes 20"
    assert set(record.provenance.wall_seconds) == {"stop-line-v0/rule-2", "stop-line-v0/rule-4"}
    said = done("evaluate", "rule-2", "rule-4", "--episodes", "20")
    assert said.count("stop-line-v0, 20 test episodes") == 1
    assert said.index("\nrule-2 ") < said.index("\nrule-4 ")


def without_provenance(record: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in record.items() if name != "provenance"}


def test_several_tasks_are_scored_each_as_it_is_alone() -> None:
    tasks = ("stop-line-v0", "stop-line-wet-v0")
    words = [word for task in tasks for word in ("--task", task)]
    both = json.loads(done("evaluate", "rule-2", "rule-4", *words, "--episodes", "5", "--json"))
    for task, record in zip(tasks, both, strict=True):
        alone = json.loads(done("evaluate", "rule-2", "rule-4", "--task", task, "--episodes", "5", "--json"))
        assert without_provenance(record) == without_provenance(alone)
        assert record["provenance"]["command"] == alone["provenance"]["command"]
    said = done("evaluate", "rule-2", *words, "--episodes", "5")
    assert said.index("stop-line-v0, 5 test episodes") < said.index("stop-line-wet-v0, 5 test episodes")
    assert said.count("\nrule-2 ") == 2


def test_an_agent_that_fails_on_one_task_leaves_the_other_tables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("dry.py").write_text(DRY)
    words = ("--task", "stop-line-wet-v0", "--task", "stop-line-v0", "--episodes", "2")
    ended = invoke("evaluate", "dry:make", *words, "--json")
    assert ended.exit_code == 2
    assert [record["task"]["id"] for record in json.loads(ended.stdout)] == ["stop-line-v0"]
    assert "too wet" in ended.stderr.splitlines()[-1]


DRY = """
from hhrl_agents import RULES

def make(scenario):
    if "wet" in scenario.id:
        raise ValueError("too wet")
    return RULES["rule-4"](scenario)
"""


def test_every_episode_can_be_written_on_a_line_of_its_own(tmp_path: Path) -> None:
    path = tmp_path / "new/episodes.csv"
    words = ("--task", "stop-line-v0", "--task", "adversary-v0", "--episodes", "3", "--per-episode", str(path))
    record = json.loads(done("evaluate", "rule-2", "ddqn", *words, "--json"))[1]["results"]
    rows = [*csv.DictReader(path.read_text().splitlines())]
    assert [path.name for path in path.parent.iterdir()] == [path.name]
    assert [(row["task"], row["agent"]) for row in rows[:4:3]] == [("stop-line-v0", "rule-2"), ("stop-line-v0", "ddqn")]
    assert len(rows) == 2 * (1 + 5) * 3
    for agent, result in zip(("rule-2", "ddqn"), record, strict=True):
        own = [row for row in rows if (row["task"], row["agent"]) == ("adversary-v0", agent)]
        assert [int(row["world_seed"]) for row in own[:3]] == [2_000_000_000, 2_000_000_001, 2_000_000_002]
        for number, run in enumerate(result["runs"]):
            three = own[3 * number : 3 * number + 3]
            assert sum(int(row["steps"]) for row in three) == pytest.approx(3 * run["metrics"]["steps"])
            assert sum(row["outcome"] == "success" for row in three) == round(3 * run["metrics"]["success"])
    for row in rows:
        assert (row["cause"] or row["outcome"]) == row["outcome"]
        assert (not row["cause"]) == (row["outcome"] == "success")
        assert row["profiles"].split("+")[0] == row["profile"]
        assert (row["profile"] == "agent") == (row["task"] == "adversary-v0")


def test_an_agent_that_does_not_load_is_said_before_the_others_play(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hhrl_bench.evaluation.results.evaluate_agent", lambda *_: pytest.fail("played"))
    assert "unknown agent 'rule-9'" in refused("evaluate", "rule-1", "rule-9")


def test_evaluate_twice_differs_in_its_provenance_only() -> None:
    first, again = (json.loads(done("evaluate", "rule-3", "--episodes", "30", "--json")) for _ in range(2))
    del first["provenance"], again["provenance"]
    assert first == again


def test_the_oracle_is_scored_as_what_is_possible() -> None:
    words = ("evaluate", "oracle", "--episodes", "20", "--task")
    (result,) = json.loads(done(*words, "stop-line-dense-v0", "--json"))["results"]
    assert (result["kind"], result["metrics"]["success"]["mean"]) == ("oracle", 1.0)
    assert "oracle knows how the traffic will drive" in " ".join(done(*words, "stop-line-v0").split())
    assert "the oracle foresees scripted traffic alone; platoon-v0 has" in refused(*words, "platoon-v0")


def test_evaluate_holds_the_option() -> None:
    held = json.loads(done("evaluate", "rule-4", "--episodes", "30", "--option", "stop", "--json"))
    rule = json.loads(done("evaluate", "rule-2", "--episodes", "30", "--json"))
    assert held["results"][0]["option"] == "stop"
    assert held["results"][0]["runs"] == rule["results"][0]["runs"]
    assert held["provenance"]["command"].endswith("--option stop")


@pytest.mark.parametrize(("spelling", "name"), [("SSL", "stop"), ("ffv", "follow"), ("Follow", "follow")])
def test_an_option_may_be_spelt_as_in_the_paper(spelling: str, name: str) -> None:
    said = done("evaluate", "rule-4", "--episodes", "5", "--option", spelling, "--json")
    assert json.loads(said)["results"][0]["option"] == name


def test_the_table_fits_narrow_and_wide_terminals() -> None:
    for columns in (30, 40, 60, 80, 120):
        result = invoke("evaluate", "rule-2", "--episodes", "20", columns=columns)
        lines = result.stdout.splitlines()
        assert max(map(len, lines)) <= columns
        assert "…" not in result.stdout
        assert "\nrule-2 " in result.stdout
        said = " ".join(result.stdout.split())
        assert "success" in said
        assert ("unsafe" in said) == (columns >= 60)
        assert ("r^o" in said) == ("more columns" not in said) == (columns >= 80)
        assert "Wilson" not in said


def test_the_papers_rows_stand_below_the_task_of_its_world_only() -> None:
    for task in ("stop-line-v0", "stop-line-paper-v0", "stop-line-wet-v0"):
        said = done("evaluate", "rule-2", "--episodes", "20", "--task", task)
        assert ("Hybrid HRL" in said) == ("Table I" in said) == (task == "stop-line-paper-v0")


def test_a_checkpoint_of_another_scenario_is_noted_below_the_table() -> None:
    note = "ddqn was trained in stop-line-v0."
    assert note in done("evaluate", "ddqn", "--episodes", "2", "--task", "solo-stop-v0")
    assert note not in done("evaluate", "ddqn", "--episodes", "2")


def test_run_writes_the_leaderboard_and_show_prints_it_again(tiny: ScoreSuite, tmp_path: Path) -> None:
    path = tmp_path / "boards" / "a.json"
    said = done("run", "--suite", "quick", "--out", str(path))
    board = LeaderboardRecord.model_validate_json(path.read_text())
    assert tuple(result.agent for result in board.results) == tiny.agents
    assert board.provenance.command == "hhrl-bench run --suite quick"
    assert done("leaderboard", "show", str(path)) == said
    assert LeaderboardRecord.model_validate_json(done("leaderboard", "show", str(path), "--json")) == board
    assert sorted(p.name for p in path.parent.iterdir()) == ["a.json", "evidence"]


@pytest.mark.usefixtures("tiny")
def test_other_agents_are_scored_in_a_folder_of_their_own() -> None:
    done("run", "--suite", "quick", "--agent", "rule-1")
    assert Path("runs/quick-agents/entry.json").exists()
    assert not Path("runs/quick").exists()
    assert not Path("leaderboards").exists()


@pytest.mark.usefixtures("tiny")
def test_a_run_is_compared_with_the_published_entry_which_stays() -> None:
    published = Path("leaderboards/quick.json")
    assert "published" not in done("run", "--suite", "quick")
    published.parent.mkdir()
    published.write_bytes(Path("runs/quick/entry.json").read_bytes())
    assert done("run", "--suite", "quick").endswith("equal to the published leaderboards/quick.json, digit for digit\n")
    first = LeaderboardRecord.model_validate_json(published.read_text()).results[0]
    steps = first.metrics.steps.mean
    text = published.read_text().replace(f'"mean": {steps}', '"mean": 7.5', 1)
    published.write_text(text)
    said = done("run", "--suite", "quick").splitlines()
    assert said[-2:] == [
        "differs from the published leaderboards/quick.json in 1 place:",
        f"  results[0].metrics.steps.mean: 7.5 is published, {steps} was found",
    ]
    assert published.read_text() == text
    assert list(published.parent.iterdir()) == [published]


@pytest.mark.usefixtures("tiny")
def test_run_that_fails_leaves_the_old_leaderboard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.json"
    path.write_text("before")

    def fails(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device", "somewhere")

    monkeypatch.setattr(units, "evaluate_agent", fails)
    said = invoke("run", "--out", str(path), "--workers", "1")
    assert (said.exit_code, said.stdout) == (1, "")
    first, last = said.stderr.splitlines()[-3::2]
    assert first.startswith("hhrl-bench: rule-2 on stop-line-v0 failed: ")
    assert first.endswith("No space left on device: somewhere; make room there, and run the same command again")
    assert last == "hhrl-bench: no leaderboard was written; the same command goes on with what is left"
    assert path.read_text() == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["a.json"]


def test_lists_name_what_is_registered() -> None:
    agents = json.loads(done("list", "agents", "--json"))
    assert [agent["id"] for agent in agents] == [*RULES, *ORACLES, *METHODS]
    assert [task["id"] for task in json.loads(done("list", "tasks", "--json"))] == [*TASKS]
    assert [entry["id"] for entry in json.loads(done("list", "suites", "--json"))] == [*SUITES]
    for what, names in (("agents", [*RULES, *ORACLES, *METHODS]), ("tasks", TASKS), ("suites", SUITES)):
        said = done("list", what)
        assert all(name in said for name in names)
        assert f"\n{said}" in done("list")
    together = json.loads(done("list", "--json"))
    assert together == {what: json.loads(done("list", what, "--json")) for what in ("agents", "tasks", "suites")}


def test_learned_agents_are_listed_with_what_sets_them_apart() -> None:
    agents = {agent["id"]: agent for agent in json.loads(done("list", "agents", "--json"))}
    assert {name: agents[name]["summary"] for name in METHODS} == {name: m.summary for name, m in METHODS.items()}
    assert agents["rule-2"]["summary"] == "always stops at the stop-line"
    assert all(agents[name]["summary"] for name in [*RULES, *ORACLES])
    lines = done("list", "agents").splitlines()
    for name, method in METHODS.items():
        assert any(line.split()[0] == name and line.rstrip().endswith(method.summary) for line in lines)


@pytest.mark.parametrize("columns", [40, 80, 120])
def test_lists_keep_ids_whole_where_there_is_little_room(columns: int) -> None:
    for what, names in (("agents", [*RULES, *ORACLES, *METHODS]), ("tasks", TASKS), ("suites", SUITES)):
        lines = invoke("list", what, columns=columns).stdout.splitlines()
        assert max(map(len, lines)) <= columns
        assert {line.split()[0] for line in lines if line.strip()} >= {*names}
        assert not any("\N{HORIZONTAL ELLIPSIS}" in line for line in lines)
    assert "shows drives, opponent, summary too" in invoke("list", "tasks", columns=60).stdout


def test_what_is_the_same_for_all_tasks_is_said_once_below_them() -> None:
    lines = invoke("list", "tasks", columns=100).stdout.splitlines()
    assert lines[0].split() == ["id", "scenario", "env_steps", "drives", "opponent", "summary"]
    assert " ".join(" ".join(lines[-2:]).split()) == (
        "The same for all: train_seeds 0 to 999,999,999; validation_seeds 1,000,000,000 to 1,999,999,999; "
        "test_seeds 2,000,000,000 to 2,999,999,999."
    )


def test_version_and_help() -> None:
    assert done("--version") == f"hhrl-bench {hhrl_bench.__version__}\n"
    assert done() == done("--help")
    for command in ("train", "evaluate", "run", "list", "leaderboard", "watch"):
        assert command in done("--help")
        assert "Usage" in done(command, "--help")
    assert "the task's budget" in " ".join(done("train", "--help").split())


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["evaluate"], "Missing argument 'AGENT'"),
        (["evaluate", "rule-1", "rule-2", "rule-1"], "agent 'rule-1' is named twice; name each agent once"),
        (["evaluate", "rule-9"], "unknown agent 'rule-9'"),
        (["evaluate", "rule-1", "--per-episode", "x.txt"], "the file to export to is 'x.txt'; write a name that ends"),
        (["evaluate", "rule-1", "--per-episode", "x"], "'x' is no file of rows; write a name that ends in .csv"),
        (["evaluate", "rule-1", *2 * ("--task", "stop-line-v0")], "task 'stop-line-v0' is named twice; name each"),
        (["evaluate", "rule-1", "--task", "x"], "unknown task 'x'; known tasks: stop-line-v0"),
        (["evaluate", "rule-1", "--episodes", "0"], "ask for 1 to"),
        (["evaluate", "rule-1", "--episodes", "many"], "'--episodes'"),
        (["evaluate", "rule-1", "--option", "left"], "unknown option 'left'; write one of: stop or SSL, follow or FFV"),
        (["evaluate", "rule-1", "ddqn", "--option", "ssl"], "ddqn: a flat agent has no option to hold; leave out"),
        (["evaluate", "rule-1", "--speed", "9"], "No such option"),
        (["evaluate", "nowhere:make"], "cannot import 'nowhere'"),
        (["evaluate", "rule-1", "--task", "stop_line"], "unknown task 'stop_line', did you mean stop-line-v0; known"),
        (["run", "--suite", "quik"], "unknown suite 'quik', did you mean quick; known suites"),
        (["train", "hybrid_hlr"], "unknown method 'hybrid_hlr', did you mean hybrid-hrl; write one of"),
        (["run", "--suite", "slow"], "unknown suite 'slow'; known suites: quick"),
        (["train", "sarsa"], "unknown method 'sarsa'"),
        (["train", "ddqn", "--seeds", "4-2"], "write 2-4"),
        (["train", "ddqn", "--env-steps", "0"], "'--env-steps'"),
        (["leaderboard", "show", "nowhere.json"], "cannot read nowhere.json: No such file"),
        (["leaderboard"], "Missing command"),
        (["list", "dances"], "Invalid value for 'what': 'dances' is not one of 'agents', 'tasks', 'suites'"),
        (["dance"], "No such command 'dance'"),
        (["watch", "rule-1", "--out", "x.mp4"], "x.mp4"),
    ],
)
def test_bad_usage_is_one_line_and_exit_code_2(arguments: list[str], said: str) -> None:
    assert said in refused(*arguments)


def test_a_registered_name_is_not_that_of_the_folder_here_and_a_line_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("rule-2", "ppo"):
        Path(name).mkdir()
    scored = invoke("evaluate", "rule-2", "--episodes", "3")
    assert scored.exit_code == 0
    assert "hhrl-bench: rule-2 is the registered agent; for what lies here write ./rule-2" in scored.stderr
    assert "for what lies here write ./ppo" in invoke("evaluate", "ppo", "--episodes", "3").stderr


def test_output_below_a_file_is_refused_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hhrl_bench.suites.study.run_stages", lambda *_: pytest.fail("played"))
    file = tmp_path / "file"
    file.write_text("before")
    assert "cannot write" in refused("run", "--out", str(file / "a.json"))
    assert "cannot write" in refused("train", "ddqn", "--out", str(file / "run"))
    assert file.read_text() == "before"


def test_a_fault_of_ours_keeps_its_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hhrl_bench.evaluation.results.evaluate_agent", lambda *_: 1 // 0)
    assert isinstance(invoke("evaluate", "rule-1").exception, ZeroDivisionError)


def test_a_process_says_errors_on_stderr_and_exits_2(tmp_path: Path) -> None:
    ended = process("evaluate", "rule-9", folder=tmp_path)
    assert (ended.returncode, ended.stdout) == (2, "")
    (said,) = (line for line in ended.stderr.splitlines() if "compiling" not in line)
    assert said.startswith("hhrl-bench: unknown agent 'rule-9'")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
@pytest.mark.parametrize("arguments", [["--version"], ["list", "--json"], ["evaluate", "rule-1", "--episodes", "5"]])
def test_a_full_disk_below_stdout_is_one_line(tmp_path: Path, arguments: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        ended = process(*arguments, folder=tmp_path, stdout=full)
    said = [line for line in ended.stderr.splitlines() if "No space left" in line or "Error" in line]
    assert (ended.returncode, said) == (2, ["hhrl-bench: No space left on device"])


def test_a_process_finds_factories_in_its_folder(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("from hhrl_agents import RULES\nmake = RULES['rule-2']\n")
    ended = process("evaluate", "mine:make", "--episodes", "30", "--json", folder=tmp_path)
    assert ended.returncode == 0, ended.stderr
    runs = json.loads(ended.stdout)["results"][0]["runs"]
    assert runs[0]["episodes_sha256"] == evaluate(load_agent("rule-2"), episodes=30).digest()


WITHOUT_TORCH = """
import sys
from importlib.machinery import PathFinder
find = PathFinder.find_spec
HIDDEN = {"torch", "stable_baselines3"}
PathFinder.find_spec = lambda name, *rest: None if name.partition(".")[0] in HIDDEN else find(name, *rest)
from hhrl_bench.cli import main
sys.argv[0] = "hhrl-bench"
main()
"""


@pytest.mark.parametrize("arguments", [["evaluate", "rule-1"], ["evaluate", "hybrid-hrl"], ["analyse", "hybrid-hrl"]])
def test_agents_are_evaluated_without_torch(tmp_path: Path, arguments: list[str]) -> None:
    ended = process(*arguments, "--episodes", "10", folder=tmp_path, code=WITHOUT_TORCH)
    assert ended.returncode == 0, ended.stderr


def test_all_that_is_shipped_is_scored_without_torch(tmp_path: Path) -> None:
    agents = [*RULES, *(name for name in shipped_methods() if name not in {"follow-only", "adversary", "platoon"})]
    suite = {"id": "bare", "agents": agents, "tasks": ["stop-line-v0"], "episodes": 20}
    (tmp_path / "bare.json").write_text(json.dumps(suite))
    ended = process("run", "--suite", "bare.json", "--workers", "1", folder=tmp_path, code=WITHOUT_TORCH)
    assert ended.returncode == 0, ended.stderr
    assert len(json.loads((tmp_path / "runs" / "bare" / "entry.json").read_text())["results"]) == len(agents)


@pytest.mark.parametrize("method", ["ddqn", "hybrid-hrl", "pqn"])
def test_methods_train_without_torch(tmp_path: Path, method: str) -> None:
    ended = process("train", method, "--env-steps", "1000", folder=tmp_path, code=WITHOUT_TORCH)
    assert ended.returncode == 0, ended.stderr
    assert (tmp_path / "runs" / method / "stop-line-v0" / "seed-0.final.safetensors").is_file()


def test_what_needs_torch_says_which_extra_to_install(tmp_path: Path) -> None:
    ended = process("train", "ppo", folder=tmp_path, code=WITHOUT_TORCH)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert "pip install -e '.[sb3]'" in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


HELP_IMPORTS = """
import sys
from hhrl_bench.cli.app import app
try:
    app(["--help"])
except SystemExit:
    print(sorted({"torch", "numba", "numpy", "scipy", "pydantic"} & set(sys.modules)), file=sys.stderr)
"""


def test_help_waits_for_no_heavy_import(tmp_path: Path) -> None:
    assert process(folder=tmp_path, code=HELP_IMPORTS).stderr == "[]\n"


def test_an_interrupt_is_said_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("hhrl_bench.evaluation.sources.shipped_methods", interrupted)
    result = invoke("list", "agents")
    assert result.exit_code == 130
    assert result.stderr.strip() == "hhrl-bench: interrupted; what was not finished was not written"
