"""Pools: the processes that do units. They are this one, others of this machine, or those of a Ray cluster."""

import os
import signal
import socket
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from functools import cache
from multiprocessing import parent_process
from multiprocessing.context import SpawnContext, SpawnProcess
from pathlib import Path
from threading import Thread
from typing import Any

from hhrl_bench.errors import ClusterError, LostWorkerError
from hhrl_bench.execution.progress_folder import ProgressFolder
from hhrl_bench.execution.unit import Done, Unit, attempt
from hhrl_bench.extensions import VARIABLE, load_extensions
from hhrl_bench.provenance import software
from hhrl_envs import SCENARIOS, Simulator
from hhrl_envs.errors import InputError, require

MAX_RAY_UNITS = 10_000
"""Units that a Ray cluster has at a time; it begins as many of them as it has cores."""

_THREAD_COUNTS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class LostError(Exception):
    """The process that did a unit is gone; the message says how."""


class Pool(ABC):
    """Processes that do up to ``size`` units at a time; ``folder`` is where they write how far these are."""

    def __init__(self, size: int, folder: ProgressFolder | None = None) -> None:
        self._size, self._folder = size, folder
        self._units: dict[Future[Done], Unit] = {}
        self._reasons: dict[Future[Done], str] = {}

    @property
    def free(self) -> int:
        """How many more units the pool takes now."""
        return self._size - len(self._units)

    @property
    def running(self) -> Collection[Unit]:
        """The units that the pool was given and has not returned."""
        return self._units.values()

    def begin(self, unit: Unit) -> None:
        """Give the pool a unit to do."""
        self._units[self._submit(unit)] = unit

    def wait(self, seconds: float) -> list[Done]:
        """Return the units that have ended: at once if there are some, else after at most these seconds."""
        wait(self._units, seconds, FIRST_COMPLETED)
        return [self._take(future) for future in list(self._units) if future.done()]

    def stop(self, unit: Unit, reason: str) -> None:
        """Kill the process that does a unit, which is then lost for this reason."""
        for future in [future for future, one in self._units.items() if one is unit]:
            self._reasons[future] = reason
            self._kill(future)

    def _take(self, future: Future[Done]) -> Done:
        unit, reason = self._units.pop(future), self._reasons.pop(future, "")
        try:
            return self._result(unit, future)._replace(unit=unit)
        except LostError as error:
            return Done(unit, None, reason or str(error), lost=True)

    @abstractmethod
    def _submit(self, unit: Unit) -> Future[Done]:
        """Return the future of what a process that is free makes of the unit."""

    @abstractmethod
    def _result(self, unit: Unit, future: Future[Done]) -> Done:
        """Return what became of a unit whose future is done; raise a ``LostError`` if its process is gone."""

    @abstractmethod
    def _kill(self, future: Future[Done]) -> None:
        """Kill the process that works on a future."""

    @abstractmethod
    def close(self) -> None:
        """Kill all processes of the pool, whatever they do."""


class SerialPool(Pool):
    """This process itself, which does a unit at once and cannot be stopped from outside."""

    def __init__(self, folder: ProgressFolder | None = None) -> None:
        super().__init__(1, folder)

    def _submit(self, unit: Unit) -> Future[Done]:
        future: Future[Done] = Future()
        future.set_result(attempt(unit, self._folder))
        return future

    def _result(self, unit: Unit, future: Future[Done]) -> Done:
        return future.result()

    def _kill(self, future: Future[Done]) -> None:
        pass

    def close(self) -> None:
        """Do nothing: there is no process to kill."""


