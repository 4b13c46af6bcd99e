"""Results with 95% intervals beside the paper's own rows, every training seed of them, and the worst cases."""

from collections.abc import Iterator, Sequence

from hhrl_bench import paper_table
from hhrl_bench.evaluation.metrics import HEADLINE, METRICS, Metric, columns
from hhrl_bench.evaluation.records import ResultRecord, RunRecord, TaskRecord
from hhrl_bench.leaderboard.sensitivity import SensitivityRecord
from hhrl_bench.paper_table import CASES, PaperRow
from hhrl_bench.statistics.intervals import wilson
from hhrl_bench.tables.success import held, row_name
from hhrl_bench.tables.table import (
    Cell,
    Column,
    Group,
    Note,
    Row,
    Table,
    TerminalFit,
    metric_cell,
    number_cell,
    percent,
    unbroken,
)
from hhrl_bench.tasks.tasks import TASKS
from hhrl_bench.text import NAME_WIDTH

_FIT = TerminalFit("first", name_widths=(NAME_WIDTH, 12), wider=("95% intervals", "95% intervals and more columns"))


def results_table(task: TaskRecord, results: Sequence[ResultRecord], *, seeds: bool = False) -> Table:
    """Return the results on a task: the columns of Table I, those of further metrics; in its world its rows below.

    seeds: whether the last column counts the training seeds.
    """
    metrics, last = shown_metrics(results), (Column("seeds"),) if seeds else ()
    rows = tuple(
        Row(result.agent, (*_measured(metrics, result), *((_seeds(result),) if seeds else ())), held(result))
        for result in results
    )
    groups = [Group("", rows)]
    if task.id == paper_table.TABLE_I_TASK:
        blank = (Cell(),) * len(last)
        printed = (
            Row(row.policy, (*(paper_cell(metric, row) for metric in metrics), *blank)) for row in paper_table.TABLE_I
        )
        groups.append(Group("the paper", tuple(printed), quoted=True))
    return Table(
        "Results",
        "agent",
        (*_columns(metrics), *last),
        tuple(groups),
        tuple(_notes(task, results)),
        full_title=f"{task.id}, {task.episodes:,} test episodes",
        fit=_FIT,
    )


def runs_table(results: Sequence[ResultRecord]) -> Table:
    """Return every training seed of the results that have some, with the env steps that its checkpoint was trained."""
    metrics = shown_metrics(results)
    groups = [
        Group(
            row_name(result),
            tuple(Row(f"seed {run.training.seed}", _run(metrics, run)) for run in result.runs if run.training),
        )
        for result in results
        if result.seeds
    ]
    last = (Column("env steps"), Column("checkpoint sha256"))
    return Table("Every training seed", "training seed", (*_columns(metrics), *last), tuple(groups))


def shown_metrics(results: Sequence[ResultRecord]) -> list[Metric]:
    """Return the metrics that are columns of results: those of Table I, then all others that a result has."""
    known = [metric for metric in columns("results") if any(metric.key in one.metrics for one in results)]
    return sorted(known, key=lambda metric: metric.key not in PaperRow._fields)


def paper_cell(metric: Metric, row: PaperRow) -> Cell:
    """Return a number of Table I with the digits that it is printed with; of rates with Wilson's interval."""
    value = getattr(row, metric.key, None)
    if value is None:
        return Cell()
    if metric.is_rate:
        share = wilson(value, CASES)
        return Cell(f"{share.mean:.0%}", number_cell(metric, share.mean, share.low, share.high).bounds)
    return Cell(f"{value}") if isinstance(value, int) else number_cell(metric, value)


def _notes(task: TaskRecord, results: Sequence[ResultRecord]) -> list[Note]:
    """Return what to know of the results of a task, a sentence or two a line."""
    lines = [Note(_meaning(results), "Means an episode.")]
    if task.id == paper_table.TABLE_I_TASK:
        source = f"The paper's rows: Table I, {CASES} cases"
        lines.append(Note(f"{source}, Wilson.", f"{source}."))
    lines += [Note(note) for result in results for note in _of_agent(task, result)]
    return [*lines, *map(Note, _traffic(task, results))]


