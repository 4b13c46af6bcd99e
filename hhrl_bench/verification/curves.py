"""Learning curves of an entry: whose they are, and how they agree with its runs and checkpoints.

They were played in validation worlds, of which no evidence is kept: only training again, at the level retrained, proves
them. A transfer publishes no checkpoints, so its learned rows have to be those of its curves, and their sources.
"""

from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import NamedTuple

from hhrl_bench.errors import RecordError
from hhrl_bench.evaluation.records import ResultRecord, RunRecord, TrainingRecord
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.findings import Finding, differences
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.tasks.tasks import get_task
from hhrl_bench.training.learning_curves import TRAINING_OUTCOMES, TrainingOutcomesRecord, read_outcomes
from hhrl_bench.training.train import VALIDATION_EPISODES
from hhrl_bench.transfer.transfer import CONTROL
from hhrl_bench.verification.identity import named, rounded, shipped, shipped_scenario
from hhrl_envs import SCENARIOS
from hhrl_envs.errors import InputError

UNTRAINED = "zero-shot"


class _Curves(NamedTuple):
    """The curves of the seeds of a result: success, and collisions where they are known, [seeds, reports]."""

    place: str
    agent: str
    task: str
    method: str
    arm: str | None
    seeds: tuple[int, ...]
    env_steps: tuple[int, ...]
    success: tuple[tuple[float | None, ...], ...]
    collision: tuple[tuple[float | None, ...], ...] | None = None

    def scores(self, seed: int) -> list[tuple[float, float]]:
        """Return what a checkpoint of a seed is chosen by at every report, as far as it is known: more is better."""
        index = self.seeds.index(seed)
        collisions = self.collision[index] if self.collision else (0.0,) * len(self.env_steps)
        pairs = zip(self.success[index], collisions, strict=True)
        return [(success or 0.0, -(collision or 0.0)) for success, collision in pairs]


def _curves(board: LeaderboardRecord) -> Iterator[_Curves]:
    for index, one in enumerate(board.trainings):
        tested = one.testing
        yield _Curves(
            f"trainings[{index}]", one.method, one.task, one.method, None, one.seeds, one.env_steps, tested.success,
            tested.collision,
        )  # fmt: skip
    for index, row in enumerate(board.transfer.rows if board.transfer else ()):
        own = f"{row.method} {row.arm}", row.target, row.method, row.arm
        yield _Curves(f"transfer.rows[{index}]", *own, row.seeds, row.env_steps, row.success)


def check_curves(board: LeaderboardRecord) -> Iterator[Finding]:
    """Return where curves are not those of the entry's results, as far as the entry itself shows it."""
    results = {(result.agent, result.task): index for index, result in enumerate(board.results)}
    seen: set[tuple[str, str]] = set()
    for curves in _curves(board):
        index = results.get((curves.agent, curves.task))
        if (curves.agent, curves.task) in seen:
            yield Finding(curves.place, f"{curves.agent} has curves on {curves.task} already; keep one of them")
            continue
        seen.add((curves.agent, curves.task))
        if index is None:
            yield Finding(curves.place, f"the entry has no result of {curves.agent} on {curves.task}")
            continue
        result = board.results[index]
        try:
            yield from _check_seeds(curves, result)
        except InputError as error:
            yield Finding(curves.place, str(error))
            continue
        for number, run in enumerate(result.runs):
            if run.training:
                yield from _check_origin(f"results[{index}].runs[{number}].training", curves, run.training)
            yield from _check_choice(f"results[{index}].runs[{number}].training.env_steps", curves, run)
    if board.transfer:
        yield from _check_transfer(board)


