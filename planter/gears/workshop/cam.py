"""Cams for rollers as parts, whatever mechanism they move: contour, limits of the roller, and
drawing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy
from shapely import LineString

from planter.errors import GeometryError, InputError
from planter.files import units
from planter.gears.geometry.pieces import Piece
from planter.gears.results import Cam, Contour, LiftOff, Most, Roller
from planter.gears.workshop import arcs
from planter.gears.workshop.arcs import Arcs
from planter.gears.workshop.drawing import Bore, DrawingLine, build_cross, check_wall
from planter.kernels import Array
from planter.numerics import extrema
from planter.numerics.extrema import ExtremePoint

Columns = Mapping[str, Array]
SAMPLES = 180
"""Points of a piece from which its extremes are searched."""
MAX_ROLLER_RADIUS = 1.0
_END_OFFSET = 1e-9
"""Share of a piece by which its ends are moved inwards, to the piece's side of a breakpoint."""


def check_roller(radius: float) -> None:
    """Raise InputError if a roller radius [m] is out of range."""
    if not 0 < radius <= MAX_ROLLER_RADIUS:
        raise InputError(
            f"--roller-mm = {radius * 1e3:g}: give a radius above 0 and up to "
            f"{MAX_ROLLER_RADIUS * 1e3:g}"
        )


@dataclass(frozen=True)
class Profile:
    """A cam for a roller: positions of the roller's centre and of the contact in the plane of the
    cam, by the angle.

    `course` returns at angles (n,) [rad] the columns of the generated functions contact_x,
    contact_y, heading, kappa, room, pressure (n,), and the pitch curve under the names in `pitch`
    [SI]. `breaks` are the breakpoints of a turn [rad], first and last included. `closed`: a disc,
    whose contour runs against the angle.
    """

    name: str
    roller: float
    course: Callable[[Array], Columns]
    breaks: tuple[float, ...]
    closed: bool
    pitch: tuple[str, str]

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """Exact pieces of the contour in the direction of its outline."""
        return tuple(self._list_pieces("contour", ("contact_x", "contact_y")))

    @cached_property
    def pitch_pieces(self) -> tuple[Piece, ...]:
        """Exact pieces of the pitch curve in the direction of the outline."""
        return tuple(self._list_pieces("pitch", self.pitch))

    def _list_pieces(self, kind: str, point: tuple[str, str]) -> Iterator[Piece]:
        sense = -1 if self.closed else 1
        for low, high in pairwise(self.breaks[::sense]):

            def evaluate(s: Array, low: float = low, high: float = high) -> Array:
                inside = np.clip(s, _END_OFFSET, 1 - _END_OFFSET)
                columns = self.course(low + (high - low) * inside)
                heading, bend = columns["heading"], sense * columns["kappa"]
                tangent = sense * np.cos(heading), sense * np.sin(heading)
                # a contour is as far from its pitch curve as the roller is large
                bend = bend / columns["room"] if kind == "contour" else bend
                return np.array([*(columns[name] for name in point), *tangent, bend])

            yield Piece(kind, evaluate)

    def find_smallest(self, column: str, sign: float = 1.0) -> ExtremePoint:
        """Return the smallest value of a column, times a sign, over a turn, on both sides of every
        breakpoint.
        """
        inside = np.linspace(_END_OFFSET, 1 - _END_OFFSET, SAMPLES)
        minima = []
        for start, end in pairwise(self.breaks):
            angles = start + (end - start) * inside
            minima.append(extrema.find_minimum(lambda at: sign * self.course(at)[column], angles))
        return min(minima, key=lambda minimum: minimum.value)

    def find_largest(self, column: str) -> ExtremePoint:
        """Return the largest value of a column over a turn, on both sides of every breakpoint."""
        opposite = self.find_smallest(column, -1.0)
        return ExtremePoint(opposite.place, -opposite.value)

    def check_clearance(self) -> ExtremePoint:
        """Return the smallest margin against undercutting, 1 - radius / radius of curvature, and
        its angle.

        Raises GeometryError, naming the angle and the radius, if the roller undercuts the contour.
        """
        clearance = self.find_smallest("room")
        if clearance.value <= 0:
            radius, angle = self.roller / (1 - clearance.value), np.degrees(clearance.place)
            raise GeometryError(
                f"{self.name}: a roller of a radius of {self.roller * 1e3:g} mm undercuts the "
                f"contour at a cam "
                f"angle of {angle:.4g} deg, where the pitch curve has a radius of "
                f"{radius * 1e3:.4g} mm: "
                "choose a smaller roller"
            )
        if not LineString(
            np.vstack([piece.at(np.linspace(0, 1, SAMPLES)) for piece in self.pieces])
        ).is_simple:
            raise GeometryError(
                f"{self.name}: the contour for a roller of {self.roller * 1e3:g} mm crosses itself"
            )
        return clearance


