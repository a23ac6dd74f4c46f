"""Analysis of a pick-up: its result, redesign, and columns of its CSV files."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planter.errors import InputError
from planter.kernels import Array
from planter.numerics.arrays import TURN
from planter.papers.pickup import gears
from planter.papers.pickup.file import Pickup, load_pickup
from planter.papers.pickup.gears import Locking, compute_locking_arcs
from planter.papers.pickup.inverse import invert_path
from planter.papers.pickup.law import Dwell
from planter.papers.pickup.model import PickupTrain, build_train
from planter.papers.pickup.redesign import Redesign, redesign_path
from planter.papers.pickup.requirements import find_push, list_requirements
from planter.papers.pickup.results import (
    Demand,
    ExtremaResult,
    LockingArcs,
    Optimised,
    PickupFound,
    PickupState,
    PickupWarning,
    Push,
    Slope,
    Still,
    SunToothCount,
)
from planter.progress import Listener

ROUND_TRIP_POINTS = 4096
"""Points of the tip's path from which the inverse chain must find the law again."""
COMPARED = 2881
"""Carrier angles at which both laws are compared."""
_MM = 1000.0


def count_teeth(train: PickupTrain) -> SunToothCount:
    """Number of teeth on the toothed arc, made whole by scaling the module."""
    exact = train.arc / (np.pi * float(train.teeth[0]))
    whole = max(1, round(exact))
    return SunToothCount(exact, whole, train.arc / (np.pi * whole) * _MM)


def round_trip(train: PickupTrain) -> float | None:
    """Largest difference of phi1 [rad] between a train's law and the law found again from points of
    its path alone.

    None where the arm's angle falls at times: then the tip has more than one farthest or nearest
    place.
    """
    if not train.monotone:
        return None
    inversion = invert_path(train.tip(np.arange(ROUND_TRIP_POINTS) * TURN / ROUND_TRIP_POINTS))
    t = np.linspace(0, TURN, COMPARED)
    turned = inversion.phi5_far - train.phi5_far
    turned -= TURN * round(turned / TURN)
    return float(np.abs(inversion.law.arm(t - turned) - train.law.arm(t)).max())


def build_result(machine: Pickup, train: PickupTrain, at: Sequence[float] = ()) -> PickupFound:
    """Return the result of `design pickup`; `at` are carrier angles in deg from the farthest tip.

    Raises GeometryError, naming angle and cause, if the pitch curves cannot be gears.
    """
    gears.check_gears(machine, train)
    geometry, slopes = train.geometry, train.slope_extremes
    dwell = train.law.dwell
    counted, arcs, demands = (
        count_teeth(train),
        compute_locking_arcs(train),
        list_requirements(machine, train),
    )
    where, swing = find_push(train)
    return PickupFound(
        machine=machine.name,
        driven_by="law" if machine.law is not None else "path",
        L1_mm=geometry.L1 * _MM,
        L2_mm=geometry.L2 * _MM,
        L3_max_mm=(geometry.L1 + geometry.L2) * _MM,
        L3_min_mm=(geometry.L2 - geometry.L1) * _MM,
        phi5_far_deg=_deg(train.phi5_far % TURN),
        phi5_near_deg=_deg(train.nearest_angle),
        beta1_deg=_deg(geometry.beta1),
        a1_mm=geometry.a1 * _MM,
        a2_mm=geometry.a2 * _MM,
        helix_deg=_deg(geometry.helix),
        helical_contact_ratio=geometry.helical_contact_ratio,
        dwell=None if dwell is None else _dwell(train, dwell),
        slope=Slope(0.0 if dwell else slopes[0], slopes[1], _mean_slope(train)),
        sun_radius_mm=ExtremaResult(*(geometry.a1 * slope / (1 + slope) * _MM for slope in slopes)),
        sun_toothed_arc_mm=train.arc * _MM,
        phi1_monotone=train.monotone,
        round_trip_error_rad=round_trip(train),
        teeth=counted,
        locking_arcs=None if arcs is None else _arcs(arcs),
        push=Push(_deg(where), _deg(swing)),
        requirements=demands,
        warnings=[
            *list_requirement_warnings(demands),
            *gears.list_gear_warnings(train),
            *_unlocked(train, arcs),
        ],
        at=[_row(train, angle) for angle in at],
    )


def _dwell(train: PickupTrain, dwell: Dwell) -> Still:
    radius = float(train.motion(np.array([dwell.start]))["L3"][0])
    return Still(start_deg=_deg(dwell.start), end_deg=_deg(dwell.end), tip_radius_mm=radius * _MM)


def _arcs(arcs: Locking) -> LockingArcs:
    start, end = arcs.ends
    first, last = map(_deg, arcs.reaches)
    return LockingArcs(arcs.radius * _MM, (start * _MM, end * _MM), _deg(arcs.sweep), (first, last))


def list_requirement_warnings(checked: Sequence[Demand]) -> list[PickupWarning]:
    """A warning for each requirement that does not hold."""
    return [
        PickupWarning(
            requirement.name,
            requirement.t_deg,
            f"{requirement.name} is {requirement.value:.4g} {requirement.unit}".rstrip()
            + f", wanted {requirement.wanted}",
        )
        for requirement in checked
        if not requirement.holds
    ]


