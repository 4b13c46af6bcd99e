"""A user's agent in a process of its own, which is asked by frames and ends with what it has begun."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from json import dumps
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from time import monotonic, sleep
from typing import IO, Any
from weakref import finalize

from numpy.typing import NDArray

from hhrl_agents import Decision
from hhrl_bench.errors import AgentError, FailedAgentError
from hhrl_bench.isolation import frames
from hhrl_bench.isolation.supervision import KILLED
from hhrl_envs import Scenario, scenario_to_json
from hhrl_envs.arrays import Flags, Floats32

VARIABLE = "HHRL_AGENT_SECONDS"
"""The environment variable that says how many seconds an agent may take for one answer."""

SECONDS = 120.0
"""How many it may take by default."""

MAKING = 5.0
"""Being made, with all that is imported for it, may take this many times as long as an answer."""

MEMORY_SHARE = 0.75
"""Share of the machine's memory that the data of each process of an agent may take."""

_GRACE = 2.0  # seconds in which a process may end by itself
_TICK = 0.5  # seconds after which it is seen, at the latest, that an answer takes too long
_BEGIN = (
    "import sys, json, importlib; server, path = sys.argv[1:]; sys.path[:] = json.loads(path); del sys.argv[1:]; "
    "importlib.import_module(server).main()"
)


class AgentProcess:
    """The agent that ``module:factory`` makes, in a fresh process of its own; see :class:`hhrl_agents.Agent`.

    It has ``act_with_option`` and ``attention`` if the agent has. The process ends when this is closed or forgotten.

    Args:
        server: the module whose ``main`` makes and asks the agent there.
        source: what makes the agent.
        scenario: what the factory is called with.

    Raises:
        FailedAgentError: if no agent is made; later, in place of an answer.
    """

    def __init__(self, server: str, source: str, scenario: Scenario) -> None:
        connection = self._connection = _Connection(server)
        for name in connection.begin(source, scenario):
            setattr(self, name, partial(_first, connection, name))

    def reset(self, mask: Flags) -> None:
        """Tell the agent which rows, bool [B], start an episode."""
        self._connection.call("reset", mask)

    def act(self, observations: Floats32) -> Decision:
        """Return the agent's decisions, int64 [B], for observations float32 [B, elements]."""
        return Decision(*self._connection.call("act", observations))

    def close(self) -> None:
        """End the process and all that it has begun, and remove its folder."""
        self._connection.close()


def _first(connection: "_Connection", name: str, *arrays: NDArray[Any]) -> NDArray[Any]:
    return connection.call(name, *arrays)[0]


