"""What a pick-up is found to be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planter.kernels import Array
from planter.numerics.angles import TURN
from planter.pickup import gears
from planter.pickup.file import Pickup
from planter.pickup.inverse import invert
from planter.pickup.law import Dwell
from planter.pickup.locking import Locking, locking
from planter.pickup.model import Train
from planter.pickup.requirements import Requirement, push, requirements
from planter.pickup.results import At, Extremes, LockingArcs, PickupFound, Push, Slope, Still, Warned, WholeTeeth

ROUND_TRIP_POINTS = 4096
"""Points of the tip's path from which the inverse chain must find the law again."""
COMPARED = 2881
"""Carrier angles at which both laws are compared."""
_MM = 1000.0


@dataclass(frozen=True)
class Teeth:
    """Teeth of the sun: arc over pitch, the next whole number, and the module that makes it whole [m]."""

    exact: float
    whole: int
    module: float


def teeth(train: Train) -> Teeth:
    """Number of teeth on the toothed arc, made whole by scaling the module."""
    exact = train.arc / (np.pi * float(train.teeth[0]))
    whole = max(1, round(exact))
    return Teeth(exact, whole, train.arc / (np.pi * whole))


def round_trip(train: Train, count: int = ROUND_TRIP_POINTS) -> float | None:
    """Largest difference of phi1 [rad] between a train's law and the law found again from points of its path alone.

    None where the arm's angle falls at times: then the tip has more than one farthest or nearest place.
    """
    if not train.monotone:
        return None
    found = invert(train.tip(np.arange(count) * TURN / count))
    t = np.linspace(0, TURN, COMPARED)
    turned = found.phi5_far - train.phi5_far
    turned -= TURN * round(turned / TURN)
    return float(np.abs(found.law.arm(t - turned) - train.law.arm(t)).max())


def found(machine: Pickup, train: Train, at: Sequence[float] = ()) -> PickupFound:
    """Everything that `planter pickup` tells; `at` are carrier angles in deg from the farthest tip.

    Raises GeometryError, naming angle and cause, for what cannot be gears.
    """
    gears.check(machine, train)
    geometry, slopes = train.geometry, train.slope_extremes
    dwell = train.law.dwell
    counted, arcs, wanted = teeth(train), locking(train), requirements(machine, train)
    where, swing = push(train)
    return PickupFound(
        machine=machine.name,
        driven_by="law" if machine.law is not None else "path",
        L1_mm=geometry.L1 * _MM,
        L2_mm=geometry.L2 * _MM,
        L3_max_mm=(geometry.L1 + geometry.L2) * _MM,
        L3_min_mm=(geometry.L2 - geometry.L1) * _MM,
        phi5_far_deg=_deg(train.phi5_far % TURN),
        phi5_near_deg=_deg(train.near),
        beta1_deg=_deg(geometry.beta1),
        a1_mm=geometry.a1 * _MM,
        a2_mm=geometry.a2 * _MM,
        helix_deg=_deg(geometry.helix),
        helical_contact_ratio=geometry.helical_contact_ratio,
        dwell=None if dwell is None else _dwell(train, dwell),
        slope=Slope(0.0 if dwell else slopes[0], slopes[1], _mean_slope(train)),
        sun_radius_mm=Extremes(*(geometry.a1 * slope / (1 + slope) * _MM for slope in slopes)),
        sun_toothed_arc_mm=train.arc * _MM,
        phi1_monotone=train.monotone,
        round_trip_error_rad=round_trip(train),
        teeth=WholeTeeth(counted.exact, counted.whole, counted.module * _MM),
        locking_arcs=None if arcs is None else _arcs(arcs),
        push=Push(_deg(where), _deg(swing)),
        requirements=[requirement.shown() for requirement in wanted],
        warnings=[*warnings(wanted), *gears.warnings(train), *_unlocked(train, arcs)],
        at=[_row(train, angle) for angle in at],
    )


def _dwell(train: Train, dwell: Dwell) -> Still:
    radius = float(train.motion(np.array([dwell.start]))["L3"][0])
    return Still(start_deg=_deg(dwell.start), end_deg=_deg(dwell.end), tip_radius_mm=radius * _MM)


