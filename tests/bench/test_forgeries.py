"""Forged entries: a number that is not so, a name that is another's, a file that costs too much; each is refused.

A forgery changes an honest entry, its files or the index of its folder, and says at which level it has to be refused
and where. Each family has fixed cases and, drawn by hypothesis, others of its kind.
"""

import gzip
import json
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from safetensors.numpy import load, save

from hhrl_agents import METHODS, RULES
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.learned_agent import make_agent
from hhrl_bench.evaluation.decisions import Trace
from hhrl_bench.evaluation.evidence import Evidence, unpack
from hhrl_bench.evaluation.replay import replay
from hhrl_bench.evaluation.results import task_record
from hhrl_bench.evaluation.store import Store, read
from hhrl_bench.leaderboard.entry import read_entry
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.leaderboard.record import LeaderboardRecord
from hhrl_bench.publishing.copies import Stored, copied
from hhrl_bench.publishing.publication import (
    IndexRecord,
    VerifiedEntry,
    check_index,
    check_suite,
    verified_now,
    write_index,
)
from hhrl_bench.schema import sha256_of
from hhrl_bench.suites import suites
from hhrl_bench.suites.suites import ScoreSuite, TrainingSuite, TransferSuite
from hhrl_bench.tasks.tasks import get_task
from hhrl_bench.verification.verify import verify
from hhrl_envs.errors import InputError
from support import small_board
from support.mutations import at, put

RULE, DDQN, PLATOON, ADVERSARY, FOLLOW = 0, 1, 3, 4, 5
"""Results of the small board: rule-2 and ddqn in stop-line-v0, platoon, rule-2 and follow-only behind the adversary."""


class Board:
    """An entry as a forger has it: its data, and its files in a folder."""

    def __init__(self, path: Path, data: Any) -> None:
        self.path, self.data = path, data

    @property
    def store(self) -> Store:
        return Store(self.path.parent)

    def put(self, *place: str | int, value: object) -> None:
        self.data = put(self.data, place, value)

    def at(self, *place: str | int) -> Any:
        return at(self.data, place)

    def evidence(self, result: int, run: int = 0) -> Evidence:
        return unpack(read(self.store.evidence(self.at("results", result, "runs", run, "evidence_sha256"))))

    def change_evidence(self, result: int, **arrays: Any) -> None:
        """Give the first run of a result evidence in which these arrays are others."""
        kept = self.evidence(result)
        trace = kept.trace._replace(**{name: arrays.pop(name) for name in Trace._fields if name in arrays})
        kept = kept._replace(trace=trace, **arrays)
        self.add_evidence(result, small_board.repacked(kept))

    def add_evidence(self, result: int, content: bytes) -> None:
        self.put("results", result, "runs", 0, "evidence_sha256", value=self.store.add_evidence(content))

    def change_checkpoint(self, result: int, run: int, **metadata: Any) -> None:
        """Give a run a checkpoint of the same weights that says these things of itself, and say so in the entry."""
        sha256 = self.at("results", result, "runs", run, "checkpoint_sha256")
        agent = checkpoints.load(self.store.checkpoint(sha256))
        changed = agent.metadata | metadata
        path = self.path.parent / "forged.safetensors"
        checkpoints.save(path, make_agent(agent.method, agent.scenario, agent.parameters, changed))
        content = path.read_bytes()
        path.unlink()
        self.store.add_checkpoint(content)
        self.put("results", result, "runs", run, "checkpoint_sha256", value=sha256_of(content))
        training = self.at("results", result, "runs", run, "training")
        self.put(
            "results", result, "runs", run, "training",
            value=training | {key: value for key, value in metadata.items() if key in training},
        )  # fmt: skip

    def said(self, level: Level) -> list[str]:
        """Return what is said of the entry as it is now, at a level."""
        self.path.write_text(json.dumps(self.data))
        try:
            return [str(one) for one in verify(read_entry(self.path), self.store, level)]
        except InputError as error:
            return [str(error)]


Forge = Callable[[Board], None]


@pytest.fixture(scope="module", autouse=True)
def few_resamples() -> Iterator[None]:
    with small_board.resamples(99):
        yield


@pytest.fixture(scope="module")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_board.publish(tmp_path_factory.mktemp("honest"))


@pytest.fixture
def board(honest: Path, tmp_path: Path) -> Board:
    shutil.copytree(honest.parent, tmp_path / "copy")
    return Board(tmp_path / "copy" / honest.name, json.loads(honest.read_text()))


def renamed(result: int, agent: str, kind: str | None = None) -> Forge:
    def forge(board: Board) -> None:
        board.put("results", result, "agent", value=agent)
        if kind is not None:
            board.put("results", result, "kind", value=kind)

    return forge


def with_value(*place: str | int, value: object) -> Forge:
    return lambda board: board.put(*place, value=value)


def same_run_again(board: Board) -> None:
    runs = board.at("results", DDQN, "runs")
    board.put("results", DDQN, "runs", value=[runs[0]] * len(runs))


def same_file_of_other_seeds(board: Board) -> None:
    for run in range(1, 5):
        sha256 = board.at("results", DDQN, "runs", 0, "checkpoint_sha256")
        board.put("results", DDQN, "runs", run, "checkpoint_sha256", value=sha256)


def same_weights_of_other_seeds(board: Board) -> None:
    for run in range(1, 5):
        sha256 = board.at("results", DDQN, "runs", 0, "checkpoint_sha256")
        board.put("results", DDQN, "runs", run, "checkpoint_sha256", value=sha256)
        command = f"hhrl-bench train ddqn --task stop-line-v0 --seeds {run}"
        board.change_checkpoint(DDQN, run, seed=run, command=command)


def without_the_worst_seed(board: Board) -> None:
    board.put("results", DDQN, "runs", value=board.at("results", DDQN, "runs")[1:])


def without_checkpoints(board: Board) -> None:
    for run in range(5):
        board.put("results", DDQN, "runs", run, "checkpoint_sha256", value=None)
        board.put("results", DDQN, "runs", run, "training", value=None)


def rule_with_a_network(board: Board) -> None:
    run = board.at("results", DDQN, "runs", 0)
    board.put("results", RULE, "runs", value=[run])
    board.put("results", RULE, "agent", value="rule-1")


