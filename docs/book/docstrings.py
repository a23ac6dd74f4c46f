"""Docstrings of the project, plain text with `names` in backticks, as reStructuredText."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_CODE = re.compile(r"``?([^`]+)``?")
_MARKUP = re.compile(r"([*|\\]|(?<=\w)_(?=\W|$))")


def line(text: str) -> str:
    """A line with code as code, and what would be markup as it stands.

    >>> line("`x` is *not* x_ |y|")
    '``x`` is \\\\*not\\\\* x\\\\_ \\\\|y\\\\|'
    """
    parts = _CODE.split(text)
    return "".join(
        f"``{part}``" if index % 2 else _MARKUP.sub(r"\\\1", part)
        for index, part in enumerate(parts)
    )


def as_restructured_text(
    app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]
) -> None:
    """Sphinx calls this for each docstring; examples stay as they are, indented text is shown as it stands.

    Text that is indented by four spaces, after a colon and an empty line, is code.
    """
    found: list[str] = []
    example = block = False
    for text in lines:
        example = bool(text) and (example or text.startswith(">>>"))
        opens = len(found) > 1 and not found[-1] and found[-2].endswith(":")
        if text.startswith("    ") and opens:
            found += ["::", ""]
        block = text.startswith("    ") and (block or opens)
        if example or block:
            found.append(text)
        elif text.startswith(" ") and not (found and found[-1].startswith(("|", "*"))):
            found.append(f"| {line(text.strip())}")
        else:
            if found and found[-1].startswith("| ") and text:
                found.append("")
            found.append(line(text))
    lines[:] = found
