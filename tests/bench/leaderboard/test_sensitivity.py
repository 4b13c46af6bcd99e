"""What moving the weights of the score does to rankings: known cases, and the entry's own field."""

import numpy as np
import pytest

from hhrl_bench.evaluation.episodes import EpisodeRecords
from hhrl_bench.evaluation.metrics import HEADLINE
from hhrl_bench.evaluation.score import WEIGHTS, Weights, score
from hhrl_bench.leaderboard.sensitivity import FACTORS, MOVED, rescored, sensitivity
from hhrl_envs import Outcome
from support.whole_board import whole_board

COUNT = 1 + len(MOVED)


def episode(steps: int, uncomfortable: int, too_close: int) -> EpisodeRecords:
    counts = {"fewest_steps": 100, "uncomfortable": uncomfortable, "too_close": too_close}
    measured = {key: np.array([count], np.int32) for key, count in counts.items()}
    return EpisodeRecords(
        np.zeros(1, np.uint64), np.array([Outcome.SUCCESS], np.int8), np.array([steps], np.int32), measured
    )


def test_every_weight_is_moved_by_half_either_way() -> None:
    assert {part for part, _ in MOVED} == {"progress", "comfort", "margin"}
    for (part, factor), weights in MOVED.items():
        assert factor in FACTORS
        moved = {name: value for name, value in vars(weights).items() if value != getattr(WEIGHTS, name)}
        assert moved == {part: factor * getattr(WEIGHTS, part)}


@pytest.mark.parametrize("run", [episode(200, 20, 0), episode(125, 0, 50)])
def test_scores_are_those_by_each_of_the_weights(run: EpisodeRecords) -> None:
    ours, *others = rescored(run)
    assert ours == pytest.approx(score(run)[0])
    for weights, other in zip(MOVED.values(), others, strict=True):
        assert isinstance(weights, Weights)
        assert other == pytest.approx(score(run, weights)[0])


def test_a_ranking_that_stays_correlates_fully_and_one_that_turns_round_negatively() -> None:
    same = [[place / 10.0] * COUNT for place in range(4)]
    assert {one.rank_correlation for one in sensitivity("stop-line-v0", same)} == {1.0}
    turned = [[place / 10.0, *[-place / 10.0] * len(MOVED)] for place in range(4)]
    assert {one.rank_correlation for one in sensitivity("stop-line-v0", turned)} == {-1.0}


def test_two_neighbours_that_change_places_are_spearman_s_correlation() -> None:
    """Of five: 1 - 6 (1 + 1) / (5 (25 - 1)) = 0.9."""
    scores = [[place / 10.0] * COUNT for place in range(5)]
    scores[1][1], scores[2][1] = scores[2][1], scores[1][1]
    first, *others = sensitivity("stop-line-v0", scores)
    assert (first.part, first.factor, first.agents, first.rank_correlation) == ("progress", 0.5, 5, 0.9)
    assert {one.rank_correlation for one in others} == {1.0}


def test_equal_scores_rank_nothing_and_the_last_digits_do_not_count() -> None:
    assert {one.rank_correlation for one in sensitivity("stop-line-v0", [[0.5] * COUNT] * 3)} == {None}
    nearly = [[0.5 + place * 1e-12] * COUNT for place in range(3)]
    assert {one.rank_correlation for one in sensitivity("stop-line-v0", nearly)} == {None}


def test_an_entry_says_it_of_every_task_with_scores() -> None:
    board = whole_board()
    assert [one.task for one in board.sensitivity] == [task.id for task in board.tasks for _ in MOVED]
    for one in board.sensitivity:
        assert one.agents == sum(HEADLINE in result.metrics for result in board.results if result.task == one.task)
