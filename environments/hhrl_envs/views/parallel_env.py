"""The PettingZoo view: a parallel environment of the ego and, where wanted, learned front vehicles."""

from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding
from numpy.typing import NDArray
from pettingzoo.utils.env import ParallelEnv

from hhrl_envs.errors import InputError
from hhrl_envs.rendering.renderer import Renderer
from hhrl_envs.scenario.registry import as_learned_fronts, as_scenario
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.simulation.engine.layout import ACTION_RESULTS, OPTION_RESULTS
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.sub_goals import SUCCESS, TIMEOUT, Outcome
from hhrl_envs.views.arguments import RENDER_MODES, as_agent, as_option, as_render_mode, as_seed, bad_agents, driver
from hhrl_envs.views.infos import Info, Infos, reset_info
from hhrl_envs.views.spaces import observation_space, state_space

EGO = "ego"

Observations = dict[str, NDArray[np.float32]]
Step = tuple[Observations, dict[str, float], dict[str, bool], dict[str, bool], Infos]

_OUTCOMES = list(Outcome)


class StopLineParallelEnv(ParallelEnv[str, NDArray[np.float32], Any]):
    """A parallel PettingZoo environment of one scenario.

    Its agents are the ``ego`` and ``learned_fronts`` front vehicles, ``front_1`` being the nearest to it; None stands
    for the scenario's own number, which is 0 but for the scenarios that are made for it. They leave one by one. With
    ``continuous_actions`` an action is a number in [-1, 1] instead of a level; see ``hhrl_envs.views.arguments``.

    A step wants an action of every live agent; those of agents that have left are not read.

    ``rewards`` are r^task; ``infos[agent]`` carries ``reward_option`` and ``reward_action``, float64 [K] each, one
    entry an option, and ``outcome`` and ``is_success`` on the last step. At reset it carries the drawn profiles and
    whether the episode is ``feasible``; with learned front vehicles that is known when the ego's episode ends.
    ``reset(seed=s)`` starts episode 0 of seed s, ``reset()`` the next episode of the same seed. ``render_mode="human"``
    shows every step in a window, ten steps of 0.1 s in a second; ``"rgb_array"`` lets ``render()`` return pictures.

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
        seen, done = observation_space(self.scenario), self._actions.space
        self.observation_spaces: dict[str, Any] = dict.fromkeys(self.possible_agents, seen)
        self.action_spaces: dict[str, Any] = dict.fromkeys(self.possible_agents, done)
        self.state_space = state_space(self.scenario, len(self.possible_agents))
        self._own: dict[str, tuple[NDArray[Any], ...]] = {}
        self._seeded = False
        self._np_random: np.random.Generator | None = None

    @property
    def np_random(self) -> np.random.Generator:
        """A generator for whoever wraps this view, from the seed of the last reset; episodes draw nothing from it."""
        if self._np_random is None:
            self._np_random = seeding.np_random(self.simulator.key(0)[0] if self._seeded else None)[0]
        return self._np_random

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Return the agent's observation space; the same for all agents."""
        space: spaces.Space[Any] = self.observation_spaces[as_agent(agent, self.possible_agents)]
        return space

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return the agent's action space; the same for all agents."""
        space: spaces.Space[Any] = self.action_spaces[as_agent(agent, self.possible_agents)]
        return space

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observations, Infos]:
        """Return the first observations and infos of an episode: of this seed's first one, or of the next one.

        The first reset without a seed draws one; an episode has no ``options``, so they are not read.
        """
        if seed is None and self._seeded:
            self.simulator.next_episode()
        else:
            self.simulator.reset(np.array([as_seed(seed)], np.uint64))
            self._seeded, self._np_random = True, None
        self.agents = list(self.possible_agents)
        if self._renderer is not None:
            self._renderer.reset()
        self._bind_results()
        infos = {agent: reset_info(self.simulator, 0) for agent in self.agents}
        return {agent: own[0].copy() for agent, own in self._own.items()}, infos

    def step(self, actions: Any) -> Step:
        """Return observations, rewards, terminations, truncations and infos of the live agents after one step."""
        live, slots, acceleration = self.agents, self._slots, self._actions.acceleration
        if not live or not isinstance(actions, dict):
            self._refuse_step(actions)
            return {}, {}, {}, {}, {}
        if len(actions) != len(live) and not actions.keys() <= slots.keys():
            raise bad_agents(actions, live)
        try:
            targets = {slots[agent]: acceleration(agent, actions[agent]) for agent in live}
        except KeyError:
            raise bad_agents(actions, live) from None
        self.simulator.step_row(targets)
        collected = self._collect(live)
        if self._renderer is not None:
            self._renderer.follow()
        return collected

    def step_ego(self, action: Any) -> tuple[NDArray[np.float32], float, int, NDArray[Any], NDArray[Any]]:
        """Return observation, r^task, outcome, r^option and r^action after one step of an ego without other agents."""
        if not self.agents:
            self._refuse_step({EGO: action})
        self.simulator.step_row({0: self._actions.acceleration(EGO, action)})
        observation, results, of_option, of_action, codes = self._own[EGO]
        outcome = codes.item(0)
        if outcome:
            self.agents = []
        if self._renderer is not None:
            self._renderer.follow()
        return observation.copy(), results.item(0), outcome, of_option.copy(), of_action.copy()

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
                info["outcome"], info["is_success"] = _OUTCOMES[outcome], outcome == SUCCESS
                if agent == EGO:
                    info["feasible"] = bool(self.simulator.feasible[0])
        return collected

    def _refuse_step(self, actions: Any) -> None:
        """Raise an error for a step that cannot be; one without agents and actions is the only one that is left."""
        if not self._seeded:
            raise InputError("step before reset; call reset(seed=...) first")
        if not isinstance(actions, dict) or actions or self.agents:
            raise bad_agents(actions, self.agents)
