"""Untrusted text made safe to print: without control characters, on one line, and of limited
length.
"""

import json
import math
import re
import unicodedata

ALLOWED_CONTROLS = "\n\t"
"""Control characters which a text of several lines may contain."""
MAX_LENGTH = 1500
"""Maximum number of characters in a message."""
_MAX_VALUE_LENGTH = 60
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
_INVISIBLE = {"Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp"}


def sanitise_text(raw: str) -> str:
    """Return a text with its invisible characters escaped, except line breaks and tabs.

    >>> sanitise_text("a\\x1b[31m red\\n")
    'a\\\\x1b[31m red\\n'
    """
    if raw.isascii() and raw.isprintable():
        return raw
    return "".join(c if c in ALLOWED_CONTROLS or not is_invisible(c) else _escape(c) for c in raw)


def sanitise_line(raw: str, max_length: int = MAX_LENGTH) -> str:
    """Return a text on one line, with all spaces but the plain one escaped, and without its middle
    if it is too long.

    >>> sanitise_line("two\\nlines"), sanitise_line("abcdefghijkl", 9)
    ('two\\\\nlines', 'abc...jkl')
    """
    short = _drop_middle(raw, max_length)
    return _drop_middle("".join(c if c.isprintable() else _escape(c) for c in short), max_length)


def quote_name(raw: str) -> str:
    """Return a name for a message, in quotes if it is empty or contains invisible characters."""
    short = _truncate(raw)
    return short if short and short.isprintable() else json.dumps(short)


def format_value(value: object) -> str:
    """Return a value as a TOML file would write it, on one line of limited length."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    try:
        return _truncate(json.dumps(value, default=str))
    except ValueError:  # an integer of more digits than Python writes
        return _truncate(f"{value:#x}") if isinstance(value, int) else "..."


def replace_decimal_comma(raw: str) -> str | None:
    """Return a number with a decimal comma, written with a point, or None for any other text.

    >>> replace_decimal_comma("1,20"), replace_decimal_comma("1.20"), replace_decimal_comma("1,2,3")
    ('1.20', None, None)
    """
    return raw.strip().replace(",", ".") if _DECIMAL_COMMA.fullmatch(raw.strip()) else None


def is_invisible(character: str) -> bool:
    """Return whether a character is invisible: control and format characters, surrogates, line
    separators.
    """
    return unicodedata.category(character) in _INVISIBLE


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")


def _drop_middle(raw: str, max_length: int) -> str:
    part = (max_length - 3) // 2
    return raw if len(raw) <= max_length else f"{raw[:part]}...{raw[-part:]}"


def _truncate(raw: str) -> str:
    return raw if len(raw) <= _MAX_VALUE_LENGTH else raw[:_MAX_VALUE_LENGTH] + "..."


_LONGEST_FILE_NAME = 80
"""Characters of a file's name without its ending."""
_LONGEST_BYTES = 200
"""The same in UTF-8: file systems allow 255 bytes for the whole name."""
_RESERVED = re.compile(r"(CON|PRN|AUX|NUL|COM\d|LPT\d)(\..*)?", re.IGNORECASE)
"""Names that Windows keeps for devices, whatever follows the dot."""


def file_name(name: str) -> str:
    """Return a name as the name of a file without its ending, on every system, in the folder that
    it is put in.

    Letters and digits of any script stay, what separates folders or cannot be seen becomes `_`.

    >>> file_name("wang2017"), file_name("/etc/passwd"), file_name("../a b"), file_name("nul"), file_name("..")
    ('wang2017', '_etc_passwd', '_a b', '_nul', '_')
    """
    plain = "".join(
        sign if _is_allowed(sign) else "_" for sign in unicodedata.normalize("NFC", name)
    )
    short = (
        plain.lstrip(". -")[:_LONGEST_FILE_NAME]
        .encode()[:_LONGEST_BYTES]
        .decode(errors="ignore")
        .rstrip(". ")
    )
    return f"_{short}" if not short or _RESERVED.fullmatch(short) else short


def _is_allowed(sign: str) -> bool:
    return sign.isalnum() or sign in "_-+.,=@() " or unicodedata.category(sign) in ("Mn", "Mc")
