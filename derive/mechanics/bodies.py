"""Rigid bodies, the actions between them, their Newton-Euler balances, momentum and energy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..equations import Balance, Definition, Equation, Kind, derived_equation
from ..functions import partial_derivative
from ..model import Let
from ..quantity import Quantity
from .frames import Frame, Motion, Point, Rows, Triple, Vec, displacement, zero

KINDS: tuple[Kind, Kind] = ("force", "moment")
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Part:
    """A rigid piece of a body: ``mass`` [kg], ``centroid``, centroidal ``inertia`` [kg m2] along
    the body's axes.

    ``inertia`` holds the tensor's diagonal, or its six entries xx, yy, zz, xy, xz, yz; products as
    they stand in it.
    """

    mass: Quantity
    centroid: Point
    inertia: tuple[Expr, ...]

    @property
    def tensor(self) -> Rows:
        """Rows of the inertia [kg m2]."""
        xx, yy, zz, xy, xz, yz = (*self.inertia, *[S.Zero] * (6 - len(self.inertia)))
        return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)


def about_pin(moment: Expr, mass: Expr, offset: Vec) -> tuple[Expr, Expr, Expr]:
    r"""Return the centroidal inertia [kg m2] of a body that turns about z, from its ``moment`` [kg
    m2] about a pin.

    The pin is ``offset`` [m] away from the centroid, and ``mass`` is in [kg]. Moments of inertia
    across the pin enter only the moments that tilt it, which no balance of the plane contains: they
    are zero here.

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
    """Selection of a body's balances: moments about ``at``, components along ``axes``."""

    at: Point
    axes: Frame
    asked: Asked = EVERY


@dataclass(frozen=True)
class Body:
    """A rigid body: a frame that turns with it, its parts, and the ``pin`` of its balances, if one
    is stated.
    """

    name: str
    frame: Frame
    parts: tuple[Part, ...] = ()
    pin: Pin | None = None

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True)
class Action:
    """A force at a point and a moment, of one body on another; the reverse acts on the other.

    A ``workless`` action, alone or with others of its contact, does no work in any motion that its
    joint allows.
    """

    name: str
    on: Body
    by: Body
    at: Point
    force: Vec
    moment: Vec
    workless: bool = False

    def sign(self, body: Body) -> int:
        """Return 1 for the body on which the action acts, -1 for the body by which it acts, else
        0.
        """
        return {self.on: 1, self.by: -1}.get(body, 0)

    @property
    def needs(self) -> frozenset[sp.Symbol]:
        return frozenset().union(
            *(e.free_symbols for e in (*self.force.components, *self.moment.components))
        )


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
        """Add a body to the assembly, and return the body."""
        self.bodies.append(body)
        return body

    def definitions(self) -> list[Equation]:
        """Return the equations by which contacts define unknowns."""
        return [
            Equation(
                str(law.symbol),
                law.symbol - law.expr,
                law.source,
                Definition(str(law.symbol)),
                defines=law.symbol,
            )
            for law in self.laws
        ]

    def balances(self, body: Body, pin: Pin) -> list[Equation]:
        """Newton-Euler: outer actions and weight less the rate of (angular) momentum, zero in
        motion.
        """
        loads = self.loads(body, pin, self.actions)
        inertia = [
            [self._inertia(body, part, kind, pin)[i] for part in body.parts]
            for kind, i in pin.asked
        ]
        return [
            derived_equation(
                Balance(
                    body.name, kind, AXES[i], pin.axes.name, pin.at.name if kind == "moment" else ""
                ),
                sp.Add(load, *parts),
            )
            for (kind, i), load, parts in zip(pin.asked, loads, inertia, strict=True)
        ]

    def loads(self, body: Body, pin: Pin, actions: Iterable[Action]) -> list[Expr]:
        """Return what some actions add to the balances of a body, in the order of the balances."""
        acting = [(action.sign(body), action) for action in actions if action.sign(body)]
        return [
            sp.Add(*(sign * self._wrench(a, kind, pin)[i] for sign, a in acting))
            for kind, i in pin.asked
        ]

    def unknown(self, name: str, unit: str, meaning: str) -> Quantity:
        """Add an unknown reaction in ``unit``, and return its symbol."""
        quantity = Quantity(name, unit, meaning, "derived: reaction")
        self.unknowns.append(quantity)
        return quantity

    def act(
        self,
        name: str,
        on: Body,
        by: Body,
        at: Point,
        force: Vec,
        moment: Vec | None = None,
        workless: bool = False,
    ) -> None:
        """Add a force [N] ``on`` one body ``by`` another at a point, and a moment [N m] if there is
        one.
        """
        self.actions.append(Action(name, on, by, at, force, moment or zero(force.frame), workless))

    def torque(self, name: str, on: Body, by: Body, at: Point, axis: Vec, meaning: str) -> Quantity:
        """An unknown torque about an axis."""
        torque = self.unknown(name, "N m", meaning)
        self.act(name, on, by, at, zero(axis.frame), torque * axis)
        return torque

    def law(self, symbol: Quantity) -> Let:
        """Return the step by which a contact defines an unknown.

        Raises ValueError if no contact does.
        """
        definition = next((law for law in self.laws if law.symbol == symbol), None)
        if definition is None:
            raise ValueError(f"no contact says what {symbol} is")
        return definition

    def name_vector(self, name: str, vector: Vec, unit: str, meaning: str) -> Vec:
        """Name the components of a vector; they are laws between unknowns."""
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
        force = self.motion.resolve(action.force, pin.axes)
        if kind == "force":
            return force
        moment = self.motion.resolve(action.moment, pin.axes)
        return self.motion.arm(pin.at, action.at, pin.axes).cross(force) + moment

    def _inertia(self, body: Body, part: Part, kind: Kind, pin: Pin) -> Vec:
        """Weight less inertia force of a part, or their moment less the centroidal rate of spin."""
        gravity = self.motion.resolve(self.gravity, pin.axes)
        fall = gravity - self.motion.acceleration(part.centroid, pin.axes)
        force = part.mass * fall
        if kind == "force":
            return force
        rate = self.motion.resolve(self.motion.momentum_rate(part.tensor, body.frame), pin.axes)
        return self.motion.arm(pin.at, part.centroid, pin.axes).cross(force) - rate


