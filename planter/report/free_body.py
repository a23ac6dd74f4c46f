"""Free-body diagrams: a body cut free at one moment, with its forces and moments at their points.

Forces include weights and inertia forces (d'Alembert), so that those of a body are in equilibrium.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from planter.kernels import Array
from planter.report import style
from planter.report.scene import Body, Outline
from planter.report.sheet import Arrow, Couple, Length, Mark, Sheet, build_still_scene, set_name

LONGEST = 0.55
"""Length of the largest force, relative to the extent of the body."""
LEAST_SHARE = 0.004
"""Share of the largest force or moment below which one is not drawn; tables have all."""
RADII = (0.1, 0.035)
"""Radius of the first moment's arc, and by how much each further one is larger, relative to the
extent of the body.
"""
POINT_SHARE = 0.1
"""Size of a body with a single point, relative to the extent of the machine."""
ROUND = (1, 2, 5, 10)
"""First digits of lengths of scales."""
NORMAL = np.array([0.0, 0.0, 1.0])
"""Axis across the plane."""
ACROSS = "z"
"""Name of the component across the plane."""


@dataclass(frozen=True)
class BodyLoad:
    """A force (3,) [N] at a place (3,) [m] and a moment (3,) [N m] on a body, along the axes of the
    world, by a body; `by` is empty for weights and inertia.
    """

    name: str
    by: str
    point: str
    place: Array
    force: Array
    moment: Array

    @property
    def words(self) -> str:
        """Name of the load, and of the body that it is from."""
        return f"{set_name(self.name)} by {self.by}" if self.by else self.name


@dataclass(frozen=True)
class FreeBody:
    """A body with all loads on it, and its outlines (k, 2) [mm] if its shape is known.

    Of an `is_flat` one places are known in the plane only, so that moments are about its normal.
    """

    name: str
    loads: Sequence[BodyLoad]
    outlines: Sequence[Outline] = ()
    is_flat: bool = False

    @property
    def force_sum(self) -> Array:
        """Sum of all forces (3,) [N], zero up to rounding."""
        return np.sum([load.force for load in self.loads], axis=0)

    @property
    def moment_sum(self) -> Array:
        """Sum of all moments (3,) [N m] about the place of the first load, zero up to rounding."""
        about = self.loads[0].place
        arms = (np.cross(load.place - about, load.force) + load.moment for load in self.loads)
        total = np.sum(list(arms), axis=0)
        return total * NORMAL if self.is_flat else total

    @property
    def largest_force(self) -> float:
        """Size of the largest force [N]."""
        return max(float(np.linalg.norm(load.force)) for load in self.loads)

    @property
    def largest_drawn(self) -> float:
        """Size of the largest force in the plane [N]."""
        return max(float(np.hypot(*load.force[:2])) for load in self.loads)

    @property
    def largest_moment(self) -> float:
        """Size of the largest moment [N m], of a force about the place of the first load too."""
        about = self.loads[0].place
        return max(
            float(np.linalg.norm(moment))
            for load in self.loads
            for moment in (load.moment, np.cross(load.place - about, load.force))
            for moment in (moment * NORMAL if self.is_flat else moment,)
        )


@dataclass(frozen=True)
class FreeBodies:
    """All bodies of a machine, cut free at an angle [deg] of its drive."""

    machine: str
    angle_deg: float
    bodies: Sequence[FreeBody] = field(default_factory=tuple)

    @cached_property
    def extent(self) -> float:
        """Extent of the machine [mm]."""
        places = [load.place[:2] for body in self.bodies for load in body.loads]
        return 1e3 * float(np.ptp(places, axis=0).max()) or 1.0

    def draw_sheet(self, body: FreeBody) -> Sheet:
        """Return the diagram of a body: its outline, its loads, and scales of lengths and forces."""
        shape = list(body.outlines) or [_outline_points(body, self.extent)]
        corners = np.vstack([outline.points for outline in shape])
        extent = float(np.ptp(corners, axis=0).max())
        scene = build_still_scene(body.name, [Body(body.name, shape)])
        scale = LONGEST * extent / (body.largest_drawn or 1.0)
        marks = [*_list_arrows(body, scale), *_list_couples(body, extent)]
        low = np.vstack([corners, *(mark.outline() for mark in marks)]).min(axis=0)
        start = np.array([corners[:, 0].min(), low[1] - 0.12 * extent])
        title = f"{body.name} at {self.angle_deg:g} deg"
        scales = _list_scales(start, extent, scale)
        return Sheet(f"body_{_to_file_name(body.name)}", title, scene, [*marks, *scales])


def _to_file_name(name: str) -> str:
    return "".join(c if c.isalnum() else "_" for c in name)


def _outline_points(body: FreeBody, extent: float) -> Outline:
    """Return a body by the points at which loads act: a bar, a polygon, or a block about one."""
    places = 1e3 * np.array([load.place[:2] for load in body.loads])
    points = np.unique(np.round(places, 6), axis=0)
    arms = points - points.mean(axis=0)
    points = points[np.argsort(np.arctan2(arms[:, 1], arms[:, 0]))]
    if np.ptp(points, axis=0).max() > POINT_SHARE * extent:
        return Outline(points, "body", closed=len(points) > 2)
    half = POINT_SHARE * extent / 2
    corners = half * np.array([[-1.6, -1], [1.6, -1], [1.6, 1], [-1.6, 1]])
    return Outline(points.mean(axis=0) + corners, "body")


def _list_arrows(body: FreeBody, scale: float) -> list[Mark]:
    """Return the forces in the plane, `scale` mm long per N."""
    arrows: list[Mark] = []
    for load in body.loads:
        size = float(np.linalg.norm(load.force))
        if size > LEAST_SHARE * body.largest_drawn:
            words = f"{load.words}: {np.hypot(*load.force[:2]):.3g} N"
            if abs(load.force[2]) > LEAST_SHARE * body.largest_force:
                words += f", {ACROSS} {load.force[2]:.3g} N".replace("-", "\N{MINUS SIGN}")
            place, vector = 1e3 * load.place[:2], scale * load.force[:2]
            arrows.append(Arrow([load.name], place, vector, words, _choose_colour(load)))
    return arrows


def _list_couples(body: FreeBody, extent: float) -> list[Mark]:
    """Return the moments about the normal of the plane."""
    couples: list[Mark] = []
    for load in body.loads:
        size = float(load.moment[2])
        if abs(size) > LEAST_SHARE * body.largest_moment:
            radius = extent * (RADII[0] + RADII[1] * len(couples))
            turn = float(np.copysign(250.0, size))
            words = f"{load.words}: {abs(size):.3g} N m"
            colour = _choose_colour(load)
            couples.append(Couple([load.name], 1e3 * load.place[:2], turn, radius, words, colour))
    return couples


def _choose_colour(load: BodyLoad) -> str:
    if load.by:
        return style.VERMILION
    return style.GREEN if load.name.startswith("weight") else style.BLUE


def _list_scales(start: Array, extent: float, scale: float) -> list[Mark]:
    """Return a bar of a round length and an arrow of a round force, below the body."""
    length, force = round_down(0.4 * extent), round_down(0.4 * extent / scale)
    below = start - np.array([0.0, 0.1 * extent])
    return [
        Length([f"{length:g} mm"], start, start + np.array([length, 0.0]), 1.0),
        Arrow(["scale"], below, np.array([scale * force, 0.0]), f"{force:g} N", style.SOFT),
    ]


def round_down(value: float) -> float:
    """Return the largest number of 1, 2 or 5 times a power of ten up to a value.

    >>> round_down(7.3), round_down(0.21), round_down(100.0)
    (5.0, 0.2, 100.0)
    """
    power = 10.0 ** np.floor(np.log10(value))
    digit = max(digit for digit in ROUND if digit * power <= value * (1 + 1e-12))
    return float(f"{digit * power:.12g}")
