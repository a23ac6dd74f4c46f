"""Contacts between bodies that only push: teeth of gears, and a follower on a cam."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp
from sympy import Expr, S

from ..branches import switch
from ..model import Let
from .bodies import Assembly, Body
from .frames import Frame, Motion, Point, Vec, Z, displacement, unit


@dataclass(frozen=True)
class GearContact:
    """Where two gears touch: on the line of centres, which is x of ``frame``, from the inner gear's centre outwards.

    ``tangent`` is the angle from there to the tangent of the pitch curves, counter-clockwise, in (0, pi).
    """

    world: Frame
    frame: Frame
    outer: Point
    outer_radius: Expr
    tangent: Expr
    pressure_angle: Expr
    friction: Expr

    def normal(self, bearing: int) -> Expr:
        """Direction of the normal force on the inner gear, from its radius vector: into the gear."""
        return self.tangent + self.pressure_angle if bearing > 0 else self.tangent + sp.pi - self.pressure_angle

    def across(self, bearing: int) -> Expr:
        """Direction of friction on the inner gear, from its radius vector: outwards."""
        return self.normal(bearing) - bearing * sp.pi / 2

    def flank(self, bearing: int) -> tuple[Expr, Expr, Expr]:
        """Force on the inner gear per normal force, on the flank that turns the outer one with (+1) or against it (-1).

        The normal makes the pressure angle with the tangent and points into the inner gear; friction is perpendicular
        to it, outwards.
        """
        normal, across = self.normal(bearing), self.across(bearing)
        drag = self.drag(bearing)
        return sp.cos(normal) + drag * sp.cos(across), sp.sin(normal) + drag * sp.sin(across), S.Zero

    def drag(self, bearing: int) -> Expr:
        """Friction per normal force, outwards."""
        return sp.tan(self.friction)

    def lever(self, bearing: int) -> Expr:
        """Moment about the outer gear's centre of what acts on it, per normal force."""
        return self.outer_radius * self.flank(bearing)[1]


@dataclass(frozen=True)
class SlidingContact(GearContact):
    """Teeth that touch a distance ``beyond`` from the pitch point along the line of action, and slide there.

    ``turning`` is the rate of the inner gear relative to the outer one. ``share`` of 1 has friction act against the
    sliding, of 0 outwards.
    """

    beyond: Expr
    turning: Expr
    share: Expr

    def drag(self, bearing: int) -> Expr:
        against = bearing * sp.sign(self.turning * self.beyond)
        return sp.tan(self.friction) * (1 + self.share * (against - 1))

    def lever(self, bearing: int) -> Expr:
        """Friction acts beyond the pitch point; the normal force, on its own line, has the lever that it has there."""
        return super().lever(bearing) + bearing * self.beyond * self.drag(bearing)

    def loss(self, bearing: int) -> Expr:
        """Power lost per normal force."""
        return bearing * self.drag(bearing) * self.turning * self.beyond


def mesh(mechanism: Assembly, tag: str, inner: Body, outer: Body, contact: GearContact) -> None:
    """Tooth contact: the flank that gives the required moment bears, and pushes."""
    moment = mechanism.unknown(f"M_{tag}", "N m", f"moment about {contact.outer.name} of {inner} on {outer}")
    plus, minus = contact.flank(1), contact.flank(-1)
    normal = mechanism.unknown(f"F_N{tag}", "N", f"normal force between the teeth of {inner} and {outer}")
    lever = switch(moment, contact.lever(1), contact.lever(-1))
    mechanism.laws.append(Let(normal, moment / lever, f"derived: {normal.meaning}"))
    force = Vec(contact.frame, tuple(normal * switch(moment, p, m) for p, m in zip(plus, minus, strict=True)))
    named = mechanism.name_vector(f"F_{tag}", force.resolved(contact.world), "N", f"tooth force of {outer} on {inner}")
    mechanism.act(f"F_{tag}", inner, outer, contact.outer, named, (-moment) * unit(contact.world, Z))
    if isinstance(contact, SlidingContact):
        loss = mechanism.unknown(
            f"F_{tag}_loss", "W", f"power lost to friction between the teeth of {inner} and {outer}"
        )
        power = normal * switch(moment, contact.loss(1), contact.loss(-1))
        mechanism.laws.append(Let(loss, power, f"derived: {loss.meaning}"))