def longer_trained(board: Board) -> None:
    command = "hhrl-bench train ddqn --task stop-line-v0 --seeds 0 --env-steps 900000"
    board.change_checkpoint(DDQN, 0, budget=900_000, command=command)


def several_runs_of(agent: str, *results: int, kind: str = "factory") -> Forge:
    """Return a row of this name, with the episodes of these results, each as one run."""

    def forge(board: Board) -> None:
        runs = [board.at("results", result, "runs", 0) for result in results]
        untrained = [run | {"checkpoint_sha256": None, "training": None} for run in runs]
        board.put("results", RULE, value=board.at("results", RULE) | {"agent": agent, "kind": kind, "runs": untrained})

    return forge


def on_task(name: str) -> Forge:
    """Give the task of the platoon another name."""

    def forge(board: Board) -> None:
        board.put("tasks", 1, "id", value=name)
        for part in ("results", "trainings"):
            for index, one in enumerate(board.at(part)):
                if one["task"] == "platoon-v0":
                    board.put(part, index, "task", value=name)

    return forge


def of_another_agent(board: Board) -> None:
    sha256 = board.at("results", FOLLOW, "runs", 0, "evidence_sha256")
    board.put("results", ADVERSARY, "runs", 0, "evidence_sha256", value=sha256)


def kinder_opponent(board: Board) -> None:
    actions = board.evidence(ADVERSARY).trace.actions.copy()
    actions[:, 1] = 0
    board.change_evidence(ADVERSARY, actions=actions)


def kinder_opponent_of_own_code(board: Board) -> None:
    kinder_opponent(board)
    renamed(ADVERSARY, "mine:make", "factory")(board)


def bomb(board: Board) -> None:
    content = small_board.repacked(board.evidence(RULE))
    board.add_evidence(RULE, content + bytes(40_000_000))


def bomb_under_its_own_hash(board: Board) -> None:
    content = bytes(200_000_000)
    path = board.store.evidence(sha256_of(content))
    path.write_bytes(gzip.compress(content, 1))
    board.put("results", RULE, "runs", 0, "evidence_sha256", value=sha256_of(content))


def many_results(count: int) -> Forge:
    def forge(board: Board) -> None:
        one = board.at("results", RULE)
        board.put("results", value=[one | {"agent": f"mine:make_{index}"} for index in range(count)])

    return forge


def many_episodes_to_resample(board: Board) -> None:
    many_results(50)(board)
    board.put("tasks", 0, "episodes", value=2_000)


def many_pairs_of_runs(board: Board) -> None:
    one = board.at("results", RULE)
    many = one | {"runs": one["runs"] * 100}
    board.put("results", value=[many | {"agent": f"mine:make_{index}@0-99"} for index in range(16)])


def many_runs(board: Board) -> None:
    board.put("results", DDQN, "runs", value=board.at("results", DDQN, "runs") * 30)


def many_arms(board: Board) -> None:
    curve = board.at("trainings", 0)
    board.put("trainings", value=[curve | {"method": f"method-{index}"} for index in range(501)])


def long_header(board: Board) -> None:
    """A checkpoint that is all header: reading it as JSON would take much more than its bytes."""
    header = b'{"__metadata__":{"hhrl-checkpoint":"[' + b"[]," * 500_000 + b'0]"}}'
    sha256 = board.store.add_checkpoint(len(header).to_bytes(8, "little") + header)
    board.put("results", DDQN, "runs", 0, "checkpoint_sha256", value=sha256)


def long_header_of_evidence(board: Board) -> None:
    header = b'{"__metadata__":{' + b",".join(b'"%d":""' % key for key in range(50_000)) + b"}}"
    board.add_evidence(RULE, len(header).to_bytes(8, "little") + header)


def turned(array: str) -> Forge:
    def forge(board: Board) -> None:
        values = np.asarray(getattr(board.evidence(RULE), array))
        board.change_evidence(RULE, **{array: np.roll(values, 1) if array == "steps" else 1 - values})

    return forge


def other_actions(board: Board) -> None:
    actions = board.evidence(RULE).trace.actions.copy()
    actions[:20] = 5
    board.change_evidence(RULE, actions=actions)


def measured(key: str) -> Forge:
    def forge(board: Board) -> None:
        kept = board.evidence(RULE).measured
        board.change_evidence(RULE, measured={**kept, key: np.zeros_like(kept[key])})

    return forge


def minus_zero(board: Board) -> None:
    metrics = board.at("results", RULE, "runs", 0, "metrics")
    key = next(key for key, value in metrics.items() if value == 0.0)
    board.put("results", RULE, "runs", 0, "metrics", key, value=-0.0)


def curves_of_nobody(board: Board) -> None:
    trainings = board.at("trainings")
    board.put("trainings", value=[*trainings, trainings[0] | {"method": "ddqn-plus"}])


def validated(report: int, success: float) -> Forge:
    """A report of the validation of ddqn, at its place or, for -1, where the checkpoint of seed 0 was taken."""

    def forge(board: Board) -> None:
        steps = board.at("results", DDQN, "runs", 0, "training", "env_steps")
        place = board.at("trainings", 0, "env_steps").index(steps) if report < 0 else report
        shares = {"success": success, "timeout": 1.0 - success, "not_stop": 0.0, "collision": 0.0}
        for outcome, share in shares.items():
            board.put("trainings", 0, "testing", outcome, 0, place, value=share)

    return forge


def curves_twice(board: Board) -> None:
    """The curves of ddqn once more, for what is the same task under the name of its scenario."""
    board.put("trainings", value=[*board.at("trainings"), board.at("trainings", 0)])


def best_elsewhere(board: Board) -> None:
    validated(-1, 0.0)(board)
    validated(0, 0.5)(board)


def shorter_training(board: Board) -> None:
    board.put("trainings", 0, "env_steps", value=[*board.at("trainings", 0, "env_steps")[:-1], 299_999])


def failed_without_a_fault(board: Board) -> None:
    board.put("results", DDQN, "runs", value=board.at("results", DDQN, "runs")[:-1])
    board.put("results", DDQN, "failed_seeds", value=[4])


def other_settings(board: Board) -> None:
    board.put("results", DDQN, "agent", value="my-ddqn")
    for run in range(5):
        board.put("results", DDQN, "runs", run, "training", "config_hash", value="0" * 64)


