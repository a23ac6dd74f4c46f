"""`planter train`: from an angle curve to the gear train, and the misses of its arm at poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.errors import InputError
from planter.kernels import Array
from planter.mapping import conversion, faults
from planter.mapping.curve import AngleCurve
from planter.mapping.dyads import Dyad, distinct, solve_dyads
from planter.mapping.file import PoseFile
from planter.mapping.nearest import find_misses
from planter.mapping.results import Missed, TrainFound
from planter.mapping.train import Train
from planter.numerics.arrays import TURN


@dataclass(frozen=True)
class Training:
    """A train with its carrier dyad and poses, or None; `result` is what the command returns."""

    train: Train
    crank: float | None
    dyad: Dyad | None
    poses: Array | None
    result: TrainFound


def build_training(
    curve: AngleCurve, distance: float, crank: float | None = None, file: PoseFile | None = None, carrier: int = 1
) -> Training:
    """Return the train of a curve for a centre distance and an optional carrier length [m], with its misses at poses.

    Raises ComputationError if the slope of the curve reaches zero, InputError if the carrier does not fit.
    """
    dyad = None if file is None else _carrier(file, carrier)
    if crank is None and dyad is not None:
        crank = dyad.radius
    train = Train(curve, distance)
    bend = None if crank is None else train.bend(crank)
    poses = None if file is None else file.poses
    missed = [] if dyad is None or poses is None else _missed(curve, dyad, poses)
    return Training(train, crank, dyad, poses, _result(train, bend, missed))


def _carrier(file: PoseFile, number: int) -> Dyad:
    """The dyad that a file names for its carrier, or a real one of its poses, counted by radius."""
    if file.carrier_dyad is not None and number == 1:
        return file.carrier_dyad
    dyads = solve_dyads(file.poses).dyads if len(distinct(file.poses)) > 1 else []
    if not 1 <= number <= len(dyads):
        raise InputError(f"--carrier {number}: {file.source} has {len(dyads)} real dyads; choose one of these numbers")
    return dyads[number - 1]


def _result(train: Train, bend: float | None, missed: list[Missed]) -> TrainFound:
    lowest, largest = train.curve.extremes
    smallest, biggest = train.radius_range
    return TrainFound(
        x_s=train.x_s,
        x_s_under_root=train.x_s**2,
        slope_min=lowest.value,
        slope_max=largest.value,
        slope_min_at_deg=conversion.to_degrees(lowest.angle % TURN),
        slope_max_at_deg=conversion.to_degrees(largest.angle % TURN),
        monotone=train.curve.monotone,
        ratio_min=1 / largest.value,
        ratio_max=1 / lowest.value,
        closure_error_rad=train.closure_errors,
        carrier_bend_deg=None if bend is None else conversion.to_degrees(bend),
        convex=train.convex,
        concave_deg=[
            [(conversion.to_degrees(a), conversion.to_degrees(b)) for a, b in train.concave(k)] for k in range(4)
        ],
        radius_min_mm=conversion.to_four(smallest),
        radius_max_mm=conversion.to_four(biggest),
        curvature_radius_min_mm=conversion.to_four(train.least_curvature_radius),
        module_max_mm=faults.largest_module(train) * 1e3,
        poses=missed,
        warnings=faults.warnings(train),
    )


def _missed(curve: AngleCurve, dyad: Dyad, poses: Array) -> list[Missed]:
    return [conversion.miss_result(k, miss) for k, miss in enumerate(find_misses(dyad, poses, curve), 1)]


def polar_curves(train: Train, samples: int = 361) -> tuple[Array, Array]:
    """Polar angles (4, m) [rad] and radii (4, m) [m] of the pitch curves, at the train's own carrier angles."""
    theta, psi = train.polar_angles()
    step = max(len(theta) // samples, 1)
    chosen = np.unique(np.append(np.arange(0, len(theta), step), len(theta) - 1))
    gears = train.gears(theta[chosen])
    return psi[:, chosen], np.array([gears[name] for name in ("r1", "r2", "r3", "r4")])
