"""The environments of a learner, stepped together."""

from collections.abc import Mapping

import numpy as np

from hhrl_agents.agent import ACTION, LEVELS, NO_ACTION, OPTION
from hhrl_agents.methods.method import Method
from hhrl_agents.policies.observation_memory import Traces
from hhrl_agents.replay.buffer import Transitions
from hhrl_agents.stateful import Stateful
from hhrl_agents.training.drivers import Drivers
from hhrl_envs import Outcome, Scenario
from hhrl_envs.arrays import Flags, Floats, Floats32, Ints, Keys
from hhrl_envs.errors import InputError
from hhrl_envs.simulation.rewards import TIMEOUT, UNSMOOTH
from hhrl_envs.simulation.simulator import Results


class Environments:
    """`n_envs` environments, whose learning vehicles all learn alike.

    An environment begins its next episode when those of all its learning vehicles have ended; until then the ones that
    have ended wait.

    method: how many environments there are, what is remembered of observations, and what is rewarded; world_seeds:
    uint64 [n_envs]; drivers: which vehicles learn, and who drives the others.

    Attributes:
        width: learning vehicles, n = n_envs x the slots that learn, those of an environment side by side.
        features: what the networks read now, float32 [n, features].
        outcome_counts: episodes of vehicles that ended since `clear_counts`, int64 [outcomes].
    """

    def __init__(self, method: Method, scenario: Scenario, world_seeds: Keys, drivers: Drivers) -> None:
        require_world_seeds(world_seeds, method.config.n_envs)
        self._method, self._drivers = method, drivers
        self.width = method.config.n_envs * len(drivers.slots)
        self._simulator = drivers.simulator(scenario, world_seeds.size)
        self._simulator.reset(world_seeds)
        self._memory = Traces(method.config.memory)
        self._begin(np.ones(self._simulator.num_rows, np.bool_))
        self._results = drivers.results(self._simulator)
        self.features = self._observe(None)
        self.clear_counts()

    def step(self, options: Ints, actions: Ints) -> tuple[Transitions, Flags]:
        """Return what a step of every vehicle came to, and whose episode is over, bool [n].

        options, actions: int64 [n]. The action of a vehicle that waits is `NO_ACTION` in what comes back. The next
        observations are those before any new episode begins.
        """
        simulator, features, waited = self._simulator, self.features, self._ended()
        simulator.step(self._drivers.actions(simulator, actions))
        self._results = results = self._drivers.results(simulator)
        ended = self._ended()
        step = Transitions(
            features,
            options,
            np.where(waited, NO_ACTION, actions),
            learning_rewards(self._method, results, options),
            discounts(self._method, results),
            self._observe(None),
        )
        self._count(ended & ~waited)
        self._next_episodes(ended)
        return step, ended

    def clear_counts(self) -> None:
        """Count outcomes from zero."""
        self.outcome_counts: Ints = np.zeros(len(Outcome), np.int64)

    def parts(self) -> Mapping[str, Stateful]:
        """Return what a learner has to save of the environments, by its name; after `restore`, call `refresh`."""
        others = {f"other-{slot}": agent for slot, agent in self._drivers.others.items()}
        remembering = {name: agent for name, agent in others.items() if isinstance(agent, Stateful)}
        return {"simulator": self._simulator, "memory": self._memory, **remembering}

    def refresh(self) -> None:
        """Make `features` anew from parts that were restored."""
        self._results = self._drivers.results(self._simulator)
        self.features = self._observe(np.zeros(len(self._results.outcomes), np.bool_))

    def _next_episodes(self, ended: Flags) -> None:
        over: Flags = np.all(ended.reshape(self._simulator.num_rows, -1), axis=1, keepdims=False)
        self._simulator.next_episode(over)
        self._results = self._drivers.results(self._simulator)
        self.features = self._observe(self._begin(over))

    def _begin(self, rows: Flags) -> Flags:
        """Return which vehicles begin an episode with these rows and tell them to the memory and the other drivers."""
        begun = np.repeat(rows, len(self._drivers.slots))
        self._memory.begin(begun)
        self._drivers.begin(rows)
        return begun

    def _ended(self) -> Flags:
        ended: Flags = self._results.outcomes != Outcome.RUNNING
        return ended

    def _observe(self, vehicles: Flags | None) -> Floats32:
        """Return what the networks read, [n, features], after memory has seen the new ones of `vehicles`."""
        return np.array(self._memory.observe(self._results.observations, vehicles), order="C")

    def _count(self, ended: Flags) -> None:
        self.outcome_counts += np.bincount(self._results.outcomes[ended], minlength=len(Outcome))


def require_world_seeds(world_seeds: Keys, n_envs: int) -> None:
    """Raise an `InputError` unless there is a world for each environment, [n_envs]."""
    if np.shape(world_seeds) != (n_envs,):
        raise InputError(f"world_seeds have shape {np.shape(world_seeds)}; write {(n_envs,)}")


def learning_rewards(method: Method, results: Results, options: Ints) -> Floats:
    """Return the scaled rewards of both levels for the last step, float64 [B, levels], given the selected options [B].

    results: what the agents that learn got from that step.

    With the hybrid reward they are r^option and r^action of the selected option, otherwise r^task twice. Algorithm 2
    (`credit`) is the other way round: a failure of the selected sub-goal is the option's fault, of the other one the
    action's. The penalty for unsmoothness, part of r^task and r^action, counts for `jerk_weight`. Where a time limit
    counts as truncation its penalty, part of all of them, is left out.
    """
    unsmooth = results.terms[:, UNSMOOTH]
    rewards = np.empty((len(unsmooth), len(LEVELS)))
    if method.hybrid_reward:
        rows = np.arange(len(unsmooth))
        rewards[:, OPTION] = results.reward_option[rows, options]
        rewards[:, ACTION] = results.reward_action[rows, options]
        if method.config.credit == "algorithm-2":
            rewards = rewards[:, ::-1] + np.stack((-unsmooth, unsmooth), axis=1)
    else:
        rewards[:] = results.rewards[:, None]
    excess = (1.0 - method.config.jerk_weight) * unsmooth
    rewards -= np.stack((np.zeros_like(excess) if method.hybrid_reward else excess, excess), axis=1)
    if method.config.timeout == "truncation":
        rewards -= results.terms[:, TIMEOUT, None]
    scaled: Floats = rewards * method.config.reward_scale
    return scaled


def discounts(method: Method, results: Results) -> Floats:
    """Return what the value of the next state is multiplied with, float64 [B]: gamma, or 0 after a terminal step."""
    ongoing = results.outcomes == Outcome.RUNNING
    if method.config.timeout == "truncation":
        ongoing |= results.outcomes == Outcome.TIMEOUT
    return np.where(ongoing, method.config.gamma, 0.0)