def _columns(metrics: Sequence[Metric]) -> tuple[Column, ...]:
    """Return the columns of metrics; the score is kept longest, then those of Table I, of them the last ones."""
    return tuple(
        Column(
            metric.heading,
            priority=i if metric.key in {*PaperRow._fields, HEADLINE} else -i,
            wide=unbroken(metric.heading),
            narrow=metric.heading.replace(" ", "\n"),
        )
        for i, metric in enumerate(metrics)
    )


def _measured(metrics: Sequence[Metric], result: ResultRecord) -> list[Cell]:
    return [metric_cell(metric, result.metrics.get(metric.key)) for metric in metrics]


def _seeds(result: ResultRecord) -> Cell:
    failed = f", {len(result.failed_seeds)} failed" if result.failed_seeds else ""
    count = len(result.seeds) or (len(result.runs) if len(result.runs) > 1 else 0)
    return Cell(f"{count}{failed}" if count else None)


def _run(metrics: Sequence[Metric], run: RunRecord) -> tuple[Cell, ...]:
    measured = [number_cell(metric, run.metrics.get(metric.key)) for metric in metrics]
    steps = Cell(f"{run.training.env_steps:,}" if run.training else None)
    return (*measured, steps, Cell(run.checkpoint_sha256 and run.checkpoint_sha256[:12]))


def _meaning(results: Sequence[ResultRecord]) -> str:
    """Return what the numbers and their intervals are."""
    seeds = sorted({len(result.runs) for result in results if len(result.runs) > 1})
    over = [f"over the {' or '.join(map(str, seeds))} training seeds"] if seeds else []
    if any(len(result.runs) == 1 for result in results):
        over.append("over the episodes of a single policy (rates: Wilson)")
    return f"Means and 95% intervals: bootstrap {', or '.join(over)}."


def _traffic(task: TaskRecord, results: Sequence[ResultRecord]) -> list[str]:
    """Return who drives the other vehicles, how many episodes were feasible, and how many of those succeeded."""
    said = ["One policy drives all vehicles; success: all of them stopped."] if task.shared else []
    known = TASKS.get(task.id)
    if task.opponent:
        said.append(f"The front vehicle is driven by {task.opponent.agent}.")
    elif known and known.opponent:
        said.append("The front vehicle is scripted.")
    shares = [(result.agent, result.traffic) for result in results if result.traffic]
    return said + [
        f"{agent}: {percent(traffic.feasible)} of the episodes were feasible, and {percent(traffic.success_feasible)} "
        "of those succeeded."
        for agent, traffic in shares
    ]


def _of_agent(task: TaskRecord, result: ResultRecord) -> Iterator[str]:
    """Yield what is to be known of where an agent comes from, and of its training.

    That is: whether it is an oracle or a user's own code, other scenarios than the task's, and that the training is not
    exact.
    """
    if result.kind == "oracle":
        yield (
            f"{result.agent} knows how the traffic will drive. It goes the quickest way that is comfortable and keeps "
            "the gap d_0, where there is one: it shows what is possible, and is no rival."
        )
    if result.kind == "factory":
        yield f"{result.agent} is a user's own code: to verify it, its decisions are replayed, not made again."
    trainings = [run.training for run in result.runs if run.training]
    others = {training.scenario for training in trainings} - {task.scenario}
    if others:
        yield f"{result.agent} was trained in {', '.join(sorted(others))}."
    if not all(training.exact for training in trainings):
        yield f"{result.agent}: the same training gives other policies on other machines; the policies decide the same."


WORST_CASES = (
    "Worst seed: the training seed, in brackets, that succeeds least. Collisions are counted over all seeds.",
    "Impact: the speed relative to the front vehicle, a mean over the collisions.",
    "Gap and TTC, the time to collision: the smallest of every episode, a mean over the episodes.",
)


