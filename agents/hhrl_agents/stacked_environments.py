"""The environments of E stacked seeds, stepped together: what learners of every algorithm learn from."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from hhrl_agents.base import BoolArray, Float32Array, IntArray
from hhrl_agents.learning_rewards import discounts, level_rewards
from hhrl_agents.memory import Traces
from hhrl_agents.methods import Method
from hhrl_agents.replay import Transitions
from hhrl_agents.saving import Stateful
from hhrl_envs import Outcome, Scenario, Simulator
from hhrl_envs.errors import InputError


class StackedEnvironments:
    """`n_envs` environments for each of E seeds, which begin their next episode when one has ended.

    method: how many environments a seed has, what is remembered of observations, and what is rewarded; num_seeds: E;
    world_seeds: uint64 [E, n_envs].

    Attributes:
        features: what the networks read now, float32 [E, n_envs, features].
        outcome_counts: episodes that ended since `clear_counts`, int64 [E, outcomes], by `hhrl_envs.Outcome`.
    """

    def __init__(self, method: Method, scenario: Scenario, num_seeds: int, world_seeds: npt.NDArray[np.uint64]) -> None:
        self._method, self._shape = method, (num_seeds, method.config.n_envs)
        if np.shape(world_seeds) != self._shape:
            raise InputError(f"world_seeds have shape {np.shape(world_seeds)}; write {self._shape}")
        self._simulator = Simulator(scenario, world_seeds.size)
        self._simulator.reset(world_seeds.reshape(-1))
        self._memory = Traces(method.config.memory)
        self._memory.begin(np.ones(world_seeds.size, np.bool_))
        self.features = self._observe(None)
        self.clear_counts()

    def step(self, options: IntArray, actions: IntArray) -> tuple[Transitions, BoolArray]:
        """Return what a step of every environment came to, and where it was an episode's last, bool [E, n_envs].

        options, actions: int64 [E, n_envs]. The next observations are those before any new episode begins.
        """
        simulator, shape = self._simulator, self._shape
        simulator.step(actions.reshape(-1))
        ended = simulator.outcomes != Outcome.RUNNING
        step = Transitions(
            self.features,
            options,
            actions,
            level_rewards(self._method, simulator, options.reshape(-1)).reshape(*shape, 2),
            discounts(self._method, simulator).reshape(shape),
            self._observe(None),
        )
        self._count_outcomes()
        simulator.reset_done()
        self._memory.begin(ended)
        self.features = self._observe(ended)
        return step, ended.reshape(shape)

    def clear_counts(self) -> None:
        """Return nothing; count outcomes from zero."""
        self.outcome_counts: IntArray = np.zeros((self._shape[0], len(Outcome)), np.int64)

    def parts(self) -> Mapping[str, Stateful]:
        """Return what a learner has to save of the environments, by its name; see `look` for what follows."""
        return {"simulator": self._simulator, "memory": self._memory}

    def look(self) -> None:
        """Return nothing; make `features` anew from parts that were restored."""
        self.features = self._observe(np.zeros(self._simulator.num_rows, np.bool_))

    def _observe(self, rows: BoolArray | None) -> Float32Array:
        """Return what the networks read, [E, n_envs, features], of all rows, after memory has seen the new `rows`."""
        return self._memory.observe(self._simulator.observations, rows).reshape(*self._shape, -1)

    def _count_outcomes(self) -> None:
        rows = np.flatnonzero(self._simulator.outcomes != Outcome.RUNNING)
        np.add.at(self.outcome_counts, (rows // self._shape[1], self._simulator.outcomes[rows]), 1)
