"""Files of a user's own: what is wrong with them, in a sentence that names the place."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class OwnError(Exception):
    """A sentence on what is wrong with what a user wants derived; then the lines of the user's own that led there."""


@contextmanager
def blamed(path: Path) -> Iterator[None]:
    """Turn what a file or folder raises into an OwnError."""
    try:
        yield
    except OwnError:
        raise
    except Exception as error:
        raise OwnError(complaint(error, path)) from error


def complaint(error: Exception, path: Path) -> str:
    """The place in the user's files and what was raised, then the user's own lines of the traceback."""
    folder = (path if path.is_dir() else path.parent).resolve()
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if _in(folder, frame.filename)]
    place, said = str(path), " ".join(str(error).split())
    if isinstance(error, SyntaxError) and error.filename:
        place, said = f"{error.filename}, line {error.lineno}", str(error.msg)
    elif frames:
        place = f"{frames[-1].filename}, line {frames[-1].lineno}"
    lines = "".join(traceback.format_list(frames)).rstrip()
    return f"{place}: {type(error).__name__}: {said}" + (f"\n{lines}" if lines else "")


def _in(folder: Path, filename: str) -> bool:
    """Whether a file is the user's: in the folder, neither of this package nor installed."""
    file = Path(filename).resolve()
    ours = file.is_relative_to(Path(__file__).resolve().parents[1])
    return file.is_relative_to(folder) and not ours and "site-packages" not in file.parts
