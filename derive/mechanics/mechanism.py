"""A mechanism as it is drawn: frames, points, bodies, joints, forces. What follows from them is derived."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import TypeAlias

import sympy as sp
from sympy import Expr, S

from ..branches import switch
from ..chain import ordered
from ..dimensions import DimensionError, dimension, of_unit
from ..equations import Balance, Equation, Kind
from ..model import Event, Lane, Let, LinearSolve, Step, System, needed, sorted_steps
from ..quantity import Quantity, Vector
from ..table import Quantities
from . import laws
from .bodies import AXES, Assembly, Body, Part, Pin
from .frames import Axis, Frame, Motion, Point, Triple, Vec, X, Z, displacement, unit, zero
from .loops import Coordinate, Loops

Scalar: TypeAlias = Expr | float
_RATES = {"rad": ("rad/s", "rad/s2"), "m": ("m/s", "m/s2"), "1": ("1/s", "1/s2")}
PLANAR: tuple[tuple[Kind, int], ...] = (("force", 0), ("force", 1), ("moment", 2))
"""Balances of a body that moves in the plane across z."""


class MechanismError(ValueError):
    """A mechanism is stated so that nothing can be derived of it."""


class Mechanism:
    """Bodies that move along ``angle``, which turns at the constant ``speed``: in the plane across z, or in space.

    ``given`` is the table of all quantities; ``gravity`` the acceleration of free fall, along -y of the world, or its
    components there. Lengths in m, angles in rad. Every name becomes a name in the generated code.
    """

    def __init__(
        self,
        name: str,
        given: Quantities,
        *,
        angle: Quantity,
        speed: Quantity,
        gravity: Scalar | Sequence[Scalar] = 0,
        title: str = "",
        source: str = "own",
        assumptions: Iterable[str] = (),
        spatial: bool = False,
    ) -> None:
        self.name, self.title, self.source = name, title or name.replace("_", " ").capitalize(), source
        self.given, self.angle, self.speed, self.spatial = given, angle, speed, spatial
        self.assumptions = ("rigid bodies", f"constant: {speed.meaning}", *assumptions)
        self.motion = Motion({angle: speed})
        self.world, self.O = Frame("world"), Point("O")
        fall = gravity if isinstance(gravity, Sequence) else (0, -gravity, 0)
        self._assembly = Assembly(self.motion, Vec(self.world, _triple(fall)))
        self.ground = self._assembly.add(Body("ground", self.world))
        self._loops = Loops()
        self._named: list[Let] = []
        self._reports: list[Let] = []
        self._events: list[Event] = []
        self._about: dict[Body, Point] = {}

    # Geometry and motion

    def frame(self, name: str, angle: Scalar, axis: Axis = Z, parent: Frame | None = None) -> Frame:
        """A frame turned by an angle [rad] about an axis of its parent, the world unless one is named."""
        return Frame(name, parent or self.world, axis, sp.sympify(angle))

    def point(self, name: str, base: Point, frame: Frame, x: Scalar = 0, y: Scalar = 0, z: Scalar = 0) -> Point:
        """A point at an offset [m] from another, in components of a frame."""
        return Point(name, base, self.vector(frame, x, y, z))

    def vector(self, frame: Frame, x: Scalar = 0, y: Scalar = 0, z: Scalar = 0) -> Vec:
        """A vector by its components in a frame."""
        return Vec(frame, _triple((x, y, z)))

    def position(self, point: Point, frame: Frame | None = None) -> Vec:
        """A point's place from the origin [m], in components of the world or of a frame."""
        return displacement(self.O, point, frame or self.world)

    def velocity(self, point: Point) -> Vec:
        """A point's velocity in the world [m/s]."""
        return self.motion.derivative(self.position(point))

    def coordinate(self, name: str, unit_: str, meaning: str, equals: Expr | None = None) -> Quantity:
        """A coordinate with its rate ``name_dot`` and its acceleration ``name_ddot``.

        It is what ``equals`` says, or what closed loops determine (`close`, `constrain`).
        """
        value = _quantity(name, unit_, meaning)
        rate = _quantity(f"{name}_dot", _RATES[unit_][0], f"{meaning}, rate")
        acceleration = _quantity(f"{name}_ddot", _RATES[unit_][1], f"{meaning}, acceleration")
        if equals is None:
            self._loops.coordinates.append(Coordinate(value, rate, acceleration))
        else:
            velocity = self.motion.rate(equals)
            self._name(value, equals)
            self._name(rate, velocity)
            self._name(acceleration, self.motion.rate(velocity))
        self.motion.rates |= {value: rate, rate: acceleration}
        return value

    def close(self, first: Point, second: Point, start: Mapping[Quantity, Scalar]) -> None:
        """Two points are one, always; ``start`` says about where coordinates are at the angle zero."""
        gap = displacement(first, second, self.world)
        for axis, component in zip(AXES if self.spatial else AXES[:2], gap.components, strict=False):
            self.constrain(f"{first.name}{axis}", component, start)

    def constrain(self, name: str, gap: Expr, start: Mapping[Quantity, Scalar]) -> None:
        """An expression of coordinates vanishes, always: a rolling, a toothing, a rope."""
        self._loops.gaps[f"gap_{name}"] = gap
        self._loops.start |= {value: sp.sympify(at) for value, at in start.items()}

    # Bodies, joints, forces

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The ground, then every body in the order in which it was stated."""
        return tuple(self._assembly.bodies)

    def body(
        self, name: str, frame: Frame, mass: Quantity | None = None, centroid: Point | None = None,
        inertia: Scalar | Sequence[Scalar] = 0, about: Point | None = None,
    ) -> Body:  # fmt: skip
        """A rigid body that turns with a frame; one without a mass only passes forces on.

        ``inertia`` is that about the centroid: across the plane, or the diagonal of the tensor in the body's frame, or
        its entries xx, yy, zz, xy, xz, yz [kg m2]. Moments are taken about ``about``, else about a joint, the ground's
        before others.
        """
        if (mass is None) != (centroid is None):
            raise MechanismError(f"body {name}: a mass needs a centroid, and a centroid a mass")
        if name in {body.name for body in self._assembly.bodies}:
            raise MechanismError(f"two bodies are called {name}")
        tensor = inertia if isinstance(inertia, Sequence) else (0, 0, inertia)
        parts = (Part(mass, centroid, tuple(map(sp.sympify, tensor))),) if mass is not None and centroid else ()
        body = self._assembly.add(Body(name, frame, parts))
        if about is not None:
            self._about[body] = about
        return body

    def pin(self, name: str, on: Body, by: Body, at: Point, axis: Axis = Z) -> None:
        """A revolute joint about an axis of ``by``'s frame: the force F_name on a body, in space moments M_name too."""
        across = tuple(i for i in range(3) if not axis[i]) if self.spatial else ()
        self._joint(name, on, by, at, range(3 if self.spatial else 2), across)

    def weld(self, name: str, on: Body, by: Body, at: Point) -> None:
        """A rigid joint: every force and every moment."""
        self._joint(name, on, by, at, range(3 if self.spatial else 2), range(3) if self.spatial else (2,))

    def slide(
        self, name: str, on: Body, by: Body, at: Point, along: Axis = X, friction: Scalar = 0,
        origin: Point | None = None,
    ) -> None:  # fmt: skip
        """A prismatic joint along an axis of ``by``'s frame, in the plane: forces N_name across it, moments M_name.

        Coulomb's friction, ``friction`` |N|, acts against the sliding, which is that of ``at`` as it is seen from a
        point fixed in ``by``: from ``origin``, that of the world if ``by`` is the ground.
        """
        if self.spatial:
            raise MechanismError(f"{name}: a slide is a joint of the plane")
        normal = self._unknown(f"N_{name}", "N", f"normal force of {by} on {on} at {at.name}")
        moment = self._unknown(f"M_{name}", "N m", f"moment of {by} on {on} at {at.name}")
        way = unit(by.frame, along)
        force = normal * unit(by.frame, Z).cross(way)
        if friction != 0:
            sliding = self._sliding(name, by, at, way, origin)
            drag = friction * sp.Abs(normal) * switch(sliding, S.One, S.NegativeOne)
            force -= drag * way
            self.report(f"P_{name}", "W", f"power lost to friction at {at.name}", drag * sliding)
        self._assembly.act(name, on, by, at, force, moment * unit(by.frame, Z))

    def motor(self, name: str, on: Body, by: Body, at: Point, axis: Axis = Z) -> Quantity:
        """What keeps the motion: the torque ``name``, about an axis of ``by``'s frame."""
        way = unit(by.frame, axis)
        torque = self._assembly.torque(name, on, by, at, way, f"torque of {by} on {on}, which keeps the motion")
        turning = self.motion.spin(on.frame).resolved(by.frame) - self.motion.spin(by.frame)
        self.report(f"P_{name}", "W", f"power of {name}", torque * turning.dot(way))
        return torque

    def spring(
        self, name: str, on: Body, by: Body, ends: tuple[Point, Point], stiffness: Scalar, length: Scalar,
        damping: Scalar = 0,
    ) -> Quantity:  # fmt: skip
        """A spring between a point of ``on`` and one of ``by``: it pulls by F_name where it is longer than ``length``.

        ``stiffness`` in N/m, ``length`` in m; ``damping``, of the rate of its length, in N s/m.
        """
        line = displacement(*ends, self.world)
        long = self._name(_quantity(f"l_{name}", "m", f"length of {name}"), sp.sqrt(line.dot(line)))
        rate = line.dot(self.motion.derivative(line)) / long
        self.motion.rates[long] = rate
        pull = _quantity(f"F_{name}", "N", f"pull of {name}")
        self._name(pull, stiffness * (long - length) + damping * rate)
        self.force(name, on, ends[0], (pull / long) * line, by)
        return pull

    def force(self, name: str, on: Body, at: Point, force: Vec, by: Body | None = None) -> None:
        """A given force [N] on a body at a point, by another body or by the ground."""
        self._assembly.act(name, on, by or self.ground, at, force)

    def torque(self, name: str, on: Body, by: Body, torque: Expr, axis: Axis = Z) -> None:
        """A given torque [N m] of one body on another, about an axis of ``by``'s frame."""
        self._assembly.act(name, on, by, self.O, zero(by.frame), torque * unit(by.frame, axis))

    # What follows

    def report(self, name: str, unit_: str, meaning: str, expr: Expr) -> Quantity:
        """Name an expression, so that it is told with the results."""
        symbol = _quantity(name, unit_, meaning)
        self._reports.append(_let(symbol, expr))
        return symbol

    def balance(self, body: Body, kind: Kind, axis: str = "z") -> Balance:
        """What an equation may claim to be: a body's balance of forces or moments, along an axis of the world."""
        pin = self._pin(body)
        return Balance(body.name, kind, axis, pin.axes.name, pin.at.name if kind == "moment" else "")

    def equations(self) -> list[Equation]:
        """The laws of contacts, and the balances of every body but the ground."""
        bodies = [body for body in self._assembly.bodies if body != self.ground]
        wanted = None if self.spatial else PLANAR
        found = [e for body in bodies for e in self._assembly.balanced(body, self._pin(body), wanted)]
        return [*self._assembly.definitions(), *found]

    def system(self, reported: Sequence[str | Quantity] | None = None) -> System:
        """The model along the angle: what is reported, everything unless told, from data and the places of loops.

        Raises MechanismError, LoopError, ChainError or DimensionError where it cannot be derived.
        """
        data = Vector("data", tuple(q for q in self.given.values() if q != self.angle))
        motion = self._motion()
        self._report_laws()
        outputs = self._outputs(motion, reported)
        forces = self._forces()
        steps = sorted_steps(needed((*motion, *forces, *self._reports), frozenset(outputs)))
        tested = [s for s in needed((*motion, *forces), frozenset(outputs)) if isinstance(s, LinearSolve)]
        pivots = [s.pivot for s in tested if s.pivot not in self._loops.pivots]
        told = Vector("outputs", (*outputs, *pivots))
        lane = Lane(self.angle, (data,), steps, told, tuple(self._events), along=self._loops.inputs,
                    speed=self.speed)  # fmt: skip
        functions = self._loops.functions(self.angle, data, self._named)
        return System(self.name, self.title, self.source, self.assumptions, lane, functions, self.given.data)

    def _motion(self) -> tuple[Step, ...]:
        """Coordinates, loops, and the accelerations of all centroids, which get names."""
        loops = self._loops.steps(self.motion)
        for body in self._assembly.bodies:
            for part in body.parts:
                self._name_acceleration(body, part.centroid)
        return (*loops, *map(_right, self._named))

    def _name_acceleration(self, body: Body, centroid: Point) -> None:
        if centroid in self.motion.accelerations:
            return
        found = self.motion.acceleration(centroid, self.world)
        names = [
            S.Zero if component == 0 else self._name(
                _quantity(f"a_{_word(body.name)}_{axis}", "m/s2", f"acceleration of the centroid of {body}, {axis}"),
                component)
            for axis, component in zip(AXES, found.components, strict=True)
        ]  # fmt: skip
        self.motion.accelerations[centroid] = Vec(self.world, _triple(names))

    def _forces(self) -> tuple[Step, ...]:
        """The unknown actions from the balances; raises MechanismError where some are left that nothing can keep."""
        equations = self._checked([e for e in self.equations() if e.residual != 0])
        chain = ordered(equations, self._assembly.unknowns, self._assembly.unknowns)
        if left := [e.number for e in equations if e.number not in chain.spent]:
            raise MechanismError(
                f"{self.name}: {len(equations)} balances for {len(self._assembly.unknowns)} forces and torques, so a "
                f"joint or a drive is lacking: nothing is left to keep {'; '.join(left)}"
            )
        return chain.steps()

    def _report_laws(self) -> None:
        self.report("law_power", "W", "power of all forces and of inertia, which vanishes",
                    laws.power(self._assembly, self.ground, self._anchor))  # fmt: skip
        found = laws.momentum(self._assembly, self.ground)
        for axis in AXES if self.spatial else AXES[:2]:
            self.report(
                f"law_force_{axis}", "N", f"rate of momentum less outer forces, {axis}, which vanishes", found[axis]
            )

    def _anchor(self, body: Body) -> Point:
        """A point that is fixed in a body: its centroid, or the point of its first joint."""
        return body.parts[0].centroid if body.parts else self._pin(body).at

    def _outputs(self, motion: Sequence[Step], reported: Sequence[str | Quantity] | None) -> tuple[Quantity, ...]:
        everything = [s.symbol for s in motion if isinstance(s, Let)]
        known = {q.name: q for q in (*everything, *self._loops.all, *self._assembly.unknowns, *self._symbols())}
        if reported is None:
            chosen = (*self._loops.all, *(n.symbol for n in self._named), *self._assembly.unknowns, *self._symbols())
            return tuple(dict.fromkeys(chosen))
        for name in map(str, reported):
            if name not in known:
                close = get_close_matches(name, known, 1)
                hint = f"; did you mean {close[0]}?" if close else f"; there are {', '.join(known)}"
                raise MechanismError(f"{self.name}: nothing is called {name}{hint}")
        return tuple(known[str(name)] for name in reported)

    def _symbols(self) -> list[Quantity]:
        return [report.symbol for report in self._reports]

    def _checked(self, equations: list[Equation]) -> list[Equation]:
        for equation in equations:
            try:
                dimension(equation.residual)
            except DimensionError as error:
                raise DimensionError(f"{equation.number}: {error}") from None
        return equations

    # Names

    def _name(self, symbol: Quantity, expr: Expr) -> Quantity:
        self._named.append(_let(symbol, expr))
        return symbol

    def _unknown(self, name: str, unit_: str, meaning: str) -> Quantity:
        return self._assembly.unknown(name, unit_, meaning)

    def _joint(self, name: str, on: Body, by: Body, at: Point, forces: Iterable[int], moments: Iterable[int]) -> None:
        force, moment = [S.Zero] * 3, [S.Zero] * 3
        for i in forces:
            force[i] = self._unknown(f"F_{name}{AXES[i]}", "N", f"force of {by} on {on} at {at.name}, {AXES[i]}")
        for i in moments:
            meaning = f"moment of {by} on {on} at {at.name}, {AXES[i]} of {by.frame}"
            moment[i] = self._unknown(f"M_{name}{AXES[i]}", "N m", meaning)
        self._assembly.act(name, on, by, at, Vec(self.world, _triple(force)), Vec(by.frame, _triple(moment)))

    def _sliding(self, name: str, by: Body, at: Point, way: Vec, origin: Point | None) -> Quantity:
        """How fast a point slides along a way as it is seen from a body; friction turns round where it stops."""
        if origin is None and by != self.ground:
            raise MechanismError(f"{name}: name the point of {by} that the sliding is counted from, `origin`")
        place = displacement(origin or self.O, at, by.frame)
        sliding = self._name(
            _quantity(f"v_{name}", "m/s", f"sliding at {at.name} on {by}"),
            self.motion.relative_derivative(place, by.frame).dot(way),
        )
        self._events.append(Event(f"sliding of {name} turns", sliding, S.Zero, 0))
        return sliding

    def _pin(self, body: Body) -> Pin:
        """Where a body's moments are taken: where it was told, at a joint (the ground's first), at its centroid."""
        joints = sorted((a for a in self._assembly.actions if a.sign(body)), key=lambda a: not a.sign(self.ground))
        own = [*(a.at for a in joints), *(part.centroid for part in body.parts)]
        at = self._about.get(body) or next(iter(own), None)
        if at is None:
            raise MechanismError(f"body {body.name} has neither a joint nor a mass")
        return Pin(at, self.world, not self.spatial)


def _quantity(name: str, unit_: str, meaning: str) -> Quantity:
    of_unit(unit_)
    return Quantity(name, unit_, meaning, f"derived: {meaning}")


def _let(symbol: Quantity, expr: Expr) -> Let:
    return Let(symbol, sp.sympify(expr), f"derived: {symbol.meaning}")


def _right(let: Let) -> Let:
    """A step whose unit is that of its quantity. Raises DimensionError where it is not."""
    try:
        found = dimension(let.expr)
    except DimensionError as error:
        raise DimensionError(f"{let.symbol}: {error}") from None
    if found is not None and found != of_unit(let.symbol.unit):
        raise DimensionError(f"{let.symbol} is in {let.symbol.unit}, and {let.expr} is not")
    return let


def _triple(components: Sequence[Scalar]) -> Triple:
    x, y, z = map(sp.sympify, components)
    return x, y, z


def _word(name: str) -> str:
    """A name as part of another."""
    return "_".join("".join(c if c.isalnum() else " " for c in name).split())
