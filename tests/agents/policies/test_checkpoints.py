import contextlib
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from safetensors.numpy import save_file

from hhrl_agents import METHODS
from hhrl_agents.atomic_files import OutputError
from hhrl_agents.networks.architectures import architectures
from hhrl_agents.networks.parameters import ParameterSet
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.checkpoint_file import SHIPPED, CheckpointError, read_metadata
from hhrl_agents.policies.checkpoints import frozen_parameters
from hhrl_agents.policies.learned_agent import LearnedAgent, agent_metadata, make_agent
from hhrl_agents.seeding import Purpose, generator
from hhrl_envs import get_scenario
from hhrl_envs.observation import SIZE

MAIN = get_scenario("stop-line-v0")


def agent_of(name: str, seed: int = 4) -> LearnedAgent:
    method = METHODS[name]
    drawn = ParameterSet(architectures(method, MAIN.num_actions), generator(seed, Purpose.INITIALISATION))
    parameters = {**drawn.snapshot(), **frozen_parameters(method)}
    return make_agent(method, MAIN, parameters, agent_metadata(method, MAIN, seed, 1_000, exact=True))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "seed-4.safetensors"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    made = tmp_path_factory.mktemp("whole") / "agent.safetensors"
    checkpoints.save(made, agent_of("hybrid-hrl"))
    return made.read_bytes()


def rewrite(path: Path, parameters: dict[str, NDArray[np.floating]], **metadata: Any) -> None:
    """Write the checkpoint of a hybrid-hrl agent with other parameters or metadata; None takes an entry out."""
    agent = agent_of("hybrid-hrl")
    entries = {**agent.metadata, "format_version": 1, **metadata}
    kept = {key: value for key, value in entries.items() if value is not None}
    save_file({**agent.parameters, **parameters}, path, {"hhrl-checkpoint": json.dumps(kept)})