class _Connection:
    """A process that serves an agent, the pipes to it and its scratch folder."""

    def __init__(self, server: str) -> None:
        self._seconds = allowed_seconds()
        scratch = TemporaryDirectory(prefix="hhrl-agent-", ignore_cleanup_errors=True)
        self._folder = Path(scratch.name).resolve()
        path = dumps([entry or str(Path.cwd()) for entry in sys.path])
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-c", _BEGIN, server, path],
            bufsize=0,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        output = Thread(target=_forward, args=(self._process.stderr,), daemon=True)
        output.start()
        self._watchdog = _Watchdog(self._process)
        self.close = finalize(self, _end, self._process, output, scratch)

    def begin(self, source: str, scenario: Scenario) -> list[str]:
        """Let the process make the agent; return which of ``frames.ABILITIES`` it has."""
        order = {
            "source": source,
            "scenario": scenario_to_json(scenario),
            "module_folder": str(Path.cwd()),
            "scratch": str(self._folder),
            "memory": int(MEMORY_SHARE * physical_memory()),
        }
        try:
            flags = self._exchange(
                frames.text_request(dumps(order)), f"making {source}", len(frames.ABILITIES), MAKING * self._seconds
            )
        except FailedAgentError:
            self.close()
            raise
        return [name for name, flag in zip(frames.ABILITIES, flags, strict=True) if flag]

    def call(self, name: str, *arrays: NDArray[Any]) -> list[NDArray[Any]]:
        """Return what the agent's method gives for these arrays."""
        call = frames.CALLS[name]
        request, rows, width = frames.request(call, arrays)
        answer = self._exchange(request, f"the agent's {name}", frames.size(call.gives, rows, width), self._seconds)
        return frames.unpack(call.gives, answer, rows, width)

    def _exchange(self, request: bytes, what: str, size: int, seconds: float) -> bytearray:
        """Return the bytes of the answer to a request, which must be of this size and come in these seconds."""
        if not self.close.alive:
            raise FailedAgentError(f"{what} is asked for, but its process has ended; load the agent again")
        try:
            with self._watchdog.within(seconds):
                status, answer = self._ask(request, size)
        except (EOFError, OSError) as error:
            raise FailedAgentError(self._fate(what)) from error
        except BaseException:  # whatever comes next is no answer to what is asked next
            self.close()
            raise
        if status == frames.DONE:
            return answer
        raise FailedAgentError(answer.decode(errors="replace"))

    def _ask(self, request: bytes, size: int) -> tuple[int, bytearray]:
        to, back = _pipe(self._process.stdin), _pipe(self._process.stdout)
        view = memoryview(request)
        while view:
            view = view[to.write(view) :]
        status, length = frames.ANSWER.unpack(frames.read_exactly(back, frames.ANSWER.size))
        if not (length == size if status == frames.DONE else status == frames.FAILED and length <= frames.LONGEST_TEXT):
            raise FailedAgentError(
                "the agent has written into the pipe of its process; let it write to stdout or stderr"
            )
        return status, frames.read_exactly(back, length)

    def _fate(self, what: str) -> str:
        """Return why the process is gone, and end what is left of it."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_GRACE)
        code = self._process.returncode
        self.close()
        if self._watchdog.has_bitten:
            return f"{what} took longer than {self._watchdog.seconds:g} s; set {VARIABLE} to allow more"
        if code is None:
            return f"{what} closed the pipe of its process; let it leave descriptors alone that are not its own"
        number = -code if code < 0 else code - KILLED
        if number <= 0:
            return f"{what} ended its process with exit code {code}"
        hint = "; is there enough memory?" if number == getattr(signal, "SIGKILL", None) else ""
        return f"{what} ended as its process was killed by signal {number}{hint}"


class _Watchdog:
    """Kills a process that takes too long; one thread looks on until the process is gone."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self.seconds, self.has_bitten = inf, False
        self._process, self._until = process, inf
        Thread(target=self._look_on, daemon=True).start()

    @contextmanager
    def within(self, seconds: float) -> Iterator[None]:
        """Kill the process if this context lasts longer than so many seconds."""
        self.seconds, self._until = seconds, monotonic() + seconds
        try:
            yield
        finally:
            self._until = inf

    def _look_on(self) -> None:
        while self._process.poll() is None:
            sleep(_TICK)
            if monotonic() > self._until:
                self.has_bitten = True
                _kill(self._process)


def allowed_seconds() -> float:
    """Return how long an agent may take for one answer.

    Raises:
        AgentError: if the environment says anything but a number of seconds.
    """
    said = os.environ.get(VARIABLE, "")
    try:
        seconds = float(said) if said else SECONDS
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < 1e6:
        raise AgentError(f"{VARIABLE} is {said!r}; write a number of seconds, such as {SECONDS:g}")
    return seconds


def physical_memory() -> int:
    """Return the bytes of memory of this machine; where the system does not say, more than any has."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return 1 << 62


def _forward(stream: IO[bytes]) -> None:
    """Write what a process prints to stderr, for stdout belongs to results."""
    with suppress(OSError, ValueError):  # one of them is closed
        while data := stream.read(1 << 16):
            sys.stderr.write(data.decode(errors="replace"))
            sys.stderr.flush()


def _pipe(stream: IO[bytes] | None) -> Any:
    """Return a pipe of a process that was begun with pipes."""
    return stream


def _end(process: subprocess.Popen[bytes], output: Thread, scratch: TemporaryDirectory[str]) -> None:
    """End a process, which is asked to leave first, and what it has begun; remove its folder."""
    _pipe(process.stdin).close()
    try:
        process.wait(_GRACE)
    except subprocess.TimeoutExpired:
        _kill(process)
    _kill_group(process)
    output.join(_GRACE)
    for stream in (process.stdout, process.stderr):
        _pipe(stream).close()
    scratch.cleanup()


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Kill a process; a supervisor is given the time to kill what it supervises."""
    process.terminate()
    try:
        process.wait(_GRACE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    _kill_group(process)


def _kill_group(process: subprocess.Popen[bytes]) -> None:
    """Kill what a process has left in its group, where there is no supervisor that does."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
