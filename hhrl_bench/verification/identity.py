"""What the rows of an entry stand for: agents' names and kinds, training seeds, checkpoints; nothing is played.

A registered name is that agent and no other. A rule and a user's own factory have one run and no checkpoint; of a
factory with training seeds, and of files of another library, no two runs decide alike. A learned agent has a
checkpoint for each training seed, all of one training. Of a registered method the seeds are 0 to n - 1, or those that
its name says.
"""

import hashlib
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from hhrl_agents import METHODS, ORACLES, RULES
from hhrl_agents.policies import checkpoints
from hhrl_bench.errors import SeedError
from hhrl_bench.evaluation.records import Kind, ResultRecord, RunRecord, TrainingRecord
from hhrl_bench.evaluation.sources import shipped_checkpoints, shipped_methods
from hhrl_bench.evaluation.store import Store
from hhrl_bench.leaderboard.findings import Finding, differences
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.schema import sha256_of
from hhrl_bench.tasks.seeds import parse_seeds
from hhrl_bench.tasks.tasks import Task, registered_task
from hhrl_bench.text import looks_like
from hhrl_bench.training.train import Plan, get_method
from hhrl_bench.transfer.transfer import ARMS, target_method
from hhrl_envs import get_scenario
from hhrl_envs.errors import InputError

_FACTORY = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*(?:@([0-9][0-9,-]*))?", re.ASCII)
_SEEDED = re.compile(r"(.+):([0-9][0-9,-]*)", re.ASCII | re.DOTALL)


class Named(NamedTuple):
    """What the name of an agent says.

    Attributes:
        kind: what it is.
        method: id of a registered method, and ``arm`` of a transfer, if any.
        seeds: its training seeds, if the name says them.
        free: whether the name is nobody's, so that it can be that of several training seeds.
    """

    kind: Kind
    method: str | None = None
    arm: str | None = None
    seeds: tuple[int, ...] | None = None
    free: bool = False


def named(agent: str, kind: Kind) -> Named:
    """Return what the name of an agent says that is of this ``kind``.

    A name that is nobody's is that of files: of checkpoints, or of another library's policies, which are a user's own.
    Seeds that are spelled otherwise than as ``0-4,7`` are none.
    """
    method, _, arm = agent.partition(" ")
    if agent in ORACLES:
        return Named("oracle")
    if agent in RULES:
        return Named("rule")
    if method in METHODS and (not arm or arm in ARMS):
        return Named("learned", method, arm or None)
    stem, seeds = _parts(agent)
    if stem in METHODS:
        return Named("learned", stem, seeds=seeds)
    if match := _FACTORY.fullmatch(agent):
        return Named("factory", seeds=_seeds(match[1]) if match[1] else None)
    return Named("factory" if kind == "factory" else "learned", free=True)


def _parts(agent: str) -> tuple[str, tuple[int, ...] | None]:
    """Return the name without the training seeds behind its colon, and these."""
    match = _SEEDED.fullmatch(agent)
    return (match[1], _seeds(match[2])) if match else (agent, None)


def _seeds(text: str) -> tuple[int, ...]:
    try:
        return parse_seeds(text)
    except SeedError:
        return ()


def playable(result: ResultRecord, *, checkpoints: bool) -> bool:
    """Return whether the agents of a result can be run again: they come in code, or their ``checkpoints`` are there."""
    kind = named(result.agent, result.kind).kind
    return kind in {"rule", "oracle"} or (kind == "learned" and checkpoints)


def repeatable(training: TrainingRecord) -> bool:
    """Return whether the same training leaves the same checkpoint again, and is known well enough for that."""
    return training.exact and (training.budget is not None or training.arm is not None)


def check_identity(board: LeaderboardRecord) -> Iterator[Finding]:
    """Return which rows of an entry are not what their names say, as far as the entry itself shows it."""
    for index, result in enumerate(board.results):
        place, says = f"results[{index}]", named(result.agent, result.kind)
        yield from _check_name(f"{place}.agent", result.agent)
        yield from differences(f"{place}.kind", result.kind, says.kind)
        yield from differences(f"{place}.option", result.option, None)
        if says.kind != "learned":
            yield from _check_untrained(place, result, says)
            continue
        yield from _check_seeds(place, result, says)
        for number, run in enumerate(result.runs):
            yield from _check_run(f"{place}.runs[{number}]", run, result, says)
            yield from _check_arm(f"{place}.runs[{number}].training.arm", run.training, board)
    seconds = board.provenance.wall_seconds
    timed = dict.fromkeys(sorted(f"{result.task}/{result.agent}" for result in board.results))
    yield from differences("provenance.wall_seconds", sorted(seconds), [*timed])


def _check_arm(place: str, training: TrainingRecord | None, board: LeaderboardRecord) -> Iterator[Finding]:
    """Return whether a run is that of an arm that no transfer of the entry has: its budget and source hang on that."""
    arms = {(row.method, row.target, row.arm) for row in (board.transfer.rows if board.transfer else ())}
    if training and training.arm and (training.method, training.task, training.arm) not in arms:
        yield Finding(place, f"the entry has no transfer with {training.arm} of {training.method}")


