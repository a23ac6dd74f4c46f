"""Rigid bodies, the actions between them, and their Newton-Euler balances. Knows no machine and no contact."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..equations import Balance, Definition, Equation, Kind, derived
from ..model import Let
from ..quantity import Quantity
from .frames import Axis, Frame, Motion, Point, Vec, zero

KINDS: tuple[Kind, Kind] = ("force", "moment")
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Part:
    """A rigid piece of a body: mass, centroid, centroidal inertia tensor in the body's frame.

    ``inertia`` is the tensor's diagonal, or its six entries xx, yy, zz, xy, xz, yz (products as they stand in it).
    """

    mass: Quantity
    centroid: Point
    inertia: tuple[Expr, ...]

    def momentum(self, spin: Vec) -> Vec:
        """Angular momentum about the centroid at an angular velocity in the body's frame."""
        xx, yy, zz, xy, xz, yz = (*self.inertia, *[S.Zero] * (6 - len(self.inertia)))
        tensor = sp.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        x, y, z = tensor * sp.Matrix(spin.components)
        return Vec(spin.frame, (x, y, z))


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
class Assembly:
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

    def weight(self) -> Vec:
        """Of all parts of all bodies."""
        return sp.Add(*(part.mass for body in self.bodies for part in body.parts)) * self.gravity

    def equations(self) -> list[Equation]:
        """Laws of the contacts as definitions, then the balances of every body that has a pin."""
        return [*self.definitions(), *(e for body in self.bodies if body.pin for e in self.balanced(body, body.pin))]

    def definitions(self) -> list[Equation]:
        """What contacts say of unknowns."""
        return [
            Equation(
                str(law.symbol), law.symbol - law.expr, law.source, Definition(str(law.symbol)), defines=law.symbol
            )
            for law in self.laws
        ]

    def balanced(self, body: Body, pin: Pin, wanted: Iterable[tuple[Kind, int]] | None = None) -> list[Equation]:
        """The balances of a body as equations, each under its claim."""
        return [derived(claim, residual) for claim, residual in self.balances(body, pin, wanted)]

    def balances(
        self, body: Body, pin: Pin, wanted: Iterable[tuple[Kind, int]] | None = None
    ) -> list[tuple[Balance, Expr]]:
        """Newton-Euler: outer actions and weight less the rate of (angular) momentum, zero in motion.

        Those wanted, by kind and number of the axis; else all, but the tilting moments of a planar body.
        """
        if wanted is None:
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

    def law(self, symbol: Quantity) -> Let:
        """What a contact says of an unknown. Raises ValueError where none does."""
        found = next((law for law in self.laws if law.symbol == symbol), None)
        if found is None:
            raise ValueError(f"no contact says what {symbol} is")
        return found

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
        angular = part.momentum(self.motion.spin(body.frame))
        rate = self.motion.derivative(angular).resolved(pin.axes)
        return self.motion.arm(pin.at, part.centroid, pin.axes).cross(force) - rate
