"""Orders of teeth, the limits of cutting and use, and the pairs of toothed gears that an order
gives.

Errors name the first violated limit and its position. On a concave pitch curve the tips of the mate
reach deep, and may penetrate fillets that the tip radius of the rack leaves. A smaller radius
clears them, and so does the same radius on a deeper rack, whose fillets stay strong.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from planter.errors import GeometryError, InputError
from planter.gears.geometry.contacts import Contacts, WiderMesh, move_apart
from planter.gears.geometry.flanks import Flanks, Rack
from planter.gears.geometry.gear import Gear
from planter.gears.geometry.mesh import Mesh, compute_pressure_angles
from planter.gears.geometry.pitch_curves import KAPPA, POLAR, CurvePair, PitchCurve
from planter.gears.geometry.polygons import FINE_CHORDS, Overlay
from planter.kernels import Array, Flags
from planter.numerics import extrema
from planter.numerics.arrays import to_degrees
from planter.numerics.extrema import ExtremePoint

MIN_TEETH = 6
MAX_TEETH = 1000
"""Largest number of teeth on a gear: every flank is solved, which takes some ten milliseconds per
tooth.
"""
CUTTER_TEETH = 12
"""Tooth count of the pinion cutter with which a shaper cuts concave curves."""
DEFAULT_MODULE = 2e-3
"""Module without an order of module or teeth [m]."""
_INTEGER_TOLERANCE = 1e-9
_SCALE_TOLERANCE = 1e-12
"""Relative change of size below which a pair is not scaled."""


@dataclass(frozen=True)
class ToothOrder:
    """Tooth count of the gear, module [m], which of "size" and "module" to keep, pressure angle
    [rad], rack in modules, backlash [m], process: "hob", "shaper" or "wire".

    The default of `keep` is the size if teeth are given without a module, else the module.
    """

    teeth: int | None = None
    module: float | None = None
    keep: str | None = None
    pressure_angle: float = np.pi / 9
    addendum: float = 1.0
    clearance: float = 0.25
    shift: float = 0.0
    play: float = 0.0
    tip_radius: float = 1.0
    process: str = "hob"
    allow_undercut: bool = False

    def rack(self, module: float) -> Rack:
        """Return the gear's rack; its mate's has the opposite profile shift."""
        return Rack(
            module,
            self.pressure_angle,
            self.addendum,
            self.clearance,
            self.shift,
            self.play,
            self.tip_radius,
        )


@dataclass(frozen=True)
class SizedPair:
    """A pair with integer tooth counts: scaled from its designed size by `scale`, with its module
    [m].
    """

    pair: CurvePair
    scale: float
    module: float
    teeth: tuple[int, int]


def size_pair(pair: CurvePair, order: ToothOrder, name: str) -> SizedPair:
    """Return the pair with integer tooth counts.

    Raises InputError, naming the pair, for an impossible order.
    """
    module = order.module or (None if order.teeth else DEFAULT_MODULE)
    length = pair.gear.length
    exact_count = length / (np.pi * module) if module else float(order.teeth or 0)
    z = order.teeth or round(exact_count)
    if order.teeth and module and abs(exact_count - z) > 0.5:
        raise InputError(
            f"{name}: teeth = {z} and module = {module * 1e3:g} mm disagree: the pitch curve is "
            f"{length * 1e3:.6g} mm "
            f"long, which makes {round(exact_count)} teeth of that module"
        )
    keep = order.keep or ("module" if module else "size")
    fitted_module = module if module and keep == "module" else length / (np.pi * z)
    scale = np.pi * fitted_module * z / length if keep == "module" else 1.0
    # a scale of rounding would cost the curve its digits
    scale = 1.0 if abs(scale - 1) <= _SCALE_TOLERANCE else scale
    mate = pair.mate.length * z / length
    if abs(mate - round(mate)) > _INTEGER_TOLERANCE * mate:
        raise InputError(
            f"{name}: teeth = {z}: the mate, whose pitch curve is {pair.mate.length / length:.6g} "
            f"times "
            f"as long, would have {mate:.6g} teeth"
        )
    for count in (z, round(mate)):
        if not MIN_TEETH <= count <= MAX_TEETH:
            raise InputError(
                f"{name}: {count} teeth: there must be {MIN_TEETH} to {MAX_TEETH} on a gear"
            )
    return SizedPair(pair.scaled(scale), float(scale), float(fitted_module), (z, round(mate)))


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
"""Largest penetration of the polygons of outlines that touch, in modules.