def as_transfer(board: Board) -> None:
    own = small_board.with_transfer(LeaderboardRecord.model_validate_json(json.dumps(board.data)), board.store)
    board.data = json.loads(own.model_dump_json())


def of_transfer(*place: str | int, value: object) -> Forge:
    def forge(board: Board) -> None:
        as_transfer(board)
        board.put(*place, value=value)

    return forge


def withheld(board: Board) -> None:
    own = Board(board.path, board.data)
    as_transfer(own)
    board.put("transfer", value=own.data["transfer"])
    board.put("checkpoints_published", value=False)


def arm_without_a_transfer(board: Board) -> None:
    """A row under the name of an arm, in an entry that has no transfer to hold its budget and its source to."""
    renamed(DDQN, "ddqn fine-tune")(board)
    board.put("trainings", value=board.at("trainings")[1:])
    for run in range(5):
        board.put("results", DDQN, "runs", run, "training", "arm", value="fine-tune")
        board.put("results", DDQN, "runs", run, "training", "command", value=None)


def failed_in_transfer(arm: int) -> Forge:
    """The last seed of an arm failed, though its curve says otherwise."""

    def forge(board: Board) -> None:
        as_transfer(board)
        runs = board.at("results", arm, "runs")
        board.put("results", arm, "runs", value=runs[:-1])
        board.put("results", arm, "failed_seeds", value=[len(runs) - 1])

    return forge


def inexact(board: Board) -> None:
    """Trainings by the compiled engine that say that they cannot be repeated."""
    for run in range(5):
        board.put("results", DDQN, "runs", run, "training", "exact", value=False)


def many_long_trainings(board: Board) -> None:
    run = board.at("results", DDQN, "runs", 0)
    longer = run | {"training": run["training"] | {"budget": 10**8}}
    board.put("results", DDQN, "runs", value=[longer | {"checkpoint_sha256": f"{seed:064x}"} for seed in range(11)])


def arms_after_a_long_source(board: Board) -> None:
    """Two arms of five seeds, whose sources take a hundred million steps each."""
    as_transfer(board)
    for run in range(5):
        board.put("results", DDQN, "runs", run, "training", "budget", value=10**8)


def shipped_under_another_name(board: Board) -> None:
    """The checkpoints that come with the package, saved again by a method of somebody's own."""
    board.put("trainings", value=board.at("trainings")[1:])
    renamed(DDQN, "champion")(board)
    for run in range(5):
        board.change_checkpoint(DDQN, run, method="champion", task=None, command=None)


def rows_of_nobody(board: Board) -> None:
    as_transfer(board)
    board.put("results", value=board.at("results")[:-1])


def of_another_method(board: Board) -> None:
    """The curves and checkpoints of ddqn under a name of one's own."""
    renamed(DDQN, "my-agent")(board)
    board.put("trainings", 0, "method", value="my-agent")


def from_source(board: Board, source: str) -> list[Any]:
    """Return the rows of a transfer as if they were from another source."""
    as_transfer(board)
    return [row | {"source": source} for row in board.at("transfer", "rows")]


def of_no_scenario(board: Board) -> None:
    board.put("transfer", "rows", value=from_source(board, "moon"))


def of_two_sources(board: Board) -> None:
    others = from_source(board, "solo-stop-v0")
    board.put("transfer", "rows", value=[*board.at("transfer", "rows"), *others])


def with_other_parents(board: Board) -> None:
    """Arms whose source is not in the entry, and which began with different checkpoints."""
    board.put("transfer", "rows", value=from_source(board, "solo-stop-v0"))
    board.put("results", value=[board.at("results", 0), *board.at("results")[2:]])
    board.put("results", 2, "runs", 0, "training", "source_sha256", value="0" * 64)


def without_a_metric(key: str) -> Forge:
    """The rule's row without a metric that its episodes have, and with the digest of the others."""

    def forge(board: Board) -> None:
        for place in (("runs", 0, "metrics"), ("metrics",)):
            known = board.at("results", RULE, *place)
            board.put("results", RULE, *place, value={name: one for name, one in known.items() if name != key})
        task = get_task("stop-line-v0")
        (played,) = replay([board.evidence(RULE)], task, task.test.take(small_board.EPISODES))
        kept = board.at("results", RULE, "runs", 0, "metrics")
        board.put("results", RULE, "runs", 0, "episodes_sha256", value=played.records.only(kept).digest())

    return forge


def with_more(**more: Any) -> Forge:
    """Evidence that holds more than what is known of it, or says something in its header."""

    def forge(board: Board) -> None:
        arrays = load(read(board.store.evidence(board.at("results", RULE, "runs", 0, "evidence_sha256"))))
        board.add_evidence(RULE, save({**arrays, **more.get("arrays", {})}, more.get("metadata")))

    return forge


SCHEMA, RECOMPUTED, REPLAYED, RERUN = Level.SCHEMA, Level.RECOMPUTED, Level.REPLAYED, Level.RERUN
PATHS = ("../escape", "/tmp/escape", "a/b", "README", "readme", "index", "schema", ".hidden", "x" * 62, "quick.json")
HIDDEN = ("\u200b", "\u202e", "\u2066", "\ufeff", "\u00ad", "\u2028", "\x1b", "\n", "\ud7fb\U000e0001")

