"""Quantities: symbols that have a unit, meaning and source; dimensions of expressions of them;
tables of them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from functools import cache
from keyword import iskeyword
from typing import NamedTuple

import sympy as sp
from sympy import Expr
from sympy.core.relational import Relational

from .functions import TabulatedFunction, Turns

_RESERVED: dict[str, str] = {}


def reserve(target: str, names: Iterable[str]) -> None:
    """Keep names for the code that is generated for a target: from now on they are refused."""
    _RESERVED.update(dict.fromkeys(names, target))


def refuse_name(kind: str, name: str) -> None:
    """Raise ValueError for a name that would break a generated module."""
    if not name.isidentifier():
        raise ValueError(f"{kind} {name}: the name must be a Python identifier")
    if iskeyword(name):
        raise ValueError(f"{kind} {name}: the name is a word of Python; write {name}_, or another")
    if name in _RESERVED:
        raise ValueError(
            f"{kind} {name}: generated {_RESERVED[name]} code needs that name; write {name}_, or "
            f"another"
        )


def word(name: str) -> str:
    """A name as part of another."""
    return "_".join("".join(c if c.isalnum() else " " for c in name).split())


class Quantity(sp.Symbol):
    """A real symbol with ``unit``, ``meaning`` and ``source``; two quantities are equal if their
    names and units are.

    ``unit`` is an SI unit such as "kg m2", "rad/s" or "1"; ``shown`` is the key of a machine file
    under which users see the value, such as "mass.sun_kg". Raises ValueError if a part is empty, or
    for a name that is a word of Python or that the generated code of some target needs for itself.

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
        self.unit, self.source, self.shown = unit, source, shown
        self.meaning = " ".join(meaning.split())  # comments of generated code are lines
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
    """A packed input whose length is not known here; ``known`` names the entries that are, by
    index.

    ``suffix`` is what tells the entries from those of other vectors of the kind: the number of the
    gear. ``sized_by`` is what it is as long as: a function that is composed at run time, and the
    argument of it.
    """

    name: str
    meaning: str
    known: Mapping[int, Quantity] = field(hash=False)
    suffix: str = ""
    sized_by: tuple[str, str] | None = None

    def __post_init__(self) -> None:
        refuse_name("vector", self.name)


Exponent = int | Fraction
"""The exponent of a unit: an int where it is whole, which adds up twenty times as fast as a
fraction.
"""
Dimension = tuple[Exponent, Exponent, Exponent]
NONE: Dimension = (0, 0, 0)
_BASE: dict[str, Dimension] = {
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "N": (1, 1, -2),
    "W": (1, 2, -3),
    "J": (1, 2, -2),
    "rad": (0, 0, 0),
    "1": (0, 0, 0),
}


class DimensionError(ValueError):
    """An expression adds, compares or feeds to a function what does not fit."""


@cache
def of_unit(unit: str) -> Dimension:
    """Exponents of kg, m, s in a unit such as ``kg m2``, ``m/s2`` or ``N/m1.5``; angles are pure
    numbers.
    """
    total = NONE
    for sign, part in zip((1, -1), unit.split("/"), strict=False):
        for name, power in re.findall(r"([A-Za-z]+|1)(\d*(?:\.\d+)?)", part):
            total = _plus(total, raise_dimension(_BASE[name], sign * Fraction(power or 1)))
    return total


def dimension(expr: Expr) -> Dimension | None:
    """Dimension of an expression; None for a zero, which fits everywhere.

    Raises DimensionError where it has none.
    """
    if expr.is_Symbol:
        return of_unit(expr.unit) if isinstance(expr, Quantity) else NONE
    if isinstance(expr, TabulatedFunction):  # which has checked its argument
        return expr.exponents
    if expr.is_number:
        return None if expr.is_zero else NONE
    if isinstance(expr, sp.Add | sp.Min | sp.Max):
        return _same(expr.args, expr)
    if isinstance(expr, sp.Mul):
        parts = [dimension(a) for a in expr.args]
        return None if None in parts else _sum(p for p in parts if p is not None)
    if isinstance(expr, sp.Pow):
        return _power(expr)
    if isinstance(expr, sp.Piecewise):
        for _, condition in expr.args:
            _check_condition(condition)
        return _same([value for value, _ in expr.args], expr)
    if isinstance(expr, sp.Abs):
        return dimension(expr.args[0])
    return _of_function(expr)


def is_consistent(expr: Expr) -> bool:
    """Whether all that an expression joins has one dimension."""
    try:
        dimension(expr)
    except DimensionError:
        return False
    return True


