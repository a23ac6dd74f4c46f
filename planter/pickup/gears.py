"""Whether pitch curves can be gears at all, and what must be told of those that can.

t is the carrier angle from where the tip is farthest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from planter.errors import GeometryError
from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics.angles import turn_deg
from planter.pickup import limits
from planter.pickup.file import Pickup
from planter.pickup.law import MODEL
from planter.pickup.model import Train
from planter.pickup.results import Warned

SAMPLES = 2881
STEEP = 3.0
"""Slope from which on the arm is said to hurry."""
BESIDE = np.radians(40)
"""How far from a fault its cause is looked for."""
AROUND = np.radians(5)
LEAST_JUMP = 1e-6
"""Jump of the slope that is none [-]."""
_MM = 1000.0


@dataclass(frozen=True)
class Fault:
    """What keeps a pitch curve from being a gear, and the carrier angle [rad] where that is worst."""

    t: float
    what: str


def check(machine: Pickup, train: Train) -> None:
    """Raise GeometryError, naming the angle and what causes it there, where the pitch curves cannot be gears."""
    fault = _fault(train)
    if fault is not None:
        source = machine.points_source if train.found is not None else f"{machine.source}: law"
        raise GeometryError(
            f"{source}: this cannot be a pair of gears: at t = {turn_deg(fault.t):.5g} deg from the farthest tip "
            f"{fault.what}; {_cause(machine, train, fault.t)}"
        )


def _fault(train: Train) -> Fault | None:
    """The first limit that is broken, where it is broken most."""
    t = train.samples(SAMPLES)
    slope = train.law.slopes(t)[0]
    least = int(np.argmin(slope))
    if slope[least] <= 0:
        turned = "turns back" if slope[least] < 0 else "stands still"
        return Fault(
            float(t[least]), f"the arm {turned} (slope {slope[least]:.4g}, which must stay positive on the teeth)"
        )
    curves = train.pitch(t)
    for (gear, kind), excess in limits.excesses(curves, train.teeth).items():
        worst = int(np.argmax(excess))
        if excess[worst] >= 0:
            here = {name: float(values[worst]) for name, values in curves.items()}
            return Fault(float(t[worst]), _told(train, gear, kind, here))
    return None


def _told(train: Train, gear: str, kind: str, here: Mapping[str, float]) -> str:
    """What is wrong with a gear at an angle."""
    radius, kappa = limits.GEARS[gear]
    reach, addendum = limits.reaches(train.teeth)[gear] * _MM, limits.addenda(train.teeth)[gear] * _MM
    if kind == "radius":
        ratio = here["R2"] / here["R1"]
        return (
            f"the pitch radius of the {gear} is {here[radius] * _MM:.4g} mm (total ratio {ratio:.4g}), but the teeth "
            f"of its mate reach {reach:.4g} mm into it, past its axis"
        )
    depth, end = (reach, "roots") if kind == "sharp" else (addendum, "tips")
    return (
        f"the pitch curve of the {gear} is {kind} with a radius of curvature of {_MM / abs(here[kappa]):.4g} mm, less "
        f"than the {depth:.4g} mm between it and the {end} of its teeth: a cusp"
    )


def _cause(machine: Pickup, train: Train, t: float) -> str:
    """What the path, or the law, does there."""
    law = "the law there must be changed (p, the dwell, the transition)"
    return law if train.found is None else f"there the path passes {_place(machine, train, t)}, {_doing(train, t)}"


def _place(machine: Pickup, train: Train, t: float) -> str:
    x, y = train.tip(np.array([t]))[0]
    place = f"({x * _MM:.5g}, {y * _MM:.5g}) mm"
    if machine.points is None:
        return place
    nearest = int(np.argmin(np.hypot(*(machine.points - [x, y]).T)))
    return f"{place}, by point {nearest + 1}"


def _doing(train: Train, t: float) -> str:
    """What the tip's distance from the sun's centre does about an angle, and whether the arm hurries beside it."""
    near = t + np.linspace(-BESIDE, BESIDE, 321)
    slopes = train.slope(near)
    fast = int(np.argmax(slopes))
    distance = train.motion(t + np.array([-AROUND, AROUND]))["L3"] * _MM
    told = (
        f"and its distance from the sun's centre changes by {distance[1] - distance[0]:.3g} mm in "
        f"{2 * np.degrees(AROUND):g} deg of the carrier"
    )
    if slopes[fast] < STEEP:
        return f"{told}: where the arm is to move it must change on steadily"
    return (
        f"{told}; at t = {turn_deg(near[fast]):.5g} deg the arm must turn {slopes[fast]:.3g} times as fast as the "
        f"carrier, for there the path turns back so quickly that it all but lets the carrier stand still"
    )


def warnings(train: Train) -> Iterator[Warned]:
    """What is to be known of gears that can be made: places of infinite acceleration, of no teeth, of no ratio."""
    yield from _jumps(train)
    yield from _transitions(train)
    t = train.samples(SAMPLES)
    lost = t[np.isnan(train.contact_ratio(t))]
    if len(lost):
        yield _warning(
            "contact ratio", float(lost[0]),
            f"the contact ratio has no value at {len(lost)} of {len(t)} angles on the teeth, the first at t = "
            f"{turn_deg(lost[0]):.4g} deg: a pitch curve is so hollow there that the tips of its teeth lie inside "
            f"their base circle",
        )  # fmt: skip


def _jumps(train: Train) -> Iterator[Warned]:
    """Where the tip's velocity jumps: at the ends of a dwell at which the slope does."""
    if train.law.dwell is None:
        return
    for t, end, name in ((train.driven[1], "begins", "start"), (train.driven[0], "ends", "end")):
        moving, held = _velocities(train, t)
        jump = float(np.hypot(*(moving - held)))
        if abs(float(train.law.slopes(np.array([t]))[0, 0])) > LEAST_JUMP:
            speeds = [float(np.hypot(*v)) * _MM for v in (moving, held)]
            told = "{:.5g} to {:.5g}".format(*(speeds if name == "start" else speeds[::-1]))
            remedy = (
                "a path that comes to rest gently has none"
                if train.found is not None
                else 'ends = "smooth" in [law] gives the dwell smooth ends'
            )
            yield _warning(
                f"velocity jumps at the dwell's {name}", t,
                f"where the dwell {end}, at t = {turn_deg(t):.5g} deg, the tip's velocity jumps by {jump * _MM:.5g} "
                f"mm/s (its speed from {told} mm/s): the acceleration is infinite there; {remedy}",
            )  # fmt: skip


