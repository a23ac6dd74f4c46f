"""Quantities: symbols that know their unit, meaning and source."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from keyword import iskeyword

import sympy as sp

_RESERVED: dict[str, str] = {}


def reserve(target: str, names: Iterable[str]) -> None:
    """Keep names for the code that is generated for a target: from now on they are refused."""
    _RESERVED.update(dict.fromkeys(names, target))


def refuse_name(what: str, name: str) -> None:
    """Raise ValueError for a name that would break a generated module."""
    if not name.isidentifier():
        raise ValueError(f"{what} {name}: the name must be a Python identifier")
    if iskeyword(name):
        raise ValueError(f"{what} {name}: the name is a word of Python; write {name}_, or another")
    if name in _RESERVED:
        raise ValueError(f"{what} {name}: generated {_RESERVED[name]} code needs that name; write {name}_, or another")


def word(name: str) -> str:
    """A name as part of another."""
    return "_".join("".join(c if c.isalnum() else " " for c in name).split())


class Quantity(sp.Symbol):
    """A real symbol with ``unit``, ``meaning`` and ``source``; two quantities are equal if their names and units are.

    ``unit`` is an SI unit such as "kg m2", "rad/s" or "1"; ``shown`` is the key of a machine file under which users see
    the value, such as "mass.sun_kg". Raises ValueError if a part is empty, or for a name that is a word of Python or
    that the generated code of some target needs for itself.

    >>> Quantity("r", "m", "crank", "own").unit
    'm'
    """

    unit: str
    meaning: str
    source: str
    shown: str

    def __new__(cls, name: str, unit: str, meaning: str, source: str, shown: str = "") -> Quantity:
        if not (unit and meaning and source):
            raise ValueError(f"quantity {name}: unit, meaning and source are all needed")
        refuse_name("quantity", name)
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

    def __post_init__(self) -> None:
        refuse_name("vector", self.name)

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

    def __post_init__(self) -> None:
        refuse_name("vector", self.name)