class LocalPool(Pool):
    """Up to ``size`` processes of this machine, with one thread each, that begin when they are first needed.

    Each is an executor of its own, so that one that dies takes no other's unit with it.
    """

    def __init__(self, size: int, folder: ProgressFolder | None = None) -> None:
        super().__init__(size, folder)
        self._idle: list[_Worker] = []
        self._busy: dict[Future[Done], _Worker] = {}

    def _submit(self, unit: Unit) -> Future[Done]:
        worker = self._idle_worker()
        with _interrupts_held(), _one_thread_each():
            future = worker.executor.submit(attempt, unit, self._folder)
            self._busy[future] = worker
        return future

    def _idle_worker(self) -> "_Worker":
        """Return a worker that has nothing to do, a new one if need be."""
        while self._idle:
            worker = self._idle.pop()
            if worker.is_alive():
                return worker
            worker.close()
        return _Worker()

    def _result(self, unit: Unit, future: Future[Done]) -> Done:
        worker = self._busy.pop(future)
        try:
            done = future.result()
        except (BrokenProcessPool, SystemExit) as error:
            worker.close()
            raise LostError(_fate(error.code if isinstance(error, SystemExit) else worker.exit_code)) from error
        self._idle.append(worker)
        return done

    def _kill(self, future: Future[Done]) -> None:
        self._busy[future].kill()

    def close(self) -> None:
        """Kill all processes."""
        workers = [*self._idle, *self._busy.values()]
        for worker in workers:
            worker.kill()
        for worker in workers:
            worker.close()
        self._idle, self._busy, self._units = [], {}, {}


class _Worker:
    """An executor of one process, which begins with its first unit."""

    def __init__(self) -> None:
        self._context = _KnownProcess()
        self.executor = ProcessPoolExecutor(1, self._context, _begin_worker)

    @property
    def exit_code(self) -> int | None:
        """The exit code of the process, if it has ended."""
        return self._context.process.exitcode

    def is_alive(self) -> bool:
        """Return whether the process still runs."""
        return self._context.process.is_alive()

    def kill(self) -> None:
        """Kill the process."""
        self._context.process.kill()

    def close(self) -> None:
        """Kill the process and wait until it has ended."""
        self.kill()
        self.executor.shutdown()


class _KnownProcess(SpawnContext):
    """A context that knows the process that an executor has begun in it."""

    process: SpawnProcess

    def Process(self, *args: Any, **kwargs: Any) -> SpawnProcess:  # type: ignore[override]  # noqa: N802
        self.process = SpawnProcess(*args, **kwargs)
        return self.process


Each = Callable[..., Iterator[Any]]
"""What calls a function with the items of iterables side by side, as ``map`` does, and returns what comes in order."""


@contextmanager
def mapping(jobs: int) -> Iterator[Each]:
    """Return a context with a ``map`` that works in so many processes of this machine; in this one if it is 1.

    What is mapped, and what comes of it, goes through pipes. The processes have one thread each, and end with the
    context.

    Raises:
        LostWorkerError: from the ``map``, if one of the processes has been killed.
    """
    if jobs == 1:
        yield map
        return
    Simulator(next(iter(SCENARIOS)), 1).reset([0])  # compiled once, so that the workers find it in the cache
    context = _KnownProcesses()
    executor = ProcessPoolExecutor(jobs, context, _begin_worker)

    def each(function: Callable[..., Any], *iterables: Iterable[Any]) -> Iterator[Any]:
        with _interrupts_held(), _one_thread_each():
            results = executor.map(function, *iterables)
        return _whole(results)

    try:
        yield each
    finally:
        for process in context.processes:
            process.kill()
        executor.shutdown(cancel_futures=True)


def _whole(results: Iterator[Any]) -> Iterator[Any]:
    try:
        yield from results
    except BrokenProcessPool as error:
        raise LostWorkerError("a worker process was killed; is there enough memory? ask for fewer --jobs") from error


class _KnownProcesses(SpawnContext):
    """A context that knows all processes that an executor has begun in it."""

    def __init__(self) -> None:
        super().__init__()
        self.processes: list[SpawnProcess] = []

    def Process(self, *args: Any, **kwargs: Any) -> SpawnProcess:  # type: ignore[override]  # noqa: N802
        process = SpawnProcess(*args, **kwargs)
        self.processes.append(process)
        return process


