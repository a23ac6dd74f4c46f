"""Rigid bodies, the actions between them, and their Newton-Euler balances. Knows no planter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

import sympy as sp
from sympy import Expr, S

from derive.branches import switch
from derive.frames import Axis, Frame, Motion, Point, Vec, Z, displacement, unit, zero
from derive.model import Let
from derive.quantity import Quantity

Kind = Literal["force", "moment"]
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Part:
    """A rigid piece of a body: mass, centroid, centroidal inertia tensor diagonal in the body's frame."""

    mass: Quantity
    centroid: Point
    inertia: tuple[Expr, Expr, Expr]


def about_pin(moment: Expr, mass: Expr, offset: Vec) -> tuple[Expr, Expr, Expr]:
    """Centroidal inertia of a body that turns about z, from its moment about a pin ``offset`` away.

    Moments of inertia across the pin enter only the pin's tilting moments, which nothing asks for: they are zero here.
    """
    return (S.Zero, S.Zero, moment - mass * (offset[0] ** 2 + offset[1] ** 2))


@dataclass(frozen=True)
class Body:
    """A rigid body: a frame that turns with it and the parts fixed in it."""

    name: str
    frame: Frame
    parts: tuple[Part, ...] = ()

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Action:
    """A force at a point and a moment, of one body on another; the reverse acts on the other."""

    name: str
    on: Body
    by: Body
    at: Point
    force: Vec
    moment: Vec

    def sign(self, body: Body) -> int:
        return {self.on: 1, self.by: -1}.get(body, 0)


@dataclass(frozen=True)
class Balance:
    """Which balance: of which body (or bodies as one), force or moment, along which axis of which frame, about which point."""

    body: str
    kind: Kind
    axis: str
    frame: str
    about: str = ""

    def __str__(self) -> str:
        about = f" about {self.about}" if self.about else ""
        return f"{self.body}: {self.kind} along {self.axis} of {self.frame}{about}"


