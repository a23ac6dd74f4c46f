"""What a file may hold at most: how deep it is nested, how many values, how long a name.

All of it in linear time.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import stat
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path
from typing import Any, NoReturn

from planter import paths, safe_text
from planter.errors import InputError

DEEPEST = 16
"""Levels of nested tables and lists."""
MOST_VALUES = 10_000
"""Names of tables and values, and items of lists."""
MARKS_PER_VALUE = 5
"""Brackets, points and signs between values for each value: more are told before anything is
parsed.
"""
LONGEST_NAME = 200
"""Characters of a name."""
LARGEST_WHOLE = 2**63
"""Whole numbers are less than this in size, as TOML has it."""

_TOKENS = re.compile(
    r'"""(?:[^"\\]++|\\.|"(?!""))*+(?:""")?'
    r"|'''(?:[^']++|'(?!''))*+(?:''')?"
    r'|"(?:[^"\\\n]++|\\[^\n])*+"?'
    r"|'[^'\n]*+'?"
    r"|#[^\n]*+"
    r"|[\[\]{}.,=\n]",
    re.DOTALL,
)
CONTROL = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]")
"""Characters that no text may hold: control characters and halves of characters."""
_MARKS = frozenset("[{.,=")
_STEPS = {"[": 1, "{": 1, "]": -1, "}": -1}


def check_nesting(text: str, source: str, most_values: int = MOST_VALUES) -> None:
    """Raise InputError for a TOML or JSON text nested too deep, in brackets or by dots, or with too
    many values.

    Parsing dots takes memory without end, parsing brackets the stack. An open string ends with the
    file or its line; that it is open the parser will tell. What is a comment or a string in TOML
    alone is where a parser of JSON stops.
    """
    brackets = dots = marks = 0
    for token in _TOKENS.finditer(text):
        mark = token[0]
        brackets += _STEPS.get(mark, 0)
        if mark == ".":
            dots += 1
        elif mark in ",=\n":
            dots = 0
        marks += mark in _MARKS
        if marks > MARKS_PER_VALUE * most_values:
            raise InputError(f"{source}: {_too_many(most_values)}")
        if max(brackets, dots) > DEEPEST:
            line = text.count("\n", 0, token.start()) + 1
            raise InputError(
                f"{source}: line {line}: this is nested too deep, it must not exceed {DEEPEST} "
                f"levels"
            )


def check_values(table: Mapping[str, Any], source: str, most_values: int = MOST_VALUES) -> None:
    """Raise InputError for a parsed table that is too deep or too large, for long names and numbers
    beyond 64 bits.
    """
    for count, (location, value) in enumerate(paths.walk_locations(table), 1):
        name = str(location[-1])
        if len(name) > LONGEST_NAME:
            short = safe_text.quote_name(name)
            raise InputError(
                f"{source}: the name {short} is too long, it must not exceed {LONGEST_NAME} "
                f"characters"
            )
        if len(location) > DEEPEST:
            raise InputError(
                f"{source}: {name} is nested too deep, it must not exceed {DEEPEST} levels"
            )
        if isinstance(value, int) and abs(value) >= LARGEST_WHOLE:
            entry = (
                f"{safe_text.quote_name(paths.join_location(location))} = "
                f"{safe_text.format_value(value)}"
            )
            raise InputError(
                f"{source}: {entry}: it must be a number of fewer digits, or have a point"
            )
        if count > most_values:
            raise InputError(f"{source}: {_too_many(most_values)}")


def _too_many(most_values: int) -> str:
    return f"there are too many values, they must not exceed {most_values}"


def check_json_scalars(table: Mapping[str, Any], source: str) -> None:
    """Raise InputError for what JSON can write and nothing here can take: 1e999, a surrogate, a
    control character.
    """
    for location, value in paths.walk_locations(table):
        if any(isinstance(text, str) and CONTROL.search(text) for text in (location[-1], value)):
            problem = "holds a character that no text has"
        elif isinstance(value, float) and not math.isfinite(value):
            problem = "is not a finite number"
        else:
            continue
        raise InputError(
            f"{source}: {safe_text.quote_name(paths.join_location(location))} {problem}"
        )


LIMIT_BYTES = 1_000_000
ENCODING_SAMPLE = 1000
"""Bytes at the start of a text that tell UTF-16 from other encodings."""
LONGEST_ARGUMENT = 10_000
"""Characters of a word on the command line."""
_DECIMAL_COMMA = re.compile(r"=\s*(\S+)\s*(?:#.*)?")
_NO_WAITING = (
    getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)
)
"""A pipe that takes the place of a file between two looks at it must not make the opening wait for
a writer.
"""


_READ: set[str] = set()


def was_read(path: str | Path) -> bool:
    """Whether this process has read a file, by whatever name."""
    return os.path.realpath(path) in _READ


def check_arguments(arguments: Sequence[str]) -> None:
    """Raises InputError for more words on a command line, or longer ones, than anybody types."""
    if len(arguments) > MOST_VALUES:
        raise InputError(
            f"there are {len(arguments)} words on the command line, at most {MOST_VALUES} can be"
        )
    longest = max(arguments, key=len, default="")
    if len(longest) > LONGEST_ARGUMENT:
        short = safe_text.quote_name(longest)
        raise InputError(
            f"{short} is too long, a word on the command line has at most {LONGEST_ARGUMENT} "
            f"characters"
        )


def check_regular(path: str | Path) -> None:
    """Raises InputError where there is no regular file: nothing there, a folder, a device, a
    pipe.
    """
    try:
        _check_mode(os.stat(path).st_mode, path)
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from None


def read_bytes(path: str | Path, limit: int = LIMIT_BYTES) -> bytes:
    """Return the content of a regular file of at most `limit` bytes.

    Raises InputError for anything else: missing, a directory or device, unreadable, too large.
    """
    check_regular(path)
    try:
        with _opened(path) as file:
            content = file.read(limit + 1)
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from None
    _READ.add(os.path.realpath(path))
    if len(content) > limit:
        raise InputError(f"{path}: the file is too large, it must not exceed {limit} bytes")
    return content


def hash_file(path: str | Path) -> str:
    """Return the SHA-256 of a regular file of any size. Raises InputError for anything else."""
    check_regular(path)
    try:
        with _opened(path) as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from None


def read_text(path: str | Path, limit: int = LIMIT_BYTES) -> str:
    """Return the UTF-8 text of a regular file of at most `limit` bytes.

    Raises InputError as `read_bytes` does, and for what is not UTF-8 or holds control characters.
    """
    return _decoded(read_bytes(path, limit), path)


def read_text_in_any_encoding(path: str | Path, limit: int = LIMIT_BYTES) -> tuple[str, str]:
    """Return the text of a regular file of at most `limit` bytes, and the name of its encoding.

    The encoding is that of the byte order mark, else UTF-16 if every other byte is zero, else
    UTF-8, else Windows-1252 or Latin-1. A mark of the end of the file behind the text (Ctrl-Z,
    zeros) is dropped. Raises InputError as `read_bytes` does, and for a text with control
    characters.
    """
    content = read_bytes(path, limit)
    for encoding in _list_encodings(content):
        try:
            text = content.decode(encoding)
            break
        except UnicodeDecodeError:
            continue
    else:
        raise InputError(
            f"{path}: the file is cut off within a character of {encoding}; save it again as UTF-8"
        )
    text = text.removeprefix("\ufeff").rstrip("\x00\x1a")
    check_text(text, str(path), len(content))
    return text, _ENCODINGS[encoding]


_ENCODINGS = {
    "utf-8": "UTF-8",
    "utf-16": "UTF-16",
    "utf-16-le": "UTF-16",
    "utf-16-be": "UTF-16",
    "cp1252": "Windows-1252",
    "latin-1": "Latin-1",
}


def _list_encodings(content: bytes) -> tuple[str, ...]:
    """Return the encodings to try."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return ("utf-16",)
    first = content[:ENCODING_SAMPLE]
    for encoding, high, low in (
        ("utf-16-le", first[1::2], first[::2]),
        ("utf-16-be", first[::2], first[1::2]),
    ):
        if 2 * high.count(0) > len(high) > 0 and 2 * low.count(0) < len(low):
            return (encoding,)
    return ("utf-8", "cp1252", "latin-1")


def read_toml(path: str | Path, parse_float: Callable[[str], float] = float) -> dict[str, Any]:
    """Return the tables of a TOML file. Raises InputError as `read_text` and `parse_toml` do."""
    return parse_toml(read_text(path), str(path), parse_float)


def read_json(
    path: str | Path, limit: int = LIMIT_BYTES, most_values: int = MOST_VALUES
) -> dict[str, Any]:
    """Return the object of a JSON file. Raises InputError as `read_text` and `parse_json` do."""
    return parse_json(read_text(path, limit), str(path), limit, most_values)


def check_text(text: str, source: str, limit: int = LIMIT_BYTES) -> None:
    """Raises InputError for a text that is too long, or that holds control characters or
    surrogates.
    """
    if len(text) > limit:
        raise InputError(f"{source}: the text is too long, it must not exceed {limit} characters")
    if control := CONTROL.search(text):
        line = text.count("\n", 0, control.start()) + 1
        raise InputError(
            f"{source}: line {line} holds the control character {control[0]!r}, which it must not"
        )


def parse_toml(
    text: str, source: str, parse_float: Callable[[str], float] = float
) -> dict[str, Any]:
    """Return the tables of a TOML text; `source` names it in the error, `parse_float` reads numbers
    with a point.

    Raises InputError with the line of the first syntax error, for control characters, and for what
    is nested too deep or too large to be such a file (`planter.text_files`).
    """
    check_text(text, source)
    check_nesting(text, source)
    try:
        table = tomllib.loads(text, parse_float=parse_float)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{source}: {_syntax_error(str(error), text)}") from None
    except ValueError:
        raise InputError(
            f"{source}: this is not usable TOML: a number has too many digits"
        ) from None
    check_values(table, source)
    return table


def parse_json(
    text: str, source: str, limit: int = LIMIT_BYTES, most_values: int = MOST_VALUES
) -> dict[str, Any]:
    """Return the object of a JSON text; `source` names it in the error.

    Raises InputError for what is no JSON or no object, for numbers that are not finite, strings
    with control characters or surrogates, and for what is nested too deep or too large
    (`planter.text_files`).
    """
    check_text(text, source, limit)
    check_nesting(text, source, most_values)
    try:
        table = json.loads(text, parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        raise InputError(
            f"{source}: line {error.lineno}: this is not valid JSON: {error.msg}"
        ) from None
    except ValueError:
        raise InputError(
            f"{source}: this is not usable JSON: a number is not finite or has too many digits"
        ) from None
    if not isinstance(table, dict):
        raise InputError(f"{source}: this is not a JSON object, which it must be")
    check_values(table, source, most_values)
    check_json_scalars(table, source)
    return table


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(name)


@contextmanager
def _opened(path: str | Path) -> Iterator[BufferedReader]:
    """Open a file for reading.

    Raises OSError, and InputError if it is not a regular file any more.
    """
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | _NO_WAITING)) as file:
        _check_mode(os.fstat(file.fileno()).st_mode, path)
        yield file


def _check_mode(mode: int, path: str | Path) -> None:
    if not stat.S_ISREG(mode):
        kind = "a directory" if stat.S_ISDIR(mode) else "a device or pipe"
        raise InputError(f"{path}: this is {kind}, but it must be a regular file")


def is_file(path: Path) -> bool:
    """Return whether there is a file at a path; a text that no system takes as one names none."""
    try:
        return path.is_file()
    except OSError:
        return False


def _unreadable(path: str | Path, error: OSError | ValueError) -> InputError:
    reason = error.strerror if isinstance(error, OSError) else str(error)
    return InputError(f"{str(path)!r}: the file cannot be read ({reason})")


def _decoded(content: bytes, path: str | Path) -> str:
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}: line {line} is not UTF-8 text, which it must be") from None
    check_text(text, str(path), len(content))
    return text


def _syntax_error(message: str, text: str) -> str:
    """Place and reason of a syntax error, with what is probably meant."""
    place = re.search(r" \(at (?:line (\d+).*|end of document)\)$", message)
    if place is None:
        return f"this is not valid TOML: {message}"
    line = text.splitlines()[int(place[1]) - 1] if place[1] else ""
    match = _DECIMAL_COMMA.search(line)
    pointed = safe_text.replace_decimal_comma(match[1]) if match else None
    hint = f" (with a decimal point: {pointed})" if pointed else ""
    return f"{place[0][5:-1]}: this is not valid TOML: {message[: place.start()]}{hint}"
