"""What the learners of every algorithm share: how they are made, train, report, are saved, and hand out policies."""

import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch

from hhrl_agents.methods.configs import SHARE
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import Parameters, Shapes, method_shapes
from hhrl_agents.networks.parameters import Adam, ParameterStack
from hhrl_agents.policies.learned_agent import LearnedAgent, agent_metadata, make_agent
from hhrl_agents.seeding import Purpose, generators
from hhrl_agents.stateful import Stateful, gather, scatter
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.environments import StackedEnvironments
from hhrl_agents.training.exploration import Explorer, level_choices
from hhrl_envs import Scenario
from hhrl_envs.arrays import Floats, Ints, Keys
from hhrl_envs.errors import InputError, require, require_value
from hhrl_envs.scenario.validation import check
from hhrl_envs.state import State, count, read_count


@dataclass(frozen=True)
class Progress:
    """What happened in training since the last report, all counts for each seed.

    Attributes:
        env_steps: environment steps so far.
        updates: gradient steps so far.
        losses: name -> mean loss since the last report, float64 [E]; not a number without a gradient step.
        outcome_counts: training episodes that ended since the last report, int64 [E, 6], by `hhrl_envs.Outcome`.
        diverged: index of a seed -> why the learner thinks that it has diverged.
    """

    env_steps: int
    updates: int
    losses: dict[str, Floats]
    outcome_counts: Ints
    diverged: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Start:
    """What the seeds of a training begin with, and which of their levels go on learning.

    Attributes:
        parameters: for each seed the parameters that it takes over, name -> [1, in, out]; all others are drawn. Empty:
            every seed begins from nothing.
        fixed: levels, of those that the method learns, that stay as they are taken over.
        epsilon: share of random choices at the first step; it falls to the config's `final_epsilon`.
    """

    parameters: Sequence[Parameters] = ()
    fixed: tuple[str, ...] = ()
    epsilon: float = 1.0

    def __post_init__(self) -> None:
        """Refuse an epsilon that is no share."""
        check(self, "", epsilon=SHARE)

    def require_fit(self, method: Method, shapes: Shapes, seeds: Sequence[int]) -> None:
        """Check that the start is one for these seeds of the method, whose networks have these `shapes`.

        Raises:
            InputError: if there are parameters for other than these seeds, some that the networks do not have, or no
                level is left to learn.
        """
        if self.parameters and len(self.parameters) != len(seeds):
            raise InputError(
                f"a start for {len(self.parameters)} seeds does not fit {len(seeds)}; give one for each seed"
            )
        for name, value in (item for parameters in self.parameters for item in parameters.items()):
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
    """Trains E independent seeds of one method side by side.

    A subclass says how a round of environment steps and updates goes, what a seed's parameters are, and how episodes
    ended. Its constructor takes the arguments of `make_learner`. A seed's draws do not depend on the others.

    Attributes:
        method, scenario, seeds: what is trained, where, and the seed of all random draws of each learner.
        config: the method's hyperparameters.
        env_steps: environment steps so far, each seed's.
        updates: gradient steps so far, each seed's.
    """

    def __init__(self, method: Method, scenario: Scenario, seeds: Sequence[int], losses: Sequence[str]) -> None:
        self.method, self.scenario, self.seeds = method, scenario, tuple(seeds)
        self.config: Any = method.config
        self.env_steps = self.updates = 0
        self._loss_names = losses
        self._clear_meters()

    def train(self, env_steps: int) -> Iterator[Progress]:
        """Yield reports while training until `env_steps` are done in all, those before a `restore` among them.

        A report comes after the round that reaches a multiple of `report_every` environment steps, and at the end. The
        schedules of exploration and learning rate span these `env_steps`, which are each seed's, rounded up to whole
        rounds of its `n_envs` environments.
        """
        while (before := self.env_steps) < env_steps:
            self._advance(env_steps)
            last = self.env_steps >= env_steps
            if last or self.env_steps % self.config.report_every < self.env_steps - before:
                yield self._report()

    def policies(self) -> list[LearnedAgent]:
        """Return each seed's greedy policy as it is now, E agents that later training does not change."""
        return [
            make_agent(self.method, self.scenario, self._parameters(index), self._metadata(seed))
            for index, seed in enumerate(self.seeds)
        ]

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
    def _advance(self, env_steps: int) -> None:
        """Take one round of environment steps and what is learned from them; `env_steps` is the whole budget."""

    @abstractmethod
    def _parameters(self, index: int) -> Parameters:
        """Return a copy of all parameters that the policy of a seed consists of, given the seed's index."""

    @abstractmethod
    def _take_outcome_counts(self) -> Ints:
        """Return the episodes that ended, int64 [E, outcomes], since the last call."""

    def _diverged(self) -> dict[int, str]:
        """Return the indices of seeds that have diverged, each with the reason in words."""
        return {}

    def _metadata(self, seed: int) -> dict[str, Any]:
        metadata = agent_metadata(self.method, self.scenario, seed, self.env_steps)
        metadata["versions"]["torch"] = torch.__version__
        return metadata

    def _add_losses(self, losses: Iterable[Floats]) -> None:
        """Add what was measured once of every loss, in the order of their names, [E] each, to the next report."""
        self._loss_count += 1
        for name, loss in zip(self._loss_names, losses, strict=True):
            self._losses[name] += loss

    def _report(self) -> Progress:
        with np.errstate(invalid="ignore"):
            losses = {name: total / self._loss_count for name, total in self._losses.items()}
        report = Progress(self.env_steps, self.updates, losses, self._take_outcome_counts(), self._diverged())
        self._clear_meters()
        return report

    def _clear_meters(self) -> None:
        self._loss_count = 0
        self._losses = {name: np.zeros(len(self.seeds)) for name in self._loss_names}

    def _require_plain(self, drivers: Drivers, start: Start) -> None:
        """Refuse other vehicles than the ego and a start from parameters, for an algorithm that knows neither."""
        said = "one that learns by Double DQN, to drive other than the ego"
        require_value(drivers == EGO_ALONE, "method", repr(self.method.id), said)
        said = f"none: {self.method.algorithm} begins from nothing"
        require_value(start is NOTHING, "start", "a start from other parameters", said)


