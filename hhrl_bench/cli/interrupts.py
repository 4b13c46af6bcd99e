"""Interrupts: Ctrl-C ends a command with exit code 130 and one line, whatever the command does at that moment.

Python raises a ``KeyboardInterrupt`` in the main thread. It may be lost there: numpy drops it in a comparison with a
member of an enum, for whose attribute ``__array_ufunc__`` it asks, which calls ``EnumType.__getattr__``; finalizers
drop it too. Or it comes late, while compiled code runs or a thread is waited for. So a thread raises it again until the
command unwinds, and ends the process if that takes long. As every file is written whole and locks are the system's, no
more is lost by that than by the interrupt.
"""

import atexit
import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from threading import Thread, main_thread
from typing import Any

INTERRUPTED = 130
GRACE = 3.0
"""Seconds that a command has to unwind before its process is ended."""

_AGAIN = 0.2
"""Seconds after which an interrupt that was lost is raised again."""

_SHOW_CURSOR = "\x1b[?25h"


class _Interrupts:
    """Whether this process was interrupted, whether it has said so, and what it advises then."""

    def __init__(self) -> None:
        self.pressed, self.said, self.advice = False, False, ""


_interrupts = _Interrupts()


def leave_on_interrupt(command: Callable[[], object]) -> None:
    """Do ``command`` in the main thread; an interrupt from now on ends this process with exit code 130.

    A job in the background, for which the shell has interrupts ignored, goes on ignoring them.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        command()
        return
    try:
        try:
            _listen()
            command()
        finally:
            signal.signal(signal.SIGINT, _note)  # what comes now is no more raised, but still ends the process
    except BaseException as error:
        _interrupts.pressed |= isinstance(error, KeyboardInterrupt)  # before the handler was there
        if not _interrupts.pressed:
            raise
    if _interrupts.pressed:
        if not _interrupts.said:
            say_interrupted()
        atexit._run_exitfuncs()  # noqa: SLF001 - the rest of an exit waits for threads, and may end by the signal
        os._exit(INTERRUPTED)


def was_interrupted() -> bool:
    """Return whether the command was interrupted, so that an error may come from that."""
    return _interrupts.pressed


def advise(advice: str) -> None:
    """Let the line that is said of an interrupt end with this advice."""
    _interrupts.advice = advice


def say_interrupted() -> None:
    """Say on stderr, in one line, that the command was interrupted."""
    _interrupts.said = True  # from here on nothing is raised
    with suppress(OSError):
        sys.stderr.write(_line())
        sys.stderr.flush()


def _line() -> str:
    advice = _interrupts.advice and f"; {_interrupts.advice}"
    return f"hhrl-bench: interrupted; what was not finished was not written{advice}\n"


def _listen() -> None:
    sys.unraisablehook = _report_unraisable
    reader, writer = os.pipe()
    if sys.platform != "win32":
        os.set_blocking(writer, False)
    Thread(target=_watch, args=(reader,), daemon=True).start()
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    signal.signal(signal.SIGINT, _raise)


def _raise(*_: object) -> None:
    """Raise a ``KeyboardInterrupt``, unless the command unwinds: what cleans up is not disturbed."""
    _interrupts.pressed = True
    if _interrupts.said:
        return
    error = sys.exception()
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return
        error = error.__context__
    raise KeyboardInterrupt


def _note(*_: object) -> None:
    _interrupts.pressed = True


def _watch(reader: int) -> None:
    """Wait until the pipe that signals are written to says that one was an interrupt, then see the process end."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # it is the main thread that may hold it back
    while os.read(reader, 1) != bytes([signal.SIGINT]):
        pass
    _interrupts.pressed = True
    end = time.monotonic() + GRACE
    while time.monotonic() < end:
        time.sleep(_AGAIN)
        _interrupt_main_thread()
    _end()


def _interrupt_main_thread() -> None:
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(main_thread().ident or 0, signal.SIGINT)
    else:
        signal.raise_signal(signal.SIGINT)


def _end() -> None:
    """End the process; stderr is written past its buffer, whose lock the main thread may hold."""
    if not _interrupts.said:
        cleaning = Thread(target=atexit._run_exitfuncs, daemon=True)  # noqa: SLF001 - semaphores of pools are freed
        cleaning.start()
        cleaning.join(_AGAIN)
        os.write(2, ((_SHOW_CURSOR if os.isatty(2) else "") + _line()).encode())
    os._exit(INTERRUPTED)


def _report_unraisable(error: Any) -> None:
    """Report an exception that a finalizer has raised, unless an interrupt has ended it."""
    if not issubclass(error.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(error)
