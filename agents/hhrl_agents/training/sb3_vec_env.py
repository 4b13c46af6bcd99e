"""The native vector view as a vector environment of Stable-Baselines3, which the ``sb3`` extra brings."""

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvStepReturn

from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats32
from hhrl_envs.errors import InputError
from hhrl_envs.views.vector_env import StopLineVectorEnv


class StopLineVecEnv(VecEnv):
    """``num_envs`` rows of one scenario, for the algorithms of Stable-Baselines3 and sb3-contrib; the ego alone.

    All rows are stepped at once by ``StopLineVectorEnv``, which says what the arguments are. A row's info holds what it
    holds there, and what Stable-Baselines3 wants at an episode's end: ``terminal_observation`` and
    ``TimeLimit.truncated``. Wrap it in their ``VecMonitor`` for the returns of episodes.
    """

    actions: NDArray[Any]

    def __init__(
        self,
        num_envs: int,
        scenario: Scenario | str = "stop-line-v0",
        render_mode: str | None = None,
        continuous_actions: bool = False,
        threads: int = 1,
    ) -> None:
        mode = AutoresetMode.SAME_STEP
        self.native = StopLineVectorEnv(num_envs, scenario, render_mode, continuous_actions, threads, mode)
        super().__init__(num_envs, self.native.single_observation_space, self.native.single_action_space)

    def reset(self) -> Floats32:
        """Return the first observations, float32 [B, SIZE], of the seeds given to `seed`, or of the next episodes."""
        seeds = [seed for seed in self._seeds if seed is not None]
        observations, infos = self.native.reset(seed=seeds or None)
        self.reset_infos = _rows(infos)
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: NDArray[Any]) -> None:
        """Note the actions of all rows for `step_wait`."""
        self.actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Return observations, r^task, dones and infos after one step of every row; those that end begin anew."""
        observations, rewards, terminations, truncations, infos = self.native.step(self.actions)
        dones, last = terminations | truncations, infos.pop("final_info", infos)
        final, _, _ = (infos.pop(name, None) for name in ("final_obs", "_final_obs", "_final_info"))
        said = {name: np.where(_like(dones, last[name]), last[name], infos[name]) for name in infos}
        rows = _rows(said)
        for row in np.flatnonzero(dones):
            rows[row]["terminal_observation"] = final[row]
            rows[row]["TimeLimit.truncated"] = bool(truncations[row])
            self.reset_infos[row] = {name: value[row] for name, value in infos.items()}
        return observations, rewards.astype(np.float32), dones, rows

    def get_images(self) -> Sequence[NDArray[np.uint8]]:
        """Return a picture of every row, uint8 [H, W, 3] each; needs ``render_mode="rgb_array"``."""
        return self.native.render() or ()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute of the native view, which all rows share, once for each row."""
        return [getattr(self.native, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Raise an ``InputError``: rows have no attributes of their own."""
        raise InputError(f"{attr_name} cannot be set; give it to StopLineVecEnv(...), for all rows")

    def env_method(self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any) -> list[Any]:
        """Return what a method of the native view returns for each row: ``action_masks`` or ``render``."""
        if method_name not in {"action_masks", "render"}:
            raise InputError(f"method is {method_name!r}; write 'action_masks' or 'render', which every row has")
        of_rows = getattr(self.native, method_name)(*args, **kwargs)
        return [of_rows[row] for row in self._get_indices(indices)]

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper[Any, Any, Any, Any]], indices: VecEnvIndices = None
    ) -> list[bool]:
        """Return False for each row: no wrapper is around a single one."""
        return [False for _ in self._get_indices(indices)]

    def close(self) -> None:
        """Close the native view."""
        self.native.close()


def _like(dones: NDArray[np.bool_], value: NDArray[Any]) -> NDArray[np.bool_]:
    return dones.reshape(-1, *(1,) * (value.ndim - 1))


def _rows(infos: dict[str, NDArray[Any]]) -> list[dict[str, Any]]:
    """Return the infos of each row."""
    listed = {name: value.tolist() if value.ndim == 1 else list(value) for name, value in infos.items()}
    names = [*listed]
    return [dict(zip(names, values, strict=True)) for values in zip(*listed.values(), strict=True)]
