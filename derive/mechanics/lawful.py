"""The laws of a stated mechanism by name: what must vanish, whatever the mechanism is."""

from __future__ import annotations

from collections.abc import Sequence

from sympy import Expr

from ..model import Let, let
from ..quantity import Quantity
from . import laws
from .bodies import AXES
from .statement import Statement, quantity

LAW = "law_"
"""Beginning of the names of laws."""
VANISHES = ", which vanishes"
WORK = {"rad": "N m", "m": "N", "1": "N m"}
"""Unit of the virtual work on a coordinate, by the coordinate's."""


def lawful(stated: Statement, coordinates: Sequence[tuple[Quantity, Quantity]]) -> list[Let]:
    """Power, momentum, angular momentum, and virtual work on each of the coordinates, which come with their rates."""
    parts = stated.assembly, stated.ground
    moving = stated.told_in({rate for _, rate in coordinates})
    found = [_law("power", "W", "power of all forces and of inertia", laws.power(*parts, stated.anchor))]
    momentum, angular = laws.momentum(*parts), laws.angular_momentum(*parts, stated.O)
    found += [_law(f"force_{a}", "N", f"rate of momentum less outer forces, {a}", momentum[a]) for a in stated.axes]
    turned = AXES if stated.spatial else AXES[2:]
    found += [
        _law(f"moment_{a}", "N m", f"rate of angular momentum less outer moments, {a}", angular[a]) for a in turned
    ]
    for tag, (inner, outer, at) in stated.rolling.items():
        slip = laws.sliding(stated.motion, (inner, outer), stated.ground, stated.anchor, at)
        for axis, component in zip(stated.axes, slip.components, strict=False):
            found.append(_law(f"roll_{tag}{axis}", "m/s", f"sliding of the pitch curves at {tag}, {axis}", component))
    for value, rate in coordinates:
        work = laws.virtual_work(*parts, stated.anchor, rate, lambda expr: expr.xreplace(moving))
        found.append(_law(f"work_{value}", WORK[value.unit], f"virtual work where {value} alone moves", work))
    return found


def _law(name: str, unit: str, meaning: str, vanishes: Expr) -> Let:
    return let(quantity(f"{LAW}{name}", unit, f"{meaning}{VANISHES}"), vanishes)
