"""What commands and their files are called on a page: nobody there used a command line, or knows a temporary file."""

from __future__ import annotations

from collections.abc import Mapping

from planter.files.complaints import SET

HINTS = {
    f" ({SET})": "",
    "rename it, choose another --out, or add --overwrite": "rename it, or move it elsewhere",
}
"""Parts of a sentence that speak of the command line, and what a page says instead."""


def to_page_words(sentence: str, labels: Mapping[str, str]) -> str:
    """Return a sentence as a page says it; `labels` are the names of files by their paths."""
    for before, after in {**labels, **HINTS}.items():
        sentence = sentence.replace(before, after)
    return sentence
