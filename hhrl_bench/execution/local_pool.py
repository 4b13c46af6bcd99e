"""The local pool: worker processes of this machine, each of which does one unit after the other with one thread."""

import multiprocessing
import os
import signal
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from threading import Thread

from hhrl_bench.execution.progress_board import Board
from hhrl_bench.execution.unit import Done, Unit, attempt

_CONTEXT = multiprocessing.get_context("spawn")
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class LocalPool:
    """Up to ``workers`` processes, begun when they are first needed; see :class:`hhrl_bench.execution.pool.Pool`."""

    def __init__(self, workers: int, board: Board | None = None) -> None:
        self._board, self._workers = board, workers
        self._idle: list[Worker] = []
        self._busy: dict[Connection, Worker] = {}

    @property
    def free(self) -> int:
        """How many workers have nothing to do."""
        return self._workers - len(self._busy)

    @property
    def running(self) -> Collection[Unit]:
        """The units that workers are doing."""
        return [worker.unit for worker in self._busy.values() if worker.unit]

    def begin(self, unit: Unit) -> None:
        """Return nothing; give the unit to a worker that is idle, or to a new one."""
        with _interrupts_kept():  # until the process that is begun is one that we know of
            worker = self._idle_worker() or Worker(self._board)
            self._busy[worker.pipe] = worker
        worker.take(unit)

    def wait(self, seconds: float) -> list[Done]:
        """Return the units that have ended, and those whose worker has died as lost."""
        return [self._ended(self._busy.pop(pipe)) for pipe in wait(list(self._busy), seconds) if pipe in self._busy]

    def stop(self, unit: Unit, reason: str) -> None:
        """Return nothing; end the worker of a unit."""
        for worker in self._busy.values():
            if worker.unit is unit:
                worker.reason = reason
                worker.process.kill()

    @property
    def workers(self) -> list["Worker"]:
        """The workers that there are."""
        return [*self._idle, *self._busy.values()]

    def close(self) -> None:
        """Return nothing; end all workers."""
        for worker in self.workers:
            worker.end()
        self._idle, self._busy = [], {}

    def _idle_worker(self) -> "Worker | None":
        """Return an idle worker, and end those that have died meanwhile; None if there is none."""
        while self._idle:
            worker = self._idle.pop()
            if worker.process.is_alive():
                return worker
            worker.end()
        return None

    def _ended(self, worker: "Worker") -> Done:
        done = worker.receive()
        if done.lost:
            worker.end()
        else:
            self._idle.append(worker)
        return done


class Worker:
    """A process, the pipe to it, the unit that it is doing, and why it was ended, if it was."""

    def __init__(self, board: Board | None) -> None:
        self.pipe, there = _CONTEXT.Pipe()
        self.process = _CONTEXT.Process(target=_work, args=(there, board), daemon=True)
        with _environment(_ONE_THREAD):
            self.process.start()
        there.close()
        self.unit: Unit | None = None
        self.reason = ""

    def take(self, unit: Unit) -> None:
        """Return nothing; send it the unit."""
        self.unit, self.reason = unit, ""
        with suppress(OSError):  # it has died, which is found when its answer is read
            self.pipe.send(unit)

    def receive(self) -> Done:
        """Return the unit as it has ended, lost if the process has died."""
        assert self.unit is not None
        unit, self.unit = self.unit, None
        try:
            done: Done = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            return Done(unit, None, self.reason or _fate(self.process.exitcode or 0), lost=True)
        return done._replace(unit=unit)

    def end(self) -> None:
        """Return when the process has ended, whatever it was doing."""
        self.process.kill()
        self.process.join()
        self.process.close()
        self.pipe.close()


def _work(pipe: Connection, board: Board | None) -> None:
    """Do the units that come through the pipe; interrupts are left to the process that hands them out."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError):  # nobody is there any more
        while True:
            pipe.send(attempt(pipe.recv(), board))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _fate(exitcode: int) -> str:
    if exitcode < 0:
        hint = "; is there enough memory?" if exitcode == -signal.SIGKILL else ""
        return f"its worker process was killed by signal {-exitcode}{hint}"
    return f"its worker process left with exit code {exitcode}"


@contextmanager
def _interrupts_kept() -> Iterator[None]:
    """Return a context after which an interrupt that came in it is raised; processes begun in it have none."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # beginning it with the first worker would let interrupts in again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _environment(variables: dict[str, str]) -> Iterator[None]:
    """Return a context in which these variables of the environment are set."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