FORGERIES: dict[str, tuple[Forge, Level, str]] = {
    # names
    "a rule that is a network": (rule_with_a_network, SCHEMA, "results[0].runs[0]"),
    "a network that is called a rule": (renamed(DDQN, "rule-4", "rule"), SCHEMA, "results[1].runs"),
    "a rule that is called learned": (renamed(RULE, "rule-2", "learned"), SCHEMA, "results[0].kind"),
    "a method's row of another method": (renamed(DDQN, "hybrid-hrl"), SCHEMA, "results[1].runs[0].training.method"),
    "a method's row of an arm": (renamed(DDQN, "ddqn fine-tune"), SCHEMA, "results[1].runs[0].training.arm"),
    "a method's row without checkpoints": (without_checkpoints, SCHEMA, "results[1].runs[0].checkpoint_sha256"),
    "own code that is called a rule": (renamed(RULE, "mine:make", "rule"), SCHEMA, "results[0].kind"),
    "own code under a rule's name": (renamed(RULE, "rule-1", "factory"), SCHEMA, "results[0].kind"),
    "a rule that is another rule": (renamed(RULE, "rule-1"), RERUN, "results[0].runs[0]"),
    "nobody's name": (renamed(RULE, "rule-9", "rule"), SCHEMA, "results[0].kind"),
    "a held option": (with_value("results", RULE, "option", value="follow"), SCHEMA, "results[0].option"),
    **{
        f"a name that looks like another: {name}": (renamed(RULE, name, kind), SCHEMA, "results[0].agent")
        for name, kind in (
            ("ru1e-1", "learned"),
            ("Rule-4", "learned"),
            ("rule_plus", "learned"),
            ("hybrid hrl", "learned"),
            ("DDQN", "learned"),
            ("rule\u20101", "learned"),
            ("ddq\u0578", "learned"),
            ("rule-1 ", "learned"),
            ("hybr1d-hrl", "learned"),
            ("rule4", "learned"),
            ("hybrid-hrl/", "learned"),
            ("ddqn.", "learned"),
        )
    },
    # seeds
    "one run five times": (same_run_again, SCHEMA, "results[1].runs"),
    "one checkpoint for five seeds": (same_file_of_other_seeds, SCHEMA, "results[1].runs[1].checkpoint_sha256"),
    "the same weights for five seeds": (
        same_weights_of_other_seeds,
        RECOMPUTED,
        "results[1].runs[1].checkpoint_sha256: it has the weights",
    ),
    "a seed left out": (without_the_worst_seed, SCHEMA, "results[1].runs"),
    "a longer training": (longer_trained, SCHEMA, "results[1].runs[0].training.budget"),
    "more steps than the budget": (
        with_value("results", DDQN, "runs", 0, "training", "env_steps", value=400_000),
        SCHEMA,
        "results[1].runs[0].training.env_steps",
    ),
    "a command of another seed": (
        with_value("results", DDQN, "runs", 0, "training", "command", value="hhrl-bench train ddqn --seeds 7"),
        SCHEMA,
        "results[1].runs[0].training.command",
    ),
    "another training than the checkpoint's": (
        with_value("results", DDQN, "runs", 0, "training", "exact", value=False),
        SCHEMA,
        "results[1].runs[1].training.exact",
    ),
    "steps that no curve has": (
        with_value("results", PLATOON, "runs", 0, "training", "env_steps", value=123),
        SCHEMA,
        "results[3].runs[0].training.env_steps",
    ),
    # curves
    "curves of nobody": (curves_of_nobody, SCHEMA, "trainings[2]: the entry has no result of ddqn-plus"),
    "a checkpoint that was not the best": (best_elsewhere, SCHEMA, "results[1].runs[0].training.env_steps"),
    "another validation than the checkpoint's": (validated(-1, 0.25), RECOMPUTED, "trainings[0].testing.success[0]"),
    "a rate that no episodes have": (validated(0, 0.123), SCHEMA, "trainings[0].success[0]: a rate"),
    "a shorter training": (shorter_training, SCHEMA, "trainings[0].env_steps"),
    "a seed that has failed without a fault": (failed_without_a_fault, SCHEMA, "trainings[0].success[4]: it ends"),
    "settings that are not the method's": (other_settings, SCHEMA, "results[1].runs[0].training.config_hash"),
    "curves of another method under a free name": (
        of_another_method,
        SCHEMA,
        "results[1].runs[0].training.method",
    ),
    "curves of another task": (
        with_value("results", DDQN, "runs", 0, "training", "task", value="stop-line-paper-v0"),
        SCHEMA,
        "results[1].runs[0].training.task",
    ),
    "curves twice": (curves_twice, SCHEMA, "ddqn has"),
    # transfers
    "a source that is no scenario": (
        of_no_scenario,
        SCHEMA,
        "transfer.rows[0].source: 'moon' is no registered scenario",
    ),
    "arms of two sources": (of_two_sources, SCHEMA, "transfer.rows[3].source"),
    "arms of a seed that began with different checkpoints": (with_other_parents, SCHEMA, "source_sha256"),
    "an arm with a command": (
        of_transfer("results", 3, "runs", 0, "training", "command", value="hhrl-bench train ddqn"),
        SCHEMA,
        "results[3].runs[0].training.command",
    ),
    "checkpoints withheld": (withheld, SCHEMA, "results[3].agent: it is no arm"),
    "curves of an arm that has no result": (rows_of_nobody, SCHEMA, "transfer.rows[2]: the entry has no result"),
    "an arm of nobody's": (of_transfer("results", 3, "agent", value="my-arm"), SCHEMA, "results[3].agent"),
    "an arm that was not trained": (
        of_transfer("results", 3, "runs", 0, "training", "budget", value=None),
        SCHEMA,
        "results[3].runs[0].training.budget: zero-shot",
    ),
    "an arm from another source": (
        of_transfer("results", 3, "runs", 0, "training", "source_sha256", value="0" * 64),
        SCHEMA,
        "results[3].runs[0].training.source_sha256",
    ),
    "an arm without a transfer": (
        arm_without_a_transfer,
        SCHEMA,
        "results[1].runs[0].training.arm: the entry has no transfer with fine-tune of ddqn",
    ),
    "a failed seed of zero-shot": (failed_in_transfer(2), SCHEMA, "transfer.rows[0].success[4]: its seed has failed"),
    "a failed seed of an arm that has learned": (
        failed_in_transfer(3),
        SCHEMA,
        "transfer.rows[1].success[4]: its seed has failed",
    ),
    "a control that began with something": (
        of_transfer("results", 4, "runs", 0, "training", "source_sha256", value="0" * 64),
        SCHEMA,
        "results[4].runs[0].training.source_sha256",
    ),
    "zero-shot with other settings": (
        of_transfer("results", 2, "runs", 0, "training", "config_hash", value="0" * 64),
        SCHEMA,
        "results[2].runs[0].training.config_hash",
    ),
    "an arm whose checkpoint was not the best": (
        of_transfer("results", 3, "runs", 0, "training", "env_steps", value=0),
        SCHEMA,
        "results[3].runs[0].training.env_steps: its learning curve is best at",
    ),
    # what is trained again
    "an exact training that says it is not": (inexact, SCHEMA, "results[1].runs[4].training.exact"),
    "a training without end": (
        with_value("results", DDQN, "runs", 0, "training", "budget", value=2**50),
        SCHEMA,
        "training.budget",
    ),
    "trainings without end": (many_long_trainings, SCHEMA, "env steps of all trainings: 1,101,100,000"),
    "trainings without end of sources": (arms_after_a_long_source, SCHEMA, "env steps of all trainings: 1,500,032,000"),
    "the package's checkpoints under another name": (
        shipped_under_another_name,
        RECOMPUTED,
        "results[1].runs[0].checkpoint_sha256: it has the weights of ddqn:0",
    ),
    # provenance and digits
    "a minus zero": (minus_zero, RECOMPUTED, "results[0].runs[0].metrics"),
    "a day that is none": (with_value("provenance", "created", value="today"), SCHEMA, "provenance.created"),
    "a machine that clears the screen": (
        with_value("provenance", "hardware", "processor", value="\x1b[2J"),
        SCHEMA,
        "provenance.hardware.processor",
    ),
    "a version of many lines": (
        with_value("provenance", "versions", value={"numpy": "1\n2"}),
        SCHEMA,
        "provenance.versions",
    ),
    "seconds of what is not there": (
        with_value("provenance", "wall_seconds", value={"stop-line-v0/rule-4": 0.0}),
        SCHEMA,
        "provenance.wall_seconds",
    ),
    "own code with more runs than it is": (several_runs_of("mine:make", RULE, DDQN), SCHEMA, "results[0].runs: 2 runs"),
    "own code with fewer runs than seeds": (several_runs_of("mine:make@0-2", RULE, DDQN), SCHEMA, "results[0].runs: 2"),
    "own code with a run twice": (several_runs_of("mine:make@0-1", RULE, RULE), SCHEMA, "results[0].runs[1]: it has"),
    "files with a run twice": (
        several_runs_of("models", RULE, RULE),
        SCHEMA,
        "results[0].runs[1]: it has",
    ),
    "seeds that are none": (several_runs_of("mine:make@3-1", RULE), SCHEMA, "results[0].runs: 1 runs"),
    "a rule with seeds": (renamed(RULE, "rule-2:0", "factory"), SCHEMA, "results[0].agent"),
    "a name that looks like seeds of another": (renamed(RULE, "DDQN:3", "factory"), SCHEMA, "results[0].agent"),
    "own files under the name of seeds": (renamed(RULE, "ddqn:3", "factory"), SCHEMA, "results[0].kind"),
    "other seeds than the name's": (
        renamed(DDQN, "ddqn:0-3"),
        SCHEMA,
        "results[1].runs: their seeds are 0, 1",
    ),
    "another method's seeds": (renamed(DDQN, "hybrid-hrl:0-4"), SCHEMA, "results[1].runs[0].training.method"),
    # evidence
    "a row without its score": (without_a_metric("score"), REPLAYED, "results[0].metrics.score"),
    "evidence of traffic where there is none": (
        with_more(
            arrays={
                "outcomes": np.empty((small_board.EPISODES, 0), np.int8),
                "feasible": np.full(small_board.EPISODES, 7, np.int8),
            }
        ),
        REPLAYED,
        "results[0].runs[0].evidence_sha256: it does not hold what",
    ),
    "evidence with another array": (
        with_more(arrays={"more": np.zeros(9, np.int8)}),
        RECOMPUTED,
        "results[0].runs[0].evidence_sha256",
    ),
    "evidence with words in its header": (
        with_more(metadata={"by": "me"}),
        RECOMPUTED,
        "results[0].runs[0].evidence_sha256",
    ),
    "a decision that was not made": (other_actions, REPLAYED, "results[0].runs[0].evidence_sha256"),
    "outcomes that did not come": (turned("outcome"), RECOMPUTED, "results[0]"),
    "episodes of other lengths": (turned("steps"), RECOMPUTED, "results[0]"),
    "the decisions of another agent": (of_another_agent, RECOMPUTED, "results[4]"),
    "no unsmooth steps": (measured("unsmooth"), RECOMPUTED, "results[0]"),
    "no evidence": (
        with_value("results", RULE, "runs", 0, "evidence_sha256", value=None),
        RECOMPUTED,
        "results[0].runs[0].evidence_sha256",
    ),
    "evidence that is not there": (
        with_value("results", RULE, "runs", 0, "evidence_sha256", value="0" * 64),
        RECOMPUTED,
        "results[0].runs[0].evidence_sha256",
    ),
    # opponents
    "an opponent that does not come with the package": (
        with_value("tasks", 2, "opponent", "agent", value="mine:make"),
        SCHEMA,
        "mine:make",
    ),
    "an opponent of other weights": (
        with_value("tasks", 2, "opponent", "checkpoint_sha256", value="0" * 64),
        SCHEMA,
        "tasks[2].opponent.checkpoint_sha256",
    ),
    "an opponent that decides otherwise": (kinder_opponent, REPLAYED, "results[4].runs[0].evidence_sha256"),
    "an opponent of own code's row": (kinder_opponent_of_own_code, REPLAYED, "results[4].runs[0].evidence_sha256"),
    # bombs
    "evidence with an appendix": (bomb, RECOMPUTED, "results[0].runs[0].evidence_sha256"),
    "evidence of zeros": (bomb_under_its_own_hash, RECOMPUTED, "results[0].runs[0].evidence_sha256"),
    "a checkpoint that is all header": (long_header, RECOMPUTED, "results[1].runs[0].checkpoint_sha256"),
    "evidence that is all header": (
        long_header_of_evidence,
        RECOMPUTED,
        "results[0].runs[0].evidence_sha256",
    ),
    "settings that fill a book": (
        with_value("methods", 0, "config", value={"a": [[]] * 100_000}),
        SCHEMA,
        "methods.0.config",
    ),
    "too many names": (
        with_value("provenance", "wall_seconds", value={f"{one}": 0.0 for one in range(1001)}),
        SCHEMA,
        "an object has 1,001 names",
    ),
    "many results that are none": (with_value("results", value=[[]] * 100_000), SCHEMA, "results.0: "),
    "a million results that are none": (with_value("results", value=[[]] * 1_000_000), SCHEMA, "lists and objects"),
    "too many results": (many_results(501), SCHEMA, "results"),
    "too many results on a task": (many_results(51), SCHEMA, "results on stop-line-v0: 51"),
    "too many runs": (many_runs, SCHEMA, "results.1.runs"),
    "too many curves": (many_arms, SCHEMA, "trainings"),
    "no results": (with_value("results", value=[]), SCHEMA, "results"),
    "too many episodes": (with_value("tasks", 0, "episodes", value=900_000), SCHEMA, "episodes"),
    "too many pairs of runs": (many_pairs_of_runs, SCHEMA, "pairs of runs"),
    "too many episodes to resample": (many_episodes_to_resample, SCHEMA, "that intervals resample"),
    # paths
    **{f"a suite called {path[:12]}": (with_value("suite", value=path), SCHEMA, "suite") for path in PATHS},
    "a file outside": (
        with_value("results", RULE, "runs", 0, "evidence_sha256", value="../../escape"),
        SCHEMA,
        "evidence_sha256",
    ),
    "a task of a module": (on_task("os:path"), SCHEMA, "unknown task 'os:path'"),
    "a task of a file": (on_task("/etc/hosts"), SCHEMA, "unknown task '/etc/hosts'"),
    "a training on a module": (
        with_value("results", FOLLOW, "runs", 0, "training", "task", value="os:path"),
        SCHEMA,
        "unknown task 'os:path'",
    ),
    "a task outside": (with_value("tasks", 0, "id", value="../../escape"), SCHEMA, "stop-line-v0"),
    # unicode
    **{
        f"a name with U+{ord(sign[-1]):04X}": (renamed(RULE, f"mine{sign}:make", "factory"), SCHEMA, "results.0.agent")
        for sign in HIDDEN
    },
    "a name in another normal form": (renamed(RULE, "e\u0301:make", "factory"), SCHEMA, "results.0.agent"),
}


