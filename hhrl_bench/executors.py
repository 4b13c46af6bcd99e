"""Executors: who does the units of a suite. Which one did is provenance, never a difference in numbers."""

from collections import Counter, deque
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from typing import Final, Literal

from hhrl_bench.attempts import Done
from hhrl_bench.board import Board
from hhrl_bench.local_pool import LocalPool
from hhrl_bench.overseer import Overseer
from hhrl_bench.pools import Here, Pool
from hhrl_bench.ray_pool import RayPool
from hhrl_bench.units import Unit
from hhrl_envs import SCENARIOS, Simulator

ATTEMPTS = 3
"""How often a unit is begun whose worker is lost or stalls."""

TICK = 0.2
"""Seconds after which the overseer may look at the board, though no unit has ended."""


@dataclass(frozen=True, slots=True)
class Execution:
    """Who does the units.

    Attributes:
        executor: processes of this machine, or a Ray cluster.
        workers: how many processes of this machine; 1: this one itself, unless units have to be timed.
        address: of the cluster; see :class:`hhrl_bench.ray_pool.RayPool`.
        patience: seconds without a word of a unit after which its worker is ended; None: any.
    """

    executor: Literal["local", "ray"] = "local"
    workers: int = 1
    address: str | None = None
    patience: float | None = None

    @contextmanager
    def pool(self, board: Board | None = None) -> Iterator[Pool]:
        """Return a context with a pool, of which nothing is left after it."""
        with closing(self._pool(board)) as pool:
            yield pool

    def _pool(self, board: Board | None) -> Pool:
        if self.executor == "ray":
            return RayPool(self.address, board)
        if self.workers == 1 and self.patience is None:
            return Here(board)
        Simulator(next(iter(SCENARIOS)), 1).reset([0])  # compiled once, so that the workers find it in the cache
        return LocalPool(self.workers, board)


HERE: Final = Execution()


def run_units(units: Sequence[Unit], pool: Pool, overseer: Overseer | None = None) -> Iterator[Done]:
    """Return the units as the pool has done them.

    A unit that fails does not keep the others from being done; one whose worker is lost, or has stalled and is ended,
    is begun ``ATTEMPTS`` times at most, and goes on where it was if it trains.
    """
    waiting, begun = deque(units), Counter[str]()
    while waiting or pool.running:
        while waiting and pool.free > 0:
            unit = waiting.popleft()
            begun[unit.name] += 1
            if overseer and begun[unit.name] > 1:
                overseer.begin_again(unit.name)
            pool.begin(unit)
        for done in pool.wait(TICK):
            if done.lost and begun[done.unit.name] < ATTEMPTS:
                waiting.append(done.unit)
            else:
                yield _given_up(done) if done.lost else done
        if overseer:
            _oversee(pool, overseer)


def _given_up(done: Done) -> Done:
    return done._replace(failure=f"given up after {ATTEMPTS} attempts: {done.failure}")


def _oversee(pool: Pool, overseer: Overseer) -> None:
    """End the workers of the units that have stalled."""
    stalled = set(overseer.look([unit.name for unit in pool.running]))
    for unit in [unit for unit in pool.running if unit.name in stalled]:
        pool.stop(unit, "it said nothing for longer than --unit-timeout allows")
