"""Contacts between bodies that only push: teeth of gears, a follower on a cam; gearing without loss."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp
from sympy import Expr, S

from ..branches import switch
from ..model import Event, Let
from ..quantity import Quantity
from .bodies import Body
from .frames import Frame, Motion, Point, Vec, Z, displacement, unit, zero
from .kinematics import Kinematics


@dataclass(frozen=True)
class GearContact:
    """Where two gears touch: on the line of centres, which is x of ``frame``, from the inner gear's centre outwards.

    ``outer`` is the centre of the outer gear, ``tangent`` the angle from the line to the tangent of the pitch curves,
    counter-clockwise, in (0, pi): a right angle where gears are round. ``friction`` is the angle of friction.
    """

    frame: Frame
    outer: Point
    outer_radius: Expr
    pressure_angle: Expr
    friction: Expr = S.Zero
    tangent: Expr = sp.pi / 2

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

    @property
    def pitch_point(self) -> Point:
        return Point("pitch point", self.outer, Vec(self.frame, (-self.outer_radius, S.Zero, S.Zero)))

    def lever(self, bearing: int) -> Expr:
        """Moment about the outer gear's centre of what acts on it, per normal force."""
        return self.outer_radius * self.flank(bearing)[1]


@dataclass(frozen=True)
class SlidingContact(GearContact):
    """Teeth that touch a distance ``beyond`` from the pitch point along the line of action, and slide there.

    The distance counts along the normal force on the inner gear. ``turning`` is the rate of the inner gear relative to
    the outer one. ``share`` of 1 has friction act against the sliding, of 0 outwards.
    """

    beyond: Expr = S.Zero
    turning: Expr = S.Zero
    share: Expr = S.One

    def lead(self, bearing: int) -> Expr:
        """Share of the normal force that acts beyond the pitch point, less the share before it."""
        return sp.sign(self.beyond)

    def away(self, bearing: int) -> Expr:
        """Mean distance of the normal force from the pitch point."""
        return self.beyond * sp.sign(self.beyond)

    def drag(self, bearing: int) -> Expr:
        against = bearing * sp.sign(self.turning) * self.lead(bearing)
        return sp.tan(self.friction) * (1 + self.share * (against - 1))

    def lever(self, bearing: int) -> Expr:
        """Friction acts beyond the pitch point; the normal force, on its own line, has the lever that it has there."""
        return super().lever(bearing) + sp.sign(self.turning) * self._rubbing(bearing)

    def loss(self, bearing: int) -> Expr:
        """Power lost per normal force."""
        return self.turning * sp.sign(self.turning) * self._rubbing(bearing)

    def _rubbing(self, bearing: int) -> Expr:
        """Moment of friction about the pitch point per normal force, against the turning."""
        return self.share * sp.tan(self.friction) * self.away(bearing)


@dataclass(frozen=True)
class SharedContact(SlidingContact):
    """Several pairs of teeth on one line of action that share the normal force in any way.

    ``leads`` and ``aways`` are what `lead` and `away` are over all pairs, on the flank that turns the outer gear with
    (+1) and on the one that turns it against (-1).
    """

    leads: tuple[Expr, Expr] = (S.Zero, S.Zero)
    aways: tuple[Expr, Expr] = (S.Zero, S.Zero)

    def lead(self, bearing: int) -> Expr:
        return self.leads[bearing < 0]

    def away(self, bearing: int) -> Expr:
        return self.aways[bearing < 0]


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


