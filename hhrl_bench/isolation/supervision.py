"""Supervision: a process that waits for an agent's, and ends with it all that it has begun, wherever that has gone."""

import ctypes
import os
import signal
import sys
import warnings
from contextlib import suppress
from pathlib import Path

_PARENT_DEATH_SIGNAL, _CHILD_SUBREAPER = 1, 36
_SIGNALS = (signal.SIGTERM, getattr(signal, "SIGCHLD", signal.SIGTERM))
_TICK = 1.0  # seconds after which it is seen that the harness is gone

KILLED = 128
"""A supervisor leaves with this and the signal's number where the agent was killed by a signal."""


def supervise() -> None:
    """Go on in a new process, with one thread, for whose end, or for a SIGTERM, this one waits.

    Then, or when the process that began it is gone, this one kills whatever the new process has begun, even in sessions
    of its own, and leaves with its exit code. Only Linux hands it such orphans; elsewhere this does nothing.
    """
    if sys.platform != "linux":
        return
    harness, supervisor = os.getppid(), os.getpid()
    prctl = ctypes.CDLL(None).prctl
    prctl(_CHILD_SUBREAPER, 1, 0, 0, 0)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # threads of BLAS, which are begun again where needed
        agent = os.fork()
    if agent:
        os._exit(_wait(agent, harness))
    os.setsid()
    prctl(_PARENT_DEATH_SIGNAL, signal.SIGKILL, 0, 0, 0)
    if os.getppid() != supervisor:
        os._exit(1)
    signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _wait(agent: int, harness: int) -> int:
    """Return the exit code of the agent's process when no process is left that it has begun."""
    found: int | None = None
    while found is None and os.getppid() == harness:
        woken = signal.sigtimedwait(_SIGNALS, _TICK)
        if woken is not None and woken.si_signo == signal.SIGTERM:
            break
        found = _reap(agent)
    while True:
        _kill_children()
        try:
            pid, status = os.waitpid(-1, 0)
        except ChildProcessError:
            return found if found is not None else KILLED + signal.SIGTERM
        found = _exit_code(status) if pid == agent else found


def _reap(agent: int) -> int | None:
    """Take note of all children that have ended; return the exit code of the agent's process if it is one of them."""
    found = None
    with suppress(ChildProcessError):
        while (ended := os.waitpid(-1, os.WNOHANG))[0]:
            found = _exit_code(ended[1]) if ended[0] == agent else found
    return found


def _exit_code(status: int) -> int:
    code = os.waitstatus_to_exitcode(status)
    return code if code >= 0 else KILLED - code


def _kill_children() -> None:
    """Kill the children of this process; theirs become its children then."""
    own = str(os.getpid())
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has ended meanwhile
            if path.read_text(errors="replace").rpartition(")")[2].split()[1] == own:
                os.kill(int(path.parent.name), signal.SIGKILL)
