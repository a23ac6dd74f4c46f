"""Ctrl-C and signal 15, heard from the first moment on: one line, one exit code, with `--json` one object."""

from __future__ import annotations

import json
import os
import signal
import sys
from types import FrameType

from planter.errors import Interrupted

_HEARD = (signal.SIGINT, signal.SIGTERM)
_came: list[int] = []


def listen_signals() -> None:
    """Hear both signals from now on; a process that was started deaf to one stays so.

    A signal raises KeyboardInterrupt, so that a search can save what it has found. Within an import, which may swallow
    that or make another error of it, it ends the process at once.
    """
    _came.clear()
    for number in _HEARD:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _hear)


def ignore_signals() -> None:
    """Hear them no more, where they were heard: what is left to do is done whatever comes."""
    for number in _HEARD:
        if signal.getsignal(number) is _hear:
            signal.signal(number, signal.SIG_IGN)


def exit_code() -> int | None:
    """128 and the number of the first signal that came; None where none did."""
    return 128 + _came[0] if _came else None


def _hear(number: int, frame: FrameType | None) -> None:
    _came.append(number)
    if _importing(frame):
        _leave(128 + number)
    raise KeyboardInterrupt


def _importing(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


def _leave(code: int) -> None:
    """Ends the process past everything that is only half imported: nothing has been printed by then."""
    error = Interrupted()
    os.write(2, f"planter: {error.message}\n".encode())
    if "--json" in sys.argv:
        os.write(1, f"{json.dumps(error.table(), indent=2)}\n".encode())
    os._exit(code)
