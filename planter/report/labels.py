"""Readable labels for keys, and cells for values, of results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from planter.files import units
from planter.report.html import Cell


def label(key: str) -> str:
    """Return a key as a label with its unit.

    >>> label("variance_N2"), label("start_objective"), label("seconds")
    ('variance / N2', 'start objective', 'seconds')
    """
    unit = units.unit(key)
    return f"{name(key)} / {unit}" if unit else spaced(key)


def name(key: str) -> str:
    """Return a key as words without its unit; symbols such as F_A1x keep their underscore."""
    unit = units.unit(key)
    if not unit:
        return spaced(key)
    stem = key
    while units.unit(key[len(stem) :]) != unit:
        stem = stem.rpartition("_")[0]
    return spaced(stem)


def spaced(key: str) -> str:
    """Return a key as words, unless it contains a symbol."""
    return key if any(c.isupper() for c in key) else key.replace("_", " ")


def flat(value: Any) -> Cell:
    """Return a value as one cell of a table."""
    if isinstance(value, list | tuple):
        return ", ".join(str(flat(item)) for item in value) or None
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {flat(item)}" for key, item in value.items())
    cell: Cell = value
    return cell
