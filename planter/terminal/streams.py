"""Standard output and error that accept any text, with one-line errors if they cannot be written."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from planter.errors import ComputationError


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
