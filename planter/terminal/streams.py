"""Standard output and error that take any text, and say in one sentence where they cannot be written to."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from planter.errors import ComputationError


def take_any_text() -> None:
    """Characters that a stream's encoding lacks are written out instead of raising an error."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


@contextmanager
def written() -> Iterator[None]:
    """Everything printed within has left the process at the end.

    Raises ComputationError where standard output is full or broken, SystemExit(1) where its reader went away.
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


def tell(text: str) -> None:
    """A line on standard error, where that can be written to."""
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)


def _drop() -> None:
    """What standard output still holds goes nowhere, so that nothing complains of it again."""
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