def check_weights(board: LeaderboardRecord, store: Store) -> Iterator[Finding]:
    """Return which runs have the weights of another one of their result, or of a method that comes with the package.

    Whatever the checkpoints say of themselves. Those of a method may be in its own rows.
    """
    if not board.checkpoints_published:
        return
    digest = cache(lambda sha256: _weights(store.checkpoint(sha256)))
    for index, result in enumerate(board.results):
        seen: dict[str, int] = {}
        method = named(result.agent, result.kind).method
        for number, run in enumerate(result.runs):
            place = f"results[{index}].runs[{number}]"
            if run.checkpoint_sha256 is None:
                continue
            try:
                first = seen.setdefault(digest(run.checkpoint_sha256), number)
            except InputError as error:
                yield Finding(f"{place}.checkpoint_sha256", str(error))
                continue
            if first != number:
                yield Finding(f"{place}.checkpoint_sha256", f"it has the weights of runs[{first}]")
            owner = _shipped_weights().get(digest(run.checkpoint_sha256))
            if owner is not None and owner.partition(":")[0] != method:
                yield Finding(
                    f"{place}.checkpoint_sha256", f"it has the weights of {owner}; publish it under that name"
                )


def _weights(path: Path) -> str:
    """Return the sha256 of the parameters of a checkpoint."""
    parameters = checkpoints.load(path).parameters
    return hashlib.sha256(b"".join(parameters[name].tobytes() for name in sorted(parameters))).hexdigest()


@cache
def _shipped_weights() -> dict[str, str]:
    """Return whose the weights are that come with the package: names of methods with their seeds, by digest."""
    return {
        _weights(path): f"{method}:{seed}"
        for method in shipped_methods()
        for seed, path in enumerate(shipped_checkpoints(method))
    }


def _check_name(place: str, agent: str) -> Iterator[Finding]:
    if not agent.isascii() or agent != " ".join(agent.split()):
        yield Finding(place, f"{agent!r} has signs or spaces that may look like others; publish it under a plain name")
    stem, _ = _parts(agent)
    near = looks_like(stem, _registered())
    if near is None and stem not in _registered():
        near = _named_in(agent)
    if near is not None and (near != stem or near not in _registered() or (stem != agent and stem not in METHODS)):
        yield Finding(place, f"{agent!r} looks like {near}, which it is not; publish it under another name")


_TAKEN = ("oracle", "paper")


def _taken(agent: str) -> str | None:
    """Return which word that is no agent's to have stands in a name, between whatever signs."""
    return next((near for word in re.split(r"[\W_]+", agent) if word and (near := looks_like(word, _TAKEN))), None)


_LONGEST = 3  # words of a registered name that somebody may spell with spaces


def _named_in(agent: str) -> str | None:
    """Return which registered name, or which word that is no agent's, stands in a name beside other words.

    Names of files and modules, which their paths say, are none of these words.
    """
    if _FACTORY.fullmatch(agent):
        return None
    if "/" not in agent and (taken := _taken(agent)):
        return taken
    words, known = [word for word in re.split(r"[^\w./-]+", agent) if word], _registered()
    if len(words) < 2:
        return None
    spans = ("".join(words[i : i + n]) for n in range(1, _LONGEST + 1) for i in range(len(words) - n + 1))
    return next((near for span in spans if (near := looks_like(span, known))), None)


def _registered() -> list[str]:
    return [*RULES, *ORACLES, *METHODS, *(f"{method} {arm}" for method in METHODS for arm in ARMS)]


def _check_untrained(place: str, result: ResultRecord, says: Named) -> Iterator[Finding]:
    """Return what a rule or a user's own code has that only training by this package gives."""
    yield from differences(f"{place}.failed_seeds", result.failed_seeds, ())
    count = 1 if says.seeds is None else len(says.seeds)
    if len(result.runs) != count and not says.free:
        yield Finding(f"{place}.runs", f"{len(result.runs)} runs of an agent whose name says {count}")
    first: dict[str, int] = {}
    for number, run in enumerate(result.runs):
        same = first.setdefault(run.episodes_sha256, number)
        if same != number:
            yield Finding(f"{place}.runs[{number}]", f"it has the episodes of runs[{same}]; publish each policy once")
    for number, run in enumerate(result.runs):
        yield from differences(f"{place}.runs[{number}].checkpoint_sha256", run.checkpoint_sha256, None)
        if run.training is not None:
            yield Finding(f"{place}.runs[{number}].training", f"{result.agent} is not trained")


