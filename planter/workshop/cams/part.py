"""A cam as it leaves: its contour as drawn, what limits it, and where its roller is along the turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.numerics.extremes import Extreme
from planter.workshop import biarcs
from planter.workshop.arcs import Arcs
from planter.workshop.biarcs import Fit
from planter.workshop.bores import Bore, check_wall
from planter.workshop.cams import results
from planter.workshop.cams.lifting import LiftOff
from planter.workshop.cams.profile import Columns, Profile
from planter.workshop.drawing import Line, cross

LEAST_WALL = 0.1
"""Least wall between a bore and the contour, in diameters of the bore: a rule of this program, for which no standard is
known; a thinner ring gives way under the roller and in the chuck."""
_STEP = np.radians(1.0)
_ALIKE = 1e-9
"""Angles nearer than this [rad] are one row of the table."""


@dataclass(frozen=True)
class Part:
    """A cam's profile with its lines as drawn, and the result without the files' names."""

    profile: Profile
    lines: tuple[Line, ...]
    result: results.Cam


def part(
    profile: Profile, kind: str, tolerance: float, lifted: LiftOff | None, own_speed: float, base: float,
    bore: Bore | None = None,
) -> Part:  # fmt: skip
    """The part that a profile gives, its arcs within `tolerance` [m].

    `base` is how far the strip of an open contour reaches below it [m]; a closed one may have a bore. Speeds [rad/s].

    Raises GeometryError where the roller is too large for it, InputError where the bore is.
    """
    tightest = profile.check()
    contour = biarcs.fit(profile.pieces, tolerance, profile.closed)
    pitch = biarcs.fit(profile.pitch_pieces, tolerance, profile.closed)
    outline = contour.arcs if profile.closed else _strip(contour.arcs, base)
    lines = [Line("CONTOUR", outline), Line("PITCH", pitch.arcs)]
    if profile.closed:
        if bore is not None:
            check_wall(bore, outline, profile.name, LEAST_WALL * bore.diameter)
            lines += bore.lines()
        lines += cross((0.0, 0.0), float(np.hypot(*outline.vertices.T).max()) * 1.1)
    return Part(profile, tuple(lines), _result(profile, kind, tightest, contour, lifted, own_speed))


def _result(
    profile: Profile, kind: str, tightest: Extreme, contour: Fit, lifted: LiftOff | None, own_speed: float
) -> results.Cam:
    radius, hollow, pressure = profile.roller * 1e3, tightest.value < 1, profile.largest("pressure")
    return results.Cam(
        machine=profile.name,
        kind=kind,
        roller=results.Roller(
            radius_mm=radius,
            margin=tightest.value,
            least_curvature_radius_mm=radius / (1 - tightest.value) if hollow else None,
            at_deg=float(np.degrees(tightest.place)) if hollow else None,
        ),
        pressure_angle_deg=results.Most(float(np.degrees(pressure.value)), float(np.degrees(pressure.place))),
        lift_off=None if lifted is None else results.LiftOff(
            lifted.speed / units.factor("_rpm"), own_speed / units.factor("_rpm"), float(np.degrees(lifted.angle))
        ),
        contour=results.Contour(
            float(contour.arcs.lengths.sum()) * 1e3, len(contour.arcs.chords), contour.deviation * 1e6
        ),
        files=[],
    )  # fmt: skip


def _strip(contour: Arcs, base: float) -> Arcs:
    """A contour as the upper edge of a strip, down to `base` below its lowest place [m]: one closed outline."""
    low = float(contour.vertices[:, 1].min()) - base
    corners = [(contour.vertices[-1, 0], low), (contour.vertices[0, 0], low)]
    return Arcs(np.vstack([contour.vertices, corners]), np.append(contour.bulges, [0.0, 0.0]))


def table(profile: Profile, entries: Sequence[dict[str, str]]) -> dict[str, Array]:
    """Every quantity of a contour in shown units, under keys that end in them, at whole degrees and all joints."""
    angles = np.unique(np.concatenate([np.arange(0, 2 * np.pi, _STEP), profile.breaks]))
    angles = angles[np.append(np.diff(angles) > _ALIKE, True)]
    found: Columns = profile.course(angles)
    keys = {entry["name"]: units.key(entry["name"], entry["unit"]) for entry in entries}
    return {"cam_deg": np.degrees(angles), **{key: found[name] / units.factor(key) for name, key in keys.items()}}
