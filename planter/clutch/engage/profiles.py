"""Profiles that meet in the clutches, as CasADi expressions: signed distances, negative where they overlap.

Everything is in the frame of the output shaft, which sits at the origin with a corner on the x axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from planter.kernels import formulas

SIDES = 6
VERTICES = 5
CORNER = np.pi / SIDES
"""Angle from the middle of a side of the hexagon to its corner [rad]."""
FAR = 1e3
"""Distance of profiles that cannot meet, in any unit."""


@dataclass(frozen=True)
class Touch:
    """Where two profiles come closest: signed distance [m], the point (2,) [m], and the normal (2,) off the shaft."""

    gap: ca.SX
    point: ca.SX
    normal: ca.SX


@dataclass(frozen=True)
class Tooth:
    """A straight-sided tooth that points to the centroid of the body: tip and root distance [m], face angle [rad].

    `face` is the angle between the tip's radius and either face.
    """

    tip: ca.SX
    root: ca.SX
    face: ca.SX


@dataclass(frozen=True)
class Hexagon:
    """A hexagon with rounded corners: apothem and fillet radius [m]."""

    apothem: ca.SX
    fillet: ca.SX

    @property
    def inner(self) -> ca.SX:
        """Apothem of the hexagon of the fillet centres [m]."""
        return self.apothem - self.fillet


def direction(angle: ca.SX | float) -> ca.SX:
    return ca.vertcat(ca.cos(angle), ca.sin(angle))


def turned(vector: ca.SX, angle: ca.SX | float) -> ca.SX:
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(c * vector[0] - s * vector[1], s * vector[0] + c * vector[1])


def across(vector: ca.SX) -> ca.SX:
    """The vector turned by a quarter, counter-clockwise."""
    return ca.vertcat(-vector[1], vector[0])


def wrapped(value: ca.SX, period: ca.SX | float) -> ca.SX:
    """The value less the nearest multiple of the period."""
    return value - period * ca.floor(value / period + 0.5)


def tooth_on_hexagon(tooth: Tooth, centre: ca.SX, angle: ca.SX, shaft: Hexagon) -> Touch:
    """A tooth whose tip lies at `angle` from the centroid at `centre` (2,), and the rounded hexagon.

    The distance of the tooth from the hexagon of the fillet centres, less the fillet: either its tip or one of its
    faces comes closest. Holds while the overlap is less than the fillet radius.
    """
    tip = centre + tooth.tip * direction(angle)
    at_tip, towards_tip = _from_inner_hexagon(tip, shaft)
    at_face, off_face, corner = _face(tooth, tip, angle, shaft)
    face_first = at_face < at_tip
    gap = ca.if_else(face_first, at_face, at_tip) - shaft.fillet
    normal = ca.if_else(face_first, off_face, towards_tip)
    point = ca.if_else(face_first, corner + shaft.fillet * off_face, tip - gap * towards_tip)
    return Touch(gap, point, normal)


def _from_inner_hexagon(point: ca.SX, shaft: Hexagon) -> tuple[ca.SX, ca.SX]:
    """Distance of a point from the hexagon of the fillet centres, and the direction to it."""
    middle = 2 * CORNER * ca.floor(ca.atan2(point[1], point[0]) / (2 * CORNER)) + CORNER
    local = turned(point, -middle)
    half = shaft.inner * np.tan(CORNER)
    over = ca.fmax(ca.fabs(local[1]) - half, 0) * ca.sign(local[1])
    beyond = ca.vertcat(local[0] - shaft.inner, over)
    distance = ca.if_else(over == 0, beyond[0], ca.norm_2(ca.vertcat(beyond[0], over)))
    return distance, turned(beyond / distance, middle)


def _face(tooth: Tooth, tip: ca.SX, angle: ca.SX, shaft: Hexagon) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Distance of the fillet centre next to a tooth from the tooth's nearer face, the way there, and that centre."""
    sector = 2 * CORNER * ca.floor(ca.atan2(tip[1], tip[0]) / (2 * CORNER) + 0.5)
    corner = shaft.inner / np.cos(CORNER) * direction(sector)
    local = turned(corner - tip, -angle)
    side = ca.if_else(local[1] < 0, -1, 1)
    along = ca.cos(tooth.face) * local[0] + ca.sin(tooth.face) * side * local[1]
    above = -ca.sin(tooth.face) * local[0] + ca.cos(tooth.face) * side * local[1]
    off = turned(ca.vertcat(ca.sin(tooth.face), -ca.cos(tooth.face) * side), angle)
    reach = _face_length(tooth)
    on_face = ca.logic_and(along > 0, along < reach)
    return ca.if_else(on_face, above, FAR), off, corner


def _face_length(tooth: Tooth) -> ca.SX:
    """From tip to root along a face [m]."""
    foot = tooth.tip * ca.sin(tooth.face)
    return ca.sqrt(tooth.root**2 - foot**2) - tooth.tip * ca.cos(tooth.face)


def support(angle: ca.SX, width: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Support function of the Reuleaux pentagon about its centroid, and its derivative [m].

    `angle` is that of the direction from a vertex, `width` the constant width R.
    """
    psi = ca.SX.sym("psi")
    shape = ca.vertcat(width, width / 2, VERTICES, SIDES)
    value = formulas.load("clutch_rotor").function("support")(psi, shape)[0]
    found, slope = ca.substitute([value, ca.gradient(value, psi)], [psi], [angle])
    return found, slope


def side_of_sleeve(centre: ca.SX, angle: ca.SX, width: ca.SX, apothem: ca.SX, side: int) -> Touch:
    """The Reuleaux pentagon, turned by `angle` about `centre` (2,), and one side of the hexagonal hole round it."""
    out = direction(CORNER * (2 * side + 1))
    value, slope = support(CORNER * (2 * side + 1) - angle, width)
    gap = apothem - value - ca.dot(out, centre)
    return Touch(gap, centre + value * out + slope * across(out), -out)


def jaw_on_jaw(offset: ca.SX, lift: ca.SX, half_width: ca.SX, edge: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Signed distance of two jaws with parallel flanks and rounded edges [m], and its unit gradient (2,).

    `offset` is the distance of their middles along the circumference, `lift` that of their tip faces along the axis,
    negative where they overlap; `half_width` is the sum of their half widths and `edge` that of their edge radii: one
    jaw is a point to the other, grown by the first.
    """
    over = ca.fabs(offset) - half_width + edge
    above = lift + edge
    outside = ca.sqrt(ca.fmax(over, 0) ** 2 + ca.fmax(above, 0) ** 2 + 1e-24)
    on_edge = ca.logic_and(over > 0, above > 0)
    flank_first = over > above
    way = ca.if_else(offset < 0, -1, 1)
    flank = ca.vertcat(way, 0)
    face = ca.DM([0, 1])
    gap = ca.if_else(on_edge, outside, ca.if_else(flank_first, over, above)) - edge
    gradient = ca.if_else(on_edge, ca.vertcat(way * over, above) / outside, ca.if_else(flank_first, flank, face))
    return gap, gradient