Concave chords stay within half of it; the finest gears of ISO 1328-1 have tolerances of some 1e-3
modules.
"""


def check_rack(order: ToothOrder, module: float, name: str) -> None:
    """Raise GeometryError if the rack does not exist, or its backlash is too large."""
    if order.play > MAX_PLAY * module:
        raise GeometryError(
            f"{name}: play = {order.play * 1e3:g} mm: the backlash must be at most {MAX_PLAY} "
            f"modules, "
            f"{MAX_PLAY * module * 1e3:.4g} mm"
        )
    for rack in (order.rack(module), order.rack(module).mate()):
        if rack.sizes["round_"] <= 0 or rack.sizes["half"] <= 0:
            raise GeometryError(
                f"{name}: a rack with addendum {order.addendum:g}, clearance {order.clearance:g} "
                f"and profile shift "
                f"{rack.shift:g} has pointed tips at {np.degrees(order.pressure_angle):g} deg: "
                f"reduce one of them"
            )


def check_curve(curve: PitchCurve, order: ToothOrder, tip: float, root: float, name: str) -> None:
    """Raise GeometryError if the rack cannot cut the curvature of a pitch curve."""
    places, kappa = sample_curvature(curve)
    sharpest, flattest = int(np.argmax(kappa)), int(np.argmin(kappa))
    if kappa[sharpest] * root >= 1:
        raise GeometryError(
            f"{name}: the pitch curve's radius is {1e3 / kappa[sharpest]:.4g} mm "
            f"{_describe_place(curve, places[sharpest])}; it must be above the dedendum, "
            f"{root * 1e3:.4g} mm"
        )
    if not is_concave(kappa):
        return
    bow = -1 / kappa[flattest]
    place = _describe_place(curve, places[flattest])
    finding = f"{name}: the pitch curve is concave with a radius of {bow * 1e3:.4g} mm {place}"
    if order.process == "hob":
        raise GeometryError(f"{finding}, which no hob can cut: the process must be shaper or wire")
    # the whole depth of the rack is that of the cutter in its own modules
    cutter = CUTTER_TEETH * (tip + root) / (2 * (2 * order.addendum + order.clearance))
    if order.process == "shaper" and bow <= cutter:
        raise GeometryError(
            f"{finding}, which a shaper's cutter of {CUTTER_TEETH} teeth, "
            f"{cutter * 1e3:.4g} mm in pitch "
            f"radius, cannot cut: the process must be wire"
        )
    if bow <= tip:
        raise GeometryError(f"{finding}; it must be above the addendum, {tip * 1e3:.4g} mm")


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
            f"a top land of {lands[thin]:.3g} modules"
            if lands[thin] > 0
            else "no top land: its flanks meet below"
        )
        raise GeometryError(
            f"{gear.name}: tooth {thin} has {finding}, where {MIN_TOP_LAND} modules are the least "
            f"allowed"
        )


def check_mesh(mesh: Mesh, name: str) -> None:
    """Raise GeometryError if a tooth loses contact before the next one touches."""
    ratios, laps, pairs = mesh.contact_ratios, mesh.laps, mesh.pairs
    weakest, gap_index = int(np.argmin(ratios)), int(np.argmin(laps))
    if ratios[weakest] < MIN_CONTACT_RATIO:
        tooth, mate_tooth = (
            int(n[weakest]) % g.z for n, g in zip(pairs.numbers, mesh.gears, strict=True)
        )
        raise GeometryError(
            f"{name}: the contact ratio of tooth {tooth} of {mesh.gear.name} with tooth "
            f"{mate_tooth} of "
            f"{mesh.mate.name} is {ratios[weakest]:.4g}; it must be at least "
            f"{MIN_CONTACT_RATIO:g}"
        )
    if laps[gap_index] < 0:
        tooth = int(pairs.numbers[0][gap_index]) % mesh.gear.z
        raise GeometryError(
            f"{name}: between tooth {tooth} of {mesh.gear.name} and the next no teeth touch for "
            f"{-laps[gap_index] * 1e3:.4g} mm of rolling, but the teeth must always touch"
        )


def check_penetration(mesh: Mesh, deepest: ExtremePoint, name: str) -> None:
    """Raise GeometryError if the teeth overlap; `deepest` is the rolling length [m] and the depth
    [m].
    """
    module = mesh.gear.rack.module
    if deepest.value > MAX_PENETRATION * module:
        place = _describe_place(mesh.pair.gear, mesh.pair.sense * deepest.place)
        raise GeometryError(
            f"{name}: the teeth overlap by {deepest.value / module:.3g} modules, "
            f"{deepest.value * 1e3:.3g} "
            f"mm, {place} of {mesh.gear.name}"
        )


def is_concave(kappa: Array) -> bool:
    """Return whether a curve with curvatures (n,) [1/m] is concave anywhere."""
    return bool(kappa.min() < -_CONCAVE_TOLERANCE * kappa.max())


def sample_curvature(curve: PitchCurve) -> tuple[Array, Array]:
    """Return arc lengths (n,) [m] of a curve and its curvature there [1/m], on both sides of
    breakpoints.
    """
    ends = curve.rows.ends
    shares = np.linspace(0, 1, _SAMPLES)
    places = ends[:-1, None] + np.diff(ends)[:, None] * shares
    panel = np.repeat(np.arange(len(ends) - 1), _SAMPLES)
    return places.ravel(), curve.rows(places.ravel(), panel)[KAPPA]


def _describe_place(curve: PitchCurve, s: float) -> str:
    """Return the description of an arc length [m] of a pitch curve."""
    return f"at the polar angle {to_degrees(curve.at(np.array([s]))[POLAR, 0]):.4g} deg"


def _refuse_flanks(gear: Gear, broken: Flags, finding: str) -> None:
    """Raise GeometryError, naming the teeth, if any flanks (2 z,) violate a limit."""
    teeth = sorted(set(gear.flanks.tooth[np.flatnonzero(broken)].tolist()))
    if teeth:
        more = f" and {len(teeth) - _NAMED_TEETH} more" if len(teeth) > _NAMED_TEETH else ""
        named = ", ".join(map(str, teeth[:_NAMED_TEETH]))
        raise GeometryError(f"{gear.name}: the flanks of tooth {named}{more} {finding}")


@dataclass(frozen=True)
class ToothedPair:
    """A pair of toothed gears.

    The gear has a tooth centred where its arc length is 0, the mate a space.
    """

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
        """Turn (n, 2) of the mate until each side of the teeth stops it, at the positions of the
        mesh [rad].
        """
        return self.contacts.lost_motion

    def farther(self, more: float) -> WiderMesh | None:
        """Return the teeth with their axes `more` [m] farther apart, None if teeth lose contact."""
        return move_apart(self.mesh, more)

    @cached_property
    def overlay(self) -> Overlay:
        return Overlay.from_mesh(self.mesh)

    @cached_property
    def deepest(self) -> ExtremePoint:
        """Rolling length at which the gears as polygons reach deepest into each other, and that
        depth [m].
        """
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
        """Smallest and largest angle [rad] of the tooth normal to the perpendicular of the line of
        centres.
        """
        curve, alpha = self.mesh.gear.curve, self.order.pressure_angle

        def angle(s: Array) -> Array:
            return compute_pressure_angles(curve, s, alpha)

        places = np.linspace(0, curve.length, len(self.mesh.positions), endpoint=False)
        smallest = extrema.find_minimum(lambda s: angle(s).min(axis=0), places, closed=True)
        largest = extrema.find_maximum(lambda s: angle(s).max(axis=0), places, closed=True)
        return smallest.value, largest.value


def cut_teeth(pair: CurvePair, order: ToothOrder, name: str, gears: tuple[str, str]) -> ToothedPair:
    """Cut the teeth of a pair by an order; errors name the pair `name` and its two `gears`.

    Raises InputError for an impossible order, GeometryError, with its position, for the first limit
    that the teeth violate.
    """
    size = size_pair(pair, order, name)
    check_rack(order, size.module, name)
    racks = order.rack(size.module), order.rack(size.module).mate()
    toothed = []
    for k, (curve, rack) in enumerate(zip(size.pair.curves, racks, strict=True)):
        check_curve(curve, order, rack.sizes["tip"], rack.sizes["root"], gears[k])
        phase = 0.0 if k == 0 else rack.pitch / 2
        gear = Gear(gears[k], Flanks(curve, rack, size.teeth[k], phase))
        check_gear(gear, order)
        toothed.append(gear)
    mesh = Mesh(size.pair, toothed[0], toothed[1])
    check_mesh(mesh, name)
    return ToothedPair(name, order, size, mesh)


MAX_CLEARANCE = 0.6
"""Largest clearance of the search, in modules; tip radii and clearances are tried in hundredths."""


def check_pair_penetration(pair: ToothedPair) -> None:
    """Raise GeometryError, suggesting other racks, if the teeth of a pair overlap as polygons."""
    try:
        check_penetration(pair.mesh, pair.deepest, pair.name)
    except GeometryError as error:
        raise GeometryError(f"{error}: {suggest_racks(pair)}") from error


def suggest_racks(pair: ToothedPair) -> str:
    """Return a text with the largest sufficient tip radius of the rack, and the smallest sufficient
    clearance.
    """
    hundredths = math.floor(100 * pair.order.rack(1.0).sizes["round_"])
    radius = hundredths / 100
    rounds = [replace(pair.order, tip_radius=k / 100) for k in range(hundredths, 0, -1)]
    depths = range(math.floor(100 * pair.order.clearance) + 1, round(100 * MAX_CLEARANCE) + 1)
    smaller = find_first_order(pair, rounds)
    deeper = find_first_order(
        pair, [replace(pair.order, clearance=k / 100, tip_radius=radius) for k in depths]
    )
    remedies = [] if smaller is None else [f"a tip radius of {smaller.tip_radius:g}"]
    remedies += (
        []
        if deeper is None
        else [f"a clearance of {deeper.clearance:g} with a tip radius of {radius:g}"]
    )
    if not remedies:
        return (
            f"no smaller tip radius of the rack and no clearance up to {MAX_CLEARANCE:g} modules "
            f"would do; a "
            f"smaller module or addendum might"
        )
    return f"{' or '.join(remedies)} would do"


def find_first_order(pair: ToothedPair, orders: Sequence[ToothOrder]) -> ToothOrder | None:
    """Return the first order with which the teeth pass, if all later ones pass too; None if the
    last does not.
    """
    if not orders or not passes_limits(pair, orders[-1]):
        return None
    # by bisection, since the orders that pass follow those that do not
    low, high = -1, len(orders) - 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if passes_limits(pair, orders[middle]) else (middle, high)
    return orders[high]


def passes_limits(pair: ToothedPair, order: ToothOrder) -> bool:
    """Return whether the teeth of a pair pass all limits with another order at the same size."""
    # the pair is sized already; another order must not size it again
    fixed = replace(order, teeth=pair.sized.teeth[0], module=None, keep="size")
    try:
        other = cut_teeth(
            pair.sized.pair, fixed, pair.name, (pair.gears[0].name, pair.gears[1].name)
        )
        check_penetration(other.mesh, other.deepest, pair.name)
    except GeometryError:
        return False
    return True