@pytest.mark.parametrize("agent", ["mine:make@0-1", "models", "a.zip,b.zip", "ddqn:0-4"])
def test_honest_rows_of_several_runs_hold(board: Board, agent: str) -> None:
    if agent == "ddqn:0-4":
        renamed(DDQN, agent)(board)
    else:
        several_runs_of(agent, RULE, DDQN)(board)
    place = "results[1]" if agent == "ddqn:0-4" else "results[0]"
    assert [line for line in board.said(SCHEMA) if line.startswith(f"{place}.") and ".metrics" not in line] == []


def test_an_honest_entry_holds(board: Board) -> None:
    assert board.said(RERUN) == []
    assert len(FORGERIES) >= 40
    as_transfer(board)
    assert board.said(RERUN) == []


@pytest.mark.parametrize(("forge", "level", "place"), FORGERIES.values(), ids=FORGERIES)
def test_a_forgery_is_refused_and_named(board: Board, forge: Forge, level: Level, place: str) -> None:
    forge(board)
    said = board.said(level)
    assert any(place in line for line in said), said[:5]
    assert all("\n" not in line for line in said)


drawn = settings(
    deadline=None, max_examples=15, database=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
LOOKS = {"o": "0", "l": "1I|", "i": "1l", "-": "_. \u2010\u2212", "e": "\u0435", "r": "\u0433", "d": "D", "h": "H"}


@st.composite
def alike(draw: st.DrawFn) -> str:
    """A registered name with one sign replaced by one that looks like it, or with a sign that is not seen."""
    name = draw(st.sampled_from([name for name in (*RULES, *METHODS) if set(name) & set(LOOKS)]))
    places = [index for index, sign in enumerate(name) if sign in LOOKS]
    place = draw(st.sampled_from(places))
    seen = draw(st.booleans())
    sign = draw(st.sampled_from(LOOKS[name[place]])) if seen else name[place] + draw(st.sampled_from(HIDDEN[:5]))
    return name[:place] + sign + name[place + 1 :]


@drawn
@given(name=alike(), kind=st.sampled_from(["rule", "learned", "factory"]))
def test_names_that_look_like_others_are_refused(honest: Path, board: Board, name: str, kind: str) -> None:
    forged = Board(board.path, json.loads(honest.read_text()))
    renamed(RULE, name, kind)(forged)
    assert any("agent" in line for line in forged.said(SCHEMA))


@pytest.mark.parametrize(
    "name",
    [
        "hybrid-hrl@0-9", "ddqn: 0-4", "rule-3,4", "hybrid-hrl (paper)", "the paper, Hybrid HRL", "the oracle",
        "rule-4 + hold", "ddgn", "dd9n", "cldqn", "hy8rid-hrl", "rule-tunecl",
        "paper", "the-paper", "oracle-2", "oracle_plus", "hybrid-hrl-paper", "rule-Z", "hrl-Z",
    ],
)  # fmt: skip
def test_names_that_hold_a_registered_one_or_look_like_it_are_refused(board: Board, name: str) -> None:
    renamed(RULE, name, "factory")(board)
    assert any("looks like" in line for line in board.said(SCHEMA))


@pytest.mark.parametrize("name", ["my-ddqn", "runs/ddqn/stop-line-v0", "careful driver 2", "ddqn.zip"])
def test_other_names_of_ones_own_are_free(board: Board, name: str) -> None:
    renamed(RULE, name, "factory")(board)
    assert not any("looks like" in line for line in board.said(SCHEMA))


@drawn
@given(chosen=st.lists(st.integers(0, 4), min_size=1, max_size=6).filter(lambda chosen: chosen != sorted({*chosen})))
def test_runs_in_any_other_number_or_order_are_refused(honest: Path, board: Board, chosen: list[int]) -> None:
    forged = Board(board.path, json.loads(honest.read_text()))
    runs = forged.at("results", DDQN, "runs")
    forged.put("results", DDQN, "runs", value=[runs[index] for index in chosen])
    assert any(line.startswith("results[1].runs") for line in forged.said(SCHEMA))


@drawn
@given(suite=st.text(max_size=70).filter(lambda text: not text.isalnum() or not text.isascii() or not text.islower()))
def test_a_suite_under_any_other_name_than_a_plain_one_is_refused(honest: Path, board: Board, suite: str) -> None:
    forged = Board(board.path, json.loads(honest.read_text()))
    forged.put("suite", value=suite)
    plain = suite.replace("-", "a")
    is_plain = plain.isascii() and plain.isalnum() and plain == plain.lower() and not suite.startswith("-")
    assert bool(forged.said(SCHEMA)) == (not is_plain or len(suite) > 61)


@drawn
@given(step=st.integers(0, 10**6), action=st.integers(0, 5))
def test_any_other_decision_of_an_opponent_is_found(board: Board, step: int, action: int) -> None:
    actions = board.evidence(ADVERSARY).trace.actions.copy()
    step %= len(actions)
    actions[step, 1] = action if actions[step, 1] != action else (action + 1) % 6
    honest = board.at("results", ADVERSARY, "runs", 0, "evidence_sha256")
    kept = board.evidence(ADVERSARY)
    forged = kept._replace(trace=kept.trace._replace(actions=actions))
    task = get_task("adversary-v0")
    (played,) = replay([forged], task, task.test.take(small_board.EPISODES))
    assert not np.array_equal(played.trace.actions, actions)
    assert board.at("results", ADVERSARY, "runs", 0, "evidence_sha256") == honest


@drawn
@given(size=st.integers(2_000_000, 60_000_000))
def test_evidence_that_unpacks_to_more_than_its_episodes_is_not_unpacked(honest: Path, board: Board, size: int) -> None:
    forged = Board(board.path, json.loads(honest.read_text()))
    forged.add_evidence(RULE, small_board.repacked(forged.evidence(RULE)) + bytes(size))
    assert any("of at most" in line for line in forged.said(RECOMPUTED))


def built(board: Board, level: Level) -> IndexRecord:
    entry = VerifiedEntry(read_entry(board.path), verified_now(level, level))
    return write_index(board.path.parent, {board.path.name: entry})


@pytest.fixture
def index(board: Board) -> Path:
    """The index of a folder with the entry."""
    built(board, Level.REPLAYED)
    assert list(check_index(board.path.parent)) == []
    return board.path.parent / "INDEX.json"


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("sha256", "0" * 64), ("suite", "quick"), ("tasks", ["follow-v0"]), ("agents", ["rule-9"]), ("results", 77),
        ("file", "other.json"),
    ],
)  # fmt: skip
def test_every_field_of_an_index_follows_from_its_entries(index: Path, field: str, value: object) -> None:
    data = json.loads(index.read_text())
    data["entries"][0][field] = value
    index.write_text(json.dumps(data))
    assert any("INDEX.json" in str(finding) for finding in check_index(index.parent))


