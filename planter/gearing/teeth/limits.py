"""What teeth must keep so that they can be cut and used: the first limit that is broken is told with its place."""

from __future__ import annotations

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.curve import KAPPA, POLAR, PitchCurve
from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.meshing import Mesh
from planter.gearing.teeth.order import Order
from planter.kernels import Array
from planter.numerics.angles import turn_deg
from planter.numerics.arrays import Flags
from planter.numerics.extremes import Extreme

TOP_LAND = 0.2
"""Least arc along a tip, in modules."""
PLAY = 0.2
"""Largest play of a pair, in modules."""
CONTACT_RATIO = 1.0
_HOLLOW = 1e-9
"""Curvature, as a share of the largest, below zero by which rounding makes a curve hollow."""
_TRIED = 33
"""Places on each panel of a curve where its curvature is looked at."""
_TOLD = 6
"""Teeth that are named before the others are counted."""
PENETRATION = 3e-4
"""Largest depth, in modules, to which polygons of outlines that touch may reach into each other. Their
chords stay within half of it where they are hollow; the finest gears of ISO 1328-1 are made to some 1e-3 modules."""


def check_rack(order: Order, module: float, name: str) -> None:
    """Raise GeometryError where the rack cannot be, or its play is too much."""
    if order.play > PLAY * module:
        raise GeometryError(
            f"{name}: play = {order.play * 1e3:g} mm is not allowed: it must be at most {PLAY} modules, "
            f"{PLAY * module * 1e3:.4g} mm"
        )
    for rack in (order.rack(module), order.rack(module).mate()):
        if rack.sizes["round_"] <= 0 or rack.sizes["half"] <= 0:
            raise GeometryError(
                f"{name}: a rack with addendum {order.addendum:g}, clearance {order.clearance:g} and profile shift "
                f"{rack.shift:g} comes to a point at {np.degrees(order.pressure_angle):g} deg: one of them must be less"
            )


def check_curve(curve: PitchCurve, order: Order, tip: float, root: float, name: str) -> None:
    """Raise GeometryError where the rack's tips or its straight sides do not go with the bends of a pitch curve."""
    places, kappa = bends(curve)
    most, least = int(np.argmax(kappa)), int(np.argmin(kappa))
    if kappa[most] * root >= 1:
        raise GeometryError(
            f"{name}: the pitch curve's radius is {1e3 / kappa[most]:.4g} mm {_at(curve, places[most])}, which is not "
            f"allowed: it must be above the dedendum, {root * 1e3:.4g} mm"
        )
    if not hollow(kappa):
        return
    bow = -1 / kappa[least]
    where = f"{name}: the pitch curve is hollow with a radius of {bow * 1e3:.4g} mm {_at(curve, places[least])}"
    if order.process == "hob":
        raise GeometryError(f"{where}, which no hob can cut: the process must be shaper or wire")
    cutter = order.cutter_teeth * (tip + root) / (2 * (2 * order.addendum + order.clearance))
    if order.process == "shaper" and bow <= cutter:
        raise GeometryError(
            f"{where}, which a shaper's cutter of {order.cutter_teeth} teeth, {cutter * 1e3:.4g} mm in pitch radius, "
            f"cannot cut: the process must be wire"
        )
    if bow <= tip:
        raise GeometryError(f"{where}, which is not allowed: it must be above the addendum, {tip * 1e3:.4g} mm")


def check_gear(gear: Gear, order: Order) -> None:
    """Raise GeometryError for flanks that turn back, and for tips that are too thin."""
    _refuse(gear, gear.flanks.upper_margins <= 0, "turn back below their tips, where the pitch curve is too hollow: "
            "the addendum must be less")  # fmt: skip
    if not order.allow_undercut:
        _refuse(gear, gear.flanks.margins < 0, "are undercut: more teeth, a larger pressure angle or leave for it "
                "would help")  # fmt: skip
    begin, end = gear.flanks.tips[1].reshape(2, -1)
    lands = np.where(end > begin, gear.top_lands, 0.0) / gear.rack.module
    thin = int(np.argmin(lands))
    if lands[thin] < TOP_LAND:
        told = f"a top land of {lands[thin]:.3g} modules" if lands[thin] > 0 else "no top land: its flanks meet below"
        raise GeometryError(f"{gear.name}: tooth {thin} has {told}, where {TOP_LAND} modules are the least allowed")


def check_mesh(mesh: Mesh, name: str) -> None:
    """Raise GeometryError where a tooth leaves before the next has come."""
    ratios, laps, pairs = mesh.contact_ratios, mesh.laps, mesh.pairs
    least, alone = int(np.argmin(ratios)), int(np.argmin(laps))
    if ratios[least] < CONTACT_RATIO:
        one, two = (int(n[least]) % g.z for n, g in zip(pairs.numbers, mesh.gears, strict=True))
        raise GeometryError(
            f"{name}: the contact ratio of tooth {one} of {mesh.gear.name} with tooth {two} of {mesh.mate.name} is "
            f"{ratios[least]:.4g}, which is not allowed: it must be at least {CONTACT_RATIO:g}"
        )
    if laps[alone] < 0:
        tooth = int(pairs.numbers[0][alone]) % mesh.gear.z
        raise GeometryError(
            f"{name}: between tooth {tooth} of {mesh.gear.name} and the next no teeth touch for "
            f"{-laps[alone] * 1e3:.4g} mm of rolling, which is not allowed"
        )


def check_penetration(mesh: Mesh, deepest: Extreme, name: str) -> None:
    """Raise GeometryError where the teeth run into each other: `deepest` is the rolling length and the depth [m]."""
    module = mesh.gear.rack.module
    if deepest.value > PENETRATION * module:
        place = _at(mesh.pair.gear, mesh.pair.sense * deepest.place)
        raise GeometryError(
            f"{name}: the teeth run into each other by {deepest.value / module:.3g} modules, {deepest.value * 1e3:.3g} "
            f"mm, {place} of {mesh.gear.name}"
        )


def hollow(kappa: Array) -> bool:
    """Whether a curve with these curvatures (n,) is hollow anywhere."""
    return bool(kappa.min() < -_HOLLOW * kappa.max())


def bends(curve: PitchCurve) -> tuple[Array, Array]:
    """Arc lengths (n,) along a curve and its curvature there [1/m], on both sides of joints."""
    ends = curve.rows.ends
    shares = np.linspace(0, 1, _TRIED)
    places = ends[:-1, None] + np.diff(ends)[:, None] * shares
    panel = np.repeat(np.arange(len(ends) - 1), _TRIED)
    return places.ravel(), curve.rows(places.ravel(), panel)[KAPPA]


def _at(curve: PitchCurve, s: float) -> str:
    """A place on a pitch curve, in words."""
    return f"at the polar angle {turn_deg(curve.at(np.array([s]))[POLAR, 0]):.4g} deg"


def _refuse(gear: Gear, broken: Flags, what: str) -> None:
    """Raise GeometryError where flanks (2 z,) are broken, naming their teeth."""
    teeth = sorted(set(gear.flanks.tooth[np.flatnonzero(broken)].tolist()))
    if teeth:
        more = f" and {len(teeth) - _TOLD} more" if len(teeth) > _TOLD else ""
        named = ", ".join(map(str, teeth[:_TOLD]))
        raise GeometryError(f"{gear.name}: the flanks of tooth {named}{more} {what}")
