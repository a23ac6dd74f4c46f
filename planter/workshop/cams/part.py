"""A cam as a part: its contour in arcs, its limits, and the table of its contour over the turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.numerics.extrema import ExtremePoint
from planter.workshop import biarcs
from planter.workshop.arcs import Arcs
from planter.workshop.biarcs import ArcFit
from planter.workshop.bores import Bore, check_wall
from planter.workshop.cams import results
from planter.workshop.cams.profile import Columns, Profile, RollerLiftOff
from planter.workshop.drawing import DrawingLine, build_cross

MIN_WALL = 0.1
"""Smallest wall between a bore and the contour, in diameters of the bore: a rule of this program without a standard;
a thinner ring deforms under the roller and in the chuck."""
_STEP = np.radians(1.0)
_ANGLE_TOLERANCE = 1e-9
"""Difference below which two angles are one row of the table [rad]."""


@dataclass(frozen=True)
class CamPart:
    """A cam's profile with the lines of its drawing, and the result without file names."""

    profile: Profile
    lines: tuple[DrawingLine, ...]
    result: results.Cam


def build_cam_part(
    profile: Profile, kind: str, tolerance: float, lift_off: RollerLiftOff | None, machine_speed: float, base: float,
    bore: Bore | None = None,
) -> CamPart:  # fmt: skip
    """Return the part of a profile with arcs within `tolerance` [m].

    `base` is the height of the strip below an open contour [m]; a closed one may have a bore. Speeds in [rad/s].

    Raises GeometryError if the roller is too large, InputError if the bore is.
    """
    tightest = profile.check_clearance()
    contour = biarcs.fit_arcs(profile.pieces, tolerance, profile.closed)
    pitch = biarcs.fit_arcs(profile.pitch_pieces, tolerance, profile.closed)
    outline = contour.arcs if profile.closed else _close_strip(contour.arcs, base)
    lines = [DrawingLine("CONTOUR", outline), DrawingLine("PITCH", pitch.arcs)]
    if profile.closed:
        if bore is not None:
            check_wall(bore, outline, profile.name, MIN_WALL * bore.diameter)
            lines += bore.lines()
        lines += build_cross((0.0, 0.0), float(np.hypot(*outline.vertices.T).max()) * 1.1)
    return CamPart(profile, tuple(lines), _summarise(profile, kind, tightest, contour, lift_off, machine_speed))


def _summarise(
    profile: Profile,
    kind: str,
    tightest: ExtremePoint,
    contour: ArcFit,
    lift_off: RollerLiftOff | None,
    machine_speed: float,
) -> results.Cam:
    radius, concave, pressure = profile.roller * 1e3, tightest.value < 1, profile.find_largest("pressure")
    return results.Cam(
        machine=profile.name,
        kind=kind,
        roller=results.Roller(
            radius_mm=radius,
            margin=tightest.value,
            least_curvature_radius_mm=radius / (1 - tightest.value) if concave else None,
            at_deg=float(np.degrees(tightest.place)) if concave else None,
        ),
        pressure_angle_deg=results.Most(float(np.degrees(pressure.value)), float(np.degrees(pressure.place))),
        lift_off=None
        if lift_off is None
        else results.LiftOff(
            lift_off.speed / units.factor("_rpm"),
            machine_speed / units.factor("_rpm"),
            float(np.degrees(lift_off.angle)),
        ),
        contour=results.Contour(
            float(contour.arcs.lengths.sum()) * 1e3, len(contour.arcs.chords), contour.deviation * 1e6
        ),
        files=[],
    )


def _close_strip(contour: Arcs, base: float) -> Arcs:
    """Return the closed outline of a strip under a contour, down to `base` [m] below its lowest point."""
    low = float(contour.vertices[:, 1].min()) - base
    corners = [(contour.vertices[-1, 0], low), (contour.vertices[0, 0], low)]
    return Arcs(np.vstack([contour.vertices, corners]), np.append(contour.bulges, [0.0, 0.0]))


def tabulate_contour(profile: Profile, entries: Sequence[dict[str, str]]) -> dict[str, Array]:
    """Return all quantities of a contour in display units by keys that end in them, at whole degrees and "
    "breakpoints."""
    angles = np.unique(np.concatenate([np.arange(0, 2 * np.pi, _STEP), profile.breaks]))
    angles = angles[np.append(np.diff(angles) > _ANGLE_TOLERANCE, True)]
    columns: Columns = profile.course(angles)
    keys = {entry["name"]: units.key(entry["name"], entry["unit"]) for entry in entries}
    return {"cam_deg": np.degrees(angles), **{key: columns[name] / units.factor(key) for name, key in keys.items()}}