def _unlocked(train: PickupTrain, arcs: Locking | None) -> Iterator[PickupWarning]:
    """A warning where no locking arcs would hold the dwell."""
    if arcs is None and train.law.dwell is not None:
        yield PickupWarning(
            "locking arcs",
            _deg(train.law.dwell.start),
            "no locking arcs would hold the intermediate gear both ways in the dwell: other means "
            "must",
        )


def _row(train: PickupTrain, angle: float) -> PickupState:
    t = np.array([np.radians(angle)])
    state = {name: float(value[0]) for name, value in train.motion(t).items()}
    curvature: list[float | None] = [None, None]
    ratio = None
    if train.meshes(t)[0]:
        curves = train.pitch(t)
        bends = [float(curves[name][0]) for name in ("kappa1", "kappa2")]
        curvature = [None if bend == 0 else _MM / bend for bend in bends]
        found_ratio = float(train.contact_ratio(t, *PRINTED_TEETH)[0])
        ratio = None if np.isnan(found_ratio) else found_ratio
    return PickupState(
        t_deg=float(angle),
        tip_mm=(state["x_S"] * _MM, state["y_S"] * _MM),
        L3_mm=state["L3"] * _MM,
        tip_speed_mm_s=float(np.hypot(state["vx_S"], state["vy_S"])) * _MM,
        rho1_mm=curvature[0],
        rho2_mm=curvature[1],
        contact_ratio=ratio,
    )


PRINTED_TEETH = (0.002, 1.2)
"""Module [m] and addendum coefficient for which single angles tell the contact ratio."""


def _mean_slope(train: PickupTrain) -> float:
    """Mean slope over the whole turn, from the integral over the teeth: the dwell adds nothing."""
    return train.integral(lambda t: train.law.slopes(t)[0]) / TURN


def _deg(angle: float) -> float:
    return float(np.degrees(angle))


def sample_cycle(train: PickupTrain, count: int) -> dict[str, Array]:
    """Columns of a turn at equal steps, in shown units."""
    t = np.arange(count) * TURN / count
    state = train.motion(t)
    heading = train.arm_heading(t)
    return {
        "t_deg": np.degrees(t),
        "phi1_deg": np.degrees(train.law.arm(t)),
        "slope": train.slope(t),
        "tip_x_mm": state["x_S"] * _MM,
        "tip_y_mm": state["y_S"] * _MM,
        "L3_mm": state["L3"] * _MM,
        "tip_vx_mm_s": state["vx_S"] * _MM,
        "tip_vy_mm_s": state["vy_S"] * _MM,
        "arm_turned_back_deg": np.degrees(heading[0] - heading),
    }


def sample_pitch(train: PickupTrain, count: int) -> dict[str, Array]:
    """Columns over the teeth: pitch radii, curves in the gears' own frames, curvatures, contact
    ratio.

    The contact ratio is left out where it has no value at some angles.
    """
    t = train.samples(count)
    curves, ratio = train.pitch(t), train.contact_ratio(t)
    return {
        "t_deg": np.degrees(t),
        "slope": train.law.slopes(t)[0],
        "sun_radius_mm": curves["R1"] * _MM,
        "intermediate_radius_mm": curves["R2"] * _MM,
        **{f"{axis}{gear}_mm": curves[f"{axis}{gear}"] * _MM for gear in "12" for axis in "xy"},
        "sun_curvature_per_mm": curves["kappa1"] / _MM,
        "intermediate_curvature_per_mm": curves["kappa2"] / _MM,
        **({} if np.isnan(ratio).any() else {"contact_ratio": ratio}),
    }


@dataclass(frozen=True)
class PickupOutcome:
    """A pick-up, its train, the redesign if there was one, and what the command returns."""

    machine: Pickup
    train: PickupTrain
    redesigned: Redesign | None
    result: PickupFound


def analyse_pickup(
    source: str,
    at: Sequence[float] = (),
    optimise: bool = False,
    changes: Mapping[str, float] | None = None,
    progress: Listener | None = None,
) -> PickupOutcome:
    """Return the outcome for a file, built-in name or CSV of points; `at`: carrier angles [deg]
    from the farthest tip.

    Raises InputError for bad input, ComputationError if the redesign fails.
    """
    for angle in at:
        if not math.isfinite(angle):
            raise InputError(f"--at {angle}: must be a finite angle in deg")
    machine = load_pickup(source, changes)
    train = build_train(machine)
    if not optimise:
        return PickupOutcome(machine, train, None, build_result(machine, train, at))
    moved = redesign_path(machine, train, progress)
    return PickupOutcome(
        machine,
        moved.train,
        moved,
        replace(build_result(machine, moved.train, at), optimised=_to_optimised(moved)),
    )


def _to_optimised(moved: Redesign) -> Optimised:
    return Optimised(
        holds=moved.holds,
        moved_mm=moved.moved * 1000,
        iterations=moved.iterations,
        rounds=moved.rounds,
        certificate=moved.certificate,
        requirements_before=moved.before,
        value_points_before_mm=[(x, y) for x, y in (moved.points_before * 1000).tolist()],
        value_points_mm=[(x, y) for x, y in (moved.points * 1000).tolist()],
    )
