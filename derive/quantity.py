"""Quantities: symbols that know their unit, meaning and source."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import sympy as sp


class Quantity(sp.Symbol):
    """A real symbol with unit, meaning and source; two quantities are equal when their names and units are.

    ``unit`` is an SI unit such as ``"kg m2"``, ``"rad/s"`` or ``"1"``; ``shown`` is where a user finds the value
    (``"mass.sun_kg"``).
    """

    unit: str
    meaning: str
    source: str
    shown: str

    def __new__(cls, name: str, unit: str, meaning: str, source: str, shown: str = "") -> Quantity:
        if not (unit and meaning and source):
            raise ValueError(f"quantity {name}: unit, meaning and source are all needed")
        if not name.isidentifier():
            raise ValueError(f"quantity {name}: the name must be a Python identifier")
        self = sp.Symbol.__xnew__(cls, name, real=True)
        self.unit, self.meaning, self.source, self.shown = unit, meaning, source, shown
        return self

    def _hashable_content(self) -> tuple[object, ...]:
        return (*super()._hashable_content(), self.unit)

    def __getnewargs_ex__(self) -> tuple[tuple[str, ...], dict[str, str]]:
        return (self.name, self.unit, self.meaning, self.source, self.shown), {}


@dataclass(frozen=True)
class Vector:
    """A packed input or output: an order of quantities under one name."""

    name: str
    quantities: tuple[Quantity, ...]

    def __iter__(self) -> Iterator[Quantity]:
        return iter(self.quantities)

    def __len__(self) -> int:
        return len(self.quantities)


@dataclass(frozen=True)
class OpenVector:
    """A packed input whose length is not known here; ``known`` names the entries that are, by index.

    ``suffix`` is what tells the entries from those of other vectors of the kind: the number of the gear.
    ``sized_by`` is what it is as long as: a function that is composed at run time, and the argument of it.
    """

    name: str
    meaning: str
    known: Mapping[int, Quantity] = field(hash=False)
    suffix: str = ""
    sized_by: tuple[str, str] | None = None
