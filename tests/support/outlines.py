"""An outline with convex and hollow pieces that is known exactly, and how far arcs are from it,
measured apart.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from itertools import pairwise

import ezdxf
import numpy as np
from ezdxf.math import bulge_to_arc
from scipy.integrate import quad

from planter.gears.geometry.pieces import Piece
from planter.gears.workshop.arcs import Arcs
from planter.kernels import Array

LAYERS = dict[str, list[Arcs]]


@dataclass(frozen=True)
class Lobes:
    """A piece of the curve of polar radius R (1 + w cos n t) between two angles; hollow between its
    lobes.
    """

    start: float
    end: float
    radius: float = 0.03
    waves: int = 3
    depth: float = 0.2
    kind: str = "flank"

    def polar(self, t: Array) -> tuple[Array, Array, Array]:
        r, n, w = self.radius, self.waves, self.depth
        return (
            r * (1 + w * np.cos(n * t)),
            -r * w * n * np.sin(n * t),
            -r * w * n**2 * np.cos(n * t),
        )

    def rows(self, s: Array) -> Array:
        """Points, unit tangents and curvature (5, n), as `Piece` has them."""
        t = self.start + (self.end - self.start) * s
        r, dr, ddr = self.polar(t)
        pace, c, d = np.hypot(r, dr), np.cos(t), np.sin(t)
        tangent = (dr * c - r * d) / pace, (dr * d + r * c) / pace
        return np.array([r * c, r * d, *tangent, (r**2 + 2 * dr**2 - r * ddr) / pace**3])

    @property
    def piece(self) -> Piece:
        return Piece(self.kind, self.rows)

    def off(self, places: Array) -> Array:
        """How far places (n, 2) near it are from the whole curve [m]: along the ray, then
        across.
        """
        t = np.arctan2(places[:, 1], places[:, 0])
        r, dr, _ = self.polar(t)
        return np.abs(np.hypot(*places.T) - r) * r / np.hypot(r, dr)

    @property
    def area(self) -> float:
        """Area of the whole curve [m2]."""
        return np.pi * self.radius**2 * (1 + self.depth**2 / 2)

    @property
    def length(self) -> float:
        """Length of the piece [m]."""
        return float(
            quad(lambda t: np.hypot(*self.polar(t)[:2]), self.start, self.end, epsabs=1e-13)[0]
        )


def lobes(count: int = 12) -> list[Piece]:
    """The whole curve, in equal pieces."""
    ends = np.linspace(0, 2 * np.pi, count + 1)
    return [Lobes(a, b).piece for a, b in pairwise(ends)]


def sampled(arcs: Arcs, each: int = 40) -> Array:
    """Places along every arc (n, 2), by another's reading of a bulge."""
    ends = np.roll(arcs.vertices, -1, axis=0)
    points = []
    for start, end, bulge in zip(arcs.vertices, ends, arcs.bulges, strict=True):
        share = np.linspace(0, 1, each)[:, None]
        if bulge == 0:
            points.append(start + share * (end - start))
            continue
        centre, low, high, radius = bulge_to_arc(start, end, bulge)
        angles = low + share * ((high - low) % (2 * np.pi))
        points.append(
            np.array([centre.x, centre.y]) + radius * np.hstack([np.cos(angles), np.sin(angles)])
        )
    return np.vstack(points)


def between(places: Array, arcs: Arcs) -> Array:
    """How far places (n, 2) are from the nearest arc [m]."""
    ends, best = np.roll(arcs.vertices, -1, axis=0), np.full(len(places), np.inf)
    for start, end, bulge in zip(arcs.vertices, ends, arcs.bulges, strict=True):
        centre, low, high, radius = bulge_to_arc(start, end, bulge)
        from_centre = places - (centre.x, centre.y)
        angle = np.arctan2(from_centre[:, 1], from_centre[:, 0])
        is_between = (angle - low) % (2 * np.pi) <= (high - low) % (2 * np.pi)
        radial = np.abs(np.hypot(*from_centre.T) - radius)
        at_ends = np.minimum(np.hypot(*(places - start).T), np.hypot(*(places - end).T))
        best = np.minimum(best, np.where(is_between, radial, at_ends))
    return best


def read_dxf(content: bytes) -> tuple[ezdxf.document.Drawing, LAYERS]:
    """A drawing, and its curves in m by their layers."""
    drawing = ezdxf.read(io.StringIO(content.decode()))
    curves: LAYERS = {}
    for line in drawing.modelspace().query("LWPOLYLINE"):
        points = np.array(line.get_points("xyb"))
        curves.setdefault(line.dxf.layer, []).append(
            Arcs(points[:, :2] / 1e3, points[:, 2], line.closed)
        )
    return drawing, curves
