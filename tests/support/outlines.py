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

    def _angle(self, s: Array) -> Array:
        return self.start + (self.end - self.start) * s

    def at(self, s: Array) -> Array:
        t = self._angle(s)
        return self.polar(t)[0][:, None] * np.column_stack([np.cos(t), np.sin(t)])

    def tangent(self, s: Array) -> Array:
        t = self._angle(s)
        r, dr, _ = self.polar(t)
        tangents = np.column_stack([dr * np.cos(t) - r * np.sin(t), dr * np.sin(t) + r * np.cos(t)])
        return tangents / np.hypot(r, dr)[:, None]

    def curvature(self, s: Array) -> Array:
        r, dr, ddr = self.polar(self._angle(s))
        return (r**2 + 2 * dr**2 - r * ddr) / np.hypot(r, dr) ** 3

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


def lobes(count: int = 12) -> list[Lobes]:
    """The whole curve, in equal pieces."""
    ends = np.linspace(0, 2 * np.pi, count + 1)
    return [Lobes(a, b) for a, b in pairwise(ends)]


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