def test_a_level_in_an_index_is_that_of_the_build(board: Board, index: Path) -> None:
    index.write_text(index.read_text().replace("replayed", "retrained"))
    found = built(board, Level.SCHEMA)
    assert found.entries[0].verified.level == Level.SCHEMA
    assert found.entries[0].verified.command == "hhrl-bench leaderboard build --level schema"


@pytest.mark.parametrize(
    ("field", "value"),
    [("level", "retrained"), ("level", "schema"), ("command", "trust me"), ("command", "hhrl-bench leaderboard build")],
)
def test_a_level_is_that_of_the_command_that_verified_it(index: Path, field: str, value: str) -> None:
    data = json.loads(index.read_text())
    data["entries"][0]["verified"][field] = value
    index.write_text(json.dumps(data))
    assert any(f"small.json.verified.{field}" in str(finding) for finding in check_index(index.parent))


def test_an_index_names_every_file_once(index: Path) -> None:
    data = json.loads(index.read_text())
    data["entries"] = [data["entries"][0] | {"results": 77}, *data["entries"]]
    index.write_text(json.dumps(data))
    assert [str(finding) for finding in check_index(index.parent)] == [
        "INDEX.json: it does not name every file once, in order"
    ]


@pytest.mark.parametrize("name", ["small.md", "schema.json"])
def test_pages_are_those_of_the_entries(index: Path, name: str) -> None:
    page = index.parent / name
    page.write_text(page.read_text().replace("e", "3", 1))
    (finding,) = check_index(index.parent)
    assert finding.place == name
    page.unlink()
    assert [finding.place for finding in check_index(index.parent)] == [name]


