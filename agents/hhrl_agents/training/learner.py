"""What the learners of every algorithm share: how they are made, train, report, are saved, and hand out policies."""

import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from math import nan
from typing import Any

from hhrl_agents.methods.configs import SHARE
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import Parameters, Shapes, architectures
from hhrl_agents.networks.layers import ValueNetwork
from hhrl_agents.networks.parameters import Adam, Memory, ParameterSet
from hhrl_agents.policies.learned_agent import LearnedAgent, agent_metadata, make_agent
from hhrl_agents.seeding import Purpose, generator
from hhrl_agents.stateful import Stateful, gather, scatter
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.environments import Environments
from hhrl_agents.training.exploration import Explorer, level_choices
from hhrl_envs import Scenario
from hhrl_envs.arrays import Ints, Keys
from hhrl_envs.errors import InputError, require, require_value
from hhrl_envs.scenario.validation import check
from hhrl_envs.state import State, count, read_count


@dataclass(frozen=True)
class Progress:
    """What happened in training since the last report.

    Attributes:
        env_steps: environment steps so far.
        updates: gradient steps so far.
        losses: name -> mean loss since the last report; not a number without a gradient step.
        outcome_counts: training episodes that ended since the last report, int64 [6], by `hhrl_envs.Outcome`.
        diverged: why the learner thinks that it has diverged, if it does.
    """

    env_steps: int
    updates: int
    losses: dict[str, float]
    outcome_counts: Ints
    diverged: str | None = None


@dataclass(frozen=True, eq=False)
class Start:
    """What a training begins with, and which of its levels go on learning.

    Attributes:
        parameters: those that are taken over, name -> [1, in, out]; all others are drawn.
        fixed: levels, of those that the method learns, that stay as they are taken over.
        epsilon: share of random choices at the first step; it falls to the config's `final_epsilon`.
    """

    parameters: Parameters = field(default_factory=dict)
    fixed: tuple[str, ...] = ()
    epsilon: float = 1.0

    def __post_init__(self) -> None:
        """Refuse an epsilon that is no share."""
        check(self, "", epsilon=SHARE)

    def require_fit(self, method: Method, shapes: Shapes) -> None:
        """Check that the start is one for the method, whose networks have these `shapes`.

        Raises:
            InputError: if there are parameters that the networks do not have, or no level is left to learn.
        """
        for name, value in self.parameters.items():
            wanted = (1, *shapes[name]) if name in shapes else None
            if tuple(value.shape) != wanted:
                raise InputError(
                    f"parameter {name} of shape {tuple(value.shape)} does not fit method {method.id!r}, which has "
                    f"{wanted or 'no such parameter'}; start from a run of the same method"
                )
        left = set(method.levels) - set(self.fixed)
        if not left or not set(self.fixed) <= set(method.levels):
            raise InputError(
                f"levels {', '.join(self.fixed)} cannot stay fixed in method {method.id!r}, which learns "
                f"{' and '.join(method.levels)}; leave one to learn"
            )


NOTHING = Start()
"""The ordinary start: every parameter is drawn, every level learns."""


class Learner(ABC):
    """Trains one seed of a method.

    A subclass says how a round of environment steps and updates goes, what the policy's parameters are, and how
    episodes ended. Its constructor takes the arguments of `make_learner`.

    Attributes:
        method, scenario, seed: what is trained, where, and the seed of all random draws.
        config: the method's hyperparameters.
        env_steps: environment steps so far.
        updates: gradient steps so far.
        runs_in_threads: whether learners may run in threads beside each other.
        exact: whether the same training leaves the same bits on every machine.
    """

    runs_in_threads: bool = False
    exact: bool = False

    def __init__(self, method: Method, scenario: Scenario, seed: int, losses: Sequence[str]) -> None:
        self.method, self.scenario, self.seed = method, scenario, seed
        self.config: Any = method.config
        self.env_steps = self.updates = 0
        self._loss_names = losses
        self._clear_meters()

    def train(self, env_steps: int, schedule_steps: int | None = None) -> Iterator[Progress]:
        """Yield reports while training until `env_steps` are done in all, those before a `restore` among them.

        A report comes after the round that reaches a multiple of `report_every` environment steps, and at the end. The
        schedules of exploration and learning rate span `schedule_steps`, by default these `env_steps`, and stay as they
        are beyond. Both are rounded up to whole rounds of the `n_envs` environments.
        """
        span = schedule_steps or env_steps
        while (before := self.env_steps) < env_steps:
            self._advance(env_steps, span)
            last = self.env_steps >= env_steps
            if last or self.env_steps % self.config.report_every < self.env_steps - before:
                yield self._report()

    def policy(self) -> LearnedAgent:
        """Return the greedy policy as it is now, which later training does not change."""
        return make_agent(self.method, self.scenario, self._policy_parameters(), self._metadata())

    def state(self) -> State | None:
        """Return all that the training depends on, as it is at a report; None if this learner cannot be saved."""
        return None

    def restore(self, state: State) -> None:
        """Go on, bit for bit, where a learner made with the same arguments has been at `state`.

        Raises:
            InputError: if it is the state of another learner, or this learner cannot be saved.
        """
        raise InputError(f"a training by {self.method.algorithm} cannot go on from a state; train from the beginning")

    @abstractmethod
    def _advance(self, env_steps: int, span: int) -> None:
        """Take one round of environment steps and what is learned from them.

        `env_steps` is the whole budget, `span` are the steps over which exploration and learning rate change.
        """

    @abstractmethod
    def _policy_parameters(self) -> Parameters:
        """Return a copy of all parameters that the policy consists of."""

    @abstractmethod
    def _take_outcome_counts(self) -> Ints:
        """Return the episodes that ended, int64 [outcomes], since the last call."""

    def _diverged(self) -> str | None:
        """Return in words why the learner has diverged, if it has."""
        return None

    def _metadata(self) -> dict[str, Any]:
        return agent_metadata(self.method, self.scenario, self.seed, self.env_steps, exact=self.exact)

    def _add_losses(self, losses: Iterable[float]) -> None:
        """Add what was measured once of every loss, in the order of their names, to the next report."""
        self._loss_count += 1
        for name, loss in zip(self._loss_names, losses, strict=True):
            self._losses[name] += float(loss)

    def _report(self) -> Progress:
        count = self._loss_count or nan
        losses = {name: total / count for name, total in self._losses.items()}
        report = Progress(self.env_steps, self.updates, losses, self._take_outcome_counts(), self._diverged())
        self._clear_meters()
        return report

    def _clear_meters(self) -> None:
        self._loss_count = 0
        self._losses = dict.fromkeys(self._loss_names, 0.0)

    def _require_plain(self, drivers: Drivers, start: Start) -> None:
        """Refuse other vehicles than the ego and a start from parameters, for an algorithm that knows neither."""
        said = "one that learns by Double DQN, to drive other than the ego"
        require_value(drivers == EGO_ALONE, "method", repr(self.method.id), said)
        said = f"none: {self.method.algorithm} begins from nothing"
        require_value(start is NOTHING, "start", "a start from other parameters", said)


