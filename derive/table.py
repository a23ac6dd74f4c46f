"""A table of quantities as a person writes it: a line each, with unit, meaning, and, for data, value and bounds.

>>> q = quantities('''
...     phi | rad | crank angle
...     r   | mm  | crank       | 50 | 30 80
... ''')
>>> q.r.unit, q.r.shown, q["phi"].meaning
('m', 'values.r_mm', 'crank angle')
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from decimal import Decimal, InvalidOperation

from .datum import Datum
from .dimensions import of_unit
from .quantity import Quantity

SHOWN = {"mm": "m", "mm/s": "m/s", "deg": "rad", "deg/s": "rad/s", "r/min": "rad/s", "GPa": "N/m2"}
"""Units that people write, with those of SI."""
_ENDINGS = {"deg/s": "deg_per_s", "r/min": "rpm", "N m": "Nm", "1": ""}
SECTION = "values"


class TableError(ValueError):
    """A line of a table of quantities says something that cannot be meant."""


class Quantities(Mapping[str, Quantity]):
    """Quantities by name, as attributes or by key, in the order of their table.

    ``data`` holds the values and bounds of those that have any, as they were written, in the units of the table.

    >>> q = quantities("r | mm | crank | 50 | 30 80")
    >>> q.r.unit, q["r"].meaning, q.data["r"].value, q.data["r"].bounds
    ('m', 'crank', Decimal('50'), (Decimal('30'), Decimal('80')))
    """

    def __init__(self, known: Mapping[str, Quantity], data: Mapping[str, Datum]) -> None:
        self._known, self.data = dict(known), dict(data)

    def __getitem__(self, name: str) -> Quantity:
        return self._known[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)

    def __getattr__(self, name: str) -> Quantity:
        known = self.__dict__.get("_known", {})
        if name not in known:
            raise AttributeError(f"there is no quantity {name}; the table has {', '.join(known)}")
        found: Quantity = known[name]
        return found


NOTHING = Quantities({}, {})


def quantities(text: str, source: str = "own", section: str = SECTION) -> Quantities:
    """Return the quantities of a table of lines ``name | unit | meaning | value | lower upper``; # begins a comment.

    Value and bounds, for data only, are in the unit of their line: an SI unit (``kg m2``, ``N/m``, ``1``) or mm, mm/s,
    deg, deg/s, r/min, GPa, which are converted; quantities themselves are in SI. ``section`` is that of the machine
    file which holds the values; without one no file does. Raises TableError, which names the line.

    >>> q = quantities('''
    ...     phi   | rad   | crank angle
    ...     omega | r/min | crank speed | 300           # no bounds: it does not vary in a search
    ...     r     | mm    | crank       | 50   | 30 80
    ... ''')
    >>> q.omega.unit, q.r.shown, sorted(q.data)
    ('rad/s', 'values.r_mm', ['omega', 'r'])
    """
    known: dict[str, Quantity] = {}
    data: dict[str, Datum] = {}
    for number, line in enumerate(text.splitlines(), 1):
        cells = [cell.strip() for cell in line.split("#", 1)[0].split("|")]
        if cells == [""]:
            continue
        try:
            quantity = _quantity(cells, source, section)
            if quantity.name in known:
                raise TableError(f"{quantity.name} stands twice")
            known[quantity.name] = quantity
            if len(cells) > 3:
                data[quantity.name] = _datum(cells[3:])
        except ValueError as error:
            raise TableError(f"line {number} of the table, '{line.strip()}': {error}") from None
    return Quantities(known, data)


def _quantity(cells: list[str], source: str, section: str) -> Quantity:
    if not 3 <= len(cells) <= 5 or not all(cells[:3]):
        raise TableError("a line says name | unit | meaning, and for data also | value | lower upper")
    name, shown, meaning = cells[:3]
    unit = SHOWN.get(shown, shown)
    try:
        of_unit(unit)
    except KeyError as error:
        raise TableError(
            f"{shown} is no unit: {error.args[0]} is not known; SI units and {', '.join(SHOWN)} are"
        ) from None
    ending = _ENDINGS.get(shown, shown.replace("/", "_").replace(" ", "_"))
    place = f"{section}.{name}_{ending}" if ending else f"{section}.{name}"
    return Quantity(name, unit, meaning, source, place if section else "")


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
