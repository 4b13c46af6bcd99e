"""Minari datasets, loaded by Minari itself; their actions come to the same episodes in the environments."""

import hashlib
from pathlib import Path
from typing import Any

import minari
import numpy as np
import pytest

from hhrl_agents.atomic_files import OutputError
from hhrl_bench import Evaluation, evaluate
from hhrl_bench.errors import RecordError
from hhrl_bench.exports import minari_dataset
from hhrl_bench.exports.minari_dataset import write_dataset
from hhrl_envs import Outcome, platoon_v0
from hhrl_envs.views.parallel_env import StopLineParallelEnv


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "data"))
    return tmp_path / "data"


def loaded(evaluation: Evaluation, folder: Path) -> Any:
    (name,) = evaluation.export(folder)
    assert name in minari.list_local_datasets()
    return minari.load_dataset(name)


def files(folder: Path) -> dict[str, str]:
    found = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in found}


def test_actions_come_to_the_same_episodes_in_the_recovered_environment(folder: Path) -> None:
    evaluation = evaluate("rule-2", "stop-line-noisy-v0", episodes=5)
    dataset = loaded(evaluation, folder)
    assert dataset.id == "hhrl/stop-line-noisy-v0/rule-2-v0"
    assert (dataset.total_episodes, dataset.total_steps) == (5, evaluation.steps.sum())
    env = dataset.recover_environment()
    assert (dataset.observation_space, dataset.action_space) == (env.observation_space, env.action_space)
    known = list(dataset.storage.get_episode_metadata(range(5)))
    for index, episode in enumerate(dataset.iterate_episodes()):
        observation, _ = env.reset(seed=int(known[index]["seed"]))
        assert np.array_equal(observation, episode.observations[0])
        for step, action in enumerate(episode.actions):
            observation, reward, terminated, truncated, info = env.step(action)
            assert np.array_equal(observation, episode.observations[step + 1])
            assert (reward, terminated, truncated) == (
                episode.rewards[step],
                episode.terminations[step],
                episode.truncations[step],
            )
            assert np.array_equal(info["reward_option"], episode.infos["reward_option"][step + 1])
        assert terminated or truncated
        assert info["outcome"] == episode.infos["outcome"][-1] == evaluation.outcome[index]
        assert known[index]["outcome"] == Outcome(int(evaluation.outcome[index])).name.lower()
        assert (episode.infos["option"][1:] == 0).all()
        assert episode.infos["option"][0] == -1


def test_every_training_seed_is_there(folder: Path) -> None:
    dataset = loaded(evaluate("ddqn", episodes=2), folder)
    known = list(dataset.storage.get_episode_metadata(range(dataset.total_episodes)))
    assert [(int(one["training_seed"]), int(one["episode"])) for one in known] == [
        (k, i) for k in range(5) for i in (0, 1)
    ]
    assert len(dataset.sample_episodes(3)) == 3


def test_actions_of_several_agents_come_to_the_same_episodes(folder: Path) -> None:
    evaluation = evaluate("rule-1", "platoon-v0", episodes=3)
    dataset = loaded(evaluation, folder)
    env = platoon_v0.parallel_env()
    assert [*dataset.action_space.spaces] == env.possible_agents
    known = list(dataset.storage.get_episode_metadata(range(3)))
    for index, episode in enumerate(dataset.iterate_episodes()):
        outcomes = played_again(env, int(known[index]["seed"]), episode)
        assert outcomes == [Outcome(int(code)) for code in evaluation.outcomes[index]]
        assert int(episode.terminations.sum()) + int(episode.truncations.sum()) == 1
        for agent, space in dataset.observation_space.spaces.items():
            assert all(space.contains(one) for one in episode.observations[agent])


def played_again(env: StopLineParallelEnv, seed: int, episode: Any) -> list[Outcome]:
    """Return how the agents end, having compared everything with the environment."""
    observations, _ = env.reset(seed=seed)
    outcomes: dict[str, Outcome] = {}
    for step in range(len(episode)):
        active = [name for name, one in episode.infos.items() if one["active"][step + 1]]
        assert active == env.agents
        taken = {name: int(episode.actions[name][step]) for name in active}
        observations, rewards, terminations, truncations, infos = env.step(taken)
        assert episode.rewards[step] == pytest.approx(sum(rewards.values()))
        for name in active:
            own = episode.infos[name]
            assert np.array_equal(observations[name], episode.observations[name][step + 1])
            assert (rewards[name], terminations[name], truncations[name]) == (
                own["reward"][step + 1],
                own["terminated"][step + 1],
                own["truncated"][step + 1],
            )
            if terminations[name] or truncations[name]:
                outcomes[name] = infos[name]["outcome"]
    assert not env.agents
    return [outcomes[name] for name in env.possible_agents]


def test_an_opponent_s_steps_are_there_and_its_rewards_apart(folder: Path) -> None:
    dataset = loaded(evaluate("rule-4", "adversary-v0", episodes=2), folder)
    for episode in dataset:
        assert set(episode.actions) == {"ego", "front_1"}
        assert np.array_equal(episode.rewards, episode.infos["ego"]["reward"][1:])
        assert not np.array_equal(episode.rewards, episode.infos["front_1"]["reward"][1:])


@pytest.mark.parametrize(("agent", "task"), [("rule-2", "stop-line-v0"), ("rule-1", "platoon-v0")])
def test_a_dataset_made_twice_is_equal_byte_for_byte(tmp_path: Path, agent: str, task: str) -> None:
    for name in ("one", "two"):
        evaluate(agent, task, episodes=2).export(tmp_path / name)
    assert files(tmp_path / "one") == files(tmp_path / "two") != {}


def test_what_fails_leaves_no_dataset_and_what_is_there_stays(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    evaluation = evaluate("rule-2", episodes=3)
    (run,) = evaluation.exported()
    with pytest.raises(RecordError, match="episode 0 does not end as its evidence says"):
        write_dataset([run._replace(outcome=run.outcome[::-1].copy() * 0 + Outcome.TIMEOUT)], folder)
    assert files(folder) == {}
    evaluation.export(folder)
    before = files(folder)
    with pytest.raises(OutputError, match="is there already; remove it, or name another folder"):
        evaluation.export(folder)
    monkeypatch.setattr(minari_dataset, "_of_episodes", lambda _: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        evaluate("rule-4", episodes=2).export(folder)
    assert files(folder) == before
