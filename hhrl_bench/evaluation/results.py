"""Results: the runs of one agent on one task, and what they come to."""

from collections.abc import Sequence

from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation import episodes as traffic
from hhrl_bench.evaluation.episodes import EpisodeRecords
from hhrl_bench.evaluation.evaluate import Played, play_task
from hhrl_bench.evaluation.evidence import pack
from hhrl_bench.evaluation.guarded_agent import OPTIONS
from hhrl_bench.evaluation.loading import Kind, LoadedAgent, load_agents
from hhrl_bench.evaluation.metrics import SCORED, means, summarise
from hhrl_bench.evaluation.records import (
    EvaluationRecord,
    OpponentRecord,
    ResultRecord,
    RunMetricsRecord,
    RunRecord,
    TaskRecord,
    TimedResult,
    TrainingRecord,
)
from hhrl_bench.evaluation.rollout import load_opponent
from hhrl_bench.evaluation.store import Store
from hhrl_bench.progress import Update, silent
from hhrl_bench.provenance import provenance
from hhrl_bench.schema import SCHEMA_VERSION, OptionName, finite
from hhrl_bench.statistics.intervals import BOOTSTRAP_SEED, CONFIDENCE
from hhrl_bench.tasks.tasks import Task
from hhrl_bench.torch_threads import one_torch_thread
from hhrl_envs import get_scenario
from hhrl_envs.simulation.trajectory_digest import trajectory_digest


def evaluate_agent(
    source: str,
    task: Task,
    episodes: int,
    option: OptionName | None = None,
    update: Update = silent,
    store: Store | None = None,
) -> ResultRecord:
    """Return the result of every training seed of agent ``source`` on the first ``episodes`` test episodes.

    ``update`` hears how many runs are done; ``store`` gets their evidence and checkpoints. Errors are those of
    :func:`hhrl_bench.evaluation.evaluate.evaluate` and :func:`hhrl_bench.evaluation.loading.load_agents`.
    """
    agents = load_agents(source, get_scenario(task.scenario))
    seeds, held = task.test.take(episodes), None if option is None else OPTIONS[option]
    records: list[EpisodeRecords] = []
    runs: list[RunRecord] = []
    with one_torch_thread():
        for loaded in agents:
            try:
                played = play_task(loaded.agent, task, seeds, held)
            except AgentError as error:
                raise AgentError(f"{source}: {error}") from error
            records.append(played.records)
            evidence = None if store is None else _keep(store, loaded, played)
            runs.append(run_record(loaded.sha256, loaded.training, played.records, evidence))
            update(len(runs), len(agents), f"success {runs[-1].metrics.success:.1%}")
    return result_record(source, agents[0].kind, task, option, runs, records)


def result_record(
    agent: str,
    kind: Kind,
    task: Task,
    option: OptionName | None,
    runs: Sequence[RunRecord],
    records: Sequence[EpisodeRecords],
) -> ResultRecord:
    """Return the result of runs whose episodes have these records."""
    return ResultRecord(
        agent=agent,
        kind=kind,
        task=task.id,
        option=option,
        runs=tuple(runs),
        metrics=summarise(records),
        traffic=traffic.summarise(records),
    )


def run_record(
    checkpoint: str | None, training: TrainingRecord | None, records: EpisodeRecords, evidence: str | None
) -> RunRecord:
    """Return the record of one policy; ``checkpoint`` and ``evidence`` are the sha256 that they are kept under."""
    return RunRecord(
        checkpoint_sha256=checkpoint,
        training=training,
        evidence_sha256=evidence,
        episodes_sha256=records.digest(),
        metrics=RunMetricsRecord.model_validate(finite(means(records, SCORED))),
        traffic=traffic.counts(records),
    )


def _keep(store: Store, loaded: LoadedAgent, played: Played) -> str:
    if loaded.path:
        store.add_checkpoint(loaded.path.read_bytes())
    return store.add_evidence(pack(played))


def evaluation_record(task: TaskRecord, timed: Sequence[TimedResult], command: str) -> EvaluationRecord:
    """Return the record of agents on one task, which ``command`` made."""
    return EvaluationRecord(
        schema_version=SCHEMA_VERSION,
        confidence=CONFIDENCE,
        bootstrap_seed=BOOTSTRAP_SEED,
        task=task,
        results=tuple(one.result for one in timed),
        provenance=provenance(command, wall_seconds(timed)),
    )


def wall_seconds(timed: Sequence[TimedResult]) -> dict[str, float]:
    """Return what each result took, by task and agent."""
    return {f"{one.result.task}/{one.result.agent}": one.seconds for one in timed}


def task_record(task: Task, episodes: int) -> TaskRecord:
    """Return the record of a task whose first ``episodes`` test episodes are played."""
    scenario, seeds = get_scenario(task.scenario), task.test.take(episodes)
    return TaskRecord(
        id=task.id,
        scenario=scenario.id,
        spec_hash=scenario.spec_hash,
        interface_hash=scenario.interface_hash,
        golden_digest=trajectory_digest(scenario),
        env_steps=task.env_steps,
        train_start=task.train.start,
        validation_start=task.validation.start,
        test_start=int(seeds[0]),
        episodes=len(seeds),
        shared=task.shared,
        opponent=_opponent_record(task),
    )


def _opponent_record(task: Task) -> OpponentRecord | None:
    loaded = load_opponent(task)
    if task.opponent is None or loaded is None:
        return None
    return OpponentRecord(agent=task.opponent, checkpoint_sha256=loaded.sha256)
