"""The PettingZoo view: a parallel environment of the ego and, where wanted, learned front vehicles."""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo.utils.env import ParallelEnv
from pettingzoo.utils.wrappers import BaseParallelWrapper

from hhrl_envs.errors import InputError
from hhrl_envs.rendering.renderer import Renderer
from hhrl_envs.scenario.registry import as_learned_fronts, as_scenario
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.simulation.engine.layout import ACTION_RESULTS, OPTION_RESULTS
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.sub_goals import SUB_GOALS, TIMEOUT, Outcome
from hhrl_envs.views.arguments import RENDER_MODES, as_agent, as_option, as_render_mode, as_seed, bad_agents, driver
from hhrl_envs.views.spaces import Info, observation_space, reset_info, state_space

EGO = "ego"

Observations = dict[str, NDArray[np.float32]]
Step = tuple[Observations, dict[str, float], dict[str, bool], dict[str, bool], dict[str, Info]]

_OUTCOMES = list(Outcome)
_AT_RESET: Info = {
    "reward_option": np.zeros(len(SUB_GOALS)),
    "reward_action": np.zeros(len(SUB_GOALS)),
    "outcome": int(Outcome.RUNNING),
}


class StopLineParallelEnv(ParallelEnv[str, NDArray[np.float32], Any]):
    """A parallel PettingZoo environment of one scenario.

    Its agents are the ``ego`` and ``learned_fronts`` front vehicles, ``front_1`` being the nearest to it; None stands
    for the scenario's own number, which is 0 but for the scenarios that are made for it. They leave one by one. With
    ``continuous_actions`` an action is a number in [-1, 1] instead of a level; see ``hhrl_envs.views.arguments``.

    ``rewards`` are r^task; ``infos[agent]`` carries ``reward_option`` and ``reward_action``, float64 [K] each, one
    entry an option, and ``outcome`` on the last step. At reset it carries the drawn profiles and whether the episode is
    ``feasible``; with learned front vehicles that is known when the ego's episode ends. ``reset(seed=s)`` starts
    episode 0 of seed s, ``reset()`` the next episode of the same seed. ``render_mode="human"`` shows every step in a
    window, ten steps of 0.1 s in a second; ``"rgb_array"`` lets ``render()`` return pictures.

    Raises:
        InputError: a scenario, render mode, seed, agent or action that is not allowed, or a step before reset.
    """

    metadata: dict[str, Any]

    def __init__(
        self,
        scenario: Scenario | str = "stop-line-v0",
        render_mode: str | None = None,
        learned_fronts: int | None = None,
        continuous_actions: bool = False,
    ) -> None:
        self.scenario, self.render_mode = as_scenario(scenario), as_render_mode(render_mode)
        self.metadata = {
            "name": self.scenario.id.replace("-", "_"),
            "render_modes": list(RENDER_MODES),
            "render_fps": round(1.0 / self.scenario.dt),
            "is_parallelizable": True,
        }
        fronts = as_learned_fronts(learned_fronts, self.scenario)
        self.simulator = Simulator(self.scenario, 1, learned_fronts=fronts)
        self._renderer = None if render_mode is None else Renderer(self.simulator, render_mode)
        self.possible_agents = [EGO, *(f"front_{slot}" for slot in range(1, fronts + 1))]
        self.agents: list[str] = []
        self._slots = {agent: slot for slot, agent in enumerate(self.possible_agents)}
        self._actions = driver(self.scenario, continuous_actions)
        self._observation_space = observation_space(self.scenario)
        self.state_space = state_space(self.scenario, len(self.possible_agents))
        self._own: dict[str, tuple[NDArray[Any], ...]] = {}
        self._seeded = False

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Return the agent's observation space; the same for all agents."""
        as_agent(agent, self.possible_agents)
        return self._observation_space

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return the agent's action space; the same for all agents."""
        as_agent(agent, self.possible_agents)
        return self._actions.space

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Info]]:
        """Return the first observations and infos of an episode: of this seed's first one, or of the next one.

        The first reset without a seed draws one; an episode has no ``options``, so they are not read.
        """
        if seed is None and self._seeded:
            self.simulator.next_episode()
        else:
            self.simulator.reset(np.array([as_seed(seed)], np.uint64))
            self._seeded = True
        self.agents = list(self.possible_agents)
        if self._renderer is not None:
            self._renderer.reset()
        self._bind_results()
        infos = {agent: reset_info(self.simulator, 0) for agent in self.agents}
        return {agent: own[0].copy() for agent, own in self._own.items()}, infos

    def step(self, actions: Any) -> Step:
        """Return observations, rewards, terminations, truncations and infos of the live agents after one step."""
        live = self.agents
        if not live or not isinstance(actions, dict) or len(actions) != len(live):
            self._refuse_step(actions)
            return {}, {}, {}, {}, {}
        slots, acceleration = self._slots, self._actions.acceleration
        try:
            targets = {slots[agent]: acceleration(agent, actions[agent]) for agent in live}
        except KeyError:
            raise bad_agents(actions, live) from None
        self.simulator.step_row(targets)
        collected = self._collect(live)
        if self._renderer is not None:
            self._renderer.follow()
        return collected

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture of the road, uint8 [H, W, 3]; None without a render mode and where a window shows it."""
        return None if self._renderer is None else self._renderer.render()

    def show_option(self, option: int | None) -> None:
        """Let the pictures show the option that the ego has selected, until the next reset; None for a flat agent."""
        selected = as_option(option)
        if self._renderer is not None:
            self._renderer.option = selected

    def state(self) -> NDArray[np.float32]:
        """Return the global state: the observations of all possible agents one after another, float32 [SIZE * agents].

        Raises:
            InputError: before the first reset.
        """
        if not self._seeded:
            raise InputError("state before reset; call reset(seed=...) first")
        return self.simulator.arrays.all_observations[:, :, 0].T.ravel()

    def close(self) -> None:
        """Close the window, where there is one."""
        if self._renderer is not None:
            self._renderer.close()

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        if self._seeded:
            self._bind_results()

    def _bind_results(self) -> None:
        """Note where in the simulator's results those of each agent lie: views, so a copy of the view looks anew."""
        arrays = self.simulator.arrays
        for agent, slot in self._slots.items():
            own = (..., slot, 0)
            results = arrays.all_results[own]
            self._own[agent] = (
                arrays.all_observations[own],
                results,
                results[OPTION_RESULTS],
                results[ACTION_RESULTS],
                arrays.all_codes[own],
            )

    def _collect(self, live: list[str]) -> Step:
        """Return what the agents that were live before the step get from it, and let those leave that have ended."""
        collected: Step = ({}, {}, {}, {}, {})
        observations, rewards, terminations, truncations, infos = collected
        for agent in live:
            observation, results, option, action, codes = self._own[agent]
            info: Info = {"reward_option": option.copy(), "reward_action": action.copy()}
            outcome = codes.item(0)
            observations[agent], rewards[agent], infos[agent] = observation.copy(), results.item(0), info
            terminations[agent] = truncations[agent] = False
            if outcome:
                self.agents = [other for other in self.agents if other != agent]
                terminations[agent], truncations[agent] = outcome != TIMEOUT, outcome == TIMEOUT
                info["outcome"] = _OUTCOMES[outcome]
                if agent == EGO:
                    info["feasible"] = bool(self.simulator.feasible[0])
        return collected

    def _refuse_step(self, actions: Any) -> None:
        """Raise an error for a step that cannot be; one without agents and actions is the only one that is left."""
        if not self._seeded:
            raise InputError("step before reset; call reset(seed=...) first")
        if not isinstance(actions, dict) or actions or self.agents:
            raise bad_agents(actions, self.agents)


class NumericInfos(BaseParallelWrapper[str, NDArray[np.float32], Any]):
    """Keeps the entries of infos that every step has: ``reward_option``, ``reward_action``, [K] each, and ``outcome``.

    They are there at reset too, as zeros and ``Outcome.RUNNING``. It is for libraries that want infos of fixed entries
    and shapes, as TorchRL does.
    """

    def __init__(self, env: ParallelEnv[str, NDArray[np.float32], Any]) -> None:
        super().__init__(env)
        self.metadata, self.possible_agents = env.metadata, env.possible_agents

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Info]]:
        """Return the first observations and infos of an episode."""
        observations, infos = super().reset(seed, options)
        return observations, {agent: dict(_AT_RESET) for agent in infos}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[Observations, dict[str, float], dict[str, bool], dict[str, bool], dict[str, Info]]:
        """Return observations, rewards, terminations, truncations and infos of the live agents after one step."""
        observations, rewards, terminations, truncations, infos = super().step(actions)
        numeric = {
            agent: {name: info.get(name, nothing) for name, nothing in _AT_RESET.items()}
            for agent, info in infos.items()
        }
        return observations, rewards, terminations, truncations, numeric