def _of_function(expr: Expr) -> Dimension:
    if isinstance(expr, sp.atan2):
        _same(expr.args, expr)
    elif isinstance(expr, Turns | sp.floor | sp.Function) and not isinstance(expr, sp.sign):
        for argument in expr.args:
            if dimension(argument) not in (None, NONE):
                raise DimensionError(f"the argument of {expr} has a dimension")
    return NONE


def _power(expr: Expr) -> Dimension | None:
    base, exponent = expr.args
    base_dimension = dimension(base)
    if base_dimension is None or base_dimension == NONE:
        return base_dimension
    exponent = exact_power(exponent)
    if not isinstance(exponent, sp.Rational):
        raise DimensionError(f"{expr} raises a dimension to a power that is no fraction")
    return raise_dimension(base_dimension, Fraction(exponent.p, exponent.q))


LARGEST_DENOMINATOR = 1000
"""Of a fraction that a decimal power may stand for."""


def exact_power(power: Expr) -> Expr:
    """Return the fraction that a decimal power stands for, any other power as it is.

    >>> exact_power(sp.Float(1.5)), exact_power(sp.Float(1 / 3))
    (3/2, 1/3)
    """
    if not isinstance(power, sp.Float):
        return power
    fraction = Fraction(float(power)).limit_denominator(LARGEST_DENOMINATOR)
    is_same = float(fraction) == float(power)
    return sp.Rational(fraction.numerator, fraction.denominator) if is_same else power


def _check_condition(condition: sp.Basic) -> None:
    for relation in condition.atoms(Relational):
        _same(relation.args, relation)


def _same(args: Iterable[Expr], expr: sp.Basic) -> Dimension | None:
    dimensions = {d for d in map(dimension, args) if d is not None}
    if len(dimensions) > 1:
        raise DimensionError(f"{expr} joins different dimensions")
    return dimensions.pop() if dimensions else None


def _plus(a: Dimension, b: Dimension) -> Dimension:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def raise_dimension(base: Dimension, power: Exponent) -> Dimension:
    """Return the dimension of a power."""
    kg, m, s = (
        product.numerator if product.denominator == 1 else product
        for product in (e * power for e in base)
    )
    return kg, m, s


def _sum(parts: Iterable[Dimension]) -> Dimension:
    total = NONE
    for part in parts:
        total = _plus(total, part)
    return total


@dataclass(frozen=True)
class Datum:
    """A value in its shown unit as it was written, with bounds if it has any."""

    value: Decimal
    bounds: tuple[Decimal, Decimal] | None = None


class ShownUnit(NamedTuple):
    """A unit that people write: its value in the unit `si`, and how it ends a key."""

    si: str
    factor: Expr
    ending: str


SHOWN = {
    "mm": ShownUnit("m", sp.Rational(1, 1000), "mm"),
    "cm": ShownUnit("m", sp.Rational(1, 100), "cm"),
    "mm/s": ShownUnit("m/s", sp.Rational(1, 1000), "mm_s"),
    "km/h": ShownUnit("m/s", sp.Rational(5, 18), "km_h"),
    "deg": ShownUnit("rad", sp.pi / 180, "deg"),
    "deg/s": ShownUnit("rad/s", sp.pi / 180, "deg_per_s"),
    "r/min": ShownUnit("rad/s", sp.pi / 30, "rpm"),
    "kN": ShownUnit("N", sp.Integer(1000), "kN"),
    "kN/m": ShownUnit("N/m", sp.Integer(1000), "kN_m"),
    "kW": ShownUnit("W", sp.Integer(1000), "kW"),
    "MPa": ShownUnit("N/m2", sp.Integer(10**6), "MPa"),
    "GPa": ShownUnit("N/m2", sp.Integer(10**9), "GPa"),
}
"""Units that are converted to those of SI."""
_ENDINGS = {"N m": "Nm", "1": ""}


def find_factor(key: str) -> Expr:
    """Return the value in SI of the unit that ends a key.

    >>> find_factor("values.speed_km_h"), find_factor("values.stiffness_N_m")
    (5/18, 1)
    """
    endings = {f"_{unit.ending}": unit.factor for unit in SHOWN.values()}
    matching = [ending for ending in endings if key.endswith(ending)]
    return endings[max(matching, key=len)] if matching else sp.S.One


SECTION = "values"


class TableError(ValueError):
    """A line of a table of quantities says something that cannot be meant."""


