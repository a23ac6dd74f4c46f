"""Pairs of toothed gears by an order: their mesh with all its measures, and racks whose teeth do not overlap.

On a concave pitch curve the tips of the mate reach deep, and may penetrate fillets that the tip radius of the rack
leaves. A smaller radius clears them, and so does the same radius on a deeper rack, whose fillets stay strong.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth import limits
from planter.gearing.teeth.contacts import Contacts
from planter.gearing.teeth.curve import POLAR
from planter.gearing.teeth.flanks import Flanks
from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.meshing import Mesh
from planter.gearing.teeth.order import SizedPair, ToothOrder, size_pair
from planter.gearing.teeth.pair import CurvePair
from planter.gearing.teeth.polygons import FINE_CHORDS, Overlay
from planter.gearing.teeth.rack import RACK
from planter.gearing.teeth.wider import WiderMesh, move_apart
from planter.kernels import Array
from planter.numerics import extremes
from planter.numerics.extremes import Extreme


@dataclass(frozen=True)
class ToothedPair:
    """A pair of toothed gears. The gear has a tooth centred where its arc length is 0, the mate a space."""

    name: str
    order: ToothOrder
    sized: SizedPair
    mesh: Mesh

    @property
    def gears(self) -> tuple[Gear, Gear]:
        return self.mesh.gears

    @cached_property
    def contacts(self) -> Contacts:
        """Contacts of facing flanks at the positions of the mesh."""
        return Contacts(self.mesh, self.mesh.facing(self.mesh.positions))

    @cached_property
    def gaps(self) -> Array:
        """Gaps of all facing flanks along their common normals [m]."""
        return self.contacts.gaps if self.order.play else np.zeros_like(self.contacts.faced.at)

    @cached_property
    def lost_motion(self) -> Array:
        """Turn (n, 2) of the mate until each side of the teeth stops it, at the positions of the mesh [rad]."""
        return self.contacts.lost_motion

    def farther(self, more: float) -> WiderMesh | None:
        """Return the teeth with their axes `more` [m] farther apart, None if teeth lose contact."""
        return move_apart(self.mesh, more)

    @cached_property
    def overlay(self) -> Overlay:
        return Overlay.from_mesh(self.mesh)

    @cached_property
    def deepest(self) -> Extreme:
        """Rolling length at which the gears as polygons reach deepest into each other, and that depth [m]."""
        return Overlay.from_mesh(self.mesh, FINE_CHORDS).deepest

    @cached_property
    def overlaps(self) -> Array:
        """Areas that the gears share as polygons at the positions of the mesh [m2]."""
        return self.overlay.overlaps(self.mesh.positions)

    @cached_property
    def polygon_gaps(self) -> Array:
        """Smallest distances of the gears as polygons at the positions of the mesh [m]."""
        return self.overlay.gaps(self.mesh.positions)

    @cached_property
    def pressure_angles(self) -> tuple[float, float]:
        """Smallest and largest angle [rad] of the tooth normal to the perpendicular of the line of centres."""
        curve, alpha = self.mesh.gear.curve, self.order.pressure_angle

        def angle(s: Array) -> Array:
            columns = (RACK("pressure", place=curve.at(s)[:POLAR], side=side, alpha=alpha) for side in (1.0, -1.0))
            return np.array([column["pressure"] for column in columns])

        places = np.linspace(0, curve.length, len(self.mesh.positions), endpoint=False)
        smallest = extremes.least(lambda s: angle(s).min(axis=0), places, closed=True)
        largest = extremes.largest(lambda s: angle(s).max(axis=0), places, closed=True)
        return smallest.value, largest.value


def cut_teeth(pair: CurvePair, order: ToothOrder, name: str, gears: tuple[str, str]) -> ToothedPair:
    """Cut the teeth of a pair by an order; errors name the pair `name` and its two `gears`.

    Raises InputError for an impossible order, GeometryError, with its position, for the first limit that the teeth
    violate.
    """
    size = size_pair(pair, order, name)
    limits.check_rack(order, size.module, name)
    racks = order.rack(size.module), order.rack(size.module).mate()
    cut_gears = []
    for k, (curve, rack) in enumerate(zip(size.pair.curves, racks, strict=True)):
        limits.check_curve(curve, order, rack.sizes["tip"], rack.sizes["root"], gears[k])
        phase = 0.0 if k == 0 else rack.pitch / 2
        gear = Gear(gears[k], Flanks(curve, rack, size.teeth[k], phase))
        limits.check_gear(gear, order)
        cut_gears.append(gear)
    mesh = Mesh(size.pair, cut_gears[0], cut_gears[1])
    limits.check_mesh(mesh, name)
    return ToothedPair(name, order, size, mesh)


MAX_CLEARANCE = 0.6
"""Largest clearance of the search, in modules; tip radii and clearances are tried in hundredths."""


def check_pair_penetration(pair: ToothedPair) -> None:
    """Raise GeometryError, suggesting other racks, if the teeth of a pair overlap as polygons."""
    try:
        limits.check_penetration(pair.mesh, pair.deepest, pair.name)
    except GeometryError as error:
        raise GeometryError(f"{error}: {suggest_racks(pair)}") from error


def suggest_racks(pair: ToothedPair) -> str:
    """Return a text with the largest sufficient tip radius of the rack, and the smallest sufficient clearance."""
    hundredths = math.floor(100 * pair.order.rack(1.0).sizes["round_"])
    radius = hundredths / 100
    rounds = [replace(pair.order, tip_radius=k / 100) for k in range(hundredths, 0, -1)]
    depths = range(math.floor(100 * pair.order.clearance) + 1, round(100 * MAX_CLEARANCE) + 1)
    smaller = find_first_order(pair, rounds)
    deeper = find_first_order(pair, [replace(pair.order, clearance=k / 100, tip_radius=radius) for k in depths])
    remedies = [] if smaller is None else [f"a tip radius of {smaller.tip_radius:g}"]
    remedies += [] if deeper is None else [f"a clearance of {deeper.clearance:g} with a tip radius of {radius:g}"]
    if not remedies:
        return (
            f"no smaller tip radius of the rack and no clearance up to {MAX_CLEARANCE:g} modules would do; a "
            f"smaller module or addendum might"
        )
    return f"{' or '.join(remedies)} would do"


def find_first_order(pair: ToothedPair, orders: Sequence[ToothOrder]) -> ToothOrder | None:
    """Return the first order with which the teeth pass, if all later ones pass too; None if the last does not."""
    if not orders or not passes_limits(pair, orders[-1]):
        return None
    low, high = -1, len(orders) - 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if passes_limits(pair, orders[middle]) else (middle, high)
    return orders[high]


def passes_limits(pair: ToothedPair, order: ToothOrder) -> bool:
    """Return whether the teeth of a pair pass all limits with another order at the same size."""
    fixed = replace(order, teeth=pair.sized.teeth[0], module=None, keep="size")
    try:
        other = cut_teeth(pair.sized.pair, fixed, pair.name, (pair.gears[0].name, pair.gears[1].name))
        limits.check_penetration(other.mesh, other.deepest, pair.name)
    except GeometryError:
        return False
    return True
