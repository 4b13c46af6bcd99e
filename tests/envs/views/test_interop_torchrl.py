"""TorchRL wraps the PettingZoo view; its own checker accepts it, and rollouts carry the rewards of both levels."""

import warnings

import numpy as np
import pytest
import torch

from hhrl_envs import SCENARIOS, triad
from hhrl_envs.views.infos import NumericInfos
from hhrl_envs.views.parallel_env import EGO
from hhrl_envs.views.triad import ViewArguments

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # TorchRL and what it imports use names that Python and torch are retiring
    pytest.importorskip("torchrl", reason="TorchRL is not installed")
    from tensordict import TensorDict
    from torchrl.envs import GymEnv, PettingZooWrapper
    from torchrl.envs.utils import check_env_specs

pytestmark = pytest.mark.filterwarnings("ignore:PettingZoo in TorchRL is tested using version:UserWarning")


@pytest.mark.parametrize("scenario_id", SCENARIOS)
def test_torchrl_accepts_the_view(scenario_id: str) -> None:
    view = NumericInfos(triad(scenario_id).parallel_env())
    check_env_specs(PettingZooWrapper(view, use_mask=True, return_state=True, seed=3))


@pytest.mark.parametrize(
    ("scenario_id", "arguments"),
    [
        ("stop-line-v0", ViewArguments(learned_fronts=2)),
        ("two-stops-v0", ViewArguments(learned_fronts=2, continuous_actions=True)),
        ("platoon-v0", ViewArguments(continuous_actions=True)),
        ("adversary-v0", ViewArguments(learned_fronts=3)),
        ("follow-v0", ViewArguments(continuous_actions=True)),
    ],
    ids=str,
)
def test_torchrl_accepts_several_agents_and_continuous_actions(scenario_id: str, arguments: ViewArguments) -> None:
    env = triad(scenario_id).parallel_env(**arguments)
    wrapped = PettingZooWrapper(NumericInfos(env), use_mask=True, return_state=True, seed=3)
    groups = {name: agents for name, agents in wrapped.group_map.items() if agents}
    assert sorted(agent for agents in groups.values() for agent in agents) == sorted(env.possible_agents)
    check_env_specs(wrapped)
    states = wrapped.rollout(200)["next", "state"]
    assert all(env.state_space.contains(state) for state in states.numpy())


def test_a_rollout_holds_what_the_view_says() -> None:
    wrapped = PettingZooWrapper(NumericInfos(triad("stop-line-v0").parallel_env()), seed=3)
    alone = triad("stop-line-v0").parallel_env()
    wrapped.set_seed(3)
    alone.reset(seed=3)
    alone.reset()  # a rollout resets without a seed, which is the next episode of seed 3
    rollout = wrapped.rollout(40, policy=lambda data: data.set((EGO, "action"), torch.tensor([4])))
    assert rollout.shape == (40,)
    for step in range(40):
        observations, rewards, _, _, infos = alone.step({EGO: 4})
        after = rollout[step]["next", EGO]
        assert np.array_equal(after["observation"][0].numpy(), observations[EGO])
        assert after["reward"].item() == np.float32(rewards[EGO])
        for name in ("reward_option", "reward_action"):
            assert np.array_equal(after["info", name][0].numpy(), infos[EGO][name].astype(np.float32))


@pytest.mark.parametrize("scenario_id", ["platoon-v0", "adversary-v0"])
def test_agents_that_have_left_do_not_end_the_episode_of_the_others(scenario_id: str) -> None:
    view = NumericInfos(triad(scenario_id).parallel_env())
    wrapped = PettingZooWrapper(view, use_mask=True, done_on_any=False, seed=3)
    check_env_specs(wrapped)

    def full_throttle(data: TensorDict) -> TensorDict:
        for group, agents in wrapped.group_map.items():
            data.set((group, "action"), torch.full((len(agents),), 5))
        return data

    rollout = wrapped.rollout(600, policy=full_throttle, break_when_any_done=False)
    ended = torch.stack([rollout["next", group, "done"].flatten(1).any(1) for group in wrapped.group_map])
    assert int(rollout["next", "done"].sum()) > 3
    assert (ended.any(0) & ~rollout["next", "done"].flatten()).any(), "nobody left before the others"


def test_torchrl_reads_infos_of_the_gymnasium_view() -> None:
    env = GymEnv("hhrl_envs:hhrl_envs/StopLine-v0", categorical_action_encoding=True).auto_register_info_dict()
    check_env_specs(env)

    def full_throttle(data: TensorDict) -> TensorDict:
        return data.set("action", torch.tensor(5))

    rollout = env.rollout(300, policy=full_throttle, break_when_any_done=False)
    assert rollout["next", "done"].sum() > 2
    assert rollout["next", "reward_option"].shape == (300, 2)
