"""Transitions: what every driven vehicle saw, did and got in every step, made again from the decisions."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hhrl_bench.evaluation.decisions import Trace, episodes_of, recordings
from hhrl_bench.evaluation.episodes import worst_outcome
from hhrl_bench.evaluation.paired_evaluation import BATCH_ROWS, evaluation_drivers, evaluation_slots
from hhrl_bench.evaluation.replay import require_fit
from hhrl_bench.evaluation.rollout import Rollout
from hhrl_bench.exports.episodes import Run, require_same_episodes
from hhrl_envs import Outcome, get_scenario
from hhrl_envs.arrays import Flags
from hhrl_envs.simulation.simulator import Results
from hhrl_envs.views.parallel_env import EGO


class VehicleSteps(NamedTuple):
    """What one vehicle saw and did in an episode of T steps, and what it got.

    Attributes:
        observations: float32 [T + 1, SIZE], before the first step and after each; once its own episode has ended, the
            last one.
        actions: levels, int64 [T]; 0 once its own episode has ended.
        rewards: r^task, float64 [T].
        options: the selected options, -1 where none is, int64 [T].
        reward_option, reward_action: of all options, float64 [T, K].
        outcomes: codes of ``Outcome`` after each step, int8 [T].
    """

    observations: NDArray[np.float32]
    actions: NDArray[np.int64]
    rewards: NDArray[np.float64]
    options: NDArray[np.int64]
    reward_option: NDArray[np.float64]
    reward_action: NDArray[np.float64]
    outcomes: NDArray[np.int8]

    @property
    def active(self) -> Flags:
        """In which steps it was an agent, bool [T]."""
        active: Flags = np.concatenate([[True], self.outcomes[:-1] == Outcome.RUNNING])
        return active

    @property
    def terminated(self) -> Flags:
        """In which step its episode terminated, bool [T]."""
        terminated: Flags = self.active & (self.outcomes != Outcome.RUNNING) & (self.outcomes != Outcome.TIMEOUT)
        return terminated

    @property
    def truncated(self) -> Flags:
        """In which step its episode was truncated, bool [T]."""
        truncated: Flags = self.active & (self.outcomes == Outcome.TIMEOUT)
        return truncated


def agent_names(run: Run) -> tuple[str, ...]:
    """Return the names of the vehicles that are driven by agents, as PettingZoo's view has them; the ego first."""
    return (EGO, *(f"front_{slot}" for slot in range(1, run.trace.actions.shape[1])))


def transitions(run: Run) -> Iterator[tuple[int, Mapping[str, VehicleSteps]]]:
    """Yield the seed of the world, and the steps of every vehicle that is driven, of every episode.

    Raises:
        RecordError: if the decisions do not come to the run's episodes.
    """
    task, count = run.task, len(run.outcome)
    require_fit(run.trace, evaluation_drivers(task), count, get_scenario(task.scenario))
    for first in range(0, count, BATCH_ROWS):
        part = slice(first, min(first + BATCH_ROWS, count))
        yield from zip(map(int, run.worlds[part]), _steps(run, episodes_of(run.trace, part), part), strict=True)


def _steps(run: Run, trace: Trace, part: slice) -> Iterator[Mapping[str, VehicleSteps]]:
    """Yield the steps of every vehicle in the episodes of a batch."""
    task, names, slots = run.task, agent_names(run), evaluation_slots(run.task)
    agent, drivers = recordings(trace, slots)
    rollout = Rollout(agent, get_scenario(task.scenario), run.worlds[part], drivers=drivers)
    seen = [[rollout.simulator.of_agent(slot)] for slot in range(len(names))]
    driven, options = [], []
    for step in rollout:
        driven.append(step.driven.reshape(len(trace.steps), -1))
        options.append(step.option.reshape(len(trace.steps), -1))
        for slot, results in enumerate(seen):
            results.append(step.simulator.of_agent(slot))
    own = rollout.simulator.agent_outcomes[:, list(slots)]
    require_same_episodes(run, part, worst_outcome(own), rollout.simulator.steps)
    decided, chosen = np.stack(driven), np.full((len(driven), len(trace.steps), len(names)), -1, np.int64)
    chosen[:, :, list(slots)] = np.stack(options)
    for row, length in enumerate(trace.steps):
        yield {
            name: _vehicle(seen[slot], decided[:, row, slot], chosen[:, row, slot], row, int(length))
            for slot, name in enumerate(names)
        }


def _vehicle(
    results: Sequence[Results], actions: NDArray[np.int64], options: NDArray[np.int64], row: int, length: int
) -> VehicleSteps:
    def of(name: str, first: int = 1) -> NDArray[Any]:
        return np.stack([getattr(one, name)[row] for one in results[first : length + 1]])

    outcomes = of("outcomes")
    active = np.concatenate([[True], outcomes[:-1] == Outcome.RUNNING])
    last_seen = np.minimum(np.arange(length + 1), active.sum())
    return VehicleSteps(
        observations=of("observations", 0)[last_seen],
        actions=np.where(active, actions[:length], 0),
        rewards=of("rewards"),
        options=np.where(active, options[:length], -1),
        reward_option=of("reward_option"),
        reward_action=of("reward_action"),
        outcomes=outcomes,
    )
