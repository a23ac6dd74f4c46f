"""Gears of a pick-up: checks and warnings of its pitch curves, and its locking arcs.

t is the carrier angle from where the tip is farthest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from planter.errors import GeometryError
from planter.gears.geometry.locking_arcs import (
    ARCS,
    Rolling,
    compute_arc_radius,
    compute_horn_reaches,
)
from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics.arrays import to_degrees
from planter.papers.pickup import model
from planter.papers.pickup.file import Pickup
from planter.papers.pickup.law import MODEL
from planter.papers.pickup.model import PickupTrain
from planter.papers.pickup.results import PickupWarning

SAMPLES = 2881
STEEP = 3.0
"""Slope from which on the arm is said to hurry."""
BESIDE = np.radians(40)
"""How far from a fault its cause is looked for."""
AROUND = np.radians(5)
LEAST_JUMP = 1e-6
"""Jump of the slope that is none [-]."""
_MM = 1000.0


def check_gears(machine: Pickup, train: PickupTrain) -> None:
    """Raise GeometryError, naming the angle and what causes it there, where the pitch curves cannot
    be gears.
    """
    fault = _find_fault(train)
    if fault is not None:
        t, problem = fault
        source = machine.points_source if train.inversion is not None else f"{machine.source}: law"
        raise GeometryError(
            f"{source}: this cannot be a pair of gears: at t = {to_degrees(t):.5g} deg from "
            f"the farthest tip {problem}; {_cause(machine, train, t)}"
        )


def _find_fault(train: PickupTrain) -> tuple[float, str] | None:
    """Return the first limit that a pitch curve violates: the carrier angle [rad] of the largest
    violation, and what is wrong.
    """
    t = train.samples(SAMPLES)
    slope = train.law.slopes(t)[0]
    lowest = int(np.argmin(slope))
    if slope[lowest] <= 0:
        turned = "turns back" if slope[lowest] < 0 else "stands still"
        return (
            float(t[lowest]),
            f"the arm {turned} (slope {slope[lowest]:.4g}, which must stay positive on the teeth)",
        )
    curves = train.pitch(t)
    for (gear, kind), excess in model.limit_excesses(curves, train.teeth).items():
        worst = int(np.argmax(excess))
        if excess[worst] >= 0:
            curve = {name: float(values[worst]) for name, values in curves.items()}
            return float(t[worst]), _describe_limit(train, gear, kind, curve)
    return None


def _describe_limit(train: PickupTrain, gear: str, kind: str, curve: Mapping[str, float]) -> str:
    """Return the description of a violated limit of a gear at an angle."""
    radius, kappa = model.GEARS[gear]
    reach, addendum = (
        model.mate_reaches(train.teeth)[gear] * _MM,
        model.tip_heights(train.teeth)[gear] * _MM,
    )
    if kind == "radius":
        ratio = curve["R2"] / curve["R1"]
        return (
            f"the pitch radius of the {gear} is {curve[radius] * _MM:.4g} mm (total ratio "
            f"{ratio:.4g}), but the teeth of its mate reach {reach:.4g} mm into it, past its axis"
        )
    depth, end = (reach, "roots") if kind == "sharp" else (addendum, "tips")
    return (
        f"the pitch curve of the {gear} is {kind} with a radius of curvature of "
        f"{_MM / abs(curve[kappa]):.4g} mm, less "
        f"than the {depth:.4g} mm between it and the {end} of its teeth: a cusp"
    )


def _cause(machine: Pickup, train: PickupTrain, t: float) -> str:
    """Return the cause in the path or the law at an angle."""
    law = "the law there must be changed (p, the dwell, the transition)"
    return (
        law
        if train.inversion is None
        else f"there the path passes {_place(machine, train, t)}, {_doing(train, t)}"
    )


def _place(machine: Pickup, train: PickupTrain, t: float) -> str:
    x, y = train.tip(np.array([t]))[0]
    place = f"({x * _MM:.5g}, {y * _MM:.5g}) mm"
    if machine.points is None:
        return place
    nearest = int(np.argmin(np.hypot(*(machine.points - [x, y]).T)))
    return f"{place}, by point {nearest + 1}"


def _doing(train: PickupTrain, t: float) -> str:
    """Return the change of the tip's distance from the sun's centre about an angle, and fast turns
    of the arm.
    """
    angles = t + np.linspace(-BESIDE, BESIDE, 321)
    slopes = train.slope(angles)
    fast = int(np.argmax(slopes))
    distance = train.motion(t + np.array([-AROUND, AROUND]))["L3"] * _MM
    change = (
        f"and its distance from the sun's centre changes by {distance[1] - distance[0]:.3g} mm in "
        f"{2 * np.degrees(AROUND):g} deg of the carrier"
    )
    if slopes[fast] < STEEP:
        return f"{change}: where the arm is to move it must change on steadily"
    return (
        f"{change}; at t = {to_degrees(angles[fast]):.5g} deg the arm must turn {slopes[fast]:.3g} "
        "times as fast as the carrier, for there the path turns back so quickly that it all but "
        "lets the carrier stand still"
    )


def list_gear_warnings(train: PickupTrain) -> Iterator[PickupWarning]:
    """Yield warnings of feasible gears: infinite acceleration, angles without teeth or without
    contact ratio.
    """
    yield from _jumps(train)
    yield from _transitions(train)
    t = train.samples(SAMPLES)
    lost = t[np.isnan(train.contact_ratio(t))]
    if len(lost):
        yield _warning(
            "contact ratio",
            float(lost[0]),
            f"the contact ratio has no value at {len(lost)} of {len(t)} angles on the teeth, the "
            f"first at t = {to_degrees(lost[0]):.4g} deg: a pitch curve is so hollow there that "
            "the tips of its teeth lie inside their base circle",
        )


def _jumps(train: PickupTrain) -> Iterator[PickupWarning]:
    """Yield a warning for each end of the dwell at which slope and tip velocity jump."""
    if train.law.dwell is None:
        return
    for t, end, name in ((train.driven[1], "begins", "start"), (train.driven[0], "ends", "end")):
        moving, locked = _velocities(train, t)
        jump = float(np.hypot(*(moving - locked)))
        if abs(float(train.law.slopes(np.array([t]))[0, 0])) > LEAST_JUMP:
            speeds = [float(np.hypot(*v)) * _MM for v in (moving, locked)]
            speeds_text = "{:.5g} to {:.5g}".format(*(speeds if name == "start" else speeds[::-1]))
            remedy = (
                "a path that comes to rest gently has none"
                if train.inversion is not None
                else 'ends = "smooth" in [law] gives the dwell smooth ends'
            )
            yield _warning(
                f"velocity jumps at the dwell's {name}",
                t,
                f"where the dwell {end}, at t = {to_degrees(t):.5g} deg, the tip's velocity jumps "
                f"by {jump * _MM:.5g} mm/s (its speed from {speeds_text} mm/s): the acceleration "
                f"is infinite there; {remedy}",
            )


def _velocities(train: PickupTrain, t: float) -> tuple[Array, Array]:
    """Velocity of the tip (2,) [m/s] at an end of the dwell, as the teeth drive it and as the
    locking arcs hold it.
    """
    at = np.array([t])
    angles = {"phi5": train.phi5_far + at, "phi1": train.law.arm(at), "omega": train.omega}
    motions = [
        load(MODEL)("motion", **angles, g=slope, triangle=train.geometry.triangle)
        for slope in (train.law.slopes(at)[0], np.zeros(1))
    ]
    moving, locked = (np.array([motion["vx_S"][0], motion["vy_S"][0]]) for motion in motions)
    return moving, locked


def _transitions(train: PickupTrain) -> Iterator[PickupWarning]:
    """Yield a warning for each range in which the arm moves but no teeth can drive it."""
    for driven, toothed, name in zip(train.driven, train.toothed, ("end", "start"), strict=True):
        if driven != toothed:
            first, last = sorted((to_degrees(driven), to_degrees(toothed)))
            yield _warning(
                f"no teeth at the dwell's {name}",
                driven,
                f"from t = {first:.5g} to {last:.5g} deg the slope goes to zero, and the sun's "
                f"pitch radius with it, "
                f"as no teeth can: other means (a cam, a pin) must drive the arm there",
            )


def _warning(name: str, t: float, message: str) -> PickupWarning:
    return PickupWarning(name, to_degrees(t), message)


@dataclass(frozen=True)
class Locking:
    """Locking arcs: radius [m], pitch radii of the sun where the dwell begins and where it ends
    [m], sweep [rad].

    While they act both arcs lie about the sun's centre. The concave one on the intermediate gear
    reaches `reaches` [rad, at the sun's centre] to both sides of the centre line, to that gear's
    tips: first on the side of the teeth that were in mesh before the dwell.
    """

    radius: float
    ends: tuple[float, float]
    sweep: float
    reaches: tuple[float, float]


def compute_locking_arcs(train: PickupTrain) -> Locking | None:
    """The locking arcs of a train that dwells, between the teeth next to the dwell, or None if none
    would hold.

    Where no teeth lead to the dwell they are as large as the larger of the sun's pitch radii where
    the teeth end, and the adjacent tips of the intermediate gear are taken for circles.
    """
    dwell = train.law.dwell
    if dwell is None:
        return None
    addendum = float(train.teeth[2] * train.teeth[0])
    if train.toothed == train.driven:
        curves = build_rolling(train)
        try:
            radius = compute_arc_radius(curves, addendum)
            after, before = compute_horn_reaches(curves, radius, addendum)
        except GeometryError:
            return None
        return Locking(radius, curves.ends[::-1], dwell.width, (before, after))
    first, last = train.pitch(np.array(train.toothed[::-1]))["R1"].tolist()
    reaches = [
        _on_circle(train.geometry.a1, max(first, last), end, addendum) for end in (first, last)
    ]
    return Locking(max(first, last), (first, last), dwell.width, (reaches[0], reaches[1]))


def _on_circle(distance: float, radius: float, end: float, addendum: float) -> float:
    return ARCS.at("horn", distance=distance, radius=radius, tips=distance - end + addendum)[
        "reach"
    ]


def build_rolling(train: PickupTrain) -> Rolling:
    """The sun's pitch curve and the intermediate gear's where they roll on each other."""

    def radius(t: Array) -> Array:
        return train.pitch(t)["R1"]

    return Rolling.from_radius(radius, train.toothed, train.law.breakpoints(), train.geometry.a1)
