"""Spellings of a quantity's name: results, tables and pages print it in several, and each is
accepted everywhere.

A name is a symbol (`F_A1x`), a key with its unit (`F_A1x_N`), or its words (`bearing A1`); a page
writes the meaning with the symbol in brackets. A force with components has their common name
(`F_A1`), too.
"""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterable, Mapping
from typing import TypeVar

from planter.files import units

_SYMBOL = re.compile(r"(.+) \(([^()]+)\)")


Key = TypeVar("Key", bound=Hashable)


def find_spelled(name: str, spellings: Mapping[Key, Iterable[str]]) -> list[Key]:
    """Return the keys one of whose `spellings` a text is: exactly, or else with other spaces, or
    capital letters.

    >>> forces = {"bearing_A1": list_spellings("bearing_A1", "bearing_A1_N", "", ("F_A1x", "F_A1y"))}
    >>> [find_spelled(name, forces) for name in ("bearing A1", "F_A1", "Bearing A1", "bearing_A1_N", "bearing")]
    [['bearing_A1'], ['bearing_A1'], ['bearing_A1'], ['bearing_A1'], []]
    """
    if bracketed := _SYMBOL.fullmatch(name.strip()):
        return find_spelled(bracketed[2], spellings)
    for form in (str.strip, _join_words, lambda text: _join_words(text).casefold()):
        target = form(name)
        matches = [key for key, ways in spellings.items() if target in map(form, ways)]
        if matches:
            return matches
    return []


def list_spellings(
    name: str, key: str, meaning: str = "", components: tuple[str, ...] = ()
) -> tuple[str, ...]:
    """Return the spellings of a quantity with a key, or of the size of a vector with components."""
    stem = key.removesuffix(units.unit_suffix(key))
    spellings = [name, key, stem, meaning]
    ends = {part[:-1] for part in components if part[-1:] in "xyz"}
    if len(ends) == 1 and len(components) == len({part[-1:] for part in components}):
        spellings += [end.rstrip("_") for end in ends]
    return tuple(dict.fromkeys(filter(None, spellings)))


def _join_words(name: str) -> str:
    return re.sub(r"[\s_,]+", "_", name.strip())
