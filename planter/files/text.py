"""Text that a user hands in: read with a limit, decoded and parsed, every failure one sentence."""

import os
import re
import stat
import tomllib
from pathlib import Path
from typing import Any

from planter.errors import InputError

LIMIT_BYTES = 1_000_000


def read_text(path: str | Path) -> str:
    """The UTF-8 text of a regular file of at most `LIMIT_BYTES`.

    Raises InputError for anything else: missing, a directory or device, unreadable, too large, not UTF-8.
    """
    try:
        mode = os.stat(path).st_mode
        if not stat.S_ISREG(mode):
            kind = "a directory" if stat.S_ISDIR(mode) else "a device or pipe"
            raise InputError(f"{path}: this is {kind}, but it must be a text file")
        with open(path, "rb") as file:
            content = file.read(LIMIT_BYTES + 1)
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"{str(path)!r}: the file cannot be read ({reason})") from None
    if len(content) > LIMIT_BYTES:
        raise InputError(f"{path}: the file is too large, it must not exceed {LIMIT_BYTES} bytes")
    return _decoded(content, path)


def _decoded(content: bytes, path: str | Path) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}: line {line} is not UTF-8 text, which it must be") from None


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """The tables of a TOML text; `source` names it in the error.

    Raises InputError with the line of the first syntax error.
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r" \(at (.*)\)$", str(error))
        reason = str(error)[: place.start()] if place else str(error)
        where = place[1] if place else "unknown place"
        raise InputError(f"{source}: {where}: this is not valid TOML: {reason}") from None
    except (RecursionError, ValueError):
        raise InputError(
            f"{source}: this is not usable TOML: tables are nested too deep or a number has too many digits"
        ) from None
