"""Rigid bodies, the actions between them, and their Newton-Euler balances. Knows no machine and no contact."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..equations import Balance, Definition, Equation, Kind, derived
from ..model import Let
from ..quantity import Quantity
from .frames import Frame, Motion, Point, Vec, zero

KINDS: tuple[Kind, Kind] = ("force", "moment")
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Part:
    """A rigid piece of a body: ``mass`` [kg], ``centroid``, centroidal ``inertia`` [kg m2] along the body's axes.

    ``inertia`` holds the tensor's diagonal, or its six entries xx, yy, zz, xy, xz, yz; products as they stand in it.
    """

    mass: Quantity
    centroid: Point
    inertia: tuple[Expr, ...]

    def momentum(self, spin: Vec) -> Vec:
        """Return the angular momentum about the centroid [kg m2/s] at a ``spin`` [rad/s], along the body's axes."""
        xx, yy, zz, xy, xz, yz = (*self.inertia, *[S.Zero] * (6 - len(self.inertia)))
        tensor = sp.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        x, y, z = tensor * sp.Matrix(spin.components)
        return Vec(spin.frame, (x, y, z))


def about_pin(moment: Expr, mass: Expr, offset: Vec) -> tuple[Expr, Expr, Expr]:
    r"""Return the centroidal inertia [kg m2] of a body that turns about z, from its ``moment`` [kg m2] about a pin.

    The pin is ``offset`` [m] away from the centroid, and ``mass`` is in [kg]. Moments of inertia across the pin enter
    only the moments that tilt it, which no balance of the plane contains: they are zero here.

    >>> from derive import Vec, about_pin, quantities
    >>> from derive.mechanics.frames import Frame
    >>> q = quantities("J | kg m2 | about the pin | 0.02\nm | kg | mass | 2\ns | m | centroid | 0.05")
    >>> about_pin(q.J, q.m, Vec(Frame("arm"), (q.s, 0, 0)))
    (0, 0, J - m*s**2)
    """
    return (S.Zero, S.Zero, moment - mass * (offset[0] ** 2 + offset[1] ** 2))


Asked = tuple[tuple[Kind, int], ...]
"""Balances by kind and number of the axis."""
EVERY: Asked = tuple((kind, i) for kind in KINDS for i in range(3))
SHAFT: Asked = (("force", 0), ("force", 1), ("force", 2), ("moment", 2))
"""All but the moments that tilt the shaft of a body that turns about z."""
PLANE: Asked = (("force", 0), ("force", 1), ("moment", 2))
"""Of a body that moves in the plane across z."""


@dataclass(frozen=True)
class Pin:
    """Which balances of a body are written, and how: moments about ``at``, components along ``axes``."""

    at: Point
    axes: Frame
    asked: Asked = EVERY


@dataclass(frozen=True)
class Body:
    """A rigid body: a frame that turns with it, its parts, and the ``pin`` of its balances, if one is stated."""

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

    @property
    def needs(self) -> frozenset[sp.Symbol]:
        return frozenset().union(*(e.free_symbols for e in (*self.force.components, *self.moment.components)))


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

    def definitions(self) -> list[Equation]:
        """What contacts say of unknowns."""
        return [
            Equation(
                str(law.symbol), law.symbol - law.expr, law.source, Definition(str(law.symbol)), defines=law.symbol
            )
            for law in self.laws
        ]

    def balances(self, body: Body, pin: Pin) -> list[Equation]:
        """Newton-Euler: outer actions and weight less the rate of (angular) momentum, zero in motion."""
        loads = self.loads(body, pin, self.actions)
        inertia = [[self._inertia(body, part, kind, pin)[i] for part in body.parts] for kind, i in pin.asked]
        return [
            derived(
                Balance(body.name, kind, AXES[i], pin.axes.name, pin.at.name if kind == "moment" else ""),
                sp.Add(load, *parts),
            )
            for (kind, i), load, parts in zip(pin.asked, loads, inertia, strict=True)
        ]

    def loads(self, body: Body, pin: Pin, actions: Iterable[Action]) -> list[Expr]:
        """What some actions add to the balances of a body, in their order."""
        acting = [(action.sign(body), action) for action in actions if action.sign(body)]
        return [sp.Add(*(sign * self._wrench(a, kind, pin)[i] for sign, a in acting)) for kind, i in pin.asked]

    def unknown(self, name: str, unit: str, meaning: str) -> Quantity:
        quantity = Quantity(name, unit, meaning, "derived: reaction")
        self.unknowns.append(quantity)
        return quantity

    def act(self, name: str, on: Body, by: Body, at: Point, force: Vec, moment: Vec | None = None) -> None:
        self.actions.append(Action(name, on, by, at, force, moment or zero(force.frame)))

    def torque(self, name: str, on: Body, by: Body, at: Point, axis: Vec, meaning: str) -> Quantity:
        """An unknown torque about an axis."""
        torque = self.unknown(name, "N m", meaning)
        self.act(name, on, by, at, zero(axis.frame), torque * axis)
        return torque

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
