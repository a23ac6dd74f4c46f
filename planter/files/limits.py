"""What a file may hold at most: how deep it is nested, how many values, how long a name. All of it in linear time."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

from planter import safe_text
from planter.errors import InputError
from planter.files import paths

DEEPEST = 16
"""Levels of nested tables and lists."""
MOST_VALUES = 10_000
"""Names of tables and values, and items of lists."""
MARKS_PER_VALUE = 5
"""Brackets, points and signs between values for each value: more are told before anything is parsed."""
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
    """Raise InputError for a TOML or JSON text nested too deep, in brackets or by dots, or with too many values.

    Parsing dots takes memory without end, parsing brackets the stack. An open string ends with the file or its line;
    that it is open the parser will tell. What is a comment or a string in TOML alone is where a parser of JSON stops.
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
            raise InputError(f"{source}: line {line}: this is nested too deep, it must not exceed {DEEPEST} levels")


def check_values(table: Mapping[str, Any], source: str, most_values: int = MOST_VALUES) -> None:
    """Raise InputError for a parsed table that is too deep or too large, for long names and numbers beyond 64 bits."""
    for count, (location, value) in enumerate(paths.places(table), 1):
        name = str(location[-1])
        if len(name) > LONGEST_NAME:
            short = safe_text.quote_name(name)
            raise InputError(f"{source}: the name {short} is too long, it must not exceed {LONGEST_NAME} characters")
        if len(location) > DEEPEST:
            raise InputError(f"{source}: {name} is nested too deep, it must not exceed {DEEPEST} levels")
        if isinstance(value, int) and abs(value) >= LARGEST_WHOLE:
            entry = f"{safe_text.quote_name(paths.join(location))} = {safe_text.format_value(value)}"
            raise InputError(f"{source}: {entry} is not allowed: it must be a number of fewer digits, or have a point")
        if count > most_values:
            raise InputError(f"{source}: {_too_many(most_values)}")


def _too_many(most_values: int) -> str:
    return f"there are too many values, they must not exceed {most_values}"


def check_json_scalars(table: Mapping[str, Any], source: str) -> None:
    """Raise InputError for what JSON can write and nothing here can take: 1e999, a surrogate, a control character."""
    for location, value in paths.places(table):
        for text in (location[-1], value):
            if isinstance(text, str) and CONTROL.search(text):
                raise InputError(
                    f"{source}: {safe_text.quote_name(paths.join(location))} holds a character that no text has"
                )
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{source}: {safe_text.quote_name(paths.join(location))} is not a finite number")