class Contacts(Kinematics):
    """What touches what: a force each, by laws where it is of a kind, and the events where a law turns round."""

    def contact(self, name: str, on: Body, by: Body, at: Point, way: Vec) -> Quantity:
        """A smooth contact: the force N_name along a unit vector, out of ``by``; below zero it would have to pull."""
        normal = self.assembly.unknown(f"N_{name}", "N", f"force of {by} on {on} at {at.name}, along the normal")
        self.pushing.append(normal)
        self.assembly.act(name, on, by, at, normal * way)
        return normal

    def mesh(self, tag: str, inner: Body, outer: Body, contact: GearContact) -> None:
        """Teeth of two gears beside each other: the flank bears that gives the required moment, and pushes.

        M_tag is the moment of the inner gear's action about the outer one's centre, F_Ntag the normal force, F_tag the
        force on the inner gear by axes of the world, F_tag_loss, where the teeth slide, the power lost.
        """
        mechanism, teeth = self.assembly, f"the teeth of {inner} and {outer}"
        self.rolling[tag] = inner, outer, contact.pitch_point
        moment = mechanism.unknown(f"M_{tag}", "N m", f"moment about {contact.outer.name} of {inner} on {outer}")
        plus, minus = contact.flank(1), contact.flank(-1)
        normal = mechanism.unknown(f"F_N{tag}", "N", f"normal force between {teeth}")
        lever = switch(moment, contact.lever(1), contact.lever(-1))
        mechanism.laws.append(Let(normal, moment / lever, f"derived: {normal.meaning}"))
        force = Vec(contact.frame, tuple(normal * switch(moment, p, m) for p, m in zip(plus, minus, strict=True)))
        named = mechanism.name_vector(f"F_{tag}", force.resolved(self.world), "N", f"tooth force of {outer} on {inner}")
        mechanism.act(f"F_{tag}", inner, outer, contact.outer, named, (-moment) * unit(self.world, Z))
        self.events.append(Event(f"teeth at {tag}, change of flank", moment, S.Zero, order=1))
        if isinstance(contact, SlidingContact):
            loss = mechanism.unknown(f"F_{tag}_loss", "W", f"power lost to friction between {teeth}")
            power = normal * switch(moment, contact.loss(1), contact.loss(-1))
            mechanism.laws.append(Let(loss, power, f"derived: {loss.meaning}"))

    def follower(
        self, name: str, on: Body, cam: Body, at: Point, cam_axis: Point, friction: Expr = S.Zero,
        across: Vec | None = None, rubbing: Expr = S.Zero,
    ) -> Quantity:  # fmt: skip
        """One-sided contact of a follower with a cam: the force ``name`` by its size, and its components.

        ``at`` is the roller's centre. The normal lies in the plane normal to ``across``, a unit vector, else the
        world's z, and is perpendicular to the follower's velocity there relative to the cam. Friction turns the force
        by the angle ``friction`` against the sliding: that velocity, and the share ``rubbing`` of the velocity along
        ``across``; ``name``_loss is the power lost. The force is positive when it pushes the follower to the side
        ``velocity x across``.
        """
        mechanism, across = self.assembly, across or unit(self.world, Z)
        self.rollers[name] = cam, displacement(cam_axis, at, self.world)
        velocity = self.motion.relative_derivative(displacement(cam_axis, at, across.frame), cam.frame)
        in_plane = velocity - velocity.dot(across) * across
        if not any(in_plane.components):
            raise ValueError(f"{name}: {on} does not slide on {cam} at {at.name}, so the contact has no normal")
        sliding = in_plane + (rubbing * velocity.dot(across)) * across
        force = f"contact force of {cam} on {on} at {at.name}"
        size = mechanism.unknown(name, "N", force)
        self.pushing.append(size)
        direction = (sp.cos(friction) / sp.sqrt(in_plane.dot(in_plane))) * in_plane.cross(across)
        direction -= (sp.sin(friction) / sp.sqrt(sliding.dot(sliding))) * sliding
        components = mechanism.name_vector(name, size * direction, "N", force)
        mechanism.act(name, on, cam, at, components)
        if friction != 0:
            loss = mechanism.unknown(f"{name}_loss", "W", f"power lost to friction between {cam} and {on} at {at.name}")
            mechanism.laws.append(Let(loss, -components.dot(sliding), f"derived: {loss.meaning}"))
        return size

    def couple(
        self, name: str, first: Body, second: Body, carrier: Body, hinges: tuple[Point, Point], axis: Vec, ratio: Expr
    ) -> Quantity:  # fmt: skip
        """Ideal gearing of two hinges on one body: the second swings ``ratio`` times the first, and no work is done.

        So the moments about the hinges stand as -ratio to one, ``name`` on the second; the body that carries the
        hinges takes their reverse.
        """
        meaning = f"moment of the coupling on {second}"
        moment = self.assembly.torque(name, second, carrier, hinges[1], axis, meaning)
        self.assembly.act(name, first, carrier, hinges[0], zero(axis.frame), (-ratio * moment) * axis)
        return moment
