"""Executors: who does the units of a suite. Which one did is provenance, never a difference in numbers."""

import multiprocessing
import os
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from threading import Thread
from typing import NamedTuple

from hhrl_bench.records import TimedResult
from hhrl_bench.units import Unit
from hhrl_envs import SCENARIOS, Simulator
from hhrl_envs.errors import InputError

ATTEMPTS = 3
"""How often a unit is begun whose process, or one beside it, has died."""


class Done(NamedTuple):
    """A unit and its outcome; where there is none, ``failure`` says why."""

    unit: Unit
    outcome: TimedResult | None
    failure: str = ""


def run_units(units: Sequence[Unit], workers: int) -> Iterator[Done]:
    """Return the units as they are done: by ``workers`` processes of this machine, or by this one if that is 1.

    Every process computes with one thread. A unit that fails does not keep the others from being done; one whose
    process dies is begun again, and goes on where it was if it trains.
    """
    if workers == 1:
        for unit in units:
            yield _attempt(unit)
        return
    _compile()
    waiting = list(units)
    for _ in range(ATTEMPTS):
        for done in _run_pool(waiting, workers):
            waiting.remove(done.unit)
            yield done
        if not waiting:
            return
    for unit in waiting:
        yield Done(unit, None, f"a worker process died {ATTEMPTS} times; is there enough memory?")


def _run_pool(units: Sequence[Unit], workers: int) -> Iterator[Done]:
    """Return the units as they are done, until there are no more, or a process has died."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(workers, len(units)), mp_context=context, initializer=_begin) as pool:
        try:
            for future in as_completed([pool.submit(_attempt, unit) for unit in units]):
                yield future.result()
        except BrokenProcessPool:
            return
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            while children := multiprocessing.active_children():
                for process in children:
                    process.terminate()
                    process.join()
            raise


def _attempt(unit: Unit) -> Done:
    try:
        return Done(unit, unit.run())
    except InputError as error:
        return Done(unit, None, str(error))
    except Exception as error:  # noqa: BLE001 - the other units go on, and this one is shown as failed
        return Done(unit, None, f"{type(error).__name__}: {error}")


def _begin() -> None:
    """Leave interrupts to the process that hands out the work, and end when that one is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _compile() -> None:
    """Compile the simulator once, so that the workers find it in the cache."""
    Simulator(next(iter(SCENARIOS)), 1).reset([0])