@pytest.mark.parametrize("name", METHODS)
def test_an_agent_comes_back_as_it_was(name: str, path: Path) -> None:
    agent = agent_of(name)
    checkpoints.save(path, agent, {"command": "train it", "validation": {"success": 0.9}})
    loaded = checkpoints.load(path)
    assert type(loaded) is type(agent)
    assert loaded.method == agent.method
    assert {key: loaded.metadata[key] for key in agent.metadata} == agent.metadata
    assert loaded.metadata["validation"] == {"success": 0.9}
    assert loaded.parameters.keys() == agent.parameters.keys()
    assert all(np.array_equal(loaded.parameters[key], value) for key, value in agent.parameters.items())
    observations = np.random.default_rng(0).normal(size=(50, SIZE)).astype(np.float32)
    for ours, theirs in zip(agent.act(observations), loaded.act(observations), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_the_same_agent_gives_the_same_file_and_a_loaded_one_too(path: Path, whole: bytes) -> None:
    checkpoints.save(path, agent_of("hybrid-hrl"))
    assert path.read_bytes() == whole
    checkpoints.save(path, checkpoints.load(path))
    assert path.read_bytes() == whole


def test_no_metadata_replace_the_agent_s_own(path: Path) -> None:
    checkpoints.save(path, agent_of("ddqn"), {"seed": 99, "format_version": 7, "note": "mine"})
    loaded = checkpoints.load(path)
    assert loaded.metadata["seed"] == 4
    assert loaded.metadata["note"] == "mine"


def refused(path: Path) -> str:
    with pytest.raises(CheckpointError) as error:
        checkpoints.load(path)
    assert "\n" not in str(error.value)
    assert str(path) in str(error.value)
    return str(error.value)


def test_a_missing_file_and_a_folder_are_refused(path: Path) -> None:
    assert "no such file" in refused(path)
    assert "no such file" in refused(path.parent)


@pytest.mark.parametrize("share", [0.0, 0.0001, 0.01, 0.05, 0.5, 0.99999])
def test_a_truncated_file_is_refused(path: Path, whole: bytes, share: float) -> None:
    path.write_bytes(whole[: int(share * len(whole))])
    refused(path)


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
@given(content=st.binary(max_size=200))
def test_any_other_file_is_refused(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    refused(path)


@pytest.mark.parametrize("seed", range(50))
def test_a_damaged_header_never_gives_another_error(path: Path, whole: bytes, seed: int) -> None:
    rng, header = np.random.default_rng(seed), 8 + int.from_bytes(whole[:8], "little")
    damaged = bytearray(whole)
    damaged[rng.integers(header)] ^= int(rng.integers(1, 256))
    path.write_bytes(bytes(damaged))
    with contextlib.suppress(CheckpointError):
        checkpoints.load(path)


@pytest.mark.parametrize("header", ["", "[1, 2]", "3", '"text"', "{}"])
def test_metadata_that_are_no_object_are_refused(path: Path, header: str) -> None:
    save_file({"weight": np.zeros(3, np.float32)}, path, {"hhrl-checkpoint": header})
    refused(path)


def test_a_foreign_safetensors_file_is_refused(path: Path) -> None:
    save_file({"weight": np.zeros(3, np.float32)}, path)
    assert "none that this package has written" in refused(path)


@pytest.mark.parametrize(
    ("metadata", "complaint"),
    [
        ({"format_version": 2}, "format version 2; this version reads 1"),
        ({"seed": None}, "lack seed"),
        ({"exact": None, "spec_hash": None}, "lack spec_hash, exact"),
        ({"interface_hash": "0" * 64}, "another interface"),
        ({"config_hash": "0" * 64}, "config hash"),
        ({"scenario": "unknown-v0"}, "unknown scenario"),
        ({"scenario": ["stop-line-v0"]}, "list"),
        ({"seed": "four"}, "seed is 'four'"),
        ({"config": {}}, "config"),
        ({"config": {**METHODS["hybrid-hrl"].data(), "colour": "red"}}, "colour"),
    ],
)
def test_other_metadata_are_refused(path: Path, metadata: dict[str, Any], complaint: str) -> None:
    rewrite(path, {}, **metadata)
    assert complaint in refused(path)


@pytest.mark.parametrize(
    "parameters",
    [
        {"more": np.zeros(1, np.float32)},
        {"action.values.0.weight": np.zeros((1, 2, 2), np.float32)},
        {"action.values.0.weight": np.zeros((2, 13, 64), np.float32)},
    ],
)
def test_other_shapes_are_refused(path: Path, parameters: dict[str, NDArray[np.floating]]) -> None:
    rewrite(path, parameters)
    assert "names or shapes" in refused(path)


@pytest.mark.parametrize(
    "values",
    [
        np.full((1, 64, 64), np.nan, np.float32),
        np.full((1, 64, 64), np.inf, np.float32),
        np.zeros((1, 64, 64), np.float64),
    ],
)
def test_other_numbers_are_refused(path: Path, values: NDArray[np.floating]) -> None:
    rewrite(path, {"action.values.1.weight": values})
    assert "finite float32" in refused(path)


def test_a_failed_save_leaves_what_was(path: Path) -> None:
    checkpoints.save(path, agent_of("ddqn"))
    before = path.read_bytes()
    with pytest.raises(ValueError, match="JSON"):
        checkpoints.save(path, agent_of("ddqn"), {"score": float("nan")})
    with pytest.raises(OutputError, match="cannot write"):
        checkpoints.save(path / "below" / path.name, agent_of("ddqn"))
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_metadata_are_read_from_a_path_or_the_content(path: Path, whole: bytes) -> None:
    path.write_bytes(whole)
    assert read_metadata(path) == read_metadata(whole) == checkpoints.load(path).metadata


@pytest.mark.parametrize("content", [b"", b"{}", bytes(200)])
def test_metadata_of_what_is_no_checkpoint_are_refused(path: Path, whole: bytes, content: bytes) -> None:
    for wrong in (content, whole[:-1], whole[:50]):
        with pytest.raises(CheckpointError, match="not a whole safetensors file"):
            read_metadata(wrong)
    with pytest.raises(CheckpointError, match="not a whole safetensors file"):
        read_metadata(path)


@pytest.mark.parametrize("header", ["", "3", '"text"', "[" * 60_000])
def test_metadata_that_cannot_be_read_are_refused(path: Path, header: str) -> None:
    save_file({"weight": np.zeros(3, np.float32)}, path, {"hhrl-checkpoint": header})
    with pytest.raises(CheckpointError, match="its metadata are no JSON object"):
        read_metadata(path)


ACT_ALL = """
import sys
sys.modules["torch"] = None
import numpy as np
from hhrl_agents.policies import checkpoints
from hhrl_agents.policies.checkpoint_file import SHIPPED
for path in sorted(SHIPPED.rglob("*.safetensors")):
    agent = checkpoints.load(path)
    decision = agent.act(np.random.default_rng(0).normal(size=(3, 11)).astype(np.float32))
    print(path.stem, agent.method.id, *decision.action)
"""


def test_every_shipped_policy_acts_without_torch() -> None:
    done = subprocess.run([sys.executable, "-c", ACT_ALL], capture_output=True, text=True, check=True)
    assert len(done.stdout.splitlines()) == len(list(SHIPPED.rglob("*.safetensors"))) > 10


def test_metadata_are_read_without_torch() -> None:
    code = (
        "import sys; sys.modules['torch'] = None; from hhrl_agents.policies.checkpoint_file import SHIPPED,"
        " read_metadata; print(read_metadata(SHIPPED / 'ddqn' / 'seed-0.safetensors')['method'])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["ddqn"]


@pytest.mark.parametrize(
    "path", sorted(SHIPPED.rglob("*.safetensors")), ids=lambda path: f"{path.parent.name}-{path.stem}"
)
def test_a_shipped_checkpoint_is_what_saving_it_again_writes(path: Path, tmp_path: Path) -> None:
    again = tmp_path / path.name
    checkpoints.save(again, checkpoints.load(path))
    assert again.read_bytes() == path.read_bytes()