def _arcs(arcs: Locking) -> LockingArcs:
    start, end = arcs.ends
    first, last = map(_deg, arcs.reaches)
    return LockingArcs(arcs.radius * _MM, (start * _MM, end * _MM), _deg(arcs.sweep), (first, last))


def warnings(wanted: Sequence[Requirement]) -> list[Warned]:
    """A warning for each requirement that does not hold."""
    return [
        Warned(one.name, one.t_deg, f"{one.name} is {one.value:.4g} {one.unit}".rstrip() + f", wanted {one.wanted}")
        for one in wanted
        if not one.holds
    ]


def _unlocked(train: Train, arcs: Locking | None) -> Iterator[Warned]:
    """A warning where no locking arcs would hold the dwell."""
    if arcs is None and train.law.dwell is not None:
        yield Warned(
            "locking arcs", _deg(train.law.dwell.start),
            "no locking arcs would hold the intermediate gear both ways in the dwell: other means must",
        )  # fmt: skip


def _row(train: Train, angle: float) -> At:
    t = np.array([np.radians(angle)])
    found = {name: float(value[0]) for name, value in train.motion(t).items()}
    curvature: list[float | None] = [None, None]
    ratio = None
    if train.meshes(t)[0]:
        curves = train.pitch(t)
        bends = [float(curves[name][0]) for name in ("kappa1", "kappa2")]
        curvature = [None if bend == 0 else _MM / bend for bend in bends]
        found_ratio = float(train.contact_ratio(t, *PRINTED_TEETH)[0])
        ratio = None if np.isnan(found_ratio) else found_ratio
    return At(
        t_deg=float(angle),
        tip_mm=(found["x_S"] * _MM, found["y_S"] * _MM),
        L3_mm=found["L3"] * _MM,
        tip_speed_mm_s=float(np.hypot(found["vx_S"], found["vy_S"])) * _MM,
        rho1_mm=curvature[0],
        rho2_mm=curvature[1],
        contact_ratio=ratio,
    )


PRINTED_TEETH = (0.002, 1.2)
"""Module [m] and addendum coefficient for which single angles tell the contact ratio."""


def _mean_slope(train: Train) -> float:
    """Mean slope over the whole turn, from the integral over the teeth: the dwell adds nothing."""
    return train.integral(lambda t: train.law.slopes(t)[0]) / TURN


def _deg(angle: float) -> float:
    return float(np.degrees(angle))


def cycle(train: Train, count: int) -> dict[str, Array]:
    """Columns of a turn at equal steps, in shown units."""
    t = np.arange(count) * TURN / count
    found = train.motion(t)
    heading = train.arm_heading(t)
    return {
        "t_deg": np.degrees(t),
        "phi1_deg": np.degrees(train.law.arm(t)),
        "slope": train.slope(t),
        "tip_x_mm": found["x_S"] * _MM,
        "tip_y_mm": found["y_S"] * _MM,
        "L3_mm": found["L3"] * _MM,
        "tip_vx_mm_s": found["vx_S"] * _MM,
        "tip_vy_mm_s": found["vy_S"] * _MM,
        "arm_turned_back_deg": np.degrees(heading[0] - heading),
    }


def pitch(train: Train, count: int) -> dict[str, Array]:
    """Columns over the teeth: pitch radii, curves in the gears' own frames, curvatures, contact ratio.

    The contact ratio is left out where it has no value at some angles.
    """
    t = train.samples(count)
    found, ratio = train.pitch(t), train.contact_ratio(t)
    return {
        "t_deg": np.degrees(t),
        "slope": train.law.slopes(t)[0],
        "sun_radius_mm": found["R1"] * _MM,
        "intermediate_radius_mm": found["R2"] * _MM,
        **{f"{axis}{gear}_mm": found[f"{axis}{gear}"] * _MM for gear in "12" for axis in "xy"},
        "sun_curvature_per_mm": found["kappa1"] / _MM,
        "intermediate_curvature_per_mm": found["kappa2"] / _MM,
        **({} if np.isnan(ratio).any() else {"contact_ratio": ratio}),
    }