class Quantities(Mapping[str, Quantity]):
    """Quantities by name, as attributes or by key, in the order of their table.

    ``data`` holds the values and bounds of those that have any, as they were written, in the units
    of the table.

    >>> q = quantities("r | mm | crank | 50 | 30 80")
    >>> q.r.unit, q["r"].meaning, q.data["r"].value, q.data["r"].bounds
    ('m', 'crank', Decimal('50'), (Decimal('30'), Decimal('80')))
    """

    def __init__(self, by_name: Mapping[str, Quantity], data: Mapping[str, Datum]) -> None:
        self._by_name, self.data = dict(by_name), dict(data)

    def __getitem__(self, name: str) -> Quantity:
        return self._by_name[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name)

    def __len__(self) -> int:
        return len(self._by_name)

    def __getattr__(self, name: str) -> Quantity:
        by_name = self.__dict__.get("_by_name", {})
        if name not in by_name:
            raise AttributeError(f"there is no quantity {name}; the table has {', '.join(by_name)}")
        quantity: Quantity = by_name[name]
        return quantity

    def select(self, names: str) -> tuple[Quantity, ...]:
        """Return the quantities whose names stand in a text, in its order."""
        return tuple(self[name] for name in names.split())


NOTHING = Quantities({}, {})


def quantities(text: str, source: str = "own", section: str = SECTION) -> Quantities:
    """Return the quantities of a table of lines ``name | unit | meaning | value | lower upper``; #
    begins a comment.

    Value and bounds, for data only, are in the unit of their line: an SI unit (``kg m2``, ``N/m``,
    ``1``) or one of `SHOWN`, such as mm, deg, r/min, km/h, kN, which are converted; quantities
    themselves are in SI. ``section`` is that of the machine file which holds the values; without one no file does.
    Raises TableError, which names the line.

    >>> q = quantities('''
    ...     phi   | rad   | crank angle
    ...     omega | r/min | crank speed | 300           # no bounds: it does not vary in a search
    ...     r     | mm    | crank       | 50   | 30 80
    ... ''')
    >>> q.omega.unit, q.r.shown, sorted(q.data)
    ('rad/s', 'values.r_mm', ['omega', 'r'])
    """
    by_name: dict[str, Quantity] = {}
    data: dict[str, Datum] = {}
    for number, line in enumerate(text.splitlines(), 1):
        cells = [cell.strip() for cell in line.split("#", 1)[0].split("|")]
        if cells == [""]:
            continue
        try:
            quantity = _quantity(cells, source, section)
            if quantity.name in by_name:
                raise TableError(f"{quantity.name} stands twice")
            by_name[quantity.name] = quantity
            if len(cells) > 3:
                data[quantity.name] = _datum(cells[3:])
        except ValueError as error:
            raise TableError(f"line {number} of the table, '{line.strip()}': {error}") from None
    return Quantities(by_name, data)


def read_quantities(text: str) -> Quantities:
    """Read the quantities of a built-in machine: `name | unit | meaning | key`, in SI units.

    A line without a bar is the source of the lines below it. The key, that of the machine file or
    of a result, may be absent.
    """
    by_name: dict[str, Quantity] = {}
    source = ""
    for line in filter(None, text.splitlines()):
        name, *rest = (cell.strip() for cell in line.split("|"))
        if rest:
            unit, meaning, *key = rest
            by_name[name] = Quantity(name, unit, meaning, source, *key)
        else:
            source = name
    return Quantities(by_name, {})


def _quantity(cells: list[str], source: str, section: str) -> Quantity:
    if not 3 <= len(cells) <= 5 or not all(cells[:3]):
        raise TableError(
            "a line says name | unit | meaning, and for data also | value | lower upper"
        )
    name, written_unit, meaning = cells[:3]
    converted = SHOWN.get(written_unit)
    unit = converted.si if converted else written_unit
    try:
        of_unit(unit)
    except KeyError as error:
        raise TableError(
            f"{written_unit} is no unit: {error.args[0]} is not known; SI units and "
            f"{', '.join(SHOWN)} are"
        ) from None
    si_ending = unit.replace("/", "_").replace(" ", "_").replace(".", "")
    ending = converted.ending if converted else _ENDINGS.get(unit, si_ending)
    key = f"{section}.{name}_{ending}" if ending else f"{section}.{name}"
    return Quantity(name, unit, meaning, source, key if section else "")


def _datum(cells: list[str]) -> Datum:
    value = _number(cells[0])
    if len(cells) < 2:
        return Datum(value)
    ends = cells[1].split()
    if len(ends) != 2:
        raise TableError(f"bounds are two numbers, lower and upper, not '{cells[1]}'")
    lower, upper = map(_number, ends)
    if not lower < upper:
        raise TableError(f"the lower bound {lower} is not below the upper {upper}")
    return Datum(value, (lower, upper))


def _number(text: str) -> Decimal:
    try:
        number = Decimal(text)
    except InvalidOperation:
        hint = f"; write {text.replace(',', '.')}" if "," in text else ""
        raise TableError(f"'{text}' is no number{hint}") from None
    if not number.is_finite():
        raise TableError(f"'{text}' is not finite")
    return number
