"""Limits of teeth for cutting and use; the error names the first violated limit and its position."""

from __future__ import annotations

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.curve import KAPPA, POLAR, PitchCurve
from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.meshing import Mesh
from planter.gearing.teeth.order import ToothOrder
from planter.kernels import Array
from planter.numerics.angles import turn_deg
from planter.numerics.arrays import Flags
from planter.numerics.extremes import Extreme

MIN_TOP_LAND = 0.2
"""Smallest arc along a tip, in modules."""
MAX_PLAY = 0.2
"""Largest backlash of a pair, in modules."""
MIN_CONTACT_RATIO = 1.0
_CONCAVE_TOLERANCE = 1e-9
"""Share of the largest curvature by which rounding makes curvature negative."""
_SAMPLES = 33
"""Points of each panel of a curve at which its curvature is checked."""
_NAMED_TEETH = 6
"""Number of teeth that an error names; the others are counted."""
MAX_PENETRATION = 3e-4
"""Largest penetration of the polygons of outlines that touch, in modules. Concave chords stay within half of it; the
finest gears of ISO 1328-1 have tolerances of some 1e-3 modules."""


def check_rack(order: ToothOrder, module: float, name: str) -> None:
    """Raise GeometryError if the rack does not exist, or its backlash is too large."""
    if order.play > MAX_PLAY * module:
        raise GeometryError(
            f"{name}: play = {order.play * 1e3:g} mm: the backlash must be at most {MAX_PLAY} modules, "
            f"{MAX_PLAY * module * 1e3:.4g} mm"
        )
    for rack in (order.rack(module), order.rack(module).mate()):
        if rack.sizes["round_"] <= 0 or rack.sizes["half"] <= 0:
            raise GeometryError(
                f"{name}: a rack with addendum {order.addendum:g}, clearance {order.clearance:g} and profile shift "
                f"{rack.shift:g} has pointed tips at {np.degrees(order.pressure_angle):g} deg: reduce one of them"
            )


def check_curve(curve: PitchCurve, order: ToothOrder, tip: float, root: float, name: str) -> None:
    """Raise GeometryError if the rack cannot cut the curvature of a pitch curve."""
    places, kappa = sample_curvature(curve)
    sharpest, flattest = int(np.argmax(kappa)), int(np.argmin(kappa))
    if kappa[sharpest] * root >= 1:
        raise GeometryError(
            f"{name}: the pitch curve's radius is {1e3 / kappa[sharpest]:.4g} mm "
            f"{_describe_place(curve, places[sharpest])}, which is not allowed: it must be above the dedendum, "
            f"{root * 1e3:.4g} mm"
        )
    if not is_concave(kappa):
        return
    bow = -1 / kappa[flattest]
    place = _describe_place(curve, places[flattest])
    finding = f"{name}: the pitch curve is concave with a radius of {bow * 1e3:.4g} mm {place}"
    if order.process == "hob":
        raise GeometryError(f"{finding}, which no hob can cut: the process must be shaper or wire")
    cutter = order.cutter_teeth * (tip + root) / (2 * (2 * order.addendum + order.clearance))
    if order.process == "shaper" and bow <= cutter:
        raise GeometryError(
            f"{finding}, which a shaper's cutter of {order.cutter_teeth} teeth, {cutter * 1e3:.4g} mm in pitch "
            f"radius, cannot cut: the process must be wire"
        )
    if bow <= tip:
        raise GeometryError(f"{finding}, which is not allowed: it must be above the addendum, {tip * 1e3:.4g} mm")


