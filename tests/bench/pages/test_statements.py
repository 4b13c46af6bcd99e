"""What pages say about agents, sentence by sentence: each stands there, and holds in the entry that it is about."""

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

from hhrl_bench.evaluation.records import MetricsRecord
from hhrl_bench.leaderboard.comparisons import DifferenceRecord, against
from hhrl_bench.leaderboard.entry import read_entry
from hhrl_bench.leaderboard.record import LeaderboardRecord

ROOT = Path(__file__).parents[3]
MAIN, HELD_OUT, PAPER, ADVERSARY = "stop-line-v0", "stop-line-heldout-v0", "stop-line-paper-v0", "adversary-v0"
FOLLOWING = ("rule-3", "rule-4", "rule-plus", "rule-tuned", "rule-robust")


class Statement(NamedTuple):
    """A sentence of a page, or the part of it that is told of an entry, and whether it holds there."""

    page: str
    said: str
    entry: str
    holds: Callable[["Entry"], bool]


class Entry:
    """A published entry, and how statements ask about it."""

    def __init__(self, board: LeaderboardRecord) -> None:
        self.board = board

    def agents(self, task: str) -> list[str]:
        return [result.agent for result in self.board.results if result.task == task]

    def of(self, agent: str, task: str = MAIN) -> MetricsRecord:
        return self.board.find(agent, task).metrics

    def mean(self, agent: str, task: str = MAIN, metric: str = "score") -> float:
        value = getattr(self.of(agent, task), metric).mean
        assert value is not None
        return float(value)

    def ranked(self, task: str = MAIN) -> list[str]:
        """The agents by their score, the best first; the oracle is no rival."""
        rivals = [agent for agent in self.agents(task) if agent != "oracle"]
        return sorted(rivals, key=lambda agent: -self.mean(agent, task))

    def difference(self, agent: str, other: str, task: str = MAIN, metric: str = "score") -> DifferenceRecord:
        """The difference of two agents' means, with its interval."""
        pairs = [one for one in self.board.comparisons if one.task == task and one.metric == metric]
        return next(one.difference for one in against(other, pairs) if one.agent == agent)


def percent(share: float) -> str:
    return f"{share:.1%}"


STATEMENTS = [
    Statement(
        "README.md",
        "On this task every rule but Rules 1 and 2 stops in 99.9% of the episodes or more, and so does Double DQN.",
        "quick",
        lambda e: (
            all(round(e.mean(one, metric="success"), 3) >= 0.999 for one in (*FOLLOWING, "ddqn"))
            and e.mean("rule-1", metric="success") < e.mean("rule-2", metric="success") < 0.9
        ),
    ),
    Statement(
        "README.md",
        "has the best score, 0.026 below the oracle's.",
        "quick",
        lambda e: e.ranked()[0] == "rule-tuned" and round(e.mean("oracle") - e.mean("rule-tuned"), 3) == 0.026,
    ),
    Statement(
        "README.md",
        "the best of them, Double DQN, scores 0.125 less, with a 95% interval of 0.084 to 0.167.",
        "quick",
        lambda e: (
            next(one for one in e.ranked() if not one.startswith("rule")) == "ddqn"
            and rounded(e.difference("ddqn", "rule-tuned")) == (-0.125, -0.167, -0.084)
        ),
    ),
    Statement(
        "README.md",
        "The learned ones have been trained in `stop-line-v0` alone and mostly fail in that other traffic",
        "quick",
        lambda e: all(e.mean(one, PAPER, "success") < 0.5 for one in ("ddqn", "hybrid-hrl", "hybrid-hrl-plus")),
    ),
    Statement(
        "README.md",
        "Neither had a collision in 1,000 episodes (at most 0.4%), and Rule plus was never closer than its safety "
        "distance",
        "quick",
        lambda e: (
            all(e.of(one).collision.mean == 0.0 for one in ("rule-tuned", "rule-plus"))
            and percent(e.of("rule-plus").collision.high or 1.0) == "0.4%"
            and e.of("rule-plus").unsafe.mean == 0.0
            and e.board.tasks[0].episodes == 1000
        ),
    ),
    Statement(
        "README.md",
        "all rules with a follower still succeed in 99.4% or more",
        "robustness",
        lambda e: min(e.mean(one, task, "success") for one in FOLLOWING for task in (HELD_OUT, ADVERSARY)) == 0.994,
    ),
    Statement(
        "README.md",
        "Double DQN succeeds in 97.5% and 44.3% there, Hybrid HRL plus in 99.9% and 88.2%.",
        "robustness",
        lambda e: (
            [
                percent(e.mean(one, task, "success"))
                for one in ("ddqn", "hybrid-hrl-plus")
                for task in (HELD_OUT, ADVERSARY)
            ]
            == ["97.5%", "44.3%", "99.9%", "88.2%"]
        ),
    ),
]


def rounded(difference: DifferenceRecord) -> tuple[float, ...]:
    ends = (difference.mean, difference.low, difference.high)
    return tuple(round(end, 3) for end in ends if end is not None)


@cache
def entry(name: str) -> Entry:
    return Entry(read_entry(ROOT / "leaderboards" / f"{name}.json"))


@pytest.mark.parametrize("statement", STATEMENTS, ids=lambda one: re.sub(r"\W+", "-", one.said.lower())[:60])
def test_what_a_page_says_stands_there_and_holds(statement: Statement) -> None:
    page = " ".join((ROOT / statement.page).read_text().split())
    assert " ".join(statement.said.split()) in page
    assert statement.holds(entry(statement.entry))
