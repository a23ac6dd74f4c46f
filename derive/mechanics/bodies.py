"""Rigid bodies, the actions between them, and their Newton-Euler balances. Knows no planter."""

from __future__ import annotations

from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..branches import switch
from ..equations import Balance, Definition, Equation, Kind
from ..model import Let
from ..quantity import Quantity
from .frames import Axis, Frame, Motion, Point, Vec, Z, displacement, unit, zero

KINDS: tuple[Kind, Kind] = ("force", "moment")
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
class Pin:
    """Where and how the balances of a body are written: moments about ``at``, components along ``axes``.

    Of a ``planar`` body the moments across z are left out, which only tilt its shaft.
    """

    at: Point
    axes: Frame
    planar: bool = False


@dataclass(frozen=True)
class Body:
    """A rigid body: a frame that turns with it, the parts fixed in it, and the pin of its balances."""

    name: str
    frame: Frame
    parts: tuple[Part, ...] = ()
    pin: Pin | None = None

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


@dataclass
class Mechanism:
    """Bodies in a given motion with unknown actions between them."""

    motion: Motion
    gravity: Vec
    bodies: list[Body] = field(default_factory=list)
    actions: list[Action] = field(default_factory=list)
    laws: list[Let] = field(default_factory=list)
    unknowns: list[Quantity] = field(default_factory=list)

    def add(self, body: Body) -> Body:
        self.bodies.append(body)
        return body

    def equations(self) -> list[Equation]:
        """Laws of the contacts as definitions, then the balances of every body that has a pin."""
        laws = [
            Equation(
                str(law.symbol), law.symbol - law.expr, law.source, Definition(str(law.symbol)), defines=law.symbol
            )
            for law in self.laws
        ]
        balances = [balance for body in self.bodies if body.pin for balance in self.balances(body, body.pin)]
        return laws + [Equation(str(claim), residual, f"derived: {claim}", claim) for claim, residual in balances]

    def balances(self, body: Body, pin: Pin) -> list[tuple[Balance, Expr]]:
        """Newton-Euler: outer actions and weight less the rate of (angular) momentum, zero in motion."""
        wanted = [(kind, i) for kind in KINDS for i in range(3) if not (pin.planar and kind == "moment" and i < 2)]
        return [self._balance(body, kind, axis, pin) for kind, axis in wanted]

    def unknown(self, name: str, unit: str, meaning: str) -> Quantity:
        quantity = Quantity(name, unit, meaning, "derived: reaction")
        self.unknowns.append(quantity)
        return quantity

    def act(self, name: str, on: Body, by: Body, at: Point, force: Vec, moment: Vec | None = None) -> None:
        self.actions.append(Action(name, on, by, at, force, moment or zero(force.frame)))

    def joint(self, name: str, on: Body, by: Body, at: Point, frame: Frame, free: Axis | None = None) -> None:
        """A joint that takes every force and every moment but the one about its free axis (unit axis of ``frame``)."""
        label, tag = name.split("_", 1)
        x, y, z = (self.unknown(f"{label}_{tag}{a}", "N", f"force of {by} on {on} at {at.name}, {a}") for a in AXES)
        moment: list[Expr] = [S.Zero] * 3
        for i in (i for i in range(3) if free is None or not free[i]):
            moment[i] = self.unknown(f"M_{tag}{AXES[i]}", "N m", f"moment of {by} on {on} at {at.name}, {AXES[i]}")
        self.act(name, on, by, at, Vec(frame, (x, y, z)), Vec(frame, (moment[0], moment[1], moment[2])))

    def torque(self, name: str, on: Body, by: Body, at: Point, axis: Vec, meaning: str) -> Quantity:
        """An unknown torque about an axis."""
        torque = self.unknown(name, "N m", meaning)
        self.act(name, on, by, at, zero(axis.frame), torque * axis)
        return torque

    def couple(
        self,
        name: str,
        first: Body,
        second: Body,
        carrier: Body,
        hinges: tuple[Point, Point],
        axis: Vec,
        ratio: Expr,
    ) -> None:
        """Ideal gearing of two hinges on one body: the second swings ``ratio`` times the first, and no work is done.

        So the moments about the hinges stand as -ratio to one; the body that carries the hinges takes their reverse.
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
        if not any(sliding.components):
            raise ValueError(f"{name}: {on} does not slide on {cam} at {at.name}, so the contact has no normal")
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

    def _balance(self, body: Body, kind: Kind, axis: int, pin: Pin) -> tuple[Balance, Expr]:
        terms = [sign * self._wrench(a, kind, pin)[axis] for a in self.actions if (sign := a.sign(body))]
        terms += [self._inertia(body, part, kind, pin)[axis] for part in body.parts]
        about = pin.at.name if kind == "moment" else ""
        return Balance(body.name, kind, AXES[axis], pin.axes.name, about), sp.Add(*terms)

    def _wrench(self, action: Action, kind: Kind, pin: Pin) -> Vec:
        force = action.force.resolved(pin.axes)
        if kind == "force":
            return force
        return self.motion.arm(pin.at, action.at, pin.axes).cross(force) + action.moment.resolved(pin.axes)

    def _inertia(self, body: Body, part: Part, kind: Kind, pin: Pin) -> Vec:
        """Weight less inertia force of a part, or their moment less the centroidal rate of spin."""
        fall = self.gravity.resolved(pin.axes) - self.motion.acceleration(part.centroid, pin.axes)
        force = part.mass * fall
        if kind == "force":
            return force
        spin = self.motion.spin(body.frame)
        angular = Vec(body.frame, (part.inertia[0] * spin[0], part.inertia[1] * spin[1], part.inertia[2] * spin[2]))
        rate = self.motion.derivative(angular).resolved(pin.axes)
        return self.motion.arm(pin.at, part.centroid, pin.axes).cross(force) - rate


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
        drag = sp.tan(self.friction)
        return sp.cos(normal) + drag * sp.cos(across), sp.sin(normal) + drag * sp.sin(across), S.Zero


def tangent_angle(motion: Motion, line: Frame, gear: Frame, parameter: Expr, radius: Expr, slope: Expr) -> Expr:
    """Angle from a gear's radius vector at the contact to its pitch curve's tangent, counter-clockwise, in (0, pi).

    ``slope`` is along the curve's own parameter; whether that runs with the polar angle of the gear or against it
    follows from the motion of the line of centres and the gear.
    """
    polar_rate = (motion.spin(line) - motion.spin(gear).resolved(line))[2]
    return sp.atan2(radius, sp.cancel(motion.rate(parameter) / polar_rate) * slope)
