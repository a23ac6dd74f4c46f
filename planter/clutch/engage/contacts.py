"""The contacts of both clutches: signed distance and slip of each pair of surfaces, and the one law of all.

Law: Hunt and Crossley, "Coefficient of restitution interpreted as damping in vibroimpact", J. Appl. Mech. 42 (1975)
440-445: N = K d^1.5 (1 + D d') at a depth d, never less than zero; the dissipation D is a given number. Friction:
Coulomb's with its sign smoothed, mu N v / sqrt(v^2 + v_s^2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from planter.clutch.engage import profiles
from planter.clutch.engage.inputs import Symbols

EXPONENT = 1.5
TINY = 1e-9
"""Length that keeps the direction of an eccentricity of zero defined [m]."""


@dataclass(frozen=True)
class State:
    """Coordinates [m, rad] and their rates: centre of the body, sleeve's travel, output and input angle, shaft end.

    `pushed` is the travel to which the linkage has pushed the sleeve.
    """

    centre: ca.SX
    travel: ca.SX
    output: ca.SX
    shaft: ca.SX
    angle: ca.SX
    pushed: ca.SX

    @property
    def free(self) -> ca.SX:
        """The six degrees of freedom."""
        return ca.vertcat(self.centre, self.travel, self.output, self.shaft)

    @property
    def all(self) -> ca.SX:
        """Degrees of freedom, then what is prescribed: input angle and linkage."""
        return ca.vertcat(self.free, self.angle, self.pushed)

    @property
    def seen(self) -> tuple[ca.SX, ca.SX]:
        """Centre (2,) and rotation of the body as the turning, deflected output shaft sees them."""
        return profiles.turned(self.centre - self.shaft, -self.output), self.angle - self.output


@dataclass(frozen=True)
class Contact:
    """A pair of surfaces: signed distance [m] and slip velocity [m/s], one component or two."""

    name: str
    gap: ca.SX
    slip: ca.SX


def _slip(at: State, rate: State, touch: profiles.Touch) -> ca.SX:
    """Velocity of the body over shaft or sleeve along the surface at the point of contact, in the section's plane."""
    centre, _ = at.seen
    across = profiles.across
    of_body = profiles.turned(rate.centre, -at.output) + rate.angle * across(touch.point - centre)
    of_shaft = profiles.turned(rate.shaft, -at.output) + rate.output * across(touch.point)
    return ca.dot(across(touch.normal), of_body - of_shaft)


def teeth(at: State, rate: State, p: Symbols) -> list[Contact]:
    """The five teeth on the output shaft; the hole is relieved behind their roots."""
    centre, angle = at.seen
    tooth = profiles.Tooth(p.tip, p.root, ca.asin(ca.fmin(p.apothem / p.tip, 1)))
    shaft = profiles.Hexagon(p.apothem, p.fillet)
    found = []
    for i in range(profiles.VERTICES):
        touch = profiles.tooth_on_hexagon(tooth, centre, angle + 2 * np.pi * i / profiles.VERTICES, shaft)
        found.append(Contact(f"tooth {i + 1}", touch.gap, _slip(at, rate, touch)))
    return found


def sides(at: State, rate: State, p: Symbols) -> list[Contact]:
    """The body's outline in the tapered hexagonal hole of the sleeve."""
    centre, angle = at.seen
    apothem = p.hole + (p.travel - at.travel) * ca.tan(p.taper)
    found = []
    for i in range(profiles.SIDES):
        touch = profiles.side_of_sleeve(centre, angle, p.width, apothem, i)
        slip = ca.vertcat(_slip(at, rate, touch), rate.travel)
        found.append(Contact(f"side {i + 1}", touch.gap * ca.cos(p.taper), slip))
    return found


def jaws(at: State, rate: State, p: Symbols, count: int) -> list[Contact]:
    """The jaws of the dog clutch, each with the nearest of the other half, in the plane of circumference and axis."""
    centre, angle = at.seen
    pitch = 2 * np.pi / count
    behind = p.radius * profiles.wrapped(angle, pitch)
    found = []
    for i in range(count):
        along = profiles.across(profiles.direction(angle + pitch * i))
        offset = behind + ca.dot(along, centre)
        gap, normal = profiles.jaw_on_jaw(offset, at.travel - p.depth, (p.radius * pitch - p.backlash) / 2, p.edge)
        speed = ca.vertcat(ca.jacobian(offset, at.all) @ rate.all, rate.travel)
        found.append(Contact(f"jaw {i + 1}", gap, ca.dot(profiles.across(normal), speed)))
    return found


def fit(at: State, rate: State, p: Symbols) -> Contact:
    """The body round in the fit that centres it."""
    eccentric = ca.sqrt(ca.sumsqr(at.centre) + TINY**2)
    over = rate.centre - rate.angle * profiles.across(at.centre)
    around = ca.dot(profiles.across(at.centre / eccentric), over)
    return Contact("fit", p.fit - eccentric, ca.vertcat(around, rate.travel))


def face(at: State, rate: State) -> Contact:
    """The thrust bearing on the face of the coupling: ends the sleeve's way, and brakes the coupling's slides."""
    return Contact("bearing", at.travel, rate.centre - rate.angle * profiles.across(at.centre))


def link(at: State) -> Contact:
    """The linkage pushes the sleeve away; what brings it back is the spring."""
    return Contact("linkage", at.travel - at.pushed, ca.SX(0, 1))


def reuleaux(at: State, rate: State, p: Symbols) -> list[Contact]:
    """Every contact of the Reuleaux clutch, those that carry the load first."""
    return [*teeth(at, rate, p), *sides(at, rate, p), face(at, rate), link(at)]


def dog(at: State, rate: State, p: Symbols, count: int) -> list[Contact]:
    """Every contact of the dog clutch, those that carry the load first."""
    return [*jaws(at, rate, p, count), fit(at, rate, p), face(at, rate), link(at)]


@dataclass(frozen=True)
class Forces:
    """What the contacts do: normal forces [N], generalised forces on `State.all`, energy [J], powers lost [W]."""

    normal: ca.SX
    gaps: ca.SX
    generalised: ca.SX
    stored: ca.SX
    damping: ca.SX
    friction: ca.SX


def forces(contacts: Sequence[Contact], at: State, rate: State, p: Symbols) -> Forces:
    """The law, applied to every contact; virtual work carries its forces to the coordinates."""
    gaps = ca.vertcat(*(contact.gap for contact in contacts))
    depth = ca.fmax(-gaps, 0)
    elastic = p.stiffness * depth**EXPONENT
    slopes = ca.jacobian(gaps, at.all)
    closing = -slopes @ rate.all
    normal = elastic * ca.fmax(1 + p.dissipation * closing, 0)
    generalised = slopes.T @ normal
    rubbed = ca.SX(0)
    for i, contact in enumerate(contacts):
        slip = contact.slip
        drag = p.friction * normal[i] / ca.sqrt(ca.sumsqr(slip) + p.slip_speed**2)
        generalised = generalised - ca.jacobian(slip, rate.all).T @ (drag * slip)
        rubbed = rubbed + drag * ca.sumsqr(slip)
    stored = ca.sum1(p.stiffness * depth ** (EXPONENT + 1)) / (EXPONENT + 1)
    return Forces(normal, gaps, generalised, stored, ca.dot(normal - elastic, closing), rubbed)
