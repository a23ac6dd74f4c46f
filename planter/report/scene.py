"""The motion of a mechanism over a cycle: poses of rigid bodies, points, forces, curves and events;
sampling of curves.

Lengths in mm, angles in deg, y upwards; all series are sampled at the same n moments.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray

from planter.kernels import Array, Flags, Integers

Complex = NDArray[np.complex128]
Look = Literal["body", "gear", "teeth", "frame", "line", "mark", "ground", "soil", "before"]
"""Style of an outline: filled as a body or a gear, as a bar of a frame, as a line in its shade, as a
thin mark, as ground, filled as soil, or pale.

A gear is its pitch curve, which is a thin mark if the scene has teeth.
"""


@dataclass(frozen=True)
class Outline:
    """Points (k, 2) [mm] of a line that is fixed in a body, relative to the origin of the body."""

    points: Array
    look: Look = "body"
    closed: bool = True
    shade: int = 0


@dataclass(frozen=True)
class Body:
    """A body: its outlines, and its origin [mm] and angle [deg] relative to its parent or the
    machine.

    Its outlines are stretched along its axes by its `scale`, as those of a spring; such a body has
    no parts.
    """

    name: str
    outlines: Sequence[Outline]
    at: Sequence[float | Array] | Array = (0.0, 0.0)
    turn: float | Array = 0.0
    parts: Sequence[Body] = ()
    scale: Sequence[float | Array] = (1.0, 1.0)


@dataclass(frozen=True)
class Point:
    """A point (n,) [mm] of the machine; its path over the cycle is drawn if `traced`."""

    name: str
    x: float | Array
    y: float | Array
    traced: bool = False


@dataclass(frozen=True)
class Chain:
    """A line through points, by their numbers in the scene: a body that is defined by its joints
    only.
    """

    name: str
    points: Sequence[int]
    closed: bool = False
    shade: int = 0


@dataclass(frozen=True)
class Label:
    """A text at a point [mm] of the machine, which is the start, middle or end of the text."""

    text: str
    x: float
    y: float
    anchor: Literal["start", "middle", "end"] = "middle"


@dataclass(frozen=True)
class Force:
    """A force (n,) [N] at a point."""

    name: str
    at: Point
    x: Array
    y: Array


@dataclass(frozen=True)
class Curve:
    """A quantity over the cycle (n,); `reference` is a value to compare it with, such as the
    weight.
    """

    name: str
    unit: str
    values: Array
    reference: float | None = None


@dataclass(frozen=True)
class Event:
    """An event of the cycle, at a place in the unit of the scene's places."""

    name: str
    place: float


@dataclass(frozen=True)
class Scene:
    """A mechanism over a cycle of a duration `seconds` [s], with the positions `places` (n,) of its
    moments.

    `shares` (n,) are the elapsed shares of the duration at all moments, from 0; by default they are
    equidistant. A cycle is repeated `again`, and its last share is below 1, unless the motion is
    not periodic. `later` returns the same scene with details that take too long to compute while a
    slider moves, such as teeth. `travel` (n,) [mm] is the displacement of the machine in x relative
    to the ground, in which `ground` is fixed.
    """

    title: str
    place: str
    unit: str
    places: Array
    seconds: float
    bodies: Sequence[Body] = ()
    points: Sequence[Point] = ()
    chains: Sequence[Chain] = ()
    forces: Sequence[Force] = ()
    curves: Sequence[Curve] = ()
    events: Sequence[Event] = ()
    ground: Sequence[Outline] = ()
    travel: Array | None = None
    again: bool = True
    labels: Sequence[Label] = ()
    later: Callable[[], Scene] | None = None
    shares: Array | None = None

    @property
    def times(self) -> Array:
        """Elapsed shares of the duration at all moments, (n,)."""
        return np.arange(self.moments) / self.moments if self.shares is None else self.shares

    @property
    def moments(self) -> int:
        """Number n of moments."""
        return len(self.places)

    def with_details(self) -> Scene:
        """Return the scene with the details that take longer to compute."""
        return self if self.later is None else self.later()

    @property
    def travels(self) -> bool:
        """Whether the machine moves over the ground."""
        return self.travel is not None and bool(np.ptp(self.travel) > 0)

    @property
    def toothed(self) -> bool:
        """Whether any teeth are drawn."""
        return any(
            outline.look == "teeth" for body in self.all_bodies() for outline in body.outlines
        )

    @property
    def largest_force(self) -> float:
        """Largest force of all moments [N], or zero if there are no forces."""
        return max((float(np.hypot(force.x, force.y).max()) for force in self.forces), default=0.0)

    def all_bodies(self) -> Iterator[Body]:
        """Return bodies and their parts in the order of the drawing, parents before parts."""
        return _with_parts(self.bodies)

    def placed(self, moments: slice) -> Iterator[tuple[Outline, Array]]:
        """Yield every outline with its points (m, k, 2) [mm] in the machine at some moments."""
        still = np.zeros(1, dtype=complex)
        for body in self.bodies:
            yield from self._placed(body, moments, still, still + 1)

    def _placed(
        self, body: Body, moments: slice, origin: Complex, direction: Complex
    ) -> Iterator[tuple[Outline, Array]]:
        """Yield outlines of a body and its parts; the parent's origins and directions (m,) are
        complex numbers.
        """
        x, y, turn, *scale = (channel[moments] for channel in self.pose(body))
        origin, direction = (
            origin + direction * (x + 1j * y),
            direction * np.exp(1j * np.radians(turn)),
        )
        for outline in body.outlines:
            x, y = (np.outer(factor, outline.points[:, axis]) for axis, factor in enumerate(scale))
            points = origin[:, None] + direction[:, None] * (x + 1j * y)
            yield outline, np.stack([points.real, points.imag], axis=-1)
        for part in body.parts:
            yield from self._placed(part, moments, origin, direction)

    def pose(self, body: Body) -> list[Array]:
        """Return x, y [mm], angle [deg] and both scales of a body at all moments, (n,) each."""
        channels = (np.asarray(v, dtype=float) for v in (*body.at, body.turn, *body.scale))
        return [np.broadcast_to(channel, (self.moments,)) for channel in channels]