def check_gear(gear: Gear, order: ToothOrder) -> None:
    """Raise GeometryError if flanks turn back or tips are too thin."""
    _refuse_flanks(
        gear,
        gear.flanks.upper_margins <= 0,
        "turn back below their tips, on a concave pitch curve: reduce the addendum",
    )
    if not order.allow_undercut:
        _refuse_flanks(
            gear,
            gear.flanks.margins < 0,
            "are undercut: use more teeth or a larger pressure angle, or allow undercut",
        )
    begin, end = gear.flanks.tips[1].reshape(2, -1)
    lands = np.where(end > begin, gear.top_lands, 0.0) / gear.rack.module
    thin = int(np.argmin(lands))
    if lands[thin] < MIN_TOP_LAND:
        finding = (
            f"a top land of {lands[thin]:.3g} modules" if lands[thin] > 0 else "no top land: its flanks meet below"
        )
        raise GeometryError(
            f"{gear.name}: tooth {thin} has {finding}, where {MIN_TOP_LAND} modules are the least allowed"
        )


def check_mesh(mesh: Mesh, name: str) -> None:
    """Raise GeometryError if a tooth loses contact before the next one touches."""
    ratios, laps, pairs = mesh.contact_ratios, mesh.laps, mesh.pairs
    weakest, gap_index = int(np.argmin(ratios)), int(np.argmin(laps))
    if ratios[weakest] < MIN_CONTACT_RATIO:
        tooth, mate_tooth = (int(n[weakest]) % g.z for n, g in zip(pairs.numbers, mesh.gears, strict=True))
        raise GeometryError(
            f"{name}: the contact ratio of tooth {tooth} of {mesh.gear.name} with tooth {mate_tooth} of "
            f"{mesh.mate.name} is {ratios[weakest]:.4g}, which is not allowed: it must be at least "
            f"{MIN_CONTACT_RATIO:g}"
        )
    if laps[gap_index] < 0:
        tooth = int(pairs.numbers[0][gap_index]) % mesh.gear.z
        raise GeometryError(
            f"{name}: between tooth {tooth} of {mesh.gear.name} and the next no teeth touch for "
            f"{-laps[gap_index] * 1e3:.4g} mm of rolling, which is not allowed"
        )


def check_penetration(mesh: Mesh, deepest: Extreme, name: str) -> None:
    """Raise GeometryError if the teeth overlap; `deepest` is the rolling length [m] and the depth [m]."""
    module = mesh.gear.rack.module
    if deepest.value > MAX_PENETRATION * module:
        place = _describe_place(mesh.pair.gear, mesh.pair.sense * deepest.place)
        raise GeometryError(
            f"{name}: the teeth overlap by {deepest.value / module:.3g} modules, {deepest.value * 1e3:.3g} "
            f"mm, {place} of {mesh.gear.name}"
        )


def is_concave(kappa: Array) -> bool:
    """Return whether a curve with curvatures (n,) [1/m] is concave anywhere."""
    return bool(kappa.min() < -_CONCAVE_TOLERANCE * kappa.max())


def sample_curvature(curve: PitchCurve) -> tuple[Array, Array]:
    """Return arc lengths (n,) [m] of a curve and its curvature there [1/m], on both sides of breakpoints."""
    ends = curve.rows.ends
    shares = np.linspace(0, 1, _SAMPLES)
    places = ends[:-1, None] + np.diff(ends)[:, None] * shares
    panel = np.repeat(np.arange(len(ends) - 1), _SAMPLES)
    return places.ravel(), curve.rows(places.ravel(), panel)[KAPPA]


def _describe_place(curve: PitchCurve, s: float) -> str:
    """Return the description of an arc length [m] of a pitch curve."""
    return f"at the polar angle {turn_deg(curve.at(np.array([s]))[POLAR, 0]):.4g} deg"


def _refuse_flanks(gear: Gear, broken: Flags, finding: str) -> None:
    """Raise GeometryError, naming the teeth, if any flanks (2 z,) violate a limit."""
    teeth = sorted(set(gear.flanks.tooth[np.flatnonzero(broken)].tolist()))
    if teeth:
        more = f" and {len(teeth) - _NAMED_TEETH} more" if len(teeth) > _NAMED_TEETH else ""
        named = ", ".join(map(str, teeth[:_NAMED_TEETH]))
        raise GeometryError(f"{gear.name}: the flanks of tooth {named}{more} {finding}")
