"""Threads that share the work of one step: the caller takes pieces from the first on, the others from the last on.

To wake a thread takes some 30 us; what a late one finds done it leaves alone.
As all begin where they began before, what they need is still in the caches of their cores.
"""

from collections import deque
from collections.abc import Callable, Sequence
from queue import SimpleQueue
from threading import Thread
from typing import Any
from weakref import finalize

Call = tuple[Any, ...]


class _Work:
    """Calls of one function that several threads take from, and what they returned or raised."""

    def __init__(self, function: Callable[..., Any], calls: Sequence[Call]) -> None:
        left = deque(calls)
        self._function, self._count, self.from_first, self.from_last = function, len(calls), left.popleft, left.pop
        self._results: SimpleQueue[Any] = SimpleQueue()

    def do_calls(self, take: Callable[[], Call]) -> None:
        """Do calls, taken ``from_first`` or ``from_last`` on, until none is left."""
        while True:
            try:
                call = take()
            except IndexError:
                return
            try:
                self._results.put(self._function(*call))
            except BaseException as error:  # noqa: BLE001  (the caller raises it)
                self._results.put(error)

    def results(self) -> list[Any]:
        """Return what all calls returned, in any order, once they are done; an error in any of them is raised."""
        results = [self._results.get() for _ in range(self._count)]
        for result in results:
            if isinstance(result, BaseException):
                raise result
        return results


class Workers:
    """``count`` threads beside the caller's, which end with this object."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._tasks: SimpleQueue[_Work | None] = SimpleQueue()
        for _ in range(count):
            Thread(target=_work, args=(self._tasks,), daemon=True).start()
            finalize(self, self._tasks.put, None)

    def __reduce__(self) -> tuple[type["Workers"], tuple[int]]:
        """Return how to copy or unpickle them: as new threads, for what they do is over between two calls."""
        return Workers, (self._count,)

    def run(self, function: Callable[..., Any], calls: Sequence[Call]) -> list[Any]:
        """Return what ``function`` returns for the arguments of each call, in any order.

        An error in any of them is raised once all are done.
        """
        work = _Work(function, calls)
        for _ in range(self._count):
            self._tasks.put(work)
        work.do_calls(work.from_first)
        return work.results()


def _work(tasks: "SimpleQueue[_Work | None]") -> None:
    while (work := tasks.get()) is not None:
        work.do_calls(work.from_last)