def only(board: Board, results: list[int], tasks: list[int]) -> LeaderboardRecord:
    """Return an entry of some results and tasks."""
    record = LeaderboardRecord.model_validate_json(json.dumps(board.data))
    chosen = tuple(record.results[one] for one in results), tuple(record.tasks[one] for one in tasks)
    return record.model_copy(update={"results": chosen[0], "tasks": chosen[1], "trainings": ()})


def without_runs(record: LeaderboardRecord, first: int) -> LeaderboardRecord:
    (result,) = record.results
    return record.model_copy(update={"results": (result.model_copy(update={"runs": result.runs[:first]}),)})


def test_an_entry_of_a_folder_is_what_its_suite_makes(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    suite = ScoreSuite("small", ("ddqn",), ("stop-line-v0",), small_board.EPISODES)
    honest = only(board, [DDQN], [0])
    assert any("is no registered suite" in finding.said for finding in check_suite("small", honest))
    monkeypatch.setattr(suites, "SUITES", {"small": suite})
    assert list(check_suite("small", honest)) == list(check_suite("my-entry", honest)) == []
    fewer_seeds, longer = without_runs(honest, 4), replace(suite, episodes=9)
    as_transfer(board)
    withheld_rows = only(board, [1], [0])
    for name, record, own, said in (
        ("sma1l", honest, suite, "looks like small"),
        ("my-entry", fewer_seeds, suite, "neither what comes with the package nor trained by suite small"),
        ("my-entry", honest, longer, "other episodes"),
        ("my-entry", only(board, [0], [0, 0]), suite, "other tasks"),
        ("my-entry", withheld_rows, suite, "it has a transfer"),
    ):
        monkeypatch.setattr(suites, "SUITES", {"small": own})
        assert any(said in finding.said for finding in check_suite(name, record)), said


def test_the_entry_of_a_suite_has_all_of_its_rows(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    suite = ScoreSuite("small", ("rule-2", "ddqn"), ("stop-line-v0",), small_board.EPISODES)
    monkeypatch.setattr(suites, "SUITES", {"small": suite})
    assert list(check_suite("small", only(board, [RULE, DDQN], [0]))) == []
    assert list(check_suite("theirs", only(board, [DDQN], [0]))) == []
    (finding,) = check_suite("small", only(board, [DDQN], [0]))
    assert "other rows than suite small" in finding.said


def test_seeds_of_a_training_suite_are_all_of_its_seeds(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    trained = TrainingSuite("small", (("ddqn", "stop-line-v0"),), tuple(range(4)), small_board.EPISODES)
    monkeypatch.setattr(suites, "SUITES", {"small": trained})
    withheld = only(board, [DDQN], [0])
    honest = withheld.model_copy(update={"trainings": read_entry(board.path).trainings[:1]})
    assert list(check_suite("small", without_runs(honest, 4))) == []
    assert list(check_suite("small", honest)) == []  # what comes with the package
    assert list(check_suite("small", without_runs(honest, 3))) != []
    assert list(check_suite("small", without_runs(withheld, 4))) != []
    board.put("results", DDQN, "runs", 0, "training", "task", value="stop-line-paper-v0")
    elsewhere = only(board, [DDQN], [0]).model_copy(update={"trainings": honest.trainings})
    assert list(check_suite("small", without_runs(elsewhere, 4))) != []


def test_what_comes_with_the_package_has_no_failed_seeds(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    suite = ScoreSuite("small", ("ddqn",), ("stop-line-v0",), small_board.EPISODES)
    monkeypatch.setattr(suites, "SUITES", {"small": suite})
    board.put("results", DDQN, "failed_seeds", value=[5, 6])
    (finding,) = check_suite("small", only(board, [DDQN], [0]))
    assert "neither what comes with the package" in finding.said


def test_a_page_of_a_suite_needs_an_entry_of_it(index: Path) -> None:
    (index.parent / "full.md").write_text("| agent | success |\n")
    (finding,) = check_index(index.parent)
    assert (finding.place, finding.said) == ("full.md", "no entry is of suite full")


def transfer_to_solo_stop(board: Board) -> LeaderboardRecord:
    """Return an entry of ddqn's transfer from stop-line-v0 to solo-stop-v0."""
    as_transfer(board)
    for row in range(3):
        board.put("transfer", "rows", row, "target", value="solo-stop-v0")
    for arm in (1, 2, 3):
        board.put("results", DDQN + arm, "task", value="solo-stop-v0")
        for run in range(5):
            board.put("results", DDQN + arm, "runs", run, "training", "task", value="solo-stop-v0")
    target = task_record(get_task("solo-stop-v0"), small_board.EPISODES)
    board.put("tasks", value=[board.at("tasks", 0), target.model_dump(mode="json")])
    record = LeaderboardRecord.model_validate_json(json.dumps(board.data))
    return record.model_copy(update={"results": record.results[DDQN:]})


def test_sources_of_a_suite_s_transfer_are_the_suite_s(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    record = transfer_to_solo_stop(board)

    def said(entry: LeaderboardRecord, seeds: int = 5) -> list[str]:
        budgets = tuple(range(seeds)), small_board.BUDGET, small_board.EPISODES
        own = TransferSuite("small", ("ddqn",), "stop-line-v0", ("solo-stop-v0",), *budgets)
        monkeypatch.setattr(suites, "SUITES", {"small": own})
        return [finding.said for finding in check_suite("mine", entry)]

    assert said(record) == []
    (line,) = said(record.model_copy(update={"results": record.results[1:]}))
    assert line == "the entry lacks ddqn on stop-line-v0, the source of its zero-shot"
    (line,) = said(record, seeds=10)
    assert line.startswith("ddqn on stop-line-v0 is neither")
    assert record.transfer is not None
    rows = tuple(row.model_copy(update={"source": "follow-v0"}) for row in record.transfer.rows)
    (line,) = said(record.model_copy(update={"transfer": record.transfer.model_copy(update={"rows": rows})}))
    assert line.startswith("the entry has other sources of ddqn zero-shot on solo-stop-v0")


def test_seeds_of_ones_own_agent_are_all_that_were_trained(board: Board, monkeypatch: pytest.MonkeyPatch) -> None:
    suite = ScoreSuite("small", ("rule-2",), ("stop-line-v0",), small_board.EPISODES)
    monkeypatch.setattr(suites, "SUITES", {"small": suite})
    renamed(DDQN, "champion")(board)
    own = only(board, [DDQN], [0])
    assert list(check_suite("mine", own)) == []
    assert list(check_suite("mine", without_runs(own, 4))) == []
    chosen = own.results[0].model_copy(update={"runs": own.results[0].runs[2:4]})
    (finding,) = check_suite("mine", own.model_copy(update={"results": (chosen,)}))
    assert finding.said == "the seeds of champion are 2, 3; publish 0 to n - 1, with those that failed"


def copies(board: Board, agent: str, forge: Forge, of: int = RULE) -> list[str]:
    """Return what is said of a row under a name of somebody's own, forged of another one, beside the honest entry."""
    honest = LeaderboardRecord.model_validate_json(json.dumps(board.data))
    forge(board)
    renamed(of, agent, "factory")(board)
    stored = {"small.json": Stored(honest, board.store), "mine.json": Stored(only(board, [of], [0]), board.store)}
    assert not list(copied({"small.json": stored["small.json"]}))
    assert list(copied(stored)) == list(copied(stored, of="mine.json"))
    assert not list(copied(stored, of="small.json"))
    return [str(finding) for finding in copied(stored)]


def some_episodes_changed(episodes: int) -> Forge:
    """The rule's episodes, in some of which the last decision is another one."""

    def forge(board: Board) -> None:
        trace = board.evidence(RULE).trace
        actions, last = trace.actions.copy(), np.cumsum(trace.steps)[:episodes] - 1
        actions[last] = 1 - actions[last]
        board.change_evidence(RULE, actions=actions)

    return forge


def other_options(board: Board) -> None:
    board.change_evidence(RULE, options=np.zeros_like(board.evidence(RULE).trace.options))


def test_episodes_of_another_agent_are_found_under_a_name_of_ones_own(board: Board) -> None:
    place = "mine.json results[0].runs[0].evidence_sha256: 100% of its episodes are those of rule-2 in small.json"
    assert copies(board, "mine:make", other_options) == [place]


@pytest.mark.parametrize(("changed", "share"), [(1, "83%"), (2, "67%"), (3, None), (6, None)])
def test_a_run_may_share_half_of_its_episodes_with_another_agent(board: Board, changed: int, share: str | None) -> None:
    said = copies(board, "mine:make", some_episodes_changed(changed))
    assert [line.split(": ")[1].split()[0] for line in said] == ([share] if share else [])
