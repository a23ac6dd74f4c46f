"""Text that a user hands in: read with a limit, decoded and parsed, every failure one sentence."""

import os
import re
import stat
import tomllib
from pathlib import Path
from typing import Any

from planter import legible
from planter.errors import InputError
from planter.files import limits

LIMIT_BYTES = 1_000_000
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f]")
_DECIMAL_COMMA = re.compile(r"=\s*(\S+)\s*(?:#.*)?")


_READ: set[str] = set()


def was_read(path: str | Path) -> bool:
    """Whether this process has read a file, by whatever name."""
    return os.path.realpath(path) in _READ


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
        _READ.add(os.path.realpath(path))
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
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}: line {line} is not UTF-8 text, which it must be") from None
    if control := _CONTROL.search(text):
        line = text.count("\n", 0, control.start()) + 1
        raise InputError(f"{path}: line {line} holds the control character {control[0]!r}, which it must not")
    return text


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """The tables of a TOML text; `source` names it in the error.

    Raises InputError with the line of the first syntax error, and for what is nested too deep or too large to be such
    a file (`planter.files.limits`).
    """
    limits.check_nesting(text, source)
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{source}: {_syntax_error(str(error), text)}") from None
    except ValueError:
        raise InputError(f"{source}: this is not usable TOML: a number has too many digits") from None
    limits.check_values(table, source)
    return table


def _syntax_error(told: str, text: str) -> str:
    """Place and reason of a syntax error, with what is probably meant."""
    place = re.search(r" \(at (?:line (\d+).*|end of document)\)$", told)
    if place is None:
        return f"this is not valid TOML: {told}"
    line = text.splitlines()[int(place[1]) - 1] if place[1] else ""
    given = _DECIMAL_COMMA.search(line)
    pointed = legible.with_point(given[1]) if given else None
    hint = f" (with a decimal point: {pointed})" if pointed else ""
    return f"{place[0][5:-1]}: this is not valid TOML: {told[: place.start()]}{hint}"
