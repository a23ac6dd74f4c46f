"""Values that a table gives, and others near them."""

from __future__ import annotations

import random

from mpmath import mpf

from ...audit.case import change_slightly
from ...machine_file import scale
from ...mechanics.mechanism import Mechanism
from ...mechanics.statement import MechanismError
from ...quantity import Quantity
from ...table import Quantities

SPREAD = 0.2
"""Data without bounds are tried within this share of their values."""
Values = dict[Quantity, mpf]


def values(given: Quantities) -> Values:
    """The values that a table gives, in SI."""
    return {given[name]: mpf(str(datum.value)) * scale(given[name].shown) for name, datum in given.data.items()}


def ends(given: Quantities, own: Values) -> dict[Quantity, tuple[mpf, mpf]]:
    """Between what data are tried: their bounds, else near their values."""
    found = {}
    for quantity, value in own.items():
        bounds = given.data[quantity.name].bounds
        low, high = (value * (1 - SPREAD), value * (1 + SPREAD))
        if bounds is not None:
            low, high = (mpf(str(end)) * scale(quantity.shown) for end in bounds)
        found[quantity] = low, high
    return found


def drawn(given: Quantities, own: Values, rng: random.Random) -> Values:
    """Random ones between their ends."""
    return {q: mpf(rng.uniform(*map(float, pair))) for q, pair in ends(given, own).items()}


def draw_near(own: Values, rng: random.Random) -> Values:
    """Values that differ a little from those of a machine, so that none of them is special."""
    return {q: value + change_slightly(value, rng) for q, value in own.items()}


def of(mechanism: Mechanism) -> Values:
    """The values of a mechanism but for its angle. Raises MechanismError for one that its table does not give."""
    for quantity in mechanism.given.values():
        if quantity != mechanism.angle and quantity.name not in mechanism.given.data:
            raise MechanismError(f"{mechanism.name}: the table gives no value of {quantity}")
    return {q: value for q, value in values(mechanism.given).items() if q != mechanism.angle}