def _check_seeds(place: str, result: ResultRecord, says: Named) -> Iterator[Finding]:
    """Return what is wrong with the training seeds of a learned agent, and how its runs differ in what they share."""
    seeds = [*result.seeds, *result.failed_seeds]
    if len(set(seeds)) < len(seeds) or list(result.seeds) != sorted(result.seeds):
        yield Finding(f"{place}.runs", f"their seeds are {', '.join(map(str, seeds))}; each counts once, ascending")
    elif says.seeds is not None and sorted(seeds) != list(says.seeds):
        yield Finding(f"{place}.runs", f"their seeds are {', '.join(map(str, seeds))}, not those of {result.agent}")
    elif says.method and says.seeds is None and sorted(seeds) != list(range(len(seeds))):
        yield Finding(f"{place}.runs", f"their seeds are {', '.join(map(str, seeds))}, not 0 to {len(seeds) - 1}")
    first: dict[str | None, int] = {}
    for number, run in enumerate(result.runs):
        same = first.setdefault(run.checkpoint_sha256, number)
        if run.checkpoint_sha256 and same != number:
            yield Finding(f"{place}.runs[{number}].checkpoint_sha256", f"it is that of runs[{same}]")
    shared = [_shared(run.training) for run in result.runs if run.training]
    for number, other in enumerate(shared):
        yield from differences(f"{place}.runs[{number}].training", other, shared[0])


def _shared(training: TrainingRecord) -> dict[str, object]:
    return training.model_dump(exclude={"seed", "env_steps", "command", "source_sha256"})


def _check_run(place: str, run: RunRecord, result: ResultRecord, says: Named) -> Iterator[Finding]:
    if run.checkpoint_sha256 is None or run.training is None:
        yield Finding(f"{place}.checkpoint_sha256", f"{result.agent} is learned; publish a checkpoint of every run")
        return
    try:
        if run.training.task is not None or says.method is not None:
            yield from _check_training(f"{place}.training", run.training)
        yield from _check_method(f"{place}.training", run.training)
        if says.method is not None:
            yield from _check_registered(f"{place}.training", run, result, says)
    except InputError as error:
        yield Finding(f"{place}.training", str(error))


def _check_training(place: str, training: TrainingRecord) -> Iterator[Finding]:
    """Return what a training says of itself that cannot be."""
    task, budget = registered_task(training.task or ""), training.budget or 0
    scenario = get_scenario(task.scenario)
    yield from differences(f"{place}.scenario", training.scenario, scenario.id)
    yield from differences(f"{place}.spec_hash", training.spec_hash, scenario.spec_hash)
    if training.env_steps > rounded(budget, training.method):
        yield Finding(f"{place}.env_steps", f"{training.env_steps:,} steps are more than its budget of {budget:,}")
    commands = [None] if training.arm else _commands(training, task, budget)
    if training.command not in commands:
        yield Finding(f"{place}.command", "it is not the command that trains this seed; an arm has none")
    compiled = training.command == commands[0] and get_method(training.method).config.extra is None
    yield from differences(f"{place}.exact", training.exact, compiled)


def rounded(budget: int, method: str) -> int:
    """Return the env steps of a training that has this budget: whole rounds of the method's environments."""
    n_envs: int = get_method(method).config.n_envs
    return -(-budget // n_envs) * n_envs


def _check_method(place: str, training: TrainingRecord) -> Iterator[Finding]:
    """Return where a checkpoint has other settings than the method by whose name it was trained."""
    yield from _check_name(f"{place}.method", training.method)
    if training.method in METHODS:
        method = get_method(training.method)
        if training.arm is not None:
            if training.budget is None:
                return  # zero-shot has the settings of the other arms, whose budget it does not know
            method = target_method(method, registered_task(training.task or ""), training.budget)
        yield from differences(f"{place}.config_hash", training.config_hash, method.config_hash)


def _commands(training: TrainingRecord, task: Task, budget: int) -> list[str]:
    """Return the commands that train a seed so, by either engine."""
    method = get_method(training.method)
    ways = (("compiled", "cpu"), ("torch", "cpu"), ("torch", "cuda"))
    return [Plan(method, task, (training.seed,), budget, Path(), None, *way).command for way in ways]


def _check_registered(place: str, run: RunRecord, result: ResultRecord, says: Named) -> Iterator[Finding]:
    """Return where a row of a registered method is not of that method as it is registered, with its task's budget."""
    training, task = run.training, registered_task(result.task)
    assert training is not None
    yield from differences(f"{place}.method", training.method, says.method)
    yield from differences(f"{place}.arm", training.arm, says.arm)
    if says.arm is not None:
        yield from differences(f"{place}.task", training.task, task.id)
    elif run.checkpoint_sha256 not in shipped(says.method or ""):
        yield from differences(f"{place}.budget", training.budget, registered_task(training.task or "").env_steps)


@cache
def shipped(method: str) -> list[str]:
    """Return the hashes of the checkpoints of a method that come with the package, lowest seed first."""
    paths = shipped_checkpoints(method) if method in shipped_methods() else []
    return [sha256_of(path.read_bytes()) for path in paths]


@cache
def shipped_scenario(method: str) -> str | None:
    """Return the scenario that the checkpoints of a method which come with the package were trained in."""
    paths = shipped_checkpoints(method) if method in shipped_methods() else []
    return checkpoints.load(paths[0]).scenario.id if paths else None