def _check_seeds(curves: _Curves, result: ResultRecord) -> Iterator[Finding]:
    yield from differences(f"{curves.place}.seeds", curves.seeds, tuple(sorted((*result.seeds, *result.failed_seeds))))
    known = [run.training for run in result.runs if run.training]
    for steps in {rounded(one.budget, one.method) for one in known if one.budget is not None}:
        yield from differences(f"{curves.place}.env_steps", curves.env_steps[-1], steps)
    for index, (seed, rates) in enumerate(zip(curves.seeds, curves.success, strict=True)):
        if not all(rate is None or (rate * VALIDATION_EPISODES).is_integer() for rate in rates):
            yield Finding(f"{curves.place}.success[{index}]", f"a rate is none of {VALIDATION_EPISODES} episodes")
        failed = seed in result.failed_seeds
        if curves.collision and (rates[-1] is None) != failed:
            yield Finding(f"{curves.place}.success[{index}]", "it ends early if its seed has failed, and only then")
        if curves.arm and failed and (curves.arm == UNTRAINED or rates[-1] != 0.0):
            said = f"its seed has failed, so it ends with 0; {UNTRAINED} cannot fail"
            yield Finding(f"{curves.place}.success[{index}]", said)


def _check_origin(place: str, curves: _Curves, training: TrainingRecord) -> Iterator[Finding]:
    """Return whether a run was trained otherwise than its curve says: by another method, or in another task."""
    yield from differences(f"{place}.method", training.method, curves.method)
    yield from differences(f"{place}.task", training.task, curves.task)
    yield from differences(f"{place}.arm", training.arm, curves.arm)


def _check_choice(place: str, curves: _Curves, run: RunRecord) -> Iterator[Finding]:
    """Return whether a checkpoint was not taken at the best report of its curve."""
    training = run.training
    if training is None or training.seed not in curves.seeds:
        return
    if training.env_steps not in curves.env_steps:
        yield Finding(place, "its learning curve has no report there")
        return
    scores = curves.scores(training.seed)
    if scores[curves.env_steps.index(training.env_steps)] < max(scores):
        best = curves.env_steps[scores.index(max(scores))]
        yield Finding(place, f"its learning curve is best at {best:,} env steps, not where its checkpoint was taken")


class _Group(NamedTuple):
    """What the arms of a method in a target began with: a source scenario, and checkpoints by seed where known."""

    source: str
    parents: dict[int, str | None]
    control: str | None


def _check_transfer(board: LeaderboardRecord) -> Iterator[Finding]:
    """Return which learned rows of a transfer are neither arms nor sources, and which arms are not what they say.

    A source is a result of the entry or, where it is none, what comes with the package; the file of a user's own is
    known by its hash alone, and has to be the same for all arms of a seed.
    """
    rows = board.transfer.rows if board.transfer else ()
    origins = {(one.agent, get_task(one.task).scenario): one for one in board.results if one.runs[0].training}
    settings = {(one.agent, one.task): first.config_hash for one in board.results if (first := one.runs[0].training)}
    groups: dict[tuple[str, str], _Group] = {}
    for index, row in enumerate(rows):
        place, key = f"transfer.rows[{index}].source", (row.method, row.target)
        if key not in groups:
            if row.source not in SCENARIOS:
                yield Finding(place, f"{row.source!r} is no registered scenario, and so no source")
            parents = _parents(origins.get((row.method, row.source)), row.method, row.source)
            groups[key] = _Group(row.source, parents, settings.get((f"{row.method} {CONTROL}", row.target)))
        yield from differences(place, row.source, groups[key].source)
    arms = {(f"{row.method} {row.arm}", row.target): groups[row.method, row.target] for row in rows}
    sources = {(method, group.source) for (method, _), group in groups.items()}
    for index, result in enumerate(board.results):
        group = arms.get((result.agent, result.task))
        if group is None:
            learned = named(result.agent, result.kind).kind == "learned"
            if learned and (result.agent, get_task(result.task).scenario) not in sources:
                place = f"results[{index}].agent"
                yield Finding(place, "it is no arm of the transfer, nor its source; publish its checkpoints")
            continue
        for number, run in enumerate(result.runs):
            if run.training:
                yield from _check_arm(f"results[{index}].runs[{number}].training", run.training, group)


