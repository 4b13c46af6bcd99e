"""The Gymnasium views, single and native vector: the ego alone, scripted front vehicles being part of its world."""

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from hhrl_envs.errors import InputError
from hhrl_envs.scenario.registry import as_count, as_scenario
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.views.arguments import RENDER_MODES, as_seed, as_seeds, driver
from hhrl_envs.views.parallel_env import EGO, StopLineParallelEnv
from hhrl_envs.views.spaces import Info, observation_space

Batch = tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Info]


class StopLineEnv(gymnasium.Env[NDArray[np.float32], Any]):
    """A Gymnasium environment of one scenario: the ego of ``StopLineParallelEnv``, with the same rewards and infos.

    All front vehicles are scripted, also where the scenario is made for learned ones.
    """

    metadata = {"render_modes": list(RENDER_MODES), "render_fps": 10}  # noqa: RUF012

    def __init__(
        self,
        scenario: Scenario | str = "stop-line-v0",
        render_mode: str | None = None,
        continuous_actions: bool = False,
    ) -> None:
        self.parallel = StopLineParallelEnv(scenario, render_mode, 0, continuous_actions)
        self.metadata, self.render_mode = self.parallel.metadata, render_mode
        self.scenario = self.parallel.scenario
        self.observation_space: Any = self.parallel.observation_space(EGO)
        self.action_space: Any = self.parallel.action_space(EGO)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], Info]:
        """Return the first observation, float32 [SIZE], and info of an episode; see ``StopLineParallelEnv.reset``."""
        super().reset(seed=None if seed is None else as_seed(seed))
        observations, infos = self.parallel.reset(seed=seed, options=options)
        return observations[EGO], infos[EGO]

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, Info]:
        """Return observation, r^task, terminated, truncated and info after one step."""
        observations, rewards, terminations, truncations, infos = self.parallel.step({EGO: action})
        return observations[EGO], rewards[EGO], terminations[EGO], truncations[EGO], infos[EGO]

    def render(self) -> Any:
        """Return a picture of the road, uint8 [H, W, 3]; None without a render mode and where a window shows it."""
        return self.parallel.render()

    def show_option(self, option: int | None) -> None:
        """Let the pictures show the selected option; see ``StopLineParallelEnv.show_option``."""
        self.parallel.show_option(option)

    def close(self) -> None:
        """Close the window, where there is one."""
        self.parallel.close()


class StopLineVectorEnv(VectorEnv[NDArray[np.float32], NDArray[Any], NDArray[Any]]):
    """``num_envs`` independent rows of one scenario with NEXT_STEP auto-reset, stepped by ``threads`` threads.

    ``reset(seed=s)`` gives row i the seed s + i, a list gives every row its own. The step after an episode's end
    ignores that row's action, starts its next episode and returns the first observation with reward 0. ``infos`` holds
    ``reward_option`` and ``reward_action``, float64 [B, K] for K sub-goals, and ``outcome``, int8 [B] of ``Outcome``
    codes. With ``continuous_actions`` an action is a number in [-1, 1], float32 [B, 1]; see ``views.arguments``. All
    front vehicles are scripted.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        scenario: Scenario | str = "stop-line-v0",
        render_mode: str | None = None,
        continuous_actions: bool = False,
        threads: int = 1,
    ) -> None:
        if render_mode is not None:
            raise InputError(
                f"render_mode is {render_mode!r}; the vector view draws nothing, render a single environment"
            )
        self.num_envs, self.render_mode = as_count(num_envs, "num_envs"), None
        self.scenario = as_scenario(scenario)
        self.simulator = Simulator(self.scenario, num_envs, threads)
        self._actions = driver(self.scenario, continuous_actions)
        self.single_observation_space = observation_space(self.scenario)
        self.single_action_space = self._actions.space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._seeded = False

    def reset(
        self, *, seed: int | Sequence[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], Info]:
        """Return the first observations, float32 [B, SIZE], and infos.

        The infos are ``feasible``, bool [B], and ``option_mask``, bool [B, K] for K sub-goals.
        """
        if isinstance(options, dict) and "reset_mask" in options:
            raise InputError(
                "options have a 'reset_mask'; leave it out, for rows that have ended begin anew by themselves"
            )
        if seed is None and self._seeded:
            self.simulator.next_episode()
        else:
            self.simulator.reset(as_seeds(seed, self.num_envs))
            self._seeded = True
        option_mask = np.tile(self.scenario.option_mask, (self.num_envs, 1))
        return self.simulator.observations, {"feasible": self.simulator.feasible, "option_mask": option_mask}

    def step(self, actions: NDArray[Any]) -> Batch:
        """Return observations, r^task, terminations, truncations and infos after one step of every row."""
        simulator = self.simulator
        simulator.step(self._actions.batch(actions, self.num_envs), autoreset=True)
        arrays = simulator.arrays
        infos = {
            "reward_option": arrays.reward_option,
            "reward_action": arrays.reward_action,
            "outcome": arrays.outcomes,
        }
        return arrays.observations, arrays.rewards, arrays.terminations, arrays.truncations, infos


def gym_id(scenario_id: str) -> str:
    """Return the Gymnasium id of a scenario id."""
    *words, version = scenario_id.split("-")
    return f"hhrl_envs/{''.join(word.capitalize() for word in words)}-{version}"


def register_gym(scenario: Scenario) -> None:
    """Register a scenario with Gymnasium, single and native vector: ``stop-line-v0`` as ``hhrl_envs/StopLine-v0``."""
    gymnasium.register(
        gym_id(scenario.id),
        entry_point="hhrl_envs.views.gym_env:StopLineEnv",
        vector_entry_point="hhrl_envs.views.gym_env:StopLineVectorEnv",
        kwargs={"scenario": scenario.id},
    )
