"""Any odd Reuleaux polygon in any regular polygon: how it fits, which path its vertices take.

Frame as for the clutch: origin at the centre of the regular polygon, upper side across y, rotation
counter-clockwise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from planter.errors import GeometryError
from planter.kernels import Array, formulas
from planter.numerics import extrema
from planter.numerics.arrays import rotation_matrix, unit_vector
from planter.papers.clutch.results import CornerPath, Harmonic, Oval, PolygonFit, Sliding, SlidPath

MOST = 99
"""Most vertices and sides."""
_SAMPLES = 48


@dataclass(frozen=True)
class Rotor:
    """A Reuleaux polygon of `vertices` arcs and constant `width` [m], inside a regular polygon of
    `sides` sides.

    Raises GeometryError for an even number of vertices, or numbers outside 3..99.
    """

    vertices: int
    sides: int
    width: float = 1.0

    def __post_init__(self) -> None:
        if not (3 <= self.vertices <= MOST and self.vertices % 2):
            raise GeometryError(f"vertices = {self.vertices}: must be odd, from 3 to {MOST}")
        if not 3 <= self.sides <= MOST:
            raise GeometryError(f"sides = {self.sides}: must be from 3 to {MOST}")

    @property
    def turn(self) -> float:
        """Angle between the normals of neighbouring sides [rad]."""
        return 2 * math.pi / self.sides

    def shape(self, apothem: float | None = None) -> Array:
        """Packed input of the generated functions; sides a width apart unless said otherwise."""
        return np.array(
            [self.width, self.width / 2 if apothem is None else apothem, self.vertices, self.sides]
        )

    @cached_property
    def normals(self) -> Array:
        """Directions of the outer normals [rad], (sides,), the upper side first."""
        directions: Array = np.asarray(math.pi / 2 + self.turn * np.arange(self.sides), dtype=float)
        return directions

    def support(self, direction: object) -> Array:
        """Distance of the tangents with a normal from the centroid [m]; directions [rad] from a
        vertex's, (n,).
        """
        return formulas.load("clutch_rotor")("support", psi=direction, shape=self.shape())[
            "support"
        ]

    def supports(self, rotation: Array) -> Array:
        """Support towards every side [m], (sides, n), for rotations (n,): the direction of a vertex
        [rad].
        """
        psi = self.normals[:, None] - np.atleast_1d(rotation)
        return self.support(psi.ravel()).reshape(psi.shape)

    def tightest(self, rotation: float) -> tuple[float, Array]:
        """Least apothem [m] of a polygon round the body at a rotation [rad], and the centroid's
        place (2,) in it.

        The sides are moved out together; a linear programme finds the centroid.
        """
        reach = self.supports(np.array([rotation]))[:, 0]
        rows = np.column_stack([np.cos(self.normals), np.sin(self.normals), -np.ones(self.sides)])
        free = (None, None)
        optimum = scipy.optimize.linprog(
            [0, 0, 1], A_ub=rows, b_ub=-reach, bounds=[free, free, free], method="highs-ds"
        )
        return float(optimum.x[2]), np.asarray(optimum.x[:2])

    @cached_property
    def smallest_apothem(self) -> float:
        """Least apothem [m] of the regular polygon in which the body turns freely.

        The apothem that a rotation needs repeats after a turn divided by the common multiple of
        vertices and sides.
        """
        period = 2 * math.pi / math.lcm(self.vertices, self.sides)
        rotations = period * np.arange(_SAMPLES) / _SAMPLES
        return extrema.find_maximum(
            extrema.vectorise(lambda r: self.tightest(r)[0]), rotations, closed=True
        ).value

    def misses(self, rotation: Array) -> Array:
        """Return the gaps at the other pairs of sides [m], (pairs, n), while two neighbouring pairs
        are in contact.

        Raises GeometryError if sides are not in pairs.
        """
        self._in_pairs()
        pairs = self.sides // 2
        reach = self.supports(rotation)
        middle = (reach[:pairs] - reach[pairs:]) / 2
        rows = unit_vector(self.normals[:pairs]).T
        centroid = np.linalg.solve(rows[:2], -middle[:2])
        gaps: Array = middle + rows @ centroid
        return gaps

    @cached_property
    def miss(self) -> float:
        """Largest of `misses` over a turn [m]; zero for a rotor."""

        def size(rotation: Array) -> Array:
            largest: Array = np.abs(self.misses(rotation)).max(axis=0)
            return largest

        period = 2 * math.pi / self.vertices
        rotations = period * np.arange(40 * self.sides) / (40 * self.sides)
        return extrema.find_maximum(size, rotations, closed=True).value

    def harmonics(self, count: int) -> list[Harmonic]:
        """The first harmonics of the support function, amplitudes in widths; which of them a rotor
        may have.

        A rotor of a regular polygon of N sides has those of order k N +- 1 alone (Goldberg, Math.
        Comp. 14, 1960).
        """
        orders = 2 * np.arange(count) + 1
        amplitudes = formulas.load("clutch_rotor")("harmonic", order=orders, shape=self.shape())[
            "harmonic"
        ]
        return [
            Harmonic(
                int(k), float(h) / self.width, rotor=int(k) % self.sides in (1, self.sides - 1)
            )
            for k, h in zip(orders * self.vertices, amplitudes, strict=True)
        ]

    @cached_property
    def ellipse(self) -> dict[str, float]:
        """The vertex's path at a corner: centre, semi-axes and direction of the ellipse [m, rad],
        and what follows.

        Raises GeometryError where no vertex passes a corner between its neighbours' contacts.
        """
        self._in_pairs()
        if self.sides >= 2 * self.vertices:
            raise GeometryError(
                f"sides = {self.sides}: must be less than {2 * self.vertices} for "
                f"{self.vertices} vertices, or a vertex never leaves its side"
            )
        return formulas.load("clutch_rotor").at("ellipse", shape=self.shape())

    @property
    def passage(self) -> tuple[float, float]:
        """First and last direction theta [rad] of AC while C passes the corner."""
        return math.pi / 2 - self.ellipse["lead"], math.pi / 2

    def path(self, theta: object) -> dict[str, Array]:
        """Places of A, B, C and the centroid M [m], each coordinate (n,), while C passes the
        corner.
        """
        return formulas.load("clutch_rotor")("path", theta=theta, shape=self.shape())

    def slides(self) -> Slides:
        """Two vertices that touch two sides at once, as near as there are.

        Raises GeometryError where no two vertices do.
        """
        arc = math.pi / self.vertices
        for step in range(1, self.sides // 2 + 1):
            spread = step * self.turn
            vertices = round(spread / (2 * arc))
            delta = spread - 2 * arc * vertices
            if vertices and abs(delta) < arc * (1 - 1e-9):
                first = math.pi / 2 - arc / 2 + max(delta, 0.0)
                return Slides(self, step, vertices, (first, first + arc - abs(delta)))
        raise GeometryError(
            f"no two of {self.vertices} vertices touch two of {self.sides} sides at once"
        )

    def track(self, points: int = 25) -> Array:
        """The closed path of a vertex over a turn [m], (2, n): an arc at each corner, straight
        between.
        """
        theta = np.linspace(*self.passage, points)
        at = self.path(theta)
        arc = np.array([at["x_C"], at["y_C"]])[:, ::-1]
        return np.hstack([rotation_matrix(i * self.turn) @ arc for i in range(self.sides + 1)])[
            :, : self.sides * points + 1
        ]

    def _in_pairs(self) -> None:
        if self.sides % 2:
            raise GeometryError(f"sides = {self.sides}: must be even, so that sides are in pairs")


@dataclass(frozen=True)
class Slides:
    """Two vertices, `vertices` places apart, that slide on two sides, `side_step` sides apart, over
    rotations [rad].

    Vertex 0 slides on the upper side. Sides in pairs are a width apart, others as near as free
    turning lets them.
    """

    rotor: Rotor
    side_step: int
    vertices: int
    rotations: tuple[float, float]

    def packed(self, vertex: int) -> Array:
        """Input of the generated functions for the path of a vertex, by its number."""
        rho, step = float(self.rotor.support(0.0)[0]), 2 * math.pi / self.rotor.vertices
        apothem = self.rotor.smallest_apothem if self.rotor.sides % 2 else self.rotor.width / 2
        return np.array(
            [
                rho,
                apothem,
                self.side_step * self.rotor.turn,
                0.0,
                step * self.vertices,
                step * vertex,
            ]
        )

    def path(self, vertex: int, rotation: object) -> dict[str, Array]:
        """Places of both vertices A and B, of the vertex C and of the centroid M, each coordinate
        (n,) [m].
        """
        return formulas.load("clutch_rotor")("slid", rotation=rotation, trammel=self.packed(vertex))

    def ellipse(self, vertex: int) -> dict[str, float]:
        """The ellipse on which a vertex moves [m, rad]."""
        return formulas.load("clutch_rotor").at("slid_ellipse", trammel=self.packed(vertex))

    def to_result(self) -> Sliding:
        """Return the ellipses of all other vertices, lengths in widths."""
        width = self.rotor.width
        free_vertices = [i for i in range(self.rotor.vertices) if i not in (0, self.vertices)]
        return Sliding(
            sides_apart=self.side_step,
            vertices_apart=self.vertices,
            rotation_deg=math.degrees(self.rotations[1] - self.rotations[0]),
            paths=[
                SlidPath(vertex=i, **vars(_oval(self.ellipse(i), width))) for i in free_vertices
            ],
        )


def _oval(ellipse: Mapping[str, float], width: float) -> Oval:
    return Oval(
        centre_over_R=(ellipse["x_E"] / width, ellipse["y_E"] / width),
        semi_axes_over_R=(ellipse["s_1"] / width, ellipse["s_2"] / width),
        axis_deg=math.degrees(ellipse["axis"]) % 180,
    )


def _corner(ellipse: Mapping[str, float], width: float) -> CornerPath:
    return CornerPath(
        **vars(_oval(ellipse, width)),
        tangency_radius_over_R=ellipse["tangency"] / width,
        lead_deg=math.degrees(ellipse["lead"]),
    )


def summarise_rotor(rotor: Rotor) -> PolygonFit:
    """Return the summary of a pair of polygons, lengths in widths; None for values without meaning.

    `exact` says whether the body is a rotor: every harmonic of its support function is one that a
    rotor may have.
    """
    paired = rotor.sides % 2 == 0
    passes = paired and rotor.sides < 2 * rotor.vertices
    ellipse = rotor.ellipse if passes else None
    width, smallest = rotor.width, 2 * rotor.smallest_apothem / rotor.width
    return PolygonFit(
        vertices=rotor.vertices,
        sides=rotor.sides,
        exact=all(h.rotor for h in rotor.harmonics(4 * rotor.sides)),
        smallest_over_R=smallest,
        mismatch_over_R=rotor.miss / width if paired else None,
        fillet_limit_over_R=ellipse["fillet"] / width if ellipse else None,
        ellipse=_corner(ellipse, width) if ellipse else None,
        slides=rotor.slides().to_result(),
        harmonics=rotor.harmonics(6),
    )


def body_outline(rotor: Rotor, rotation: float, centroid: Array, points: int = 24) -> Array:
    """The body's outline [m], (2, vertices * points), with a vertex in direction `rotation` [rad]
    of its centroid.
    """
    rho, arc = float(rotor.support(0.0)[0]), math.pi / rotor.vertices
    angles = np.linspace(-arc / 2, arc / 2, points)
    parts = []
    for i in range(rotor.vertices):
        vertex = rotation + 2 * i * arc
        about = rho * unit_vector(vertex)
        directions = vertex + math.pi + angles
        parts.append(about[:, None] + rotor.width * unit_vector(directions))
    order = sorted(range(rotor.vertices), key=lambda i: (2 * i * arc + math.pi) % (2 * math.pi))
    body_points: Array = np.hstack([parts[i] for i in order]) + np.asarray(centroid)[:, None]
    return body_points


def polygon_outline(sides: int, apothem: float, fillet: float = 0.0, points: int = 16) -> Array:
    """Return the closed outline (2, n) of a regular polygon with an upper side and rounded
    corners.
    """
    turn = 2 * math.pi / sides
    centre = (apothem - fillet) / math.cos(turn / 2)
    parts = []
    for i in range(sides + 1):
        corner = math.pi / 2 + (i + 0.5) * turn
        angles = corner + np.linspace(-turn / 2, turn / 2, points if fillet else 1)
        parts.append(centre * unit_vector(corner)[:, None] + fillet * unit_vector(angles))
    return np.hstack(parts)