def _parents(result: ResultRecord | None, method: str, scenario: str) -> dict[int, str | None]:
    """Return the checkpoints of a source by seed: of a result, or else those that come with the package."""
    if result is not None:
        return {run.training.seed: run.checkpoint_sha256 for run in result.runs if run.training}
    return dict(enumerate(shipped(method))) if scenario == shipped_scenario(method) else {}


def _check_arm(place: str, training: TrainingRecord, group: _Group) -> Iterator[Finding]:
    """Return where the training of an arm is not that of one with the settings of its control and from its source."""
    if (training.budget is None) != (training.arm == UNTRAINED):
        yield Finding(f"{place}.budget", f"{UNTRAINED} has none, and every other arm has one")
    yield from differences(f"{place}.config_hash", training.config_hash, group.control)
    begins = None
    if training.arm != CONTROL:
        begins = group.parents.setdefault(training.seed, training.source_sha256) or "a checkpoint"
    yield from differences(f"{place}.source_sha256", training.source_sha256, begins)


def check_validation(board: LeaderboardRecord, store: Store) -> Iterator[Finding]:
    """Return which checkpoints say of their validation what their curves do not."""
    trainings = {(one.method, one.task): (index, one) for index, one in enumerate(board.trainings)}
    for result in board.results if board.checkpoints_published else ():
        if (result.agent, result.task) not in trainings:
            continue
        index, curves = trainings[result.agent, result.task]
        for run in result.runs:
            known = run.training and run.training.seed in curves.seeds and run.training.env_steps in curves.env_steps
            if run.checkpoint_sha256 and run.training and known:
                try:
                    said = store.checkpoint_metadata(run.checkpoint_sha256).get("validation")
                except RecordError:  # which is said of the checkpoint itself
                    continue
                yield from _check_said(f"trainings[{index}]", curves, run.training, said)


def _check_said(
    place: str, curves: TrainingOutcomesRecord, training: TrainingRecord, said: object
) -> Iterator[Finding]:
    index, report = curves.seeds.index(training.seed), curves.env_steps.index(training.env_steps)
    for outcome in TRAINING_OUTCOMES:
        known = said.get(outcome) if isinstance(said, Mapping) else None
        at = f"{place}.testing.{outcome}[{index}][{report}]"
        yield from differences(at, getattr(curves.testing, outcome)[index][report], known)


def check_trained(board: LeaderboardRecord, training: TrainingRecord, folder: Path) -> Iterator[Finding]:
    """Return where the published curves of a training are not those that it left in a run directory, trained again.

    Raises:
        CurveError: if it has left none.
    """
    seed, found = training.seed, read_outcomes(folder, (training.seed,))
    own_task = training.method, training.task
    for index, one in enumerate(board.trainings):
        if (one.method, one.task) == own_task and training.arm is None and seed in one.seeds:
            place, own = f"trainings[{index}]", one.seeds.index(seed)
            yield from differences(f"{place}.env_steps", one.env_steps[: len(found.env_steps)], found.env_steps)
            for part, outcome in product(("training", "testing"), TRAINING_OUTCOMES):
                published, again = (getattr(getattr(record, part), outcome) for record in (one, found))
                rates = (*again[0], *[None] * (len(one.env_steps) - len(again[0])))
                yield from differences(f"{place}.{part}.{outcome}[{own}]", published[own], rates)
    for index, row in enumerate(board.transfer.rows if board.transfer else ()):
        if (row.method, row.target, row.arm) == (*own_task, training.arm) and seed in row.seeds:
            place, own = f"transfer.rows[{index}]", row.seeds.index(seed)
            (success,) = found.testing.success
            rest = success[0] if row.arm == UNTRAINED else 0.0
            rates = (*(rate or 0.0 for rate in success), *[rest] * (len(row.env_steps) - len(success)))
            yield from differences(f"{place}.env_steps", row.env_steps[: len(success)], found.env_steps)
            yield from differences(f"{place}.success[{own}]", row.success[own], rates)
