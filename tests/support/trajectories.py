"""The trajectory of one row of a simulator as bytes: all that moves and all that its agents get, over episodes."""

import hashlib
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from hhrl_envs import Outcome, Scenario, Simulator
from support.draws import stream, unit

HELD = 6


def chosen_level(seed: int, episode: int, step: int, agent: int, levels: int) -> int:
    """The level that an agent takes: a pure function of where it is, so that it is the same in every batch."""
    held = stream(np.uint64(seed), episode, step // HELD, agent)
    draw = unit(np.uint64(held), 0)
    return levels - 1 if draw < 0.2 else int(draw * levels)


def frames(simulator: Simulator) -> NDArray[np.float64]:
    """What every row gets at this moment, float64 [rows, ...]; float32 and integers fit in exactly."""
    parts = [simulator.terms, simulator.feasible[:, None], simulator.steps[:, None]]
    for agent in range(simulator.num_agents):
        own = simulator.of_agent(agent)
        one = (own.rewards[:, None], own.outcomes[:, None])
        parts += [own.observations, own.reward_option, own.reward_action, *one]
    whole: NDArray[np.float64] = np.concatenate(parts, axis=1, dtype=np.float64)
    return whole


class TrajectoryRecorder:
    """Records the ``watched`` rows of a simulator of these seeds, which ``change`` may tamper with before."""

    def __init__(
        self,
        scenario: Scenario,
        seeds: Sequence[int],
        watched: Iterable[int],
        fronts: int = 0,
        threads: int = 1,
        change: Callable[[Simulator], None] | None = None,
    ) -> None:
        self.watched, self.levels = list(watched), scenario.num_actions
        self.simulator = Simulator(scenario, len(seeds), threads, fronts)
        if change is not None:
            change(self.simulator)
        self.simulator.reset(seeds)
        self.recorded: list[list[bytes]] = [[] for _ in self.watched]

    def record(self, steps: int, autoreset: bool = True) -> list[bytes]:
        """Return ``steps`` frames of every watched row; without ``autoreset`` ended rows are reset by hand."""
        self._note(self.watched)
        for _ in range(steps):
            self.simulator.step(self._actions(), autoreset=autoreset)
            self._note(self.watched)
            if not autoreset:
                over = self._over()
                self.simulator.reset_done()
                self._note([row for row in self.watched if over[row]])
        return [b"".join(frames[:steps]) for frames in self.recorded]

    def _note(self, rows: Sequence[int]) -> None:
        now = frames(self.simulator)
        for row in rows:
            motion = self.simulator.vehicles(row).tobytes()
            self.recorded[self.watched.index(row)].append(now[row].tobytes() + motion)

    def _over(self) -> NDArray[np.bool_]:
        outcomes = [self.simulator.of_agent(agent).outcomes for agent in range(self.simulator.num_agents)]
        over: NDArray[np.bool_] = (np.stack(outcomes) != Outcome.RUNNING).all(axis=0)
        return over

    def _actions(self) -> NDArray[np.int64]:
        """Rows that nobody watches drive on at full throttle, so that they end at other times."""
        agents, steps = self.simulator.num_agents, self.simulator.steps
        chosen = np.full((len(steps), agents), self.levels - 1)
        for row in self.watched:
            at = (*self.simulator.key(row), int(steps[row]))
            chosen[row] = [chosen_level(*at, agent, self.levels) for agent in range(agents)]
        return chosen[:, 0] if agents == 1 else chosen


def digest(trajectories: list[bytes]) -> str:
    return hashlib.sha256(b"".join(trajectories)).hexdigest()