def _velocities(train: Train, t: float) -> tuple[Array, Array]:
    """Velocity of the tip (2,) [m/s] at an end of the dwell, as the teeth drive it and as the locking arcs hold it."""
    at = np.array([t])
    angles = {"phi5": train.phi5_far + at, "phi1": train.law.arm(at), "omega": train.omega}
    found = [
        load(MODEL)("motion", **angles, g=slope, triangle=train.geometry.triangle)
        for slope in (train.law.slopes(at)[0], np.zeros(1))
    ]
    moving, held = (np.array([one["vx_S"][0], one["vy_S"][0]]) for one in found)
    return moving, held


def _transitions(train: Train) -> Iterator[Warned]:
    """Where the arm moves and no teeth can drive it."""
    for driven, toothed, name in zip(train.driven, train.toothed, ("end", "start"), strict=True):
        if driven != toothed:
            first, last = sorted((turn_deg(driven), turn_deg(toothed)))
            yield _warning(
                f"no teeth at the dwell's {name}", driven,
                f"from t = {first:.5g} to {last:.5g} deg the slope goes to zero, and the sun's pitch radius with it, "
                f"as no teeth can: other means (a cam, a pin) must drive the arm there",
            )  # fmt: skip


def _warning(name: str, t: float, message: str) -> Warned:
    return Warned(name, turn_deg(t), message)
