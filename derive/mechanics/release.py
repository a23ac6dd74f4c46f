"""A driven mechanism released: a motor line drives it, teeth give way, its frame stands on a mount."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..quantity import Quantities, Quantity
from .bodies import Body, Part
from .contacts import GearContact
from .frames import Axis, Point, Z, unit
from .joints import Scalar
from .loops import Coordinate
from .mechanism import Mechanism
from .statement import MechanismError, quantity


@dataclass(frozen=True)
class ElasticTeeth:
    """Teeth of a mesh that give way: ``coordinate`` names the turning of the outer gear, which they leave free.

    ``law`` and ``backlash`` [m] are those of `Mechanism.compliant_mesh`. The angle of the outer gear must follow the
    coordinate, and `coordinate` must state it by ``equals`` in terms of the inner gear's.
    """

    coordinate: str
    law: Callable[[Expr, Expr], Expr]
    backlash: Scalar = 0


@dataclass(frozen=True)
class FrameMount:
    """Elastic mount of a frame of ``mass`` [kg], which it lets move along x and y, in space also along z.

    ``stiffness`` [N/m] and ``damping`` [N s/m] are those of each direction. The frame does not turn.
    """

    mass: Quantity
    stiffness: Scalar
    damping: Scalar = 0


@dataclass(frozen=True)
class Release:
    """Elements in place of the ideal motor, meshes and frame of a mechanism that an angle drives.

    ``motor`` is the motor line: its torque [N m] at a speed [rad/s]; ``flywheel`` [kg m2] turns with it. ``teeth``, by
    the tags of meshes, give way; other meshes stay as they are stated. The frame is at rest without a ``mount``.
    """

    motor: Callable[[Expr], Expr]
    flywheel: Scalar = 0
    teeth: Mapping[str, ElasticTeeth] = field(default_factory=dict)
    mount: FrameMount | None = None


class ReleasedMechanism(Mechanism):
    r"""A mechanism that is stated as if an angle drove it, and moves freely as ``release`` says.

    The other arguments and all statements are those of `Mechanism`, so that one function states the driven and the
    released mechanism. The angle becomes a coordinate, which starts at zero with the speed of the table under the name
    ``SPEED_start``. `motor` gives the torque of the motor line, `mesh` teeth that give way where ``release.teeth`` says
    so, and points, joints and forces of the ground are those of the frame on the mount: F_mountx and F_mounty [N], in
    space F_mountz, are the force of the ground on it, mount_x and mount_y [m] its places. Freed coordinates start as
    the angle would drive them. Raises MechanismError without an angle, for teeth of an unknown mesh or coordinate (in
    `system`), and for teeth whose coordinate does not turn the outer gear.

    >>> from derive import ElasticTeeth, GearContact, Mechanism, Release, ReleasedMechanism, quantities
    >>> q = quantities('''
    ...     phi   | rad   | pinion
    ...     omega | rad/s | its speed            | 10
    ...     r     | m     | pinion               | 0.02
    ...     R     | m     | wheel                | 0.04
    ...     m     | kg    | wheel                | 1
    ...     J     | kg m2 | each gear            | 1e-4
    ...     alpha | rad   | pressure angle       | 0.35
    ...     K     | N/m   | stiffness            | 1e8
    ...     M_0   | N m   | stall torque         | 4
    ...     W     | rad/s | idle speed           | 12
    ... ''')
    >>> def state(m):
    ...     theta = m.coordinate("theta", "rad", "wheel", equals=-q.phi * q.r / q.R)
    ...     D = m.point("D", m.O, m.world, q.r + q.R)
    ...     pinion = m.body("pinion", m.frame("pinion", q.phi))
    ...     wheel = m.body("wheel", m.frame("wheel", theta), q.m, D, q.J)
    ...     m.pin("O", pinion, m.ground, m.O)
    ...     m.pin("D", wheel, m.ground, D)
    ...     m.mesh("P", pinion, wheel, GearContact(m.world, D, q.R, q.alpha))
    ...     m.motor("M_in", pinion, m.ground, m.O)
    ...     return m
    >>> line = Release(
    ...     motor=lambda speed: q.M_0 * (1 - speed / q.W), flywheel=q.J,
    ...     teeth={"P": ElasticTeeth("theta", lambda depth, rate: q.K * depth)},
    ... )
    >>> driven = state(Mechanism("driven", q, angle=q.phi, speed=q.omega))
    >>> released = state(ReleasedMechanism("released", q, line, angle=q.phi, speed=q.omega))
    >>> driven.unknowns
    [F_Ox, F_Oy, F_Dx, F_Dy, M_P, F_NP, F_Px, F_Py, M_in]
    >>> released.start
    {phi: 0, omega: omega_start, theta: 0, theta_dot: -omega_start*r/R}
    """

    def __init__(
        self, name: str, table: Quantities, release: Release, *, angle: Quantity, speed: Quantity,
        acceleration: Quantity | None = None, **stated: object,
    ) -> None:  # fmt: skip
        Mechanism(name, table, angle=angle, speed=speed, acceleration=acceleration)  # refuses another unit
        begun = Quantity(
            f"{speed}_start", speed.unit, f"{speed.meaning}, at the start", speed.source,
            speed.shown.replace(f"{speed}_", f"{speed}_start_", 1),
        )  # fmt: skip
        states = {angle.name, speed.name} | ({acceleration.name} if acceleration is not None else set())
        remaining = {key: q for key, q in table.items() if key not in states} | {begun.name: begun}
        data = {key: datum for key, datum in table.data.items() if key not in states}
        data |= {begun.name: table.data[speed.name]} if speed.name in table.data else {}
        super().__init__(name, Quantities(remaining, data), **stated)  # type: ignore[arg-type]
        change = acceleration or quantity(f"{angle}_ddot", "rad/s2", f"{angle.meaning}, acceleration")
        self.loops.coordinates.append(Coordinate(angle, speed, change))
        self.motion.rates |= {angle: speed, speed: change}
        self.begin({angle: S.Zero, speed: begun})
        self.release, self._driven = release, dict[str, tuple[Quantity, Expr]]()
        self._freed = {teeth.coordinate for teeth in release.teeth.values()}
        if release.mount is not None:
            self._mount(release.mount)

    def _mount(self, mount: FrameMount) -> None:
        """Let the frame and its points move on the mount."""
        places = [self.coordinate(f"mount_{axis}", "m", f"place of the frame, {axis}") for axis in self.axes]
        self.O = self.point("frame", self.origin, self.world, *places)
        self.ground = self.body("frame", self.world, mount.mass, self.O)
        ends = self.O, self.origin
        self.bushing("mount", self.ground, self.earth, ends, mount.stiffness, mount.damping)
        self._joint("mount", self.ground, self.earth, self.O, (), range(3) if self.spatial else (2,))

    def follow(
        self, symbols: tuple[Quantity, Quantity, Quantity], equals: Expr | None = None, at_start: Expr | None = None
    ) -> Quantity:
        """State a coordinate as `Mechanism.follow` does; one that teeth leave free starts as ``equals`` says."""
        value, rate, _ = symbols
        if equals is None or value.name not in self._freed:
            super().follow(symbols, equals, at_start)
            if equals is not None:  # in the rates of what is free, so that ratios of speeds cancel
                self.motion.rates[value] = self.motion.rate(sp.sympify(equals))
            return value
        self._driven[value.name] = value, sp.sympify(equals)
        self.begin({value: self._at_start(equals), rate: self._at_start(self.motion.rate(equals))})
        return super().follow(symbols)

    def _at_start(self, expr: Expr) -> Expr:
        """Return an expression of the motion at the start."""
        for step in reversed(self.named):
            expr = expr.xreplace({step.symbol: step.expr})
        return expr.xreplace(self.start)

    def motor(self, name: str, on: Body, by: Body, at: Point, axis: Axis = Z) -> Quantity:
        """State the motor by its line, with its flywheel, and return its torque; the rest is as `Mechanism.motor`."""
        way = unit(by.frame, axis)
        turning = (self.motion.spin(on.frame).resolved(by.frame) - self.motion.spin(by.frame)).dot(way)
        torque = self.name_(name, "N m", f"torque of {by} on {on}, by the motor line", self.release.motor(turning))
        self.torque(name, on, by, torque, axis)
        if self.release.flywheel != 0:
            inertia = tuple(sp.sympify(self.release.flywheel) * abs(a) for a in axis)
            flywheel = self.assembly.add(Body("flywheel", on.frame, (Part(S.Zero, at, inertia),)))
            self.weld("flywheel", flywheel, on, at)
        self.report(f"P_{name}", "W", f"power of {name}", torque * turning)
        return torque

    def mesh(
        self, tag: str, inner: Body, outer: Body, contact: GearContact, equal_to: Quantity | None = None
    ) -> Quantity:
        """State teeth as `Mechanism.mesh` does, or teeth that give way and part where the release says so.

        Of the latter F_Ntag [N] is returned, and the load on several planets follows from them, not from ``equal_to``.
        """
        teeth = self.release.teeth.get(tag)
        if teeth is None:
            return super().mesh(tag, inner, outer, contact, equal_to)
        if teeth.coordinate not in self._driven:
            raise MechanismError(f"teeth {tag}: no coordinate {teeth.coordinate} is stated by `equals`")
        value, equals = self._driven[teeth.coordinate]
        rate = self.motion.rates[value]
        turns = [self.motion.spin(body.frame)[2].diff(rate) for body in (inner, outer)]
        if turns != [0, 1]:
            raise MechanismError(f"teeth {tag}: {value} must turn {outer}, the outer gear, and not {inner}")
        return self.compliant_mesh(tag, inner, outer, contact, equals - value, teeth.law, teeth.backlash)
