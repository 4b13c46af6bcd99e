"""The PettingZoo view: a parallel environment with the ego as its agent among scripted front vehicles."""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo.utils.env import ParallelEnv

from hhrl_envs.arguments import (
    RENDER_MODES,
    as_agent,
    as_option,
    as_render_mode,
    as_scenario,
    as_seed,
    bad_action,
    bad_agents,
)
from hhrl_envs.errors import InputError
from hhrl_envs.outcomes import Outcome
from hhrl_envs.scenario import Scenario
from hhrl_envs.screen import Screen
from hhrl_envs.simulator import Simulator
from hhrl_envs.views import Info, action_space, is_terminal, observation_space, reset_info, state_space, step_info

EGO = "ego"


class StopLineParallelEnv(ParallelEnv[str, NDArray[np.float32], int | None]):
    """A parallel PettingZoo environment of one scenario.

    ``rewards`` are r^task; ``infos[agent]`` carries ``reward_option`` and ``reward_action``, float64 [2] each, one
    entry an option, and ``outcome`` on the last step. At reset it carries the drawn profiles. ``reset(seed=s)`` starts
    episode 0 of seed s, ``reset()`` the next episode of the same seed. ``render_mode="human"`` shows every step in a
    window, ten steps of 0.1 s in a second; ``"rgb_array"`` lets ``render()`` return pictures.

    Raises:
        InputError: a scenario, render mode, seed, agent or action that is not allowed, or a step before reset.
    """

    metadata: dict[str, Any]

    def __init__(self, scenario: Scenario | str = "stop-line-v0", render_mode: str | None = None) -> None:
        self.scenario, self.render_mode = as_scenario(scenario), as_render_mode(render_mode)
        self.metadata = {
            "name": self.scenario.id.replace("-", "_"),
            "render_modes": list(RENDER_MODES),
            "render_fps": round(1.0 / self.scenario.dt),
            "is_parallelizable": True,
        }
        self.simulator = Simulator(self.scenario, 1)
        self._screen = None if render_mode is None else Screen(self.simulator, render_mode)
        self.possible_agents = [EGO]
        self.agents: list[str] = []
        self._observation_space, self._action_space = observation_space(self.scenario), action_space(self.scenario)
        self.state_space = state_space(self.scenario, len(self.possible_agents))
        self._seeded = False

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Return the agent's observation space; the same for all agents."""
        as_agent(agent, self.possible_agents)
        return self._observation_space

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return the agent's action space; the same for all agents."""
        as_agent(agent, self.possible_agents)
        return self._action_space

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, Info]]:
        """Return the first observations and infos of an episode."""
        if seed is None and self._seeded:
            self.simulator.next_episode(np.ones(1, np.bool_))
        else:
            self.simulator.reset(np.array([as_seed(seed)], np.uint64))
            self._seeded = True
        self.agents = list(self.possible_agents)
        if self._screen is not None:
            self._screen.begin()
        return {EGO: self.simulator.observations[0]}, {EGO: reset_info(self.simulator, 0)}

    def step(
        self, actions: dict[str, int | None]
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, float], dict[str, bool], dict[str, bool], dict[str, Info]]:
        """Return observations, rewards, terminations, truncations and infos of the live agents after one step."""
        self._check(actions)
        if not self.agents:
            return {}, {}, {}, {}, {}
        simulator = self.simulator
        try:
            simulator.step(np.array([actions[EGO]]))
        except ValueError as refused:
            raise bad_action(EGO, actions[EGO], self.scenario) from refused
        outcome = int(simulator.outcomes[0])
        if outcome != Outcome.RUNNING:
            self.agents = []
        if self._screen is not None:
            self._screen.follow()
        return (
            {EGO: simulator.observations[0]},
            {EGO: float(simulator.rewards[0])},
            {EGO: is_terminal(outcome)},
            {EGO: outcome == Outcome.TIMEOUT},
            {EGO: step_info(simulator, 0)},
        )

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of the road, uint8 [H, W, 3]; None without a render mode and where a window shows it."""
        return None if self._screen is None else self._screen.render()

    def show_option(self, option: int | None) -> None:
        """Let the pictures show the option that the ego has selected, until the next reset; None for a flat agent."""
        selected = as_option(option)
        if self._screen is not None:
            self._screen.option = selected

    def state(self) -> NDArray[np.float32]:
        """Return the global state: the observations of all possible agents one after another, float32 [11 * agents]."""
        return self.simulator.observations.ravel().copy()

    def close(self) -> None:
        """Close the window, where there is one."""
        if self._screen is not None:
            self._screen.close()

    def _check(self, actions: Any) -> None:
        if not self._seeded:
            raise InputError("step before reset; call reset(seed=...) first")
        if not isinstance(actions, dict) or set(actions) != set(self.agents):
            raise bad_agents(actions, self.agents)
