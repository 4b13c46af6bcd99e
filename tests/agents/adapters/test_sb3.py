"""Models of Stable-Baselines3 as agents, and their zips, of which nothing is run that is in them."""

import base64
import json
import os
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch

from hhrl_agents import from_sb3
from hhrl_envs import InputError

sb3 = pytest.importorskip("stable_baselines3")

STATES = np.random.default_rng(0).uniform(-1.0, 2.0, size=(200, 11)).astype(np.float32)
MODELS: dict[str, tuple[str, dict[str, Any]]] = {
    "DQN": ("DQN", {}),
    "PPO": ("PPO", {}),
    "A2C": ("A2C", {"net_arch": [16]}),
    "PPO of others layers": ("PPO", {"net_arch": {"pi": [8, 8, 8], "vf": [4]}, "activation_fn": torch.nn.ELU}),
    "DQN of one layer": ("DQN", {"net_arch": []}),
}


@pytest.fixture(scope="module")
def env() -> Any:
    return gymnasium.make("hhrl_envs/StopLine-v0")


def model(env: Any, kind: str, policy: str = "MlpPolicy", **settings: Any) -> Any:
    return getattr(sb3, kind)(policy, env, policy_kwargs=settings, seed=3, device="cpu")


def rewritten(path: Path, change: Callable[[dict[str, Any]], None], **members: bytes) -> Path:
    """Write the zip again with other settings, or with other members."""
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    data = json.loads(content["data"])
    change(data)
    content |= {
        "data": json.dumps(data).encode(),
        **{name.replace("_pth", ".pth"): one for name, one in members.items()},
    }
    with zipfile.ZipFile(path, "w") as archive:
        for name, one in content.items():
            archive.writestr(name, one)
    return path


@pytest.mark.parametrize("name", MODELS)
def test_a_standard_policy_decides_as_its_model_predicts(name: str, env: Any, tmp_path: Path) -> None:
    kind, settings = MODELS[name]
    own = model(env, kind, **settings)
    own.save(tmp_path / "model.zip")
    predicted, _ = own.predict(STATES, deterministic=True)
    for agent in (from_sb3(own), from_sb3(tmp_path / "model.zip", 6), from_sb3(tmp_path / "model.zip", trust=True)):
        agent.reset(np.ones(200, np.bool_))
        decision = agent.act(STATES)
        assert decision.action.tolist() == predicted.tolist()
        assert decision.option.tolist() == [-1] * 200


class Evil:
    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (os.environ["EVIL"],)


def test_no_pickle_of_a_zip_is_loaded(env: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sign = tmp_path / "has-run"
    monkeypatch.setenv("EVIL", str(sign))
    code = pickle.dumps(Evil())
    path = tmp_path / "model.zip"
    model(env, "PPO").save(path)

    def infect(data: dict[str, Any]) -> None:
        for value in data.values():
            if isinstance(value, dict) and ":serialized:" in value:
                value[":serialized:"] = base64.b64encode(code).decode()

    agent = from_sb3(rewritten(path, infect))
    assert agent.act(STATES).action.shape == (200,)
    for member in (code, zipped(code)):
        with pytest.raises(InputError, match="holds weights that torch does not read as data; save the model again"):
            from_sb3(rewritten(path, of(), policy_pth=member))
    assert not sign.exists()
    with pytest.raises(InputError):
        from_sb3(path, trust=True)
    assert sign.exists()


def zipped(code: bytes) -> bytes:
    """Return a file of torch's format whose pickle is this code."""
    path = Path(os.environ["EVIL"]).with_name("weights.pth")
    torch.save({"a": torch.zeros(1)}, path)
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, one in content.items():
            archive.writestr(name, code if name.endswith("data.pkl") else one)
    return path.read_bytes()


def of(**settings: Any) -> Callable[[dict[str, Any]], None]:
    return lambda data: data.update(settings)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            of(policy_class={"__module__": "my_policies"}),
            "as its policy is of my_policies; if you trust",
        ),
        (of(policy_class="x"), "as its policy is of an unknown module"),
        (of(policy_class={"__module__": "stable_baselines3.dqn.policies"}), "as its policy is no plain MLP"),
        (
            of(policy_kwargs={"features_extractor_class": "mine"}),
            "as its policy has the setting features_ex",
        ),
        (of(policy_kwargs={"activation_fn": "<class 'mine.Act'>"}), "as its activation is <class 'mine.Act'>"),
        (of(policy_kwargs={"activation_fn": "Linear"}), "as its activation is Linear"),
    ],
)
def test_a_zip_that_would_have_to_be_trusted_says_why(
    change: Callable[[dict[str, Any]], None], said: str, env: Any, tmp_path: Path
) -> None:
    path = tmp_path / "model.zip"
    model(env, "PPO").save(path)
    with pytest.raises(InputError, match="would have to be loaded by running code that is in it") as caught:
        from_sb3(rewritten(path, change))
    assert said in str(caught.value)


def test_other_networks_and_continuous_actions_are_refused(env: Any, tmp_path: Path) -> None:
    path = tmp_path / "model.zip"
    box = gymnasium.make("hhrl_envs/StopLine-v0", continuous_actions=True)
    continuous = sb3.PPO("MlpPolicy", box, device="cpu")
    continuous.save(path)
    with pytest.raises(InputError, match="holds a policy of continuous actions; train one on the discrete levels"):
        from_sb3(path)
    with pytest.raises(InputError, match="is no model of Stable-Baselines3 with discrete actions"):
        from_sb3(continuous)
    model(env, "DQN").save(path)
    with pytest.raises(InputError, match=r"let it return values of shape \(200, 5\)"):
        from_sb3(path, 5).act(STATES)
    moved = {name.replace(".2.", ".3."): one for name, one in sb3.DQN.load(path).policy.state_dict().items()}
    torch.save(moved, tmp_path / "weights.pth")
    with pytest.raises(InputError, match=r"its policy is no plain MLP \(layers between the layers\)"):
        from_sb3(rewritten(path, of(), policy_pth=(tmp_path / "weights.pth").read_bytes()))


@pytest.mark.parametrize("content", [None, b"", b"PK no zip", {"data": b"{}"}, {"policy.pth": b""}, {"data": b"\xff"}])
def test_a_file_that_is_no_zip_of_theirs_is_refused_in_one_line(content: Any, tmp_path: Path) -> None:
    path = tmp_path / "model.zip"
    if isinstance(content, dict):
        with zipfile.ZipFile(path, "w") as archive:
            for name, one in content.items():
                archive.writestr(name, one)
    elif content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        from_sb3(path)
    assert str(path) in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_what_a_recurrent_model_remembers_is_handed_back_and_forgotten_at_the_start_of_an_episode() -> None:
    class Counting:
        action_space = gymnasium.spaces.Discrete(6)

        def predict(
            self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = False
        ) -> Any:
            assert deterministic
            known = np.zeros(len(observation), np.int64) if state is None else state
            known = np.where(episode_start, 0, known + 1)
            return known, known

    agent = from_sb3(Counting())
    agent.reset(np.ones(2, np.bool_))
    assert agent.act(STATES[:2]).action.tolist() == [0, 0]
    agent.reset(np.array([False, True]))
    assert agent.act(STATES[:2]).action.tolist() == [1, 0]
    agent.reset(np.ones(3, np.bool_))
    assert agent.act(STATES[:3]).action.tolist() == [0, 0, 0]
