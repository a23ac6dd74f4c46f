"""The one place where this project starts Python: worker processes, and commands of its own.

Such a process is isolated: the standard library comes first, then the paths of this process, so that no file of the
current folder, and none that PYTHONPATH names, is taken for a module of the library. Foreign programs, such as
compilers, are run by `planter.kernels.builds`; `tests/test_house.py` forbids all other starts.
"""

from __future__ import annotations

import os
import queue
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from planter import rooms

if TYPE_CHECKING:
    from asyncio.subprocess import Process

PACKAGE = str(Path(rooms.__file__).with_name("__init__.py"))
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
_PROGRAM = "import runpy; del sys.argv[0]; runpy.run_module(sys.argv[0], run_name='__main__', alter_sys=True)"
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
"""Environment of a worker that shares the processor with others like it."""


def python_command(code: str, *words: str, checkout: Path | None = None) -> list[str]:
    """Return the command of an isolated Python that executes a text, with `words` as its arguments.

    `planter` is the one of this process, or that of another `checkout`.
    """
    first, package = [], _PLANTER.format(package=PACKAGE)
    if checkout is not None:
        first, package = [str(checkout)], ""
    last = [os.path.abspath(path) for path in sys.path]
    return [sys.executable, "-I", "-c", _PATHS.format(first=first, last=last) + package + code, *words]


def program_command(module: str, *words: str, checkout: Path | None = None) -> list[str]:
    """Return the command that runs a module as `python -m MODULE WORDS` does, isolated."""
    return python_command(_PROGRAM, module, *words, checkout=checkout)


def start_worker(
    module: str, stdout: IO[str] | int, settings: Mapping[str, str] | None = None
) -> subprocess.Popen[str]:
    """Start a process that runs `main` of an importable module; it is sent lines through its standard input.

    Ctrl-C does not reach it. `settings` are added to its environment. It has to read by `read_lines`.
    """
    return subprocess.Popen(
        _worker_command(module), stdin=subprocess.PIPE, stdout=stdout, stderr=subprocess.DEVNULL, text=True,
        env={**os.environ, **(settings or {})}, **apart(),
    )  # fmt: skip


async def start_async_worker(module: str, longest_line: int, settings: Mapping[str, str] | None = None) -> Process:
    """Start such a process for an event loop, which reads its answers: lines of at most `longest_line` bytes."""
    import asyncio

    return await asyncio.create_subprocess_exec(
        *_worker_command(module), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        limit=longest_line, env={**os.environ, **(settings or {})}, **apart(),
    )  # fmt: skip


async def start_async_program(module: str, *words: str) -> Process:
    """Start `python -m MODULE WORDS` for an event loop, which reads what it prints and what it reports."""
    import asyncio

    return await asyncio.create_subprocess_exec(
        *program_command(module, *words), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def run_command(
    command: Sequence[str], cwd: Path | None = None, variables: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run one of the commands above to its end, and return what it prints; `variables` are added to its environment."""
    return subprocess.run(
        command, cwd=cwd, env={**os.environ, **(variables or {})}, stdin=subprocess.DEVNULL, capture_output=True,
        text=True, errors="replace", check=False,
    )  # fmt: skip


def end_worker(process: subprocess.Popen[str]) -> None:
    """Kill a process that may still run, and close what leads to it."""
    process.kill()
    process.wait()
    for channel in (process.stdin, process.stdout):
        if channel is not None:
            try:
                channel.close()
            except OSError:  # what was not yet written has no reader any more
                continue


def read_lines() -> Iterator[str]:
    """Yield, in a worker, the lines that it is sent. When no more can come, it ends at once, at work or not."""
    received: queue.SimpleQueue[str] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(received,), daemon=True).start()
    while True:
        yield received.get()


def apart() -> dict[str, Any]:
    """Return what `subprocess.Popen` takes for a process that Ctrl-C in this one's terminal does not reach."""
    if sys.platform == "win32":
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    return {"start_new_session": True}


def _worker_command(module: str) -> list[str]:
    return python_command(_WORKER, module)


def _read(received: queue.SimpleQueue[str]) -> None:
    rest = b""
    while block := os.read(0, 1 << 16):
        *whole, rest = (rest + block).split(b"\n")
        for line in whole:
            received.put(line.decode())
    os._exit(1)
