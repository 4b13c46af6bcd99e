"""Summaries: each metric by itself comes to the published digits, from the episodes or from the runs' means alone."""

import numpy as np
import pytest

from hhrl_agents import RULES
from hhrl_bench.evaluation.evaluate import evaluate
from hhrl_bench.evaluation.metrics import SCORED, over_episodes, summarise, summarise_runs
from hhrl_bench.evaluation.records import RunMetricsRecord, metric_record
from hhrl_bench.evaluation.results import run_record
from hhrl_bench.statistics.intervals import bootstrap_mean, generator
from hhrl_envs import get_scenario

SCENARIO = get_scenario("stop-line-v0")
PLAYED = [evaluate(RULES[rule](SCENARIO), episodes=25) for rule in ("rule-2", "rule-3", "rule-4")]


@pytest.mark.parametrize("metric", SCORED, ids=lambda metric: metric.key)
def test_a_metric_of_one_run_is_made_again_by_itself(metric) -> None:  # type: ignore[no-untyped-def]  # noqa: ANN001
    assert over_episodes(metric, metric.values(PLAYED[0])) == getattr(summarise(PLAYED[:1]), metric.key)


def test_several_runs_are_summarised_from_their_means_alone() -> None:
    runs = [run_record(None, None, records, None).metrics for records in PLAYED]
    assert summarise_runs(runs) == summarise(PLAYED)
    again = summarise_runs([RunMetricsRecord.model_validate_json(run.model_dump_json()) for run in runs])
    assert again == summarise(PLAYED)


def test_a_run_without_a_metric_does_not_count() -> None:
    summary = summarise(PLAYED)  # of the rules, only rule 2 collides
    crashed = [records for records in PLAYED if np.isfinite(records.impact_speed).any()]
    assert 0 < len(crashed) < len(PLAYED)
    assert summary.impact_speed.n == len(crashed)
    assert summary.success.n == len(PLAYED)


def test_every_key_has_draws_of_its_own() -> None:
    values = np.arange(20.0)
    one, again, other = (metric_record(bootstrap_mean(values, generator(key), "bootstrap-seeds")) for key in "aab")
    assert one == again
    assert (one.mean, one.n) == (other.mean, other.n)
    assert (one.low, one.high) != (other.low, other.high)
