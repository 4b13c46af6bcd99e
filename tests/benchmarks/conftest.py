"""Systems measured in turns in one run, and the table of their ratios at its end.

Absolute figures drift with the machine; the ratio is what to quote. Each round times the peer and then ours, and the
quickest round of each counts. Nothing is asserted: a bar stands beside its ratio for the reader to compare.
"""

import os
import sys
import threading
from collections.abc import Callable, Iterator

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from benchmarks.systems import Compare, Report, System

HEADER = ("measured", "", "next to", "", "ratio", "bar")
ROWS = pytest.StashKey[list[tuple[str, ...]]]()


@pytest.fixture
def one_core() -> Iterator[None]:
    """Hold this thread on one core, where the system can do that."""
    if sys.platform != "linux":
        yield
        return
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(allowed)})
    yield
    os.sched_setaffinity(0, allowed)


@pytest.fixture
def a_core_each() -> Iterator[Callable[[], None]]:
    """Return what holds every thread of this process on a core of its own, where the system can do that.

    Beside other work the system tends to run both of two threads on the same core.
    """
    allowed = os.sched_getaffinity(0) if sys.platform == "linux" else set()

    def spread() -> None:
        for thread, core in zip(threading.enumerate(), sorted(allowed), strict=False):
            os.sched_setaffinity(thread.native_id or 0, {core})

    yield spread
    if allowed:
        os.sched_setaffinity(0, allowed)


@pytest.fixture
def report(request: pytest.FixtureRequest) -> Report:
    """Return what takes one row of the table at the end of the run."""
    rows: list[tuple[str, ...]] = request.config.stash.setdefault(ROWS, [HEADER])
    return lambda *cells: rows.append(cells)


@pytest.fixture
def compare(benchmark: BenchmarkFixture, report: Report) -> Compare:
    """Return what measures two systems in turns: ``compare(ours, peer, bar)``."""

    def measure(ours: System, peer: System, bar: float, rounds: int = 20) -> None:
        seconds: list[float] = []
        timer: Callable[[], float] = benchmark._timer  # the one that --benchmark-timer names: both are timed alike

        def before_ours() -> None:
            peer.prepare()
            started = timer()
            peer.run()
            seconds.append(timer() - started)
            ours.prepare()

        benchmark.pedantic(ours.run, setup=before_ours, rounds=rounds, warmup_rounds=1)
        if benchmark.stats is None:  # --benchmark-disable
            return
        rates = ours.steps / benchmark.stats.stats.min, peer.steps / min(seconds)
        ratio = rates[0] / rates[1]
        benchmark.extra_info |= {"steps_a_second": rates[0], "peer_steps_a_second": rates[1], "ratio": ratio}
        report(ours.name, f"{rates[0]:,.0f}/s", peer.name, f"{rates[1]:,.0f}/s", f"{ratio:.2f}x", f"at least {bar}x")

    return measure


@pytest.hookimpl(trylast=True)
def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Print the rows that the tests reported, in columns."""
    rows = config.stash.get(ROWS, [])
    if len(rows) < 2:
        return
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    terminalreporter.section("ratios of this run")
    for row in rows:
        terminalreporter.write_line("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)))
