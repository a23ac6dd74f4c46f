"""Two gears with teeth, as ordered, and how they mesh: all that is found of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.gearing.teeth import limits
from planter.gearing.teeth.apart import Apart, move_apart
from planter.gearing.teeth.contacts import Contacts
from planter.gearing.teeth.curve import POLAR
from planter.gearing.teeth.flanks import Flanks
from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.meshing import Mesh
from planter.gearing.teeth.order import Order, Sized, sized
from planter.gearing.teeth.pair import Pair
from planter.gearing.teeth.polygons import FINE_CHORDS, Overlay
from planter.gearing.teeth.rack import RACK
from planter.kernels import Array
from planter.numerics import extremes
from planter.numerics.extremes import Extreme


@dataclass(frozen=True)
class Toothed:
    """A pair with teeth. The gear has a tooth centred where its arc length is 0, the mate a space."""

    name: str
    order: Order
    sized: Sized
    mesh: Mesh

    @property
    def gears(self) -> tuple[Gear, Gear]:
        return self.mesh.gears

    @cached_property
    def contacts(self) -> Contacts:
        """Of the flanks that face each other at the positions of the mesh."""
        return Contacts(self.mesh, self.mesh.facing(self.mesh.positions))

    @cached_property
    def gaps(self) -> Array:
        """Of all flanks that face each other, along their common normals [m]."""
        return self.contacts.gaps if self.order.play else np.zeros_like(self.contacts.faced.at)

    @cached_property
    def lost_motion(self) -> Array:
        """Turn (n, 2) of the mate until each side of the teeth stops it, at the positions of the mesh [rad]."""
        return self.contacts.lost_motion

    def farther(self, more: float) -> Apart | None:
        """Return the teeth with their axes `more` [m] farther apart, None where teeth lose contact."""
        return move_apart(self.mesh, more)

    @cached_property
    def overlay(self) -> Overlay:
        return Overlay.of(self.mesh)

    @cached_property
    def deepest(self) -> Extreme:
        """Rolling length at which the gears as polygons reach deepest into each other, and that depth [m]."""
        return Overlay.of(self.mesh, FINE_CHORDS).deepest

    @cached_property
    def overlaps(self) -> Array:
        """Areas that the gears share as polygons at the positions of the mesh [m2]."""
        return self.overlay.overlaps(self.mesh.positions)

    @cached_property
    def polygon_gaps(self) -> Array:
        """Least distances of the gears as polygons at the positions of the mesh [m]."""
        return self.overlay.gaps(self.mesh.positions)

    @cached_property
    def pressure_angles(self) -> tuple[float, float]:
        """Least and largest angle [rad] of the teeth's normal to the perpendicular of the line of centres."""
        curve, alpha = self.mesh.gear.curve, self.order.pressure_angle

        def angle(s: Array) -> Array:
            found = (RACK("pressure", place=curve.at(s)[:POLAR], side=side, alpha=alpha) for side in (1.0, -1.0))
            return np.array([one["pressure"] for one in found])

        places = np.linspace(0, curve.length, len(self.mesh.positions), endpoint=False)
        least = extremes.least(lambda s: angle(s).min(axis=0), places, closed=True)
        most = extremes.largest(lambda s: angle(s).max(axis=0), places, closed=True)
        return least.value, most.value


def toothed(pair: Pair, order: Order, name: str, gears: tuple[str, str]) -> Toothed:
    """Teeth on a pair, as ordered; `name` says in errors which pair is meant, `gears` which gear and which mate.

    Raises InputError for an order that cannot be met, GeometryError, with its place, for the first limit that the
    teeth break.
    """
    found = sized(pair, order, name)
    limits.check_rack(order, found.module, name)
    racks = order.rack(found.module), order.rack(found.module).mate()
    made = []
    for k, (curve, rack) in enumerate(zip(found.pair.curves, racks, strict=True)):
        limits.check_curve(curve, order, rack.sizes["tip"], rack.sizes["root"], gears[k])
        phase = 0.0 if k == 0 else rack.pitch / 2
        gear = Gear(gears[k], Flanks(curve, rack, found.teeth[k], phase))
        limits.check_gear(gear, order)
        made.append(gear)
    mesh = Mesh(found.pair, made[0], made[1])
    limits.check_mesh(mesh, name)
    return Toothed(name, order, found, mesh)
