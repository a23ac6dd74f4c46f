"""A mechanism as it is drawn: frames, points, bodies, joints, forces. What follows from them is derived."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import sympy as sp
from sympy import Expr, S

from ..branches import switch
from ..model import Event, System
from ..quantity import Quantity
from ..table import Quantities
from . import moving, turning
from .bodies import AXES, Body, Part
from .frames import Axis, Frame, Motion, Point, Vec, X, Z, displacement, unit, zero
from .loops import Coordinate
from .statement import MechanismError, Statement, let, quantity, triple

Scalar: TypeAlias = Expr | float
TIME = Quantity("time", "s", "time", "given")
_RATES = {"rad": ("rad/s", "rad/s2"), "m": ("m/s", "m/s2"), "1": ("1/s", "1/s2")}


class Mechanism(Statement):
    """Bodies that move along ``angle``, which turns at the constant ``speed``, or by themselves where none is given.

    They move in the plane across z unless ``spatial``. ``given`` is the table of all quantities; ``gravity`` the
    acceleration of free fall, along -y of the world, or its components there. Lengths in m, angles in rad. Every name
    becomes a name in the generated code.
    """

    def __init__(
        self,
        name: str,
        given: Quantities,
        *,
        angle: Quantity | None = None,
        speed: Quantity | None = None,
        gravity: Scalar | Sequence[Scalar] = 0,
        title: str = "",
        source: str = "own",
        assumptions: Iterable[str] = (),
        spatial: bool = False,
    ) -> None:
        if (angle is None) != (speed is None):
            raise MechanismError(f"{name}: an angle to move along needs its speed, and a speed an angle")
        fall = gravity if isinstance(gravity, Sequence) else (0, -gravity, 0)
        motion = Motion({TIME: S.One} if angle is None else {angle: speed})
        super().__init__(name, given, motion, fall, spatial)
        self.title, self.source, self.angle, self.speed = (
            title or name.replace("_", " ").capitalize(),
            source,
            angle,
            speed,
        )
        steady = (f"constant: {speed.meaning}",) if speed is not None else ()
        self.assumptions = ("rigid bodies", *steady, *assumptions)

    @property
    def time(self) -> Quantity:
        """Time [s], for what is prescribed to a mechanism that moves by itself."""
        return TIME

    # Geometry and motion
    def frame(self, name: str, angle: Scalar, axis: Axis = Z, parent: Frame | None = None) -> Frame:
        """A frame turned by an angle [rad] about an axis of its parent, the world unless one is named."""
        return Frame(name, parent or self.world, axis, sp.sympify(angle))

    def point(self, name: str, base: Point, frame: Frame, x: Scalar = 0, y: Scalar = 0, z: Scalar = 0) -> Point:
        """A point at an offset [m] from another, in components of a frame."""
        return Point(name, base, self.vector(frame, x, y, z))

    def vector(self, frame: Frame, x: Scalar = 0, y: Scalar = 0, z: Scalar = 0) -> Vec:
        """A vector by its components in a frame."""
        return Vec(frame, triple((x, y, z)))

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
        value = quantity(name, unit_, meaning)
        rate = quantity(f"{name}_dot", _RATES[unit_][0], f"{meaning}, rate")
        acceleration = quantity(f"{name}_ddot", _RATES[unit_][1], f"{meaning}, acceleration")
        if equals is None:
            self.loops.coordinates.append(Coordinate(value, rate, acceleration))
        else:
            velocity = self.motion.rate(equals)
            self.named += [let(value, equals), let(rate, velocity), let(acceleration, self.motion.rate(velocity))]
        self.motion.rates |= {value: rate, rate: acceleration}
        return value

    def close(self, first: Point, second: Point, start: Mapping[Quantity, Scalar]) -> None:
        """Two points are one, always; ``start`` says about where coordinates are at the angle zero."""
        gap = displacement(first, second, self.world)
        for axis, component in zip(AXES if self.spatial else AXES[:2], gap.components, strict=False):
            self.constrain(f"{first.name}{axis}", component, start)

    def constrain(self, name: str, gap: Expr, start: Mapping[Quantity, Scalar]) -> None:
        """An expression of coordinates vanishes, always: a rolling, a toothing, a rope."""
        if f"gap_{name}" in self.loops.gaps:
            raise MechanismError(f"two loops are called {name}")
        self.loops.gaps[f"gap_{name}"] = gap
        self.loops.start |= {value: sp.sympify(at) for value, at in start.items()}

    def roll(self, name: str, slip: Expr) -> None:
        """A speed vanishes, always, that is no rate of a gap: a wheel rolls, a blade does not slip. In free motion."""
        self.slips[f"slip_{name}"] = slip

    def begin(self, start: Mapping[Quantity, Scalar]) -> None:
        """What coordinates, or their rates (``motion.rates``), are at the start of free motion; zero unless told."""
        self.start |= {q: sp.sympify(at) for q, at in start.items()}

    def rate(self, expr: Expr) -> Expr:
        """Rate of an expression of coordinates."""
        return self.motion.rate(expr)

    # Bodies, joints, forces

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The ground, then every body in the order in which it was stated."""
        return tuple(self.assembly.bodies)

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
        if name in {body.name for body in self.assembly.bodies}:
            raise MechanismError(f"two bodies are called {name}")
        tensor = inertia if isinstance(inertia, Sequence) else (0, 0, inertia)
        parts = (Part(mass, centroid, tuple(map(sp.sympify, tensor))),) if mass is not None and centroid else ()
        body = self.assembly.add(Body(name, frame, parts))
        if about is not None:
            self.about[body] = about
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
        normal = self.assembly.unknown(f"N_{name}", "N", f"normal force of {by} on {on} at {at.name}")
        moment = self.assembly.unknown(f"M_{name}", "N m", f"moment of {by} on {on} at {at.name}")
        way = unit(by.frame, along)
        force = normal * unit(by.frame, Z).cross(way)
        if friction != 0:
            sliding = self._sliding(name, by, at, way, origin)
            drag = friction * sp.Abs(normal) * switch(sliding, S.One, S.NegativeOne)
            force -= drag * way
            self.report(f"P_{name}", "W", f"power lost to friction at {at.name}", drag * sliding)
        self.assembly.act(name, on, by, at, force, moment * unit(by.frame, Z))

    def motor(self, name: str, on: Body, by: Body, at: Point, axis: Axis = Z) -> Quantity:
        """What keeps the motion: the torque ``name``, about an axis of ``by``'s frame."""
        way = unit(by.frame, axis)
        torque = self.assembly.torque(name, on, by, at, way, f"torque of {by} on {on}, which keeps the motion")
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
        long = self.name_(f"l_{name}", "m", f"length of {name}", sp.sqrt(line.dot(line)))
        rate = line.dot(self.motion.derivative(line)) / long
        self.motion.rates[long] = rate
        pull = self.name_(f"F_{name}", "N", f"pull of {name}", stiffness * (long - length) + damping * rate)
        self.potentials.append(stiffness * (long - length) ** 2 / 2)
        self.force(name, on, ends[0], (pull / long) * line, by)
        return pull

    def force(self, name: str, on: Body, at: Point, force: Vec, by: Body | None = None) -> None:
        """A given force [N] on a body at a point, by another body or by the ground."""
        self.assembly.act(name, on, by or self.ground, at, force)

    def torque(self, name: str, on: Body, by: Body, torque: Expr, axis: Axis = Z) -> None:
        """A given torque [N m] of one body on another, about an axis of ``by``'s frame."""
        self.assembly.act(name, on, by, self.O, zero(by.frame), torque * unit(by.frame, axis))

    # What follows

    def system(self, reported: Sequence[str | Quantity] | None = None) -> System:
        """The model: what is reported (everything, unless told) along the angle, or what an integrator needs.

        Raises MechanismError, LoopError, ChainError or DimensionError where it cannot be derived.
        """
        if self.angle is not None and self.speed is not None:
            lane, functions = turning.along(self, self.angle, self.speed, reported)
            return System(self.name, self.title, self.source, self.assumptions, lane, functions, self.given.data)
        functions = moving.freely(self, TIME, reported)
        return System(self.name, self.title, self.source, self.assumptions, None, functions, self.given.data)

    def _joint(self, name: str, on: Body, by: Body, at: Point, forces: Iterable[int], moments: Iterable[int]) -> None:
        force, moment = [S.Zero] * 3, [S.Zero] * 3
        for i in forces:
            force[i] = self.assembly.unknown(
                f"F_{name}{AXES[i]}", "N", f"force of {by} on {on} at {at.name}, {AXES[i]}"
            )
        for i in moments:
            meaning = f"moment of {by} on {on} at {at.name}, {AXES[i]} of {by.frame}"
            moment[i] = self.assembly.unknown(f"M_{name}{AXES[i]}", "N m", meaning)
        self.assembly.act(name, on, by, at, Vec(self.world, triple(force)), Vec(by.frame, triple(moment)))

    def _sliding(self, name: str, by: Body, at: Point, way: Vec, origin: Point | None) -> Quantity:
        """How fast a point slides along a way as it is seen from a body; friction turns round where it stops."""
        if origin is None and by != self.ground:
            raise MechanismError(f"{name}: name the point of {by} that the sliding is counted from, `origin`")
        place = displacement(origin or self.O, at, by.frame)
        speed = self.motion.relative_derivative(place, by.frame).dot(way)
        sliding = self.name_(f"v_{name}", "m/s", f"sliding at {at.name} on {by}", speed)
        self.events.append(Event(f"sliding of {name} turns", sliding, S.Zero, 0))
        return sliding
