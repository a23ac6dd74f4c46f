"""Text of strangers made fit to be shown: no control characters, on one line, and no longer than need be."""

import json
import math
import re
import unicodedata

KEPT = "\n\t"
"""Control characters that a text of several lines may hold."""
LONGEST = 1500
"""Characters of a message at most."""
_SHOWN_AT_MOST = 60
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
_HIDDEN = {"Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp"}


def text(raw: str) -> str:
    """A text in which what cannot be seen is written out; lines and tabs stay.

    >>> text("a\\x1b[31m red\\n")
    'a\\\\x1b[31m red\\n'
    """
    if raw.isascii() and raw.isprintable():
        return raw
    return "".join(one if one in KEPT or not hidden(one) else _written_out(one) for one in raw)


def line(raw: str, longest: int = LONGEST) -> str:
    """A text on one line, with no spaces that only look like one; of one that is too long the middle is left out.

    >>> line("two\\nlines"), line("abcdefghijkl", 9)
    ('two\\\\nlines', 'abc...jkl')
    """
    short = _without_middle(raw, longest)
    return _without_middle("".join(one if one.isprintable() else _written_out(one) for one in short), longest)


def name(raw: str) -> str:
    """A name as it is shown, in quotes where it holds what cannot be seen, or nothing."""
    short = _cut(raw)
    return short if short and short.isprintable() else json.dumps(short)


def value(given: object) -> str:
    """A value as a TOML file would show it, on one line of reasonable length."""
    if isinstance(given, float) and not math.isfinite(given):
        return str(given)
    try:
        return _cut(json.dumps(given, default=str))
    except ValueError:  # a whole number of more digits than Python writes
        return _cut(f"{given:#x}") if isinstance(given, int) else "..."


def with_point(raw: str) -> str | None:
    """A number with a decimal comma, written with a point; None for anything else.

    >>> with_point("1,20"), with_point("1.20"), with_point("1,2,3")
    ('1.20', None, None)
    """
    return raw.strip().replace(",", ".") if _DECIMAL_COMMA.fullmatch(raw.strip()) else None


def hidden(one: str) -> bool:
    """Whether a character cannot be seen: control and format characters, surrogates, line separators."""
    return unicodedata.category(one) in _HIDDEN


def _written_out(one: str) -> str:
    return one.encode("unicode_escape").decode("ascii")


def _without_middle(raw: str, longest: int) -> str:
    part = (longest - 3) // 2
    return raw if len(raw) <= longest else f"{raw[:part]}...{raw[-part:]}"


def _cut(raw: str) -> str:
    return raw if len(raw) <= _SHOWN_AT_MOST else raw[:_SHOWN_AT_MOST] + "..."
