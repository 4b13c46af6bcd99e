"""Summaries: each metric by itself comes to the published digits, from the episodes or from the runs' means alone."""

import numpy as np
import pytest

from hhrl_agents import RULES
from hhrl_bench import evaluate
from hhrl_bench.evaluation.metrics import METRICS
from hhrl_bench.evaluation.records import RunMetricsRecord, metric_record
from hhrl_bench.evaluation.results import over_episodes, run_record, summarise
from hhrl_bench.statistics.intervals import bootstrap_mean, generator
from hhrl_envs import get_scenario

SCENARIO = get_scenario("stop-line-v0")
RECORDS = [evaluate(RULES[rule](SCENARIO), episodes=25).records for rule in ("rule-2", "rule-3", "rule-4")]
RUNS = [run_record(None, None, records, None).metrics for records in RECORDS]


@pytest.mark.parametrize("key", METRICS)
def test_a_metric_of_one_run_is_made_again_by_itself(key: str) -> None:
    metric = METRICS[key]
    assert over_episodes(metric, metric.values(RECORDS[0])) == getattr(summarise(RUNS[:1], RECORDS[0]), key)


def test_several_runs_are_summarised_from_their_means_alone() -> None:
    again = [RunMetricsRecord.model_validate_json(run.model_dump_json()) for run in RUNS]
    assert summarise(again, RECORDS[0]) == summarise(RUNS, RECORDS[0])
    means = np.array([METRICS["steps"].values(records).mean() for records in RECORDS])
    assert summarise(RUNS, RECORDS[0]).steps == metric_record(
        bootstrap_mean(means, generator("steps"), "bootstrap-seeds")
    )


def test_a_run_without_a_metric_does_not_count() -> None:
    summary = summarise(RUNS, RECORDS[0])  # of the rules, only rule 2 collides
    crashed = [records for records in RECORDS if np.isfinite(records.impact_speed).any()]
    assert 0 < len(crashed) < len(RECORDS)
    assert summary.impact_speed.n == len(crashed)
    assert summary.success.n == len(RECORDS)


def test_every_key_has_draws_of_its_own() -> None:
    values = np.arange(20.0)
    one, again, other = (metric_record(bootstrap_mean(values, generator(key), "bootstrap-seeds")) for key in "aab")
    assert one == again
    assert (one.mean, one.n) == (other.mean, other.n)
    assert (one.low, one.high) != (other.low, other.high)