def _with_parts(bodies: Sequence[Body]) -> Iterator[Body]:
    for body in bodies:
        yield body
        yield from _with_parts(body.parts)


TOLERANCE = 5e-4
"""Maximum deviation of a segment from its curve, relative to the range of the curve; it is
invisible.
"""
ROUNDS = 7
"""Maximum number of bisections of a segment: a jump is drawn within 1/128 of the initial
spacing.
"""
Rows = Callable[[Array], Sequence[Array] | Array]
"""Function that returns series (n,) at ordered positions (n,); angles must be unwrapped."""


def refine_places(rows: Rows, places: Array) -> Array:
    """Return the ordered places (n,) with more places between them, (m,), where straight segments
    follow all rows.

    A segment is bisected as long as its middle deviates by more than TOLERANCE of the range of a
    row. A detail between two of the initial places can be missed, so that these must include known
    zeros and corners.
    """
    unresolved = np.ones(len(places) - 1, dtype=bool)
    for _ in range(ROUNDS):
        cells = np.flatnonzero(unresolved)
        if not len(cells):
            break
        middles = (places[cells] + places[cells + 1]) / 2
        both = np.insert(places, cells + 1, middles)
        at = cells + 1 + np.arange(len(cells))
        bad = _deviates(np.array([np.asarray(row, dtype=float) for row in rows(both)]), at)
        # Good middles are removed; segments next to a bad one are checked again.
        keep = np.ones(len(both), dtype=bool)
        keep[at[~bad]] = False
        fresh = np.zeros(len(both), dtype=bool)
        fresh[at[bad]] = True
        fresh = fresh[keep]
        places = both[keep]
        unresolved = fresh[1:] | fresh[:-1]
    return places


def _deviates(values: Array, at: Integers) -> Flags:
    """Return whether the points at indices `at` (k,) deviate from the chord of their neighbours in
    any row, (k,).
    """
    sizes = np.ptp(values, axis=1)
    off = np.abs(values[:, at] - (values[:, at - 1] + values[:, at + 1]) / 2)
    is_off: Flags = (off > TOLERANCE * sizes[:, None]).any(axis=0)
    return is_off


def simplify_outline(points: Array, tolerance: float) -> Array:
    """Return the points (m, 2) of a closed line (k, 2) whose chords deviate from it by at most a
    tolerance.

    >>> simplify_outline(np.array([[0.0, 0.0], [1.0, 0.001], [2.0, 0.0], [1.0, 2.0]]), 0.01).tolist()
    [[0.0, 0.0], [2.0, 0.0], [1.0, 2.0]]
    """
    ring = shapely.simplify(shapely.linearrings(points), tolerance, preserve_topology=False)
    return np.asarray(shapely.get_coordinates(ring)[:-1])
