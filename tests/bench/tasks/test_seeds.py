from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hhrl_bench.errors import SeedError, UnknownTaskError
from hhrl_bench.tasks.seeds import MAX_TRAINING_SEED, SeedRange, consecutive_ranges, format_seeds, parse_seeds
from hhrl_bench.tasks.tasks import SCRIPTED, TASKS, Task, get_task
from hhrl_envs import SCENARIOS
from hhrl_envs.errors import InputError

SEED_SETS = st.sets(st.integers(0, MAX_TRAINING_SEED), min_size=1, max_size=40)


@given(SEED_SETS)
def test_a_spelling_reads_back_as_the_seeds_it_spells(seeds: set[int]) -> None:
    assert parse_seeds(format_seeds(sorted(seeds))) == tuple(sorted(seeds))


@given(SEED_SETS)
def test_single_numbers_in_any_order_are_a_spelling_too(seeds: set[int]) -> None:
    assert parse_seeds(",".join(map(str, seeds))) == tuple(sorted(seeds))


@given(st.text(max_size=12))
def test_any_text_is_read_or_refused_in_one_line(text: str) -> None:
    try:
        seeds = parse_seeds(text)
    except SeedError as error:
        assert len(str(error).splitlines()) == 1  # noqa: PT017
    else:
        assert seeds == tuple(sorted(set(seeds)))
        assert parse_seeds(format_seeds(seeds)) == seeds


def test_spellings_by_hand() -> None:
    assert parse_seeds("0-4,7") == (0, 1, 2, 3, 4, 7)
    assert parse_seeds(" 9 , 3-3") == (3, 9)
    assert format_seeds((0, 1, 2, 3, 4, 7, 9, 10)) == "0-4,7,9-10"


@pytest.mark.parametrize(
    "text", ["", "a", "1-", "-1", "1--2", "1,,2", "4-2", "1,1", "0-4,3", "1000", "0-999999999", "1.5", "²"]
)
def test_no_spelling(text: str) -> None:
    with pytest.raises(SeedError):
        parse_seeds(text)


def test_ranges_follow_one_another_without_a_gap_or_an_overlap() -> None:
    ranges = consecutive_ranges("a", "b", "c")
    assert [r.start for r in ranges] == [0, ranges[0].size, ranges[0].size + ranges[1].size]


def test_a_range_hands_out_its_own_seeds_only() -> None:
    seeds = SeedRange("test", 100, size=10)
    assert seeds.take(3, offset=7).tolist() == [107, 108, 109]
    assert seeds.take(10).dtype == np.uint64
    for count, offset in ((0, 0), (-1, 0), (11, 0), (4, 7), (1, -1), (10**5 + 1, 0)):
        with pytest.raises(SeedError):
            seeds.take(count, offset)


@pytest.mark.parametrize("task", TASKS.values(), ids=TASKS)
def test_a_task_never_trains_on_the_worlds_it_is_tested_on(task: Task) -> None:
    ranges = (task.train, task.validation, task.test)
    assert [r.name for r in ranges] == ["train", "validation", "test"]
    for a, b in combinations(ranges, 2):
        assert a.start + a.size <= b.start or b.start + b.size <= a.start


@pytest.mark.parametrize("task_id", TASKS)
def test_a_task_has_its_id_and_a_registered_scenario(task_id: str) -> None:
    task = get_task(task_id)
    assert task.id == task_id
    assert task.scenario in SCENARIOS
    assert get_task(task) is task


def test_every_scenario_is_a_task() -> None:
    of_a_level = {"option-only-v0": "stop-line-v0"}
    assert set(TASKS) - set(of_a_level) == set(SCENARIOS)
    assert {task_id: task.scenario for task_id, task in TASKS.items() if task_id != task.scenario} == of_a_level


@pytest.mark.parametrize("task", TASKS.values(), ids=TASKS)
def test_a_task_casts_every_learned_front_vehicle_of_its_scenario(task: Task) -> None:
    scenario = SCENARIOS[task.scenario]
    assert (task.opponent is not None) == (task.ego is not None) == (scenario.adversary is not None)
    assert task.shared == bool(scenario.learned_fronts and not scenario.adversary)


def test_a_task_with_an_opponent_can_be_played_against_another_one() -> None:
    task = get_task("adversary-v0")
    assert task.against(None) is task
    assert task.against("rule-4") == replace(task, opponent="rule-4")
    assert task.against(SCRIPTED) == replace(task, opponent=None)
    with pytest.raises(UnknownTaskError, match="platoon-v0 has no opponent; leave out --opponent"):
        get_task("platoon-v0").against("rule-4")


def test_an_unknown_task_is_told_which_there_are() -> None:
    with pytest.raises(UnknownTaskError, match="unknown task 'stop-lin', did you mean stop-line-v0; known tasks: stop"):
        get_task("stop-lin")
    assert issubclass(UnknownTaskError, InputError)
