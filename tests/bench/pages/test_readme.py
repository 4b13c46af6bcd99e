"""What the documentation prints runs: every Python block, and every quick command of the command line."""

import re
import shlex
from pathlib import Path

import pytest

from hhrl_bench.evaluation.records import MetricRecord
from hhrl_bench.leaderboard.entry import read_entry
from support.command_line import invoke

ROOT = Path(__file__).parents[3]
PAGES = ("README.md", "environments/README.md", "docs/clients.md")
COMMANDED = (
    "README.md",
    "docs/analysis.md",
    "docs/training.md",
    "docs/traffic.md",
    "docs/transfer.md",
)
SLOW = tuple(
    f"hhrl-bench {verb}"
    for verb in (
        "train",
        "tune",
        "run",
        "evaluate runs/",
        "evaluate platoon",
        "evaluate ddqn --task adversary-v0",
        "leaderboard",
        "transfer",
        "robustness",
        "figures",
        "report",
        "watch ddqn --failed",
    )
)


def blocks(page: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", (ROOT / page).read_text(), re.MULTILINE | re.DOTALL)


def commands() -> list[str]:
    lines = [line for page in COMMANDED for block in blocks(page, "sh") for line in block.splitlines()]
    own_agent = re.findall(r"`(hhrl-bench evaluate my_agent[^`]*)`", (ROOT / "README.md").read_text())
    return [line for line in [*lines, *own_agent] if line.startswith("hhrl-bench ")]


@pytest.mark.parametrize(("page", "code"), [(page, code) for page in PAGES for code in blocks(page, "python")])
def test_python_blocks_run(page: str, code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(code, page, "exec"), {"__name__": "documentation"})


@pytest.mark.parametrize("command", [line for line in commands() if not line.startswith(SLOW)])
def test_quick_commands_run(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    own_agent = next(code for code in blocks("README.md", "python") if code.startswith("# my_agent.py"))
    Path("my_agent.py").write_text(own_agent)
    result = invoke(*shlex.split(command, comments=True)[1:])
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    "page",
    [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), ROOT / "environments" / "README.md"],
    ids=lambda page: page.name,
)
def test_links_lead_to_files(page: Path) -> None:
    links = re.findall(r"\]\(([^)#:]+)\)", page.read_text())
    assert [link for link in links if not (page.parent / link).exists()] == []


def test_documentation_holds_the_commands_it_promises() -> None:
    verbs = {line.split()[1] for line in commands()}
    assert verbs == {
        "list", "evaluate", "watch", "run", "leaderboard", "train", "calibrate", "analyse", "robustness", "transfer",
        "figures", "report", "sigma", "export", "tune",
    }  # fmt: skip


def test_the_results_table_says_what_the_published_leaderboard_holds() -> None:
    board = read_entry(ROOT / "leaderboards" / "quick.json")
    text = (ROOT / "README.md").read_text()
    rows = re.findall(r"^\| (Rule \w+|Oracle|flat Double DQN|Hybrid HRL)[^|]*\| (.*) \|$", text, re.MULTILINE)
    shown = board.on(board.tasks[0])
    assert len(rows) == len(shown)
    for (_, cells), result in zip(rows, shown, strict=True):
        assert cells.split(" | ") == [said(key, getattr(result.metrics, key)) for key in SHOWN]


SHOWN = {
    "return_option": "{:.2f}",
    "return_action": "{:.2f}",
    "steps": "{:.1f}",
    "unsmooth": "{:.2f}",
    "unsafe": "{:.2f}",
    "collision": "{:.1%}",
    "not_stop": "{:.1%}",
    "timeout": "{:.1%}",
    "success": "{:.1%}",
    "score": "{:.3f}",
}


def said(key: str, metric: MetricRecord) -> str:
    if metric.mean is None or metric.low is None or metric.high is None:
        return "\N{EN DASH}"
    interval = f" ({percent(metric.low)}, {percent(metric.high)})" if key == "success" else ""
    interval = f" ({metric.low:.3f}, {metric.high:.3f})" if key == "score" else interval
    return SHOWN[key].format(metric.mean) + interval


def percent(share: float) -> str:
    return f"{100 * share:.3g}" if share >= 0.9995 else f"{100 * share:.1f}"