class StackedLearner(Learner):
    """A learner whose seeds are stacked into shared tensors, with environments and random generators of their own.

    The tensors are small: train with one torch thread, more only wait for each other.

    Attributes:
        stack: the parameters of all networks.
    """

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        seeds: Sequence[int],
        world_seeds: Keys,
        device: str = "cpu",
        drivers: Drivers = EGO_ALONE,
        start: Start = NOTHING,
    ) -> None:
        """Make environments, parameters, optimiser and explorers; for the arguments see `make_learner`."""
        levels = [level for level in method.levels if level not in start.fixed]
        super().__init__(method, scenario, seeds, losses=levels)
        self._environments = StackedEnvironments(method, scenario, len(seeds), world_seeds, drivers)
        shapes = method_shapes(method, scenario.num_actions)
        start.require_fit(method, shapes, seeds)
        self.stack = ParameterStack(shapes, generators(seeds, Purpose.INITIALISATION), torch.device(device))
        for index, parameters in enumerate(start.parameters):
            self.stack.take_over(index, parameters)
        parts = [self.stack.part(f"{level}.") for level in levels]
        self._optimiser = Adam(self.stack.flat, parts, self.config.max_gradient_norm)
        streams, choices = generators(seeds, Purpose.EXPLORATION), level_choices(scenario)
        width, hold = self._environments.width, self.config.exploration_hold
        self._explorers = [Explorer(streams, width, choices[level], hold) for level in levels]

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
            "parameters": self.stack,
            "optimiser": self._optimiser,
            **self._environments.parts(),
            **{f"explorer-{index}": explorer for index, explorer in enumerate(self._explorers)},
        }

    def _parameters(self, index: int) -> Parameters:
        return self.stack.snapshot(index)

    def _take_outcome_counts(self) -> Ints:
        counts = self._environments.outcome_counts
        self._environments.clear_counts()
        return counts


def make_learner(
    method: Method,
    scenario: Scenario,
    seeds: Sequence[int],
    world_seeds: Keys,
    device: str = "cpu",
    drivers: Drivers = EGO_ALONE,
    start: Start = NOTHING,
) -> Learner:
    """Return the learner of the method's algorithm.

    method: what to train; scenario: the world to train in; seeds: one for each of the E learners; world_seeds: uint64
    [E, n_envs], the worlds of its environments; device: where torch computes; drivers: which vehicles learn, and who
    drives the others; start: what the seeds begin with.

    Raises:
        MissingExtraError: if the algorithm is a library's that is not installed.
        InputError: if torch has no such device, the algorithm does not use it or cannot train such vehicles or from
            such a start, or the start does not fit.
    """
    require_device(device)
    if method.config.extra is not None:
        require(*method.config.extra)
    make = pkgutil.resolve_name(method.config.learner)
    learner: Learner = make(method, scenario, seeds, world_seeds, device, drivers, start)
    return learner


def require_device(device: str) -> None:
    """Check that torch can compute on the device.

    Raises:
        InputError: if it cannot.
    """
    try:
        torch.zeros(1, device=device).cpu()
    except (RuntimeError, AssertionError) as error:
        raise InputError(
            f"torch cannot compute on device {device!r}; write cpu, or cuda where there is a GPU"
        ) from error