class ValueLearner(Learner):
    """A learner of action and option values in compiled code, exact to the bit on every processor.

    Attributes:
        parameters: those of all networks.
        levels: the names of the levels that learn.
    """

    exact = True

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        seed: int,
        world_seeds: Keys,
        drivers: Drivers = EGO_ALONE,
        start: Start = NOTHING,
    ) -> None:
        """Make environments, parameters, optimiser and explorers; for the arguments see `make_learner`."""
        self.levels = [level for level in method.levels if level not in start.fixed]
        super().__init__(method, scenario, seed, losses=self.levels)
        self._environments = Environments(method, scenario, world_seeds, drivers)
        self.runs_in_threads = not drivers.others  # which may be anybody's code
        networks = architectures(method, scenario.num_actions)
        self.parameters = ParameterSet(networks, generator(seed, Purpose.INITIALISATION))
        start.require_fit(method, self.parameters.shapes)
        self.parameters.take_over(start.parameters)
        online = self.parameters.online
        self._networks = {
            level: ValueNetwork(network, online, self.parameters.parts[level][0]) for level, network in networks.items()
        }
        self._adam = Adam(online.size)
        adam = self._adam
        self._memory = Memory(online, self.parameters.target, adam.gradient, adam.mean, adam.variance, adam.powers)
        stream, choices = generator(seed, Purpose.EXPLORATION), level_choices(scenario)
        width, hold = self._environments.width, self.config.exploration_hold
        self._explorers = [Explorer(stream, width, choices[level], hold) for level in self.levels]

    def state(self) -> State:
        """Return all that the training depends on; see `Learner.state`."""
        return {**gather(self._parts()), "env_steps": count(self.env_steps), "updates": count(self.updates)}

    def restore(self, state: State) -> None:
        """Go on where another learner has been; see `Learner.restore`."""
        scatter(self._parts(), state)
        self.env_steps, self.updates = read_count(state, "env_steps"), read_count(state, "updates")
        self._clear_meters()
        self._environments.refresh()

    def _parts(self) -> dict[str, Stateful]:
        """Return what has a state of its own, by the name before its entries in the learner's state."""
        return {
            "parameters": self.parameters,
            "optimiser": self._adam,
            **self._environments.parts(),
            **{f"explorer-{index}": explorer for index, explorer in enumerate(self._explorers)},
        }

    def _policy_parameters(self) -> Parameters:
        return self.parameters.snapshot()

    def _take_outcome_counts(self) -> Ints:
        counts = self._environments.outcome_counts
        self._environments.clear_counts()
        return counts


def make_learner(
    method: Method,
    scenario: Scenario,
    seed: int,
    world_seeds: Keys,
    drivers: Drivers = EGO_ALONE,
    start: Start = NOTHING,
) -> Learner:
    """Return the learner of the method's algorithm.

    method: what to train; scenario: the world to train in; seed: of all random draws; world_seeds: uint64 [n_envs], the
    worlds of its environments; drivers: which vehicles learn, and who drives the others; start: what it begins with.

    Raises:
        MissingExtraError: if the algorithm is a library's that is not installed.
        InputError: if the algorithm cannot train such vehicles or from such a start, or the start does not fit.
    """
    if method.config.extra is not None:
        require(*method.config.extra)
    make = pkgutil.resolve_name(method.config.learner)
    learner: Learner = make(method, scenario, seed, world_seeds, drivers, start)
    return learner
