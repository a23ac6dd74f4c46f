"""Processes of Python's own that work for this one: they see no folder of the user's before the standard library, and
they end when this one does, however it ends.
"""

from __future__ import annotations

import os
import queue
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import IO

from planter import rooms
from planter.kernels import platforms

_START = """\
import importlib, importlib.util, sys
package, module, *paths = sys.argv[1:]
sys.path += [path for path in paths if path not in sys.path]
spec = importlib.util.spec_from_file_location("planter", package)
sys.modules["planter"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules["planter"])
importlib.import_module(module).main()
"""
"""The standard library comes first, then the paths of the first process, `planter` from where that has it."""

PACKAGE = str(Path(rooms.__file__).with_name("__init__.py"))


def started(module: str, stdout: IO[str] | int, settings: Mapping[str, str] | None = None) -> subprocess.Popen[str]:
    """A process that runs `main` of an importable module, told by lines through its standard input.

    Ctrl-C does not reach it. `settings` are added to its environment. It has to read by `lines`.
    """
    paths = [os.path.abspath(path) for path in sys.path]
    return subprocess.Popen(
        [sys.executable, "-I", "-c", _START, PACKAGE, module, *paths], stdin=subprocess.PIPE, stdout=stdout,
        stderr=subprocess.DEVNULL, text=True, env={**os.environ, **(settings or {})}, **platforms.apart(),
    )  # fmt: skip


def ended(process: subprocess.Popen[str]) -> None:
    """Kills a process that may still run, and closes what leads to it."""
    process.kill()
    process.wait()
    for channel in (process.stdin, process.stdout):
        if channel is not None:
            try:
                channel.close()
            except OSError:  # what was not yet written has no reader any more
                continue


def lines() -> Iterator[str]:
    """In such a process: the lines it is told. When there can be no more of them, it ends at once, at work or not."""
    told: queue.SimpleQueue[str] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(told,), daemon=True).start()
    while True:
        yield told.get()


def _read(told: queue.SimpleQueue[str]) -> None:
    rest = b""
    while block := os.read(0, 1 << 16):
        *whole, rest = (rest + block).split(b"\n")
        for line in whole:
            told.put(line.decode())
    os._exit(1)