@dataclass
class Mechanism:
    """Bodies in a given motion with unknown actions between them."""

    motion: Motion
    gravity: Vec
    bodies: list[Body] = field(default_factory=list)
    actions: list[Action] = field(default_factory=list)
    laws: list[Let] = field(default_factory=list)
    unknowns: list[Quantity] = field(default_factory=list)

    def body(self, name: str, frame: Frame, *parts: Part) -> Body:
        body = Body(name, frame, parts)
        self.bodies.append(body)
        return body

    def unknown(self, name: str, unit: str, meaning: str) -> Quantity:
        quantity = Quantity(name, unit, meaning, "derived: reaction")
        self.unknowns.append(quantity)
        return quantity

    def act(self, name: str, on: Body, by: Body, at: Point, force: Vec, moment: Vec | None = None) -> None:
        self.actions.append(Action(name, on, by, at, force, moment or zero(force.frame)))

    def joint(self, name: str, on: Body, by: Body, at: Point, frame: Frame, free: Axis | None = None) -> None:
        """A joint that takes every force and every moment but the one about its free axis (unit axis of ``frame``)."""
        label, tag = name.split("_", 1)
        force = [self.unknown(f"{label}_{tag}{a}", "N", f"force of {by} on {on} at {at.name}, {a}") for a in AXES]
        held = [i for i in range(3) if free is None or not free[i]]
        moment: list[Expr] = [S.Zero] * 3
        for i in held:
            moment[i] = self.unknown(f"M_{tag}{AXES[i]}", "N m", f"moment of {by} on {on} at {at.name}, {AXES[i]}")
        self.act(name, on, by, at, Vec(frame, tuple(force)), Vec(frame, tuple(moment)))

    def torque(self, name: str, on: Body, by: Body, at: Point, axis: Vec, meaning: str) -> Quantity:
        """An unknown torque about an axis."""
        torque = self.unknown(name, "N m", meaning)
        self.act(name, on, by, at, zero(axis.frame), torque * axis)
        return torque

    def couple(self, name: str, first: Body, second: Body, carrier: Body, hinges: tuple[Point, Point], axis: Vec,
               ratio: Expr) -> None:
        """Ideal gearing of two hinges on one body: the second swings ``ratio`` times the first, and no work is done.

        So the moments about the hinges stand as -ratio to one, and the body that carries the hinges takes their reverse.
        """
        second_moment = self.torque(name, second, carrier, hinges[1], axis, f"moment of the coupling on {second}")
        self.act(name, first, carrier, hinges[0], zero(axis.frame), (-ratio * second_moment) * axis)

    def follower(self, name: str, on: Body, cam: Body, at: Point, cam_axis: Point, across: Vec, friction: Expr) -> None:
        """One-sided contact of a follower with a cam.

        The contact works in the plane normal to ``across``. Without friction the force is perpendicular to the
        follower's velocity relative to the cam; friction turns it by the angle ``friction`` against that velocity.
        The force is named by its size, positive when it pushes the follower to the side ``velocity x across``.
        """
        frame = across.frame
        velocity = self.motion.relative_derivative(displacement(cam_axis, at, frame), cam.frame)
        sliding = velocity - velocity.dot(across) * across
        speed = sp.sqrt(sliding.dot(sliding))
        normal = sliding.cross(across)
        size = self.unknown(name, "N", f"contact force of {cam} on {on} at {at.name}")
        direction = (sp.cos(friction) / speed) * normal - (sp.sin(friction) / speed) * sliding
        components = self.name_vector(name, size * direction, "N", f"contact force of {cam} on {on} at {at.name}")
        self.act(name, on, cam, at, components)
        loss = self.unknown(f"{name}_loss", "W", f"power lost to friction between {cam} and {on} at {at.name}")
        self.laws.append(Let(loss, -components.dot(sliding), f"derived: {loss.meaning}"))

    def name_vector(self, name: str, vector: Vec, unit: str, meaning: str) -> Vec:
        """Give the components of a vector names of their own; they are laws between unknowns."""
        symbols: list[Expr] = []
        for axis, component in zip(AXES, vector.components, strict=True):
            if component == 0:
                symbols.append(S.Zero)
                continue
            symbol = self.unknown(f"{name}{axis}", unit, f"{meaning}, {axis}")
            self.laws.append(Let(symbol, component, f"derived: {meaning}"))
            symbols.append(symbol)
        return Vec(vector.frame, tuple(symbols))

    def mesh(self, tag: str, inner: Body, outer: Body, contact: Contact) -> None:
        """Tooth contact at the pitch point: the flank that gives the required moment bears, and pushes."""
        moment = self.unknown(f"M_{tag}", "N m", f"moment about {contact.outer.name} of {inner} on {outer}")
        plus, minus = contact.flank(1), contact.flank(-1)
        normal = self.unknown(f"F_N{tag}", "N", f"normal force between the teeth of {inner} and {outer}")
        lever = switch(moment, contact.outer_radius * plus[1], contact.outer_radius * minus[1])
        self.laws.append(Let(normal, moment / lever, f"derived: {normal.meaning}"))
        force = Vec(contact.frame, tuple(normal * switch(moment, p, m) for p, m in zip(plus, minus, strict=True)))
        named = self.name_vector(f"F_{tag}", force.resolved(contact.world), "N", f"tooth force of {outer} on {inner}")
        self.act(f"F_{tag}", inner, outer, contact.outer, named, (-moment) * unit(contact.world, Z))

    def balance(self, bodies: Body | tuple[Body, ...], kind: Kind, axis: int, frame: Frame,
                about: Point | None = None) -> tuple[Balance, Expr]:
        """Newton-Euler: outer actions and weight less the rate of (angular) momentum, zero in motion."""
        group = bodies if isinstance(bodies, tuple) else (bodies,)
        terms = [self._wrench(a, sign, kind, frame, about)[axis] for a, sign in self.on(group)]
        terms += [self._inertia(body, part, kind, frame, about)[axis] for body in group for part in body.parts]
        name = " and ".join(b.name for b in group)
        return Balance(name, kind, AXES[axis], frame.name, about.name if about else ""), sp.Add(*terms)

    def on(self, group: tuple[Body, ...]) -> Iterator[tuple[Action, int]]:
        """Actions on a group of bodies from outside it, with the sign they act with."""
        for action in self.actions:
            sign = sum(action.sign(body) for body in group)
            if sign:
                yield action, sign

    def _wrench(self, action: Action, sign: int, kind: Kind, frame: Frame, about: Point | None) -> Vec:
        force = action.force.resolved(frame)
        if kind == "force":
            return S(sign) * force
        arm = self.motion.arm(about, action.at, frame)
        return S(sign) * (arm.cross(force) + action.moment.resolved(frame))

    def _inertia(self, body: Body, part: Part, kind: Kind, frame: Frame, about: Point | None) -> Vec:
        """Weight less inertia force of a part, or their moment less the centroidal rate of spin."""
        fall = self.gravity.resolved(frame) - self.motion.acceleration(part.centroid, frame)
        force = part.mass * fall
        if kind == "force":
            return force
        spin = self.motion.spin(body.frame)
        angular = Vec(body.frame, tuple(i * w for i, w in zip(part.inertia, spin.components, strict=True)))
        return self.motion.arm(about, part.centroid, frame).cross(force) - self.motion.derivative(angular).resolved(frame)


@dataclass(frozen=True)
class Contact:
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

    def flank(self, bearing: int) -> tuple[Expr, Expr, Expr]:
        """Force on the inner gear per normal force, on the flank that turns the outer one with (+1) or against it (-1).

        The normal makes the pressure angle with the tangent and points into the inner gear; friction is perpendicular
        to it, outwards.
        """
        normal = self.tangent + self.pressure_angle if bearing > 0 else self.tangent + sp.pi - self.pressure_angle
        across = normal - bearing * sp.pi / 2
        drag = sp.tan(self.friction)
        return sp.cos(normal) + drag * sp.cos(across), sp.sin(normal) + drag * sp.sin(across), S.Zero


def tangent_angle(motion: Motion, line: Frame, gear: Frame, parameter: Expr, radius: Expr, slope: Expr) -> Expr:
    """Angle from a gear's radius vector at the contact to its pitch curve's tangent, counter-clockwise, in (0, pi).

    ``slope`` is along the curve's own parameter; whether that runs with the polar angle of the gear or against it
    follows from the motion of the line of centres and the gear.
    """
    polar_rate = (motion.spin(line) - motion.spin(gear).resolved(line))[2]
    return sp.atan2(radius, sp.cancel(motion.rate(parameter) / polar_rate) * slope)
