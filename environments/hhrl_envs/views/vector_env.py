"""The native vector view of Gymnasium: many rows of one scenario in one simulator, the ego alone."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from hhrl_envs.arrays import Flags
from hhrl_envs.errors import InputError, require_value
from hhrl_envs.rendering.renderer import draw_row
from hhrl_envs.scenario.registry import as_count, as_scenario
from hhrl_envs.scenario.scenario import Scenario
from hhrl_envs.simulation.engine.memory import StepArrays
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.sub_goals import Outcome
from hhrl_envs.views.arguments import as_autoreset, as_reset_mask, as_seeds, driver, require_horizon
from hhrl_envs.views.infos import Info
from hhrl_envs.views.spaces import observation_space

Batch = tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Info]

_SUCCESS = np.int8(Outcome.SUCCESS)


class StopLineVectorEnv(VectorEnv[NDArray[np.float32], NDArray[Any], NDArray[Any]]):
    """``num_envs`` independent rows of one scenario, stepped by ``threads`` threads.

    ``reset(seed=s)`` gives row i the seed s + i, a list gives every row its own. ``autoreset_mode`` is one of
    Gymnasium's: with NEXT_STEP the step after an episode's end ignores that row's action, starts its next episode and
    returns the first observation with reward 0. With SAME_STEP the step that ends an episode returns the first
    observation of the next one; the last one and its infos are in ``infos["final_obs"]`` and ``infos["final_info"]``.
    With DISABLED, ``reset(options={"reset_mask": mask})`` starts the next episodes of the rows in ``mask``, bool [B].

    ``infos`` hold the same entries at reset and at every step: ``reward_option`` and ``reward_action``, float64 [B, K]
    for K sub-goals, ``outcome``, int8 [B] of ``Outcome`` codes, ``is_success`` and ``feasible``, bool [B], to be read
    only. With ``continuous_actions`` an action is a number in [-1, 1], float32 [B, 1]; see ``views.arguments``. All
    front vehicles are scripted. With ``render_mode="rgb_array"`` ``render()`` returns a picture of every row.
    """

    metadata = {"render_modes": ["rgb_array"], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        scenario: Scenario | str = "stop-line-v0",
        render_mode: str | None = None,
        continuous_actions: bool = False,
        threads: int = 1,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        max_episode_steps: int | None = None,
    ) -> None:
        allowed = "None or 'rgb_array'; a single environment has a window"
        require_value(render_mode in (None, "rgb_array"), "render_mode", repr(render_mode), allowed)
        self.num_envs, self.render_mode = as_count(num_envs, "num_envs"), render_mode
        self.scenario, self._autoreset = as_scenario(scenario), as_autoreset(autoreset_mode)
        require_horizon(self.scenario, max_episode_steps)
        self.metadata = {
            "render_modes": ["rgb_array"],
            "render_fps": round(1.0 / self.scenario.dt),
            "autoreset_mode": self._autoreset,
        }
        self.simulator = Simulator(self.scenario, num_envs, threads)
        self._actions = driver(self.scenario, continuous_actions)
        self.single_observation_space = observation_space(self.scenario)
        self.single_action_space = self._actions.space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._nowhere, self._feasible = (_fixed(np.full(num_envs, flag)) for flag in (False, True))
        self._seeded = False

    def reset(
        self, *, seed: int | Sequence[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], Info]:
        """Return the observations, float32 [B, SIZE], and infos of all rows after a reset of all or of some of them.

        ``options["reset_mask"]``, bool [B], says which rows begin an episode. What it does not name goes on, and keeps
        what its last step has said in ``infos``.
        """
        chosen = as_reset_mask(options, self.num_envs)
        if chosen is not None and not self._seeded:
            raise InputError("reset_mask before the first reset; call reset(seed=...) for all rows first")
        if seed is None and self._seeded:
            self.simulator.next_episode(chosen)
        else:
            seeds = as_seeds(seed, self.num_envs)
            super().reset(seed=int(seeds[0]))
            self.simulator.reset(seeds, chosen)
            self._seeded = True
        self._note_episodes()
        return self.simulator.observations, self._infos(self.simulator.arrays)

    def step(self, actions: NDArray[Any]) -> Batch:
        """Return observations, r^task, terminations, truncations and infos after one step of every row.

        Raises:
            InputError: for actions that are none, and without auto-reset for a step of rows that have ended.
        """
        simulator = self.simulator
        begins = simulator.ended
        if begins and self._autoreset is AutoresetMode.DISABLED:
            self._refuse_step()
        simulator.step(self._actions.batch(actions, self.num_envs), autoreset=True)
        if begins:
            self._note_episodes()
        arrays = simulator.arrays
        observations, infos = arrays.observations, self._infos(arrays)
        if simulator.ended and self._autoreset is AutoresetMode.SAME_STEP:
            observations, infos = self._begin_ended(arrays, infos)
        return observations, arrays.rewards, arrays.terminations, arrays.truncations, infos

    def action_masks(self) -> NDArray[np.bool_]:
        """Return which levels are allowed, bool [B, num_actions]: all of them, always. MaskablePPO asks for it."""
        return self._actions.masks(self.num_envs)

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return a picture of every row, uint8 [H, W, 3] each; None without a render mode."""
        if self.render_mode is None:
            return None
        return tuple(draw_row(self.simulator, row) for row in range(self.num_envs))

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)  # a copied array can be written again
        self._nowhere, self._feasible = (_fixed(flags.astype(np.bool_)) for flags in (self._nowhere, self._feasible))

    def _refuse_step(self) -> None:
        over = np.flatnonzero(self.simulator.outcomes)
        hint = "call reset(options={'reset_mask': terminations | truncations}) first"
        raise InputError(f"the episode of row {over[0]} is over, as in {over.size} of {self.num_envs} rows; {hint}")

    def _begin_ended(self, last: StepArrays, final: Info) -> tuple[NDArray[np.float32], Info]:
        """Start the next episodes of the rows that have ended, and return all rows' observations and infos."""
        ended = last.terminations | last.truncations
        self.simulator.reset_done()
        self._note_episodes()
        arrays = self.simulator.arrays
        observations = np.full(self.num_envs, None, object)
        for row in np.flatnonzero(ended):
            observations[row] = last.observations[row].copy()
        masks: dict[str, Flags] = {f"_{name}": ended for name in final}
        ends = {"final_obs": observations, "_final_obs": ended, "final_info": {**final, **masks}, "_final_info": ended}
        return arrays.observations, {**self._infos(arrays), **ends}

    def _note_episodes(self) -> None:
        """Note which of the present episodes are feasible: all of them, where no others are drawn."""
        if not self.scenario.feasible_only:
            self._feasible = _fixed(self.simulator.feasible)

    def _infos(self, arrays: StepArrays) -> Info:
        return {
            "reward_option": arrays.reward_option,
            "reward_action": arrays.reward_action,
            "outcome": arrays.outcomes,
            "is_success": arrays.outcomes == _SUCCESS if self.simulator.ended else self._nowhere,
            "feasible": self._feasible,
        }


def _fixed(flags: Flags) -> Flags:
    """Return the flags, which can no longer be written, so that infos can share them."""
    flags.flags.writeable = False
    return flags