def tangent_angle(motion: Motion, line: Frame, gear: Frame, parameter: Expr, radius: Expr, slope: Expr) -> Expr:
    """Angle from a gear's radius vector at the contact to its pitch curve's tangent, counter-clockwise, in (0, pi).

    ``slope`` is along the curve's own parameter, whose sense follows from the motion.
    """
    return sp.atan2(radius, polar_sense(motion, line, gear, parameter) * slope)


def polar_sense(motion: Motion, line: Frame, gear: Frame, parameter: Expr) -> Expr:
    """1 where a curve's parameter at the contact runs with the polar angle of its gear, -1 where against it."""
    polar_rate = (motion.spin(line) - motion.spin(gear).resolved(line))[2]
    return sp.cancel(motion.rate(parameter) / polar_rate)


@dataclass(frozen=True)
class PitchPoint:
    """A point of a pitch curve: polar angle, radius, and how far its conjugate has turned when it is in contact."""

    polar: Expr
    radius: Expr
    turned: Expr


def pitch_places(line: Frame, distance: Expr, sense: Expr, point: PitchPoint, now: PitchPoint) -> tuple[Vec, Vec]:
    """A point of the inner gear and its mate on the outer one while ``now`` is in contact, from the inner's centre.

    Both are as far from the line of centres as their gears have still to turn, or have turned since, the one against
    the other.
    """
    inner = Frame("radius of the inner gear", line, Z, sense * (point.polar - now.polar))
    outer = Frame("radius of the outer gear", line, Z, sp.pi - sense * (point.turned - now.turned))
    mate = Vec(outer, (distance - point.radius, S.Zero, S.Zero)).resolved(line)
    place = Vec(inner, (point.radius, S.Zero, S.Zero)).resolved(line)
    return place, Vec(line, (distance, S.Zero, S.Zero)) + mate


def follower(
    mechanism: Assembly, name: str, on: Body, cam: Body, at: Point, cam_axis: Point, across: Vec, friction: Expr,
    rubbing: Expr = S.Zero,
) -> None:  # fmt: skip
    """One-sided contact of a follower with a cam.

    The normal lies in the plane normal to ``across``, perpendicular to the follower's velocity there relative to the
    cam. Friction turns the force by the angle ``friction`` against the sliding: that velocity, and the share
    ``rubbing`` of the velocity along ``across``. The force is named by its size, positive when it pushes the follower
    to the side ``velocity x across``.
    """
    frame = across.frame
    velocity = mechanism.motion.relative_derivative(displacement(cam_axis, at, frame), cam.frame)
    in_plane = velocity - velocity.dot(across) * across
    if not any(in_plane.components):
        raise ValueError(f"{name}: {on} does not slide on {cam} at {at.name}, so the contact has no normal")
    sliding = in_plane + (rubbing * velocity.dot(across)) * across
    normal = in_plane.cross(across)
    size = mechanism.unknown(name, "N", f"contact force of {cam} on {on} at {at.name}")
    direction = (sp.cos(friction) / sp.sqrt(in_plane.dot(in_plane))) * normal
    direction -= (sp.sin(friction) / sp.sqrt(sliding.dot(sliding))) * sliding
    components = mechanism.name_vector(name, size * direction, "N", f"contact force of {cam} on {on} at {at.name}")
    mechanism.act(name, on, cam, at, components)
    loss = mechanism.unknown(f"{name}_loss", "W", f"power lost to friction between {cam} and {on} at {at.name}")
    mechanism.laws.append(Let(loss, -components.dot(sliding), f"derived: {loss.meaning}"))
