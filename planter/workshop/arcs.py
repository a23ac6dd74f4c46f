"""Curves of circular arcs in the form of drawings: vertices, and for each the bulge of the arc to the next.

A bulge is the tangent of a quarter of the central angle of an arc, positive to the left, zero for a straight line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planter.kernels import Array

_SMALL = 1e-3
"""Half angle [rad] below which the area of a segment is a series, whose next term is below rounding."""


@dataclass(frozen=True)
class Arcs:
    """A curve of arcs: `vertices` (n, 2) [m], `bulges` (n,); the last arc of a closed one leads to the first vertex.

    An open one has a bulge of 0 at its last vertex.
    """

    vertices: Array
    bulges: Array
    closed: bool = True

    @property
    def chords(self) -> Array:
        """Vectors from each vertex to the next, (n, 2) [m] if closed, else (n - 1, 2)."""
        if self.closed:
            return np.roll(self.vertices, -1, axis=0) - self.vertices
        return np.diff(self.vertices, axis=0)

    @property
    def half_angles(self) -> Array:
        """Half the central angle of each arc [rad], which is also the angle between chord and tangent at its start."""
        return 2 * np.arctan(self.bulges[: len(self.chords)])

    @property
    def lengths(self) -> Array:
        """Length of each arc [m]."""
        return np.hypot(*self.chords.T) / np.sinc(self.half_angles / np.pi)

    @property
    def area(self) -> float:
        """Area of a closed curve [m2], positive where it runs anticlockwise."""
        x, y = self.vertices.T
        polygon = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
        return float(polygon + (np.hypot(*self.chords.T) ** 2 * _segment_area(self.half_angles)).sum())

    def points(self, tolerance: float) -> Array:
        """Return points (k, 2) [m] on the curve with chords within `tolerance` [m] of its arcs, including all vertices.

        The first point of a closed curve is not repeated.
        """
        half, chords = self.half_angles, self.chords
        counts = np.maximum(1, np.ceil(np.sqrt(self.lengths * np.abs(half) / (4 * tolerance)))).astype(int)
        arc = np.repeat(np.arange(len(chords)), counts)
        step = np.arange(len(arc)) - np.repeat(np.cumsum(counts) - counts, counts)
        points = interpolate_arcs(self.vertices[arc], chords[arc], half[arc], step / counts[arc])
        return points if self.closed else np.vstack([points, self.vertices[-1]])

    def moved(self, turn: float, shift: tuple[float, float] | Array = (0.0, 0.0)) -> Arcs:
        """Return the curve rotated about the origin by `turn` [rad], then shifted [m]."""
        c, s = np.cos(turn), np.sin(turn)
        return Arcs(self.vertices @ np.array([[c, s], [-s, c]]) + np.asarray(shift), self.bulges, self.closed)


def interpolate_arcs(start: Array, chord: Array, half: Array, share: Array) -> Array:
    """Return points (n, 2) [m] at shares (n,) of the lengths of n arcs with chords (n, 2) [m], half angles (n,) "
    "[rad]."""
    angle = half * share
    size = share * np.sinc(angle / np.pi) / np.sinc(half / np.pi)
    turn = angle - half
    c, s = size * np.cos(turn), size * np.sin(turn)
    x, y = chord.T
    return start + np.column_stack([c * x - s * y, s * x + c * y])


def build_circle(radius: float, centre: tuple[float, float] = (0.0, 0.0)) -> Arcs:
    """Return a circle [m] as two half circles, anticlockwise."""
    x, y = centre
    return Arcs(np.array([[x - radius, y], [x + radius, y]]), np.ones(2))


def _segment_area(half: Array) -> Array:
    """Return the area between arc and chord over the chord's square, positive to the right of the chord."""
    safe = np.where(np.abs(half) < _SMALL, _SMALL, half)
    exact = (2 * safe - np.sin(2 * safe)) / (8 * np.sin(safe) ** 2)
    return np.where(np.abs(half) < _SMALL, half / 6 * (1 + 2 * half**2 / 15), exact)