def _begin_worker() -> None:
    """Leave interrupts to the process that hands out the units, and end when that has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()
    with suppress(InputError):  # said again when a unit is attempted
        load_extensions()  # one of them may define the class of a unit that is to be read


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _fate(code: object) -> str:
    if isinstance(code, int) and code < 0:
        hint = "; is there enough memory?" if code == -signal.SIGKILL else ""
        return f"its worker process was killed by signal {-code}{hint}"
    return f"its worker process left with exit code {code}"


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Raise an interrupt that comes in this context after it; a process begun in the context gets none.

    The pool can then end every process that was begun. The queues of its executor have to be there before: making
    them begins multiprocessing's resource tracker, which would let interrupts in again.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Let the numeric libraries of a process that is begun in this context compute with one thread."""
    before = {name: os.environ.get(name) for name in _THREAD_COUNTS}
    os.environ.update(dict.fromkeys(_THREAD_COUNTS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


class RayPool(Pool):
    """The Ray cluster at ``address``, one thread a process; every node has to see the same folders.

    By default it is the cluster that this machine belongs to, or else one of this machine alone. Ray does not begin a
    unit again whose node or process is lost.
    """

    def __init__(self, address: str | None, folder: ProgressFolder | None) -> None:
        super().__init__(MAX_RAY_UNITS, folder)
        require("ray", "ray")
        import ray  # noqa: PLC0415

        if address and address not in {"auto", "local"}:
            _require_listener(address)
        try:
            ray.init(address, log_to_driver=False, logging_level="ERROR")
        except (ConnectionError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
            raise ClusterError(f"cannot join the Ray cluster: {error}; see docs/sweeps.md") from error
        self._ray = ray
        self._task = ray.remote(num_cpus=1, max_retries=0)(attempt_on_node)
        self._references: dict[Future[Done], Any] = {}

    def _submit(self, unit: Unit) -> Future[Done]:
        extensions = os.environ.get(VARIABLE, "")
        reference = self._task.remote(unit, self._folder, Path.cwd(), extensions, software())
        future: Future[Done] = reference.future()
        self._references[future] = reference
        return future

    def _result(self, unit: Unit, future: Future[Done]) -> Done:
        del self._references[future]
        errors = self._ray.exceptions
        try:
            return future.result()
        except errors.RayTaskError as error:
            return Done(unit, None, str(error.cause))
        except errors.RayError as error:
            raise LostError(f"its node or process was lost ({type(error).__name__})") from error

    def _kill(self, future: Future[Done]) -> None:
        self._ray.cancel(self._references[future], force=True)

    def close(self) -> None:
        """End what the cluster does for this process, and leave it."""
        for future in self._references:
            self._kill(future)
        self._ray.shutdown()


def _require_listener(address: str) -> None:
    """Raise a ``ClusterError`` if nobody listens there; Ray would wait for minutes and then end this process."""
    host, _, port = address.rpartition(":")
    try:
        socket.create_connection((host, int(port)), timeout=10.0).close()
    except (OSError, OverflowError, ValueError) as error:
        raise ClusterError(f"no Ray cluster answers at {address}; start one with: ray start --head") from error


def attempt_on_node(
    unit: Unit, folder: ProgressFolder | None, working: Path, extensions: str, versions: dict[str, str]
) -> Done:
    """Do a unit on a node, from the driver's working directory and with its extensions, if all is the same there."""
    try:
        os.chdir(working)
        os.environ[VARIABLE] = extensions
        load_extensions()
        _require_same(_software(), versions)
        if folder is not None:
            folder.study()
    except (OSError, InputError) as error:
        return Done(unit, None, f"node {socket.gethostname()}: {error}; all nodes need the same folders and versions")
    return attempt(unit, folder)


@cache
def _software() -> dict[str, str]:
    return software()


def _require_same(here: dict[str, str], there: dict[str, str]) -> None:
    for name in sorted({*here, *there}):
        if here.get(name) != there.get(name):
            raise ClusterError(f"{name} is {here.get(name)} here and {there.get(name)} where the suite was started")
