"""Signals, and standard streams that accept any text, with one-line errors if they cannot be written."""

from __future__ import annotations

import io
import json
import os
import shlex
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from types import FrameType

from planter.errors import ComputationError, Interrupted

_HEARD = (signal.SIGINT, signal.SIGTERM)
_came: list[int] = []


_command: list[str] = []
IRRELEVANT = ("--json", "--overwrite", "--resume")
"""Options that change nothing of a result."""
IRRELEVANT_VALUES = ("--out", "--workers", "--cluster")
"""Options with a value that change nothing of a result."""


def record_command(arguments: Sequence[str]) -> None:
    """Record the arguments of this process's command, for `format_command`."""
    _command[:] = arguments


def format_command() -> str:
    """Return the command line that gives the same result, empty if no command runs.

    Options that only say where and how are left out, and of paths in other folders the folders.

    >>> record_command(["simulate", "/home/me/my machine.toml", "--out", "x", "--json"]); print(format_command())
    planter simulate 'my machine.toml'
    >>> record_command([]); print(format_command())
    <BLANKLINE>
    """
    words, is_value = [], False
    for word in _command:
        option = word.partition("=")[0]
        if not (is_value or option in IRRELEVANT or option in IRRELEVANT_VALUES):
            words.append(os.path.basename(word) if os.path.isabs(word) else word)
        is_value = word in IRRELEVANT_VALUES
    return shlex.join(["planter", *words]) if words else ""


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


def take_any_text() -> None:
    """Escape characters that the encoding of a stream lacks, instead of raising an error."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


@contextmanager
def flush_output() -> Iterator[None]:
    """Flush standard output at the end of the context.

    Raises ComputationError if standard output cannot be written, and SystemExit(1) if its reader has closed it.
    """
    try:
        yield
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:
        _drop()
        raise SystemExit(ComputationError.exit_code) from None
    except OSError as error:
        _drop()
        raise ComputationError(f"standard output: this cannot be written ({error.strerror or error})") from None


def print_line(text: str) -> None:
    """Print a line on standard error, if it can be written."""
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)


def _drop() -> None:
    """Discard the buffer of standard output, so that no later flush fails."""
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
