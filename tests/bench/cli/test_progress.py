"""Commands that work for more than a few seconds say how far they are: a bar on a terminal, now and then a line."""

from pathlib import Path
from typing import Any

import pytest

from hhrl_bench.cli import console
from hhrl_bench.evaluation.results import evaluate_agent
from hhrl_bench.tasks.tasks import get_task
from support.command_line import invoke

PUBLISHED = Path(__file__).parents[3] / "leaderboards"


def test_plain_lines_without_a_note_come_now_and_then(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = 0.0
    monkeypatch.setattr("hhrl_bench.cli.console.time.monotonic", lambda: now)
    with console.progress("work") as update:
        for done in range(1, 31):
            now = float(done)
            update(done, 30, "half" if done == 15 else "")
    assert capsys.readouterr().err.splitlines() == ["work: 10 of 30", "work: 15 of 30 half", "work: 25 of 30"]


def test_an_evaluation_says_how_many_episodes_have_ended() -> None:
    said: list[tuple[int, int, str]] = []
    evaluate_agent("rule-2", get_task("stop-line-v0"), 1001, update=lambda *one: said.append(one))
    assert [(done, total) for done, total, _ in said] == [(500, 1001), (1000, 1001), (1001, 1001), (1001, 1001)]
    assert [note.split()[:1] for _, _, note in said] == [[], [], [], ["success"]]


@pytest.mark.parametrize(
    ("words", "title", "total"),
    [
        (("watch", "rule-2", "--out", "a.png"), "rule-2 on stop-line-v0", 6),
        (("watch", "rule-2", "--out", "a.gif"), "rule-2 on stop-line-v0", 0),
        (("analyse", "rule-2", "--episodes", "3"), "rule-2 on stop-line-v0", 3),
        (("figures", str(PUBLISHED / "trainings.json"), "--out", "new"), "figures of trainings.json", 5),
        (("leaderboard", "verify", str(PUBLISHED / "quick.json"), "--level", "schema"), "verify quick.json", None),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else None,
)
def test_slow_commands_show_how_far_they_are(
    words: tuple[str, ...], title: str, total: int | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    heard: list[tuple[int, int]] = []

    class Lines:
        def __init__(self, _: Any, said: str) -> None:
            assert said == title

        def __call__(self, done: int, total: int, _: str) -> None:
            heard.append((done, total))

    monkeypatch.setattr(console, "_Lines", Lines)
    assert invoke(*words).exit_code == 0
    if total is not None:
        done, last = heard[-1]
        assert done == last == (total or last)