Anchor = Callable[[Body], Point]
"""A point that is fixed in a body."""


def virtual_loads(
    assembly: Assembly, ground: Body, anchor: Anchor, actions: Iterable[Action]
) -> list[tuple[Vec, Vec]]:
    """Forces and moments of actions, weights and inertia, each with the velocity that it works
    on.
    """
    motion = assembly.motion
    acting = [pair for action in actions for pair in action_load(motion, action, ground, anchor)]
    return acting + [
        pair for body in assembly.bodies for pair in body_loads(assembly, body, ground)
    ]


def action_load(
    motion: Motion, action: Action, ground: Body, anchor: Anchor
) -> list[tuple[Vec, Vec]]:
    """Force and moment of an action, with how its bodies slip and turn against each other there."""
    world = ground.frame
    slip = sliding_velocity(motion, (action.on, action.by), ground, anchor, action.at)
    turn = motion.spin(action.on.frame).resolved(world) - motion.spin(action.by.frame).resolved(
        world
    )
    return [(action.force.resolved(world), slip), (action.moment.resolved(world), turn)]


def body_loads(assembly: Assembly, body: Body, ground: Body) -> list[tuple[Vec, Vec]]:
    """Weight and inertia of a body's parts, with how these move."""
    motion, world, loads = assembly.motion, ground.frame, []
    for part in body.parts:
        fall = assembly.gravity - motion.acceleration(part.centroid, world)
        loads.append((part.mass * fall, motion.velocity(part.centroid, world)))
        loads.append((-motion.momentum_rate(part.tensor, body.frame), motion.spin(body.frame)))
    return loads


def total_power(assembly: Assembly, ground: Body, anchor: Anchor) -> Expr:
    """Power of actions, weights and inertia of all bodies [W]."""
    return sp.Add(
        *(
            load.dot(speed)
            for load, speed in virtual_loads(assembly, ground, anchor, assembly.actions)
        )
    )