MIN_SPEED_SHARE = 1e-3
"""Share of a machine's speed that stands for rest, at which directions of sliding are still
defined.
"""
MAX_SPEED_RATIO = 64
"""Multiple of a machine's speed up to which a lift-off is searched."""
_ANGLES = 2 * np.pi * np.arange(720) / 720
Push = Callable[[Array, float], Array]
"""Contact force (n,) [N], positive where the cam pushes, at angles (n,) [rad] and a speed
[rad/s].
"""


def find_lift_off(push: Push, speed: float) -> LiftOff | None:
    """Return the lowest speed at which the contact force vanishes in a turn, or None up to
    `MAX_SPEED_RATIO` times `speed`.

    The speed is zero if nothing presses the roller on at rest.
    """
    low, high, rpm = MIN_SPEED_SHARE * speed, speed, units.unit_factor("_rpm")
    critical = 0.0
    first = _find_smallest_force(push, low)
    if first.value > 0:
        # inertia grows with the square of the speed, so that doubling brackets the root soon
        while _find_smallest_force(push, high).value > 0:
            low, high = high, 2 * high
            if abs(high) > MAX_SPEED_RATIO * abs(speed):
                return None
        critical = float(
            scipy.optimize.brentq(
                lambda trial: _find_smallest_force(push, trial).value, low, high, rtol=1e-12
            )
        )
        first = _find_smallest_force(push, critical)
    return LiftOff(critical / rpm, speed / rpm, float(np.degrees(first.place % (2 * np.pi))))


def _find_smallest_force(push: Push, speed: float) -> extrema.ExtremePoint:
    return extrema.find_minimum(lambda angles: push(angles, speed), _ANGLES, closed=True)


MIN_WALL = 0.1
"""Smallest wall between a bore and the contour, in diameters of the bore: a rule of this program
without a standard; a thinner ring deforms under the roller and in the chuck.
"""
_STEP = np.radians(1.0)
_ANGLE_TOLERANCE = 1e-9
"""Difference below which two angles are one row of the table [rad]."""


@dataclass(frozen=True)
class CamPart:
    """A cam's profile with the lines of its drawing, and the result without file names."""

    profile: Profile
    lines: tuple[DrawingLine, ...]
    result: Cam


def build_cam_part(
    profile: Profile,
    kind: str,
    tolerance: float,
    lift_off: LiftOff | None,
    base: float,
    bore: Bore | None = None,
) -> CamPart:
    """Return the part of a profile with arcs within `tolerance` [m].

    `base` is the height of the strip below an open contour [m]; a closed one may have a bore.

    Raises GeometryError if the roller is too large, InputError if the bore is.
    """
    tightest, pressure = profile.check_clearance(), profile.find_largest("pressure")
    contour = arcs.fit_arcs(profile.pieces, tolerance, profile.closed)
    pitch = arcs.fit_arcs(profile.pitch_pieces, tolerance, profile.closed)
    outline = contour if profile.closed else _close_strip(contour, base)
    lines = [DrawingLine("CONTOUR", outline), DrawingLine("PITCH", pitch)]
    if profile.closed:
        if bore is not None:
            check_wall(bore, outline, profile.name, MIN_WALL * bore.diameter)
            lines += bore.lines()
        lines += build_cross((0.0, 0.0), float(np.hypot(*outline.vertices.T).max()) * 1.1)
    radius, concave = profile.roller * 1e3, tightest.value < 1
    result = Cam(
        machine=profile.name,
        kind=kind,
        roller=Roller(
            radius_mm=radius,
            margin=tightest.value,
            least_curvature_radius_mm=radius / (1 - tightest.value) if concave else None,
            at_deg=float(np.degrees(tightest.place)) if concave else None,
        ),
        pressure_angle_deg=Most(*np.degrees([pressure.value, pressure.place]).tolist()),
        lift_off=lift_off,
        contour=Contour(
            float(contour.lengths.sum()) * 1e3, len(contour.chords), contour.deviation * 1e6
        ),
        files=[],
    )
    return CamPart(profile, tuple(lines), result)


def _close_strip(contour: Arcs, base: float) -> Arcs:
    """Return the closed outline of a strip under a contour, down to `base` [m] below its lowest
    point.
    """
    low = float(contour.vertices[:, 1].min()) - base
    corners = [(contour.vertices[-1, 0], low), (contour.vertices[0, 0], low)]
    return Arcs(np.vstack([contour.vertices, corners]), np.append(contour.bulges, [0.0, 0.0]))


def tabulate_contour(profile: Profile, entries: Sequence[dict[str, str]]) -> dict[str, Array]:
    """Return all quantities of a contour in display units by keys that end in them, at whole
    degrees and " "breakpoints.
    """
    angles = np.unique(np.concatenate([np.arange(0, 2 * np.pi, _STEP), profile.breaks]))
    angles = angles[np.append(np.diff(angles) > _ANGLE_TOLERANCE, True)]
    columns: Columns = profile.course(angles)
    keys = units.display_keys(entries)
    return {
        "cam_deg": np.degrees(angles),
        **{key: columns[name] / units.unit_factor(key) for name, key in keys.items()},
    }
