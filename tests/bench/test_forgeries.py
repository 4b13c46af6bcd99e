"""Forged entries: a number that is not so, a name that is another's, a file that costs too much; each is refused.

A forgery changes an honest entry, its files or the index of its folder, and says at which level it has to be refused
and where. Each family has fixed cases and, drawn by hypothesis, others of its kind.
"""

import gzip
import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hhrl_agents import METHODS, RULES
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.learned_agent import make_agent
from hhrl_bench.evaluation.decisions import Trace
from hhrl_bench.evaluation.evidence import Evidence, unpack
from hhrl_bench.evaluation.replay import replay
from hhrl_bench.evaluation.store import Store, read
from hhrl_bench.leaderboard.entry import read_entry
from hhrl_bench.leaderboard.level import Level
from hhrl_bench.publishing.publication import check_index, write_index
from hhrl_bench.schema import sha256_of
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


def many_runs(board: Board) -> None:
    board.put("results", DDQN, "runs", value=board.at("results", DDQN, "runs") * 30)


def many_arms(board: Board) -> None:
    curve = board.at("trainings", 0)
    board.put("trainings", value=[curve | {"method": f"method-{index}"} for index in range(501)])


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
    # evidence
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
    "too many results": (many_results(501), SCHEMA, "results"),
    "too many results on a task": (many_results(51), SCHEMA, "stop-line-v0 has 51 results"),
    "too many runs": (many_runs, SCHEMA, "results.1.runs"),
    "too many curves": (many_arms, SCHEMA, "trainings"),
    "too many episodes": (with_value("tasks", 0, "episodes", value=900_000), SCHEMA, "episodes"),
    # paths
    **{f"a suite called {path[:12]}": (with_value("suite", value=path), SCHEMA, "suite") for path in PATHS},
    "a file outside": (
        with_value("results", RULE, "runs", 0, "evidence_sha256", value="../../escape"),
        SCHEMA,
        "evidence_sha256",
    ),
    "a task outside": (with_value("tasks", 0, "id", value="../../escape"), SCHEMA, "stop-line-v0"),
    # unicode
    **{
        f"a name with U+{ord(sign[-1]):04X}": (renamed(RULE, f"mine{sign}:make", "factory"), SCHEMA, "results.0.agent")
        for sign in HIDDEN
    },
    "a name in another normal form": (renamed(RULE, "e\u0301:make", "factory"), SCHEMA, "results.0.agent"),
}


def test_an_honest_entry_holds(board: Board) -> None:
    assert board.said(RERUN) == []
    assert len(FORGERIES) >= 40


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


@pytest.fixture
def index(board: Board) -> Path:
    """The index of a folder with the entry."""
    write_index(board.path.parent, {board.path.name: Level.REPLAYED}, "hhrl-bench leaderboard build")
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
    found = write_index(board.path.parent, {board.path.name: Level.SCHEMA}, "hhrl-bench leaderboard build")
    assert found.entries[0].verified.level == Level.SCHEMA
    assert found.entries[0].verified.command == "hhrl-bench leaderboard build"
