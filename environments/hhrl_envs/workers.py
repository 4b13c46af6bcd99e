"""Threads that share the work of one step; a handover costs some 20 us, half of what futures cost."""

from collections.abc import Callable, Sequence
from queue import SimpleQueue
from threading import Thread
from typing import Any
from weakref import finalize

Call = tuple[Any, ...]
Task = tuple[Callable[..., Any], Call, "SimpleQueue[Any]"]


class Workers:
    """``count`` threads beside the caller's, which end with this object."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._tasks: SimpleQueue[Task | None] = SimpleQueue()
        for _ in range(count):
            Thread(target=_work, args=(self._tasks,), daemon=True).start()
            finalize(self, self._tasks.put, None)

    def __reduce__(self) -> tuple[type["Workers"], tuple[int]]:
        """Return how to copy or unpickle them: as new threads, for what they do is over between two calls."""
        return Workers, (self._count,)

    def run(self, function: Callable[..., Any], calls: Sequence[Call]) -> list[Any]:
        """Return what ``function`` returns for the arguments of each call, in any order; the first call is run here.

        An error in any of them is raised once the own call is done.
        """
        own, *others = calls
        told: SimpleQueue[Any] = SimpleQueue()
        for call in others:
            self._tasks.put((function, call, told))
        results = [function(*own), *(told.get() for _ in others)]
        for result in results:
            if isinstance(result, BaseException):
                raise result
        return results


def _work(tasks: "SimpleQueue[Task | None]") -> None:
    while (task := tasks.get()) is not None:
        function, call, told = task
        try:
            told.put(function(*call))
        except BaseException as error:  # noqa: BLE001  (the caller raises it)
            told.put(error)