def virtual_works(
    assembly: Assembly,
    ground: Body,
    anchor: Anchor,
    rates: Sequence[Quantity],
    plain: Callable[[Expr], Expr],
    actions: Iterable[Action] | None = None,
) -> list[Expr]:
    """Virtual work of the same while each coordinate moves alone: joints that this opens do work,
    no other does.

    ``plain`` tells speeds in the rates of the coordinates, of which ``rates`` are some; of the
    actions, all count unless some are passed.
    """
    pairs = virtual_loads(
        assembly, ground, anchor, assembly.actions if actions is None else actions
    )
    plain_pairs = [(load, Vec(v.frame, _triple(map(plain, v.components)))) for load, v in pairs]
    return [_work_along(rate, plain_pairs) for rate in rates]


def _work_along(rate: Quantity, pairs: Iterable[tuple[Vec, Vec]]) -> Expr:
    works = []
    for load, velocity in pairs:
        slopes = _triple(partial_derivative(component, rate) for component in velocity.components)
        works.append(load.dot(Vec(velocity.frame, slopes)))
    return sp.Add(*works)


def momentum_residuals(assembly: Assembly, ground: Body) -> dict[str, Expr]:
    """Forces of the ground and weights less the rate of momentum of all bodies, by axes of the
    world [N].
    """
    world = ground.frame
    total = zero(world)
    for action in assembly.actions:
        if ground in (action.on, action.by):
            total = total - action.sign(ground) * action.force.resolved(world)
    for body in assembly.bodies:
        for part in body.parts:
            total = total + part.mass * (
                assembly.gravity - assembly.motion.acceleration(part.centroid, world)
            )
    return dict(zip(AXES, total.components, strict=True))


def kinetic_energy(motion: Motion, bodies: Iterable[Body], world: Frame) -> Expr:
    """Kinetic energy of bodies [J]."""
    total = S.Zero
    for body in bodies:
        for part in body.parts:
            speed, spin = motion.velocity(part.centroid, world), motion.spin(body.frame)
            turning = motion.angular_momentum(part.tensor, body.frame).dot(spin)
            total += part.mass * speed.dot(speed) / 2 + turning / 2
    return total


def potential_energy(
    assembly: Assembly, bodies: Iterable[Body], origin: Point, world: Frame
) -> Expr:
    """Potential energy of the weights of bodies [J]."""
    parts = [part for body in bodies for part in body.parts]
    places = [assembly.motion.arm(origin, part.centroid, world) for part in parts]
    return sp.Add(
        *(
            -part.mass * assembly.gravity.dot(place)
            for part, place in zip(parts, places, strict=True)
        )
    )


def angular_momentum_residuals(assembly: Assembly, ground: Body, about: Point) -> dict[str, Expr]:
    """Return the residuals of the moments of all bodies about a point at rest [N m]."""
    world, motion = ground.frame, assembly.motion
    total = zero(world)
    for action in assembly.actions:
        if ground in (action.on, action.by):
            arm = displacement(about, action.at, world)
            moment = arm.cross(action.force.resolved(world)) + action.moment.resolved(world)
            total = total - action.sign(ground) * moment
    for body in assembly.bodies:
        for part in body.parts:
            fall = part.mass * (assembly.gravity - motion.acceleration(part.centroid, world))
            rate = motion.momentum_rate(part.tensor, body.frame).resolved(world)
            total = total + displacement(about, part.centroid, world).cross(fall) - rate
    return dict(zip(AXES, total.components, strict=True))


def _triple(components: Iterable[Expr]) -> Triple:
    x, y, z = components
    return x, y, z


def material_velocity(motion: Motion, body: Body, ground: Body, anchor: Anchor, at: Point) -> Vec:
    """Velocity of a body's own matter at a point, in the world."""
    world = ground.frame
    if body == ground:
        return zero(world)
    arm = displacement(anchor(body), at, world)
    spin = motion.spin(body.frame).resolved(world)
    return motion.velocity(anchor(body), world) + spin.cross(arm)


def sliding_velocity(
    motion: Motion, bodies: tuple[Body, Body], ground: Body, anchor: Anchor, at: Point
) -> Vec:
    """Velocity of one body's matter over that of another at a point, in the world."""
    first, second = (material_velocity(motion, body, ground, anchor, at) for body in bodies)
    return first - second
