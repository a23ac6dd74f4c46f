"""Racks with which teeth that run into each other would not: found by trying, and told in the error.

Where a pitch curve is hollow the tips of the mate reach deep, and may run into fillets that the round on the tips of
the rack leaves. A smaller round clears them, and so does the same round on a deeper rack, whose fillets stay strong.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from planter.errors import GeometryError
from planter.gearing.teeth import limits
from planter.gearing.teeth.making import Toothed, toothed
from planter.gearing.teeth.order import Order

DEEPEST = 0.6
"""Largest clearance that is tried, in modules; rounds and clearances are tried in hundredths."""


def check_penetration(found: Toothed) -> None:
    """Raise GeometryError where the teeth of a pair run into each other as polygons, with racks that would do."""
    try:
        limits.check_penetration(found.mesh, found.deepest, found.name)
    except GeometryError as error:
        raise GeometryError(f"{error}: {advice(found)}") from error


def advice(found: Toothed) -> str:
    """The largest round on the rack's tips with which the teeth pass, and the least clearance with its own round."""
    hundredths = math.floor(100 * found.order.rack(1.0).sizes["round_"])
    radius = hundredths / 100
    rounds = [replace(found.order, tip_radius=k / 100) for k in range(hundredths, 0, -1)]
    depths = range(math.floor(100 * found.order.clearance) + 1, round(100 * DEEPEST) + 1)
    smaller = first(found, rounds)
    deeper = first(found, [replace(found.order, clearance=k / 100, tip_radius=radius) for k in depths])
    told = [] if smaller is None else [f"a tip radius of {smaller.tip_radius:g}"]
    told += [] if deeper is None else [f"a clearance of {deeper.clearance:g} with a tip radius of {radius:g}"]
    if not told:
        return (
            f"no smaller round on the tips of the rack and no clearance up to {DEEPEST:g} modules would do; a smaller "
            f"module or addendum may"
        )
    return f"{' or '.join(told)} would do"


def first(found: Toothed, orders: Sequence[Order]) -> Order | None:
    """The first order with which the teeth pass, if those after it pass too; None where the last does not."""
    if not orders or not passes(found, orders[-1]):
        return None
    low, high = -1, len(orders) - 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if passes(found, orders[middle]) else (middle, high)
    return orders[high]


def passes(found: Toothed, order: Order) -> bool:
    """Whether the teeth of a pair pass all limits with another order, at the size that they have."""
    own = replace(order, teeth=found.sized.teeth[0], module=None, keep="size")
    try:
        other = toothed(found.sized.pair, own, found.name, (found.gears[0].name, found.gears[1].name))
        limits.check_penetration(other.mesh, other.deepest, found.name)
    except GeometryError:
        return False
    return True
