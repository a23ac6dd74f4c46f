"""Machine data from a TOML file as SI numbers, each by the unit that its key ends in."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

import mpmath
from mpmath import mpf

_IN_SI: dict[str, Callable[[], mpf]] = {
    "_mm_s": lambda: mpf("1e-3"),
    "_mm": lambda: mpf("1e-3"),
    "_deg_per_s": lambda: mpmath.pi / 180,
    "_deg": lambda: mpmath.pi / 180,
    "_rpm": lambda: mpmath.pi / 30,
    "_GPa": lambda: mpf("1e9"),
}
"""Endings of keys with what their unit is in SI, to the precision of the moment; any other ending is an SI unit."""


@dataclass(frozen=True)
class MachineFile:
    """Tables of a machine, decimal numbers as they are written."""

    tables: Mapping[str, Any]

    @classmethod
    def read(cls, path: Path) -> MachineFile:
        return cls(tomllib.loads(path.read_text(encoding="utf-8"), parse_float=Decimal))

    def si(self, place: str) -> mpf:
        """The number at ``section.key``, ``section.key[index]`` or ``section[index].key``, to the working precision."""
        value, key = self._at(place)
        return mpf(str(value)) * scale(key)

    def all_si(self, place: str) -> list[mpf]:
        """The numbers of a list."""
        values, key = self._at(place)
        return [mpf(str(value)) * scale(key) for value in values]

    def _at(self, place: str) -> tuple[Any, str]:
        """A value and its key."""
        value: Any = self.tables
        key = ""
        for key, index in re.findall(r"(\w+)(?:\[(\d+)\])?", place):
            value = value[key][int(index)] if index else value[key]
        return value, key


def scale(key: str) -> mpf:
    """What a unit at the end of a key is in SI."""
    return next((scale() for ending, scale in _IN_SI.items() if key.endswith(ending)), mpf(1))
