"""The one place where this project starts Python: worker processes, and commands of planter.

Such a process is isolated: the standard library comes first, then the paths of this process, so
that no file of the current folder, and none that PYTHONPATH names, is taken for a module of the
library. Foreign programs, such as compilers, are run by `planter.kernels.builds`;
`tests/test_structure.py` forbids all other starts.
"""

from __future__ import annotations

import os
import queue
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from planter import plugins
from planter.errors import ComputationError

if TYPE_CHECKING:
    from asyncio.subprocess import Process

PACKAGE = str(Path(plugins.__file__).with_name("__init__.py"))
_PATHS = """\
import sys
sys.path[:0] = {first!r}
sys.path += [path for path in {last!r} if path not in sys.path]
"""
_PLANTER = """\
import importlib.util
spec = importlib.util.spec_from_file_location("planter", {package!r})
sys.modules["planter"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules["planter"])
"""
_WORKER = "import importlib; importlib.import_module(sys.argv[1]).main()"
_PROGRAM = (
    "import runpy; del sys.argv[0]; runpy.run_module(sys.argv[0], run_name='__main__', "
    "alter_sys=True)"
)
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
"""Environment of a worker, which shares the processor with others like it."""
_LENGTH = struct.Struct("<Q")
"""What stands before each message: how many bytes it has."""


def python_command(code: str, *words: str, checkout: Path | None = None) -> list[str]:
    """Return the command of an isolated Python that executes a text, with `words` as its arguments.

    `planter` is the one of this process, or that of another `checkout`.
    """
    first, package = [], _PLANTER.format(package=PACKAGE)
    if checkout is not None:
        first, package = [str(checkout)], ""
    last = [os.path.abspath(path) for path in sys.path]
    return [
        sys.executable,
        "-I",
        "-c",
        _PATHS.format(first=first, last=last) + package + code,
        *words,
    ]


def program_command(module: str, *words: str, checkout: Path | None = None) -> list[str]:
    """Return the command that runs a module as `python -m MODULE WORDS` does, isolated."""
    return python_command(_PROGRAM, module, *words, checkout=checkout)


class WorkerEndedError(ComputationError):
    """A worker process that has ended instead of answering."""


class Worker:
    """A process that answers messages, bytes each, one after another: `main` of an importable
    module calls `serve`.

    It works on one thread, is not reached by Ctrl-C, and ends with this process. `first` is a
    message without a separate answer; it is sent before the others.
    """

    def __init__(self, module: str, first: bytes, longest_answer: int | None = None) -> None:
        self._messages, self._longest_answer = [first], longest_answer
        self._process = subprocess.Popen(
            python_command(_WORKER, module),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **ONE_THREAD},
            **detached_process_options(),
        )

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def is_alive(self) -> bool:
        return self._process.poll() is None

    def ask(self, message: bytes, limit_s: float | None = None) -> bytes:
        """Return the answer to a message.

        Raises WorkerEndedError if the process ends or its answer is too long, TimeoutError after
        `limit_s` seconds; in all these cases nothing of it goes on running.
        """
        is_late = threading.Event()

        def kill_late() -> None:
            is_late.set()
            self.kill()

        timer = threading.Timer(limit_s or 0, kill_late)
        if limit_s is not None:
            timer.start()
        try:
            return self._exchange(message)
        except WorkerEndedError:
            self.end()
            if is_late.is_set():
                raise TimeoutError from None
            raise
        finally:
            timer.cancel()

    def kill(self) -> None:
        """Kill the process; a caller that waits for its answer gets an error.

        Any thread may call this.
        """
        self._process.kill()

    def end(self) -> None:
        """Kill the process, wait for its end and close what leads to it."""
        self.kill()
        self._process.wait()
        for channel in (self._process.stdin, self._process.stdout):
            with suppress(OSError):  # what was not yet written has no reader any more
                if channel is not None:
                    channel.close()

    def _exchange(self, message: bytes) -> bytes:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._messages.append(message)
        try:
            while self._messages:
                _write_message(self._process.stdin, self._messages.pop(0))
            answer = _read_message(self._process.stdout, self._longest_answer)
        except (OSError, ValueError):
            answer = None
        if answer is None:
            raise WorkerEndedError("the worker process has ended")
        return answer


def serve(
    prepare: Callable[[bytes], Callable[[bytes], bytes]], memory_bytes: int | None = None
) -> None:
    """Answer, in a worker, every message after the first by what `prepare` makes of that.

    When no more messages can come the process ends at once, at work or not. What is printed goes
    nowhere. Beyond `memory_bytes` of address space an allocation fails, where the system can limit
    it.
    """
    if memory_bytes is not None:
        _limit_memory(memory_bytes)
    answers = open(os.dup(1), "wb")  # noqa: SIM115 - open as long as the process
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    messages: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_read_messages, args=(messages,), daemon=True).start()
    answer = prepare(messages.get())
    while True:
        _write_message(answers, answer(messages.get()))


async def start_async_program(module: str, *words: str) -> Process:
    """Start `python -m MODULE WORDS` for an event loop, which reads what it prints and what it
    reports.
    """
    import asyncio

    return await asyncio.create_subprocess_exec(
        *program_command(module, *words),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def run_command(
    command: Sequence[str], cwd: Path | None = None, variables: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run one of the commands above to its end, and return what it prints; `variables` are added to
    its environment.
    """
    return subprocess.run(
        command,
        cwd=cwd,
        env={**os.environ, **(variables or {})},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )


def detached_process_options() -> dict[str, Any]:
    """Return what `subprocess.Popen` takes for a process that Ctrl-C in this one's terminal does
    not reach.
    """
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"start_new_session": True}


def _write_message(channel: IO[bytes], message: bytes) -> None:
    channel.write(_LENGTH.pack(len(message)))
    channel.write(message)
    channel.flush()


def _read_message(channel: IO[bytes], longest: int | None = None) -> bytes | None:
    """Return the next message; None if no more can come, or it is longer than allowed."""
    header = channel.read(_LENGTH.size)
    if len(header) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack(header)
    if longest is not None and length > longest:
        return None
    message = channel.read(length)
    return message if len(message) == length else None


def _read_messages(received: queue.SimpleQueue[bytes]) -> None:
    with open(0, "rb", closefd=False) as channel:
        while (message := _read_message(channel)) is not None:
            received.put(message)
    os._exit(1)


def _limit_memory(memory_bytes: int) -> None:
    try:
        import resource
    except ImportError:
        return
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    limit = memory_bytes if hard == resource.RLIM_INFINITY else min(memory_bytes, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
