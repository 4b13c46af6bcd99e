"""The Gymnasium view: the ego alone, scripted front vehicles being part of its world."""

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.views.arguments import RENDER_MODES, as_seed
from hhrl_envs.views.parallel_env import EGO, StopLineParallelEnv
from hhrl_envs.views.spaces import Info


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
        """Return the first observation, float32 [11], and info of an episode; see ``StopLineParallelEnv.reset``."""
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


def gym_id(scenario_id: str) -> str:
    """Return the Gymnasium id of a scenario id."""
    *words, version = scenario_id.split("-")
    return f"hhrl_envs/{''.join(word.capitalize() for word in words)}-{version}"


def register_gym(scenario: Scenario) -> None:
    """Register a scenario with Gymnasium, single and native vector: ``stop-line-v0`` as ``hhrl_envs/StopLine-v0``."""
    gymnasium.register(
        gym_id(scenario.id),
        entry_point="hhrl_envs.views.gym_env:StopLineEnv",
        vector_entry_point="hhrl_envs.views.vector_env:StopLineVectorEnv",
        kwargs={"scenario": scenario.id},
    )
