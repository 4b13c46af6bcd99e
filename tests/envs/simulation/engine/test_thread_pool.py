import gc
import threading

import pytest

from hhrl_envs.simulation.engine.thread_pool import Workers


def test_every_call_is_run_and_only_one_of_them_here() -> None:
    here, together = threading.get_ident(), threading.Barrier(3)

    def run(number: int) -> tuple[int, bool]:
        together.wait(timeout=10)  # breaks unless all three run at once
        return number, threading.get_ident() == here

    told = Workers(2).run(run, [(0,), (1,), (2,)])
    assert sorted(number for number, _ in told) == [0, 1, 2]
    assert [own for _, own in told].count(True) == 1


def test_nobody_waits_for_a_thread_that_is_busy_elsewhere() -> None:
    workers, free = Workers(1), threading.Event()
    busy = threading.Thread(target=lambda: workers.run(lambda _: free.wait(timeout=60), [(0,), (1,)]))
    busy.start()
    assert sorted(workers.run(lambda number: number, [(number,) for number in range(5)])) == [0, 1, 2, 3, 4]
    free.set()
    busy.join()


@pytest.mark.parametrize("wrong", [0, 1])
def test_an_error_in_any_call_is_raised_and_leaves_the_workers_usable(wrong: int) -> None:
    workers = Workers(1)

    def run(number: int) -> int:
        if number == wrong:
            raise ValueError(number)
        return number

    with pytest.raises(ValueError, match=str(wrong)):
        workers.run(run, [(0,), (1,)])
    assert sorted(workers.run(run, [(2,), (3,)])) == [2, 3]


def test_the_threads_end_with_the_object() -> None:
    before = set(threading.enumerate())
    workers = Workers(2)
    threads = set(threading.enumerate()) - before
    assert len(threads) == 2
    del workers
    gc.collect()
    for thread in threads:
        thread.join(timeout=10)
    assert not any(thread.is_alive() for thread in threads)
