"""The Gymnasium view of a single environment, and how scenarios are registered there."""

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.sub_goals import SUB_GOALS, Outcome
from hhrl_envs.views.arguments import RENDER_MODES, as_seed, driver, require_horizon
from hhrl_envs.views.infos import Info
from hhrl_envs.views.parallel_env import EGO, StopLineParallelEnv
from hhrl_envs.views.vector_env import StopLineVectorEnv

__all__ = ["StopLineEnv", "StopLineVectorEnv", "gym_id", "register_gym"]

_OUTCOMES = [np.int64(outcome) for outcome in Outcome]
_FLAGS = np.array(False), np.array(True)
_GO_ON = frozenset({int(Outcome.RUNNING), int(Outcome.TIMEOUT)})
_TIMEOUT, _SUCCESS = int(Outcome.TIMEOUT), int(Outcome.SUCCESS)


class StopLineEnv(gymnasium.Env[NDArray[np.float32], Any]):
    """A Gymnasium environment of one scenario: the ego of ``StopLineParallelEnv``, with the same rewards.

    All front vehicles are scripted, also where the scenario is made for learned ones. ``infos`` have the same numeric
    entries at reset and at every step: ``reward_option`` and ``reward_action``, float64 [K] each, ``outcome``,
    an integer, ``is_success`` and ``feasible``. What else there is of the episode, the
    ``simulator`` says: ``simulator.profiles(0)`` and ``simulator.key(0)``.
    """

    metadata = {"render_modes": list(RENDER_MODES), "render_fps": 10}  # noqa: RUF012

    def __init__(
        self,
        scenario: Scenario | str = "stop-line-v0",
        render_mode: str | None = None,
        continuous_actions: bool = False,
        max_episode_steps: int | None = None,
    ) -> None:
        self.parallel = StopLineParallelEnv(scenario, render_mode, 0, continuous_actions)
        self.metadata, self.render_mode = self.parallel.metadata, render_mode
        self.scenario = self.parallel.scenario
        require_horizon(self.scenario, max_episode_steps)
        self.observation_space: Any = self.parallel.observation_space(EGO)
        self.action_space: Any = self.parallel.action_space(EGO)
        self._actions = driver(self.scenario, continuous_actions)
        self._feasible = np.array(True)

    @property
    def simulator(self) -> Simulator:
        """The simulator below this view, of one row."""
        return self.parallel.simulator

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], Info]:
        """Return the first observation, float32 [SIZE], and info of an episode; see ``StopLineParallelEnv.reset``."""
        super().reset(seed=None if seed is None else as_seed(seed))
        observations, infos = self.parallel.reset(seed=seed, options=options)
        self._feasible = np.array(infos[EGO]["feasible"])
        return observations[EGO], self._info(np.zeros(len(SUB_GOALS)), np.zeros(len(SUB_GOALS)), Outcome.RUNNING)

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, Info]:
        """Return observation, r^task, terminated, truncated and info after one step."""
        observation, reward, outcome, option, action = self.parallel.step_ego(action)
        terminated, truncated = outcome not in _GO_ON, outcome == _TIMEOUT
        return observation, reward, terminated, truncated, self._info(option, action, outcome)

    def action_masks(self) -> NDArray[np.bool_]:
        """Return which levels are allowed, bool [num_actions]: all of them, always. MaskablePPO asks for it."""
        allowed: NDArray[np.bool_] = self._actions.masks(1)[0]
        return allowed

    def get_keys_to_action(self) -> dict[tuple[int, ...], Any]:
        """Return which key means which action, for ``gymnasium.utils.play``; see ``views.arguments``."""
        return {**self._actions.keys()}

    def render(self) -> Any:
        """Return a picture of the road, uint8 [H, W, 3]; None without a render mode and where a window shows it."""
        return self.parallel.render()

    def show_option(self, option: int | None) -> None:
        """Let the pictures show the selected option; see ``StopLineParallelEnv.show_option``."""
        self.parallel.show_option(option)

    def close(self) -> None:
        """Close the window, where there is one."""
        self.parallel.close()

    def _info(self, option: NDArray[Any], action: NDArray[Any], outcome: int) -> Info:
        """Return an info of fresh numpy numbers and arrays, which every reader of infos can stack."""
        return {
            "reward_option": option,
            "reward_action": action,
            "outcome": _OUTCOMES[outcome],
            "is_success": _FLAGS[outcome == _SUCCESS].copy(),
            "feasible": self._feasible.copy(),
        }


def gym_id(scenario_id: str) -> str:
    """Return the Gymnasium id of a scenario id."""
    *words, version = scenario_id.split("-")
    return f"hhrl_envs/{''.join(word.capitalize() for word in words)}-{version}"


def register_gym(scenario: Scenario) -> None:
    """Register a scenario with Gymnasium, single and native vector: ``stop-line-v0`` as ``hhrl_envs/StopLine-v0``.

    Its ``max_episode_steps`` is the horizon, at which the view itself truncates. The ``TimeLimit`` that ``make`` adds
    changes nothing but this: ``truncated`` is True too in an episode that terminates in the very last step. The views
    are told the limit as well, and refuse a longer scenario in place of the registered one, which it would cut.
    """
    gymnasium.register(
        gym_id(scenario.id),
        entry_point="hhrl_envs.views.gym_env:StopLineEnv",
        vector_entry_point="hhrl_envs.views.gym_env:StopLineVectorEnv",
        max_episode_steps=scenario.horizon,
        kwargs={"scenario": scenario.id, "max_episode_steps": scenario.horizon},
    )
