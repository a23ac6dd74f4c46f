"""What is seen of a mechanism over a cycle: rigid bodies and where they are, points, forces, curves, events.

Lengths in mm, angles in deg, y upwards; what varies is sampled at the same n moments.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from planter.kernels import Array

Complex = NDArray[np.complex128]
Look = Literal["body", "gear", "teeth", "frame", "mark", "ground", "before"]
"""How an outline is drawn: filled as a body or a gear, as a bar of a frame, as a thin mark, as ground, or palely.

A gear is its pitch curve, which is a thin mark where the scene has teeth.
"""


@dataclass(frozen=True)
class Outline:
    """Points (k, 2) of a line that is fixed in a body, from the body's own origin."""

    points: Array
    look: Look = "body"
    closed: bool = True
    shade: int = 0


@dataclass(frozen=True)
class Body:
    """A rigid body: its lines, and where its origin is and how it is turned, in its parent or in the machine."""

    name: str
    outlines: Sequence[Outline]
    at: Sequence[float | Array] | Array = (0.0, 0.0)
    turn: float | Array = 0.0
    parts: Sequence[Body] = ()


@dataclass(frozen=True)
class Point:
    """A point (n,) of the machine; its path over the cycle is drawn where `traced`."""

    name: str
    x: float | Array
    y: float | Array
    traced: bool = False


@dataclass(frozen=True)
class Chain:
    """A line through points, each by its number in the scene: a body of which no more is known than its joints."""

    name: str
    points: Sequence[int]
    closed: bool = False
    shade: int = 0


@dataclass(frozen=True)
class Label:
    """A text at a place of the machine, which stands at its start, middle or end."""

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
    """A quantity over the cycle (n,); `reference` is a value that it may be shown against, such as the weight."""

    name: str
    unit: str
    values: Array
    reference: float | None = None


@dataclass(frozen=True)
class Event:
    """Something that happens at a place of the cycle [in the unit of the scene's places]."""

    name: str
    place: float


@dataclass(frozen=True)
class Scene:
    """A mechanism over a cycle. `places` (n,) say where in the cycle a moment is, `seconds` how long the cycle takes.

    `shares` (n,) say how much of the cycle's time is over at each moment, from 0 on; without them the moments are even.
    The cycle begins `again` where it ends, and its last share is below 1, unless it is a motion that does not.
    `later` is the same scene with what takes longer to find than a hand that moves the machine waits, such as teeth.
    `travel` (n,) is how far the machine has moved over the ground, along x; `ground` stands still there.
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
        """How much of the cycle's time is over at each moment, (n,)."""
        return np.arange(self.moments) / self.moments if self.shares is None else self.shares

    @property
    def moments(self) -> int:
        """How many there are, n."""
        return len(self.places)

    def whole(self) -> Scene:
        """The scene with all that there is to see."""
        return self if self.later is None else self.later()

    @property
    def travels(self) -> bool:
        """Whether the machine moves over the ground."""
        return self.travel is not None and bool(np.ptp(self.travel) > 0)

    @property
    def toothed(self) -> bool:
        """Whether any teeth are drawn."""
        return any(outline.look == "teeth" for body in self.every() for outline in body.outlines)

    @property
    def largest_force(self) -> float:
        """Of all forces at all moments [N]; zero without any."""
        return max((float(np.hypot(force.x, force.y).max()) for force in self.forces), default=0.0)

    def every(self) -> Iterator[Body]:
        """Bodies and their parts, parents before parts: the order of the drawing."""
        return _every(self.bodies)

    def placed(self, moments: slice) -> Iterator[tuple[Outline, Array]]:
        """Every outline with its points (m, k, 2) in the machine at some moments."""
        still = np.zeros(1, dtype=complex)
        for body in self.bodies:
            yield from self._placed(body, moments, still, still + 1)

    def _placed(self, body: Body, moments: slice, origin: Complex, way: Complex) -> Iterator[tuple[Outline, Array]]:
        """Those of a body and its parts; the parent's places and directions are complex numbers, one a moment."""
        x, y, turn = (channel[moments] for channel in self.pose(body))
        here, way = origin + way * (x + 1j * y), way * np.exp(1j * np.radians(turn))
        for outline in body.outlines:
            points = here[:, None] + way[:, None] * (outline.points @ [1, 1j])
            yield outline, np.stack([points.real, points.imag], axis=-1)
        for part in body.parts:
            yield from self._placed(part, moments, here, way)

    def pose(self, body: Body) -> tuple[Array, Array, Array]:
        """Origin and turn of a body at every moment, (n,) each."""
        x, y, turn = (np.broadcast_to(np.asarray(v, dtype=float), (self.moments,)) for v in (*body.at, body.turn))
        return x, y, turn


def _every(bodies: Sequence[Body]) -> Iterator[Body]:
    for body in bodies:
        yield body
        yield from _every(body.parts)