def worst_cases_table(task: TaskRecord, results: Sequence[ResultRecord]) -> Table:
    """Return the worst training seed of every result, its collisions, and how severe its episodes are."""
    metrics = [metric for metric in columns("worst cases") if any(metric.key in one.metrics for one in results)]
    headings = ("worst seed's\nsuccess", "collisions", *(metric.heading for metric in metrics))
    rows = (Row(result.agent, (*_worst(task, result), *_measured(metrics, result)), held(result)) for result in results)
    return Table(
        "Worst cases",
        "agent",
        tuple(Column(heading, -i) for i, heading in enumerate(headings)),
        (Group("", tuple(rows)),),
        tuple(map(Note, WORST_CASES)),
        full_title=f"Worst cases on {task.id}, {task.episodes:,} test episodes",
    )


SCORE = (
    "Score: 0 without success, else progress times the mean of comfort and margin.",
    "Progress: the fewest steps, found by the oracle, over those taken.",
    "Comfort and margin: the shares of steps within the bounds.",
)


def further_tables(task: TaskRecord, results: Sequence[ResultRecord]) -> list[Table]:
    """Return what the scores are made of, where there are some, and the worst cases."""
    scores = [score_table(task, results)] if any(HEADLINE in one.metrics for one in results) else []
    return [*scores, worst_cases_table(task, results)]


def score_table(task: TaskRecord, results: Sequence[ResultRecord]) -> Table:
    """Return the score of every result and what it is made of."""
    metrics = [METRICS[HEADLINE], *reversed(columns("score"))]
    return Table(
        "Score",
        "agent",
        tuple(Column(metric.heading, -i) for i, metric in enumerate(metrics)),
        (Group("", tuple(Row(result.agent, tuple(_measured(metrics, result)), held(result)) for result in results)),),
        tuple(map(Note, SCORE)),
        full_title=f"Score on {task.id}, {task.episodes:,} test episodes",
    )


def sensitivity_tables(records: Sequence[SensitivityRecord], task: TaskRecord) -> list[Table]:
    """Return what moving a weight of the score changes in the ranking on a task; no table where nothing is ranked."""
    own = [one for one in records if one.task == task.id]
    if not own:
        return []
    factors = list(dict.fromkeys(one.factor for one in own))
    found = {(one.part, one.factor): one.rank_correlation for one in own}
    rows = (
        Row(part, tuple(Cell(None if (one := found[part, by]) is None else f"{one:.3f}") for by in factors))
        for part in dict.fromkeys(one.part for one in own)
    )
    known = [one for one in found.values() if one is not None]
    least = [Note(f"The lowest of these rank correlations is {min(known):.3f}.")] if known else []
    return [
        Table(
            "Sensitivity to the weights of the score",
            "weight of",
            tuple(Column(f"times {factor:g}", -i) for i, factor in enumerate(factors)),
            (Group("", tuple(rows)),),
            (Note(f"Rank correlation (Spearman) with the ranking by score, of {own[0].agents} agents."), *least),
            full_title=f"Sensitivity to the weights of the score on {task.id}",
        )
    ]


def worst_run(result: ResultRecord) -> RunRecord:
    """Return the run that succeeds least; of equal ones the first."""
    return min(result.runs, key=lambda run: run.metrics.success)


def _worst(task: TaskRecord, result: ResultRecord) -> tuple[Cell, Cell]:
    worst = worst_run(result)
    seed = f" ({worst.training.seed})" if worst.training and len(result.runs) > 1 else ""
    hits = sum(round(run.metrics.collision * task.episodes) for run in result.runs)
    rate = number_cell(METRICS["success"], worst.metrics.success).value
    return Cell(f"{rate}{seed}"), Cell(f"{hits:,} of {len(result.runs) * task.episodes:,}")
