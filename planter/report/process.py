"""Signals, and standard streams that accept any text, with one-line errors if they cannot be
written.
"""

from __future__ import annotations

import io
import json
import os
import shlex
import signal
import socket
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from types import FrameType

from planter import safe_text
from planter.errors import ComputationError, Interrupted
from planter.progress import describe_slow_step

_HEARD = (signal.SIGINT, signal.SIGTERM)
_came: list[int] = []
_heard = threading.Event()
GRACE_S = 1.5
"""Seconds after a signal in which the main thread must come back from compiled code."""
WATCH_INTERVAL_S = 0.25
"""Seconds between two looks at the step that is running."""


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

    A signal raises KeyboardInterrupt, so that a search can save what it has found. Within an
    import, which may swallow that or make another error of it, it ends the process at once. Python
    raises nothing within a call of compiled code: one that goes on for more than `GRACE_S` is ended
    with the process. Slow steps are reported.
    """
    _came.clear()
    _heard.clear()
    incoming, outgoing = socket.socketpair()
    outgoing.setblocking(False)
    signal.set_wakeup_fd(outgoing.fileno(), warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(incoming, outgoing), name="watch", daemon=True).start()
    for number in _HEARD:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _hear)


def _watch(incoming: socket.socket, _outgoing: socket.socket) -> None:
    """End the process if the main thread does not hear a signal, and report slow steps; the sockets
    stay open.
    """
    incoming.settimeout(WATCH_INTERVAL_S)
    while True:
        try:
            (number,) = incoming.recv(1)
        except TimeoutError:
            if (step := describe_slow_step()) is not None:
                print_line(f"planter: {safe_text.sanitise_line(step)}")
            continue
        if (
            number in _HEARD
            and signal.getsignal(number) is not signal.SIG_IGN
            and not _heard.wait(GRACE_S)
        ):
            _leave(128 + number)


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
    _heard.set()
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
    """End the process past what is half imported or does not come back: no result has been printed
    by then.
    """
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

    Raises ComputationError if standard output cannot be written, and SystemExit(1) if its reader
    has closed it.
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
        raise ComputationError(
            f"standard output: this cannot be written ({error.strerror or error})"
        ) from None


def print_line(text: str) -> None:
    """Print a line on standard error, if it can be written."""
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)


def _drop() -> None:
    """Discard the buffer of standard output, so that no later flush fails."""
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
