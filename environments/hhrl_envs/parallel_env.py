"""The PettingZoo view: a parallel environment with the ego as its agent among scripted front vehicles."""

from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from numpy.typing import NDArray
from pettingzoo.utils.env import ParallelEnv

from hhrl_envs.errors import InputError
from hhrl_envs.outcomes import Outcome
from hhrl_envs.registry import get_scenario
from hhrl_envs.scenario import Scenario
from hhrl_envs.simulator import Simulator
from hhrl_envs.views import Info, action_space, is_terminal, observation_space, reset_info, step_info

EGO = "ego"


class StopLineParallelEnv(ParallelEnv[str, NDArray[np.float32], int | None]):
    """A parallel PettingZoo environment of one scenario.

    ``rewards`` are r^task; ``infos[agent]`` carries ``reward_option`` and ``reward_action``, float64 [2] each, one
    entry an option, and ``outcome`` on the last step. At reset it carries the drawn profiles. ``reset(seed=s)`` starts
    episode 0 of seed s, ``reset()`` the next episode of the same seed.
    """

    metadata: dict[str, Any]

    def __init__(self, scenario: Scenario | str = "stop-line-v0", render_mode: str | None = None) -> None:
        self.scenario = get_scenario(scenario) if isinstance(scenario, str) else scenario
        if render_mode not in (None, "rgb_array"):
            raise InputError(f"render_mode is {render_mode!r}; write None or 'rgb_array'")
        self.metadata = {
            "name": self.scenario.id.replace("-", "_"),
            "render_modes": ["rgb_array"],
            "render_fps": round(1.0 / self.scenario.dt),
            "is_parallelizable": True,
        }
        self.render_mode = render_mode
        self.simulator = Simulator(self.scenario, 1)
        self.possible_agents = [EGO]
        self.agents: list[str] = []
        self._observation_space, self._action_space = observation_space(self.scenario), action_space(self.scenario)
        self._renderer: Any = None
        self._seeded = False

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Return the agent's observation space; the same for all agents."""
        return self._observation_space

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return the agent's action space; the same for all agents."""
        return self._action_space

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, Info]]:
        """Return the first observations and infos of an episode."""
        if seed is None and self._seeded:
            self.simulator.next_episode(np.ones(1, np.bool_))
        else:
            chosen = seeding.np_random()[1] % 2**63 if seed is None else seed
            self.simulator.reset(np.array([chosen]))
            self._seeded = True
        self.agents = list(self.possible_agents)
        return {EGO: self.simulator.observations[0]}, {EGO: reset_info(self.simulator, 0)}

    def step(
        self, actions: dict[str, int | None]
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, float], dict[str, bool], dict[str, bool], dict[str, Info]]:
        """Return observations, rewards, terminations, truncations and infos of the live agents after one step."""
        self._check(actions)
        if not self.agents:
            return {}, {}, {}, {}, {}
        simulator = self.simulator
        simulator.step(np.array([actions[EGO]]))
        outcome = int(simulator.outcomes[0])
        if outcome != Outcome.RUNNING:
            self.agents = []
        return (
            {EGO: simulator.observations[0]},
            {EGO: float(simulator.rewards[0])},
            {EGO: is_terminal(outcome)},
            {EGO: outcome == Outcome.TIMEOUT},
            {EGO: step_info(simulator, 0)},
        )

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of the road, uint8 [H, W, 3], or None without a render mode."""
        if self.render_mode is None:
            return None
        if self._renderer is None:
            from hhrl_envs.rendering import Renderer  # noqa: PLC0415 - only the [render] extra brings what it needs

            self._renderer = Renderer(self.scenario)
        frame: NDArray[np.uint8] = self._renderer.frame(self.simulator)
        return frame

    def state(self) -> NDArray[np.float32]:
        """Return the global state: the observations of all possible agents one after another, float32 [11 * agents]."""
        return self.simulator.observations.ravel().copy()

    def close(self) -> None:
        """Let go of the renderer."""
        self._renderer = None

    def _check(self, actions: dict[str, int | None]) -> None:
        if not self._seeded:
            raise InputError("step before reset; call reset(seed=...) first")
        if set(actions) != set(self.agents):
            raise InputError(f"actions for {sorted(actions)}; write one action for each of {self.agents}")
