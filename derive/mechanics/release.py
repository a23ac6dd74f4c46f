"""A driven mechanism released: a motor line, compliant teeth, pins and followers that can separate,
a mount.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..functions import switch
from ..model import System
from ..quantity import Quantities, Quantity
from .bodies import Body, Part
from .contacts import GearContact
from .frames import Axis, Frame, Point, Vec, Z, displacement, unit
from .joints import Scalar
from .loops import Coordinate
from .mechanism import Mechanism
from .statement import MechanismError, quantity, to_triple


@dataclass(frozen=True)
class ElasticTeeth:
    """Compliant teeth of a mesh: ``coordinate`` names the turning of the outer gear, which they
    leave free.

    ``law`` and ``backlash`` [m] are those of `Mechanism.compliant_mesh`. The angle of the outer
    gear must follow the coordinate, and `coordinate` must state it by ``equals`` in terms of the
    inner gear's.
    """

    coordinate: str
    law: Callable[[Expr, Expr], Expr]
    backlash: Scalar = 0


@dataclass(frozen=True)
class LoosePin:
    """A pin with radial ``clearance`` [m] in its bush, where a loop is closed: ``loop`` is the name
    given by `close`.

    The other arguments are those of `Mechanism.compliant_contact`. The pin must be stated after its
    loop.
    """

    loop: str
    clearance: Scalar
    law: Callable[[Expr, Expr], Expr]
    friction: Scalar = 0
    creep: Scalar = 0


@dataclass(frozen=True)
class LiftingFollower:
    """A compliant follower that can lift off: ``coordinate`` names its lift, which is left free.

    ``law`` is the force along the normal [N] of the depth [m] and its rate [m/s]. The lift must be
    stated by ``equals`` in terms of the driving angle.
    """

    coordinate: str
    law: Callable[[Expr, Expr], Expr]


@dataclass(frozen=True)
class FrameMount:
    """Elastic mount of a frame of ``mass`` [kg], which it lets move along x and y, in space also
    along z.

    ``stiffness`` [N/m] and ``damping`` [N s/m] are those of each direction. The frame does not
    turn.
    """

    mass: Quantity
    stiffness: Scalar
    damping: Scalar = 0


@dataclass(frozen=True)
class Release:
    """Elements in place of the ideal motor, contacts, pins and frame of a mechanism that an angle
    drives.

    ``motor`` is the motor line: its torque [N m] at a speed [rad/s]; ``flywheel`` [kg m2] turns
    with it. ``teeth`` by the tags of meshes, ``pins`` and ``followers`` by their names are
    compliant; the others stay as they are stated. The frame is at rest without a ``mount``.
    """

    motor: Callable[[Expr], Expr]
    flywheel: Scalar = 0
    teeth: Mapping[str, ElasticTeeth] = field(default_factory=dict)
    pins: Mapping[str, LoosePin] = field(default_factory=dict)
    followers: Mapping[str, LiftingFollower] = field(default_factory=dict)
    mount: FrameMount | None = None


class ReleasedMechanism(Mechanism):
    r"""A mechanism that is stated as if an angle drove it, and moves freely as ``release`` says.

    The other arguments and all statements are those of `Mechanism`, so that one function states the
    driven and the released mechanism. The angle becomes a coordinate, which starts at zero with the
    speed of the table under the name ``SPEED_start``. `motor` gives the torque of the motor line;
    meshes, pins and followers are compliant where ``release`` says so, and a loop whose pin is
    loose stays open. Points, joints and forces of the ground are those of the frame on the mount:
    F_mountx and F_mounty [N], in space F_mountz, are the force of the ground on it, mount_x and
    mount_y [m] its places. The motion starts at the angle zero as the angle would drive it, with
    loose pins in the middle of their bushes. Raises MechanismError without an angle, for teeth,
    pins and followers that are not stated or whose coordinate or loop is not (in `system`), and for
    a coordinate that does not move the compliant element.

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
    {phi: 0, omega: omega_start, theta: 0}
    >>> list(released.start_conditions)
    ['phi', 'theta']
    """

    def __init__(
        self,
        name: str,
        table: Quantities,
        release: Release,
        *,
        angle: Quantity,
        speed: Quantity,
        acceleration: Quantity | None = None,
        **stated: object,
    ) -> None:
        Mechanism(
            name, table, angle=angle, speed=speed, acceleration=acceleration
        )  # refuses another unit
        begun = Quantity(
            f"{speed}_start",
            speed.unit,
            f"{speed.meaning}, at the start",
            speed.source,
            speed.shown.replace(f"{speed}_", f"{speed}_start_", 1),
        )
        states = {angle.name, speed.name} | (
            {acceleration.name} if acceleration is not None else set()
        )
        remaining = {key: q for key, q in table.items() if key not in states} | {begun.name: begun}
        data = {key: datum for key, datum in table.data.items() if key not in states}
        data |= {begun.name: table.data[speed.name]} if speed.name in table.data else {}
        super().__init__(name, Quantities(remaining, data), **stated)  # type: ignore[arg-type]
        change = acceleration or quantity(
            f"{angle}_ddot", "rad/s2", f"{angle.meaning}, acceleration"
        )
        self.loops.coordinates.append(Coordinate(angle, speed, change))
        self.motion.rates |= {angle: speed, speed: change}
        self.begin({angle: S.Zero, speed: begun})
        self.start_conditions[angle.name] = angle, speed - begun
        self.release, self._driving, self._begun = release, (angle, speed), begun
        self._driven = dict[str, tuple[Quantity, Expr]]()
        self._open, self._compliant = dict[str, tuple[Point, Point]](), set[str]()
        self._freed = {teeth.coordinate for teeth in release.teeth.values()}
        self._freed |= {follower.coordinate for follower in release.followers.values()}
        self._opened = {pin.loop for pin in release.pins.values()}
        if release.mount is not None:
            self._mount(release.mount)

    def _mount(self, mount: FrameMount) -> None:
        """Let the frame and its points move on the mount."""
        places = [
            self.coordinate(f"mount_{axis}", "m", f"place of the frame, {axis}")
            for axis in self.axes
        ]
        for place in places:
            self._start_with(place.name, place)
        self.O = self.point("frame", self.origin, self.world, *places)
        self.ground = self.body("frame", self.world, mount.mass, self.O)
        ends = self.O, self.origin
        self.bushing("mount", self.ground, self.earth, ends, mount.stiffness, mount.damping)
        self._joint(
            "mount", self.ground, self.earth, self.O, (), range(3) if self.spatial else (2,)
        )

    def follow(
        self,
        symbols: tuple[Quantity, Quantity, Quantity],
        equals: Expr | None = None,
        at_start: Expr | None = None,
    ) -> Quantity:
        """State a coordinate as `Mechanism.follow` does; one that is left free starts as ``equals``
        says.
        """
        value = symbols[0]
        if equals is None or value.name not in self._freed:
            super().follow(symbols, equals, at_start)
            if equals is not None:  # in the rates of what is free, so that ratios of speeds cancel
                self.motion.rates[value] = self.motion.rate(sp.sympify(equals))
            return value
        self._driven[value.name] = value, sp.sympify(equals)
        super().follow(symbols)
        self._start_with(value.name, value - sp.sympify(equals))
        for step in reversed(self.named):
            equals = equals.xreplace({step.symbol: step.expr})
        self.begin({value: equals.xreplace(self.start)})
        return value

    def _start_with(self, name: str, gap: Expr) -> None:
        """Let the motion start with a gap that is closed and stays so."""
        self.start_conditions[name] = gap, self.motion.rate(gap)

    def close(self, first: Point, second: Point, start: Mapping[Quantity, Scalar]) -> None:
        """Close a loop as `Mechanism.close` does, one whose pin is loose at the start only."""
        if first.name not in self._opened:
            super().close(first, second, start)
            return
        self._open[first.name] = first, second
        self.begin(start)
        for axis, gap in zip(
            self.axes, displacement(first, second, self.world).components, strict=False
        ):
            self._start_with(f"{first.name}{axis}", gap)

    def pin(
        self, name: str, on: Body, by: Body, at: Point, axis: Axis = Z, axes: Frame | None = None
    ) -> None:
        """State a revolute joint as `Mechanism.pin` does, or a pin in a bush that is wider where
        the release says so.

        Of the latter the results are those of `Mechanism.compliant_contact`, and F_namex and
        F_namey [N], the force of ``by`` on ``on`` along the axes of the world.
        """
        loose = self.release.pins.get(name)
        if loose is None:
            super().pin(name, on, by, at, axis, axes)
            return
        self._in_plane(f"pin {name}")
        if loose.loop not in self._open:
            raise MechanismError(f"pin {name}: no loop {loose.loop} is closed before it")
        ends = self._open[loose.loop]
        pairs = [
            pair
            for pair in (ends, ends[::-1])
            if self._carries(on, pair[0]) and self._carries(by, pair[1])
        ]
        if not pairs:
            raise MechanismError(
                f"pin {name}: the points of the loop {loose.loop} are not fixed in {on} and {by}"
            )
        (point, bush), width = pairs[0], -sp.sympify(loose.clearance)
        self.compliant_contact(
            name,
            on,
            by,
            point,
            bush,
            loose.law,
            radius=width,
            friction=loose.friction,
            creep=loose.creep,
        )
        self._report_force(f"F_{name}", self.assembly.actions[-1].force)
        self._compliant.add(name)

    def _report_force(self, name: str, force: Vec) -> None:
        """Report a force along the axes of the world."""
        for axis, component in zip(self.axes, force.resolved(self.world).components, strict=False):
            self.report(f"{name}{axis}", "N", f"{name}, {axis}", component)

    def _in_plane(self, name: str) -> None:
        if self.spatial:
            raise MechanismError(f"{name}: is compliant in the plane only")

    def motor(self, name: str, on: Body, by: Body, at: Point, axis: Axis = Z) -> Quantity:
        """State the motor by its line, with its flywheel, and return its torque; the rest is as
        `Mechanism.motor`.
        """
        way = unit(by.frame, axis)
        turning = (self.motion.spin(on.frame).resolved(by.frame) - self.motion.spin(by.frame)).dot(
            way
        )
        torque = self.name_(
            name, "N m", f"torque of {by} on {on}, by the motor line", self.release.motor(turning)
        )
        self.torque(name, on, by, torque, axis)
        if self.release.flywheel != 0:
            inertia = tuple(sp.sympify(self.release.flywheel) * abs(a) for a in axis)
            flywheel = self.assembly.add(Body("flywheel", on.frame, (Part(S.Zero, at, inertia),)))
            self.weld("flywheel", flywheel, on, at)
        self.report(f"P_{name}", "W", f"power of {name}", torque * turning)
        return torque

    def mesh(
        self,
        tag: str,
        inner: Body,
        outer: Body,
        contact: GearContact,
        equal_to: Quantity | None = None,
    ) -> Quantity:
        """State teeth as `Mechanism.mesh` does, or compliant teeth that can separate where the
        release says so.

        Of the latter F_Ntag [N] is returned, and the load on several planets follows from them, not
        from ``equal_to``.
        """
        teeth = self.release.teeth.get(tag)
        if teeth is None:
            return super().mesh(tag, inner, outer, contact, equal_to)
        value, equals = self._find_driven(f"teeth {tag}", teeth.coordinate)
        rate = self.motion.rates[value]
        turns = [self.motion.spin(body.frame)[2].diff(rate) for body in (inner, outer)]
        if turns != [0, 1]:
            raise MechanismError(
                f"teeth {tag}: {value} must turn {outer}, the outer gear, and not {inner}"
            )
        self._compliant.add(tag)
        return self.compliant_mesh(
            tag, inner, outer, contact, equals - value, teeth.law, teeth.backlash
        )

    def _find_driven(self, name: str, coordinate: str) -> tuple[Quantity, Expr]:
        """Return a coordinate that is left free, and what the angle would make of it."""
        if coordinate not in self._driven:
            raise MechanismError(f"{name}: no coordinate {coordinate} is stated by `equals`")
        return self._driven[coordinate]

    def follower(
        self,
        name: str,
        on: Body,
        cam: Body,
        at: Point,
        cam_axis: Point,
        friction: Expr = S.Zero,
        across: Vec | None = None,
        rubbing: Expr = S.Zero,
        radius: Expr = S.Zero,
    ) -> Quantity:
        """State a follower as `Mechanism.follower` does, or one that can lift off where the release
        says so.

        Of the latter ``gap_name`` [m] is how far the lift is above what the cam gives it, along the
        normal of the path that the angle would drive it on, negative at a depth; ``name`` is the
        size of the force, ``namex`` and its like are along the axes of the world. An event marks
        where the gap opens or closes. The force has the potential of the gap: without damping the
        energy is constant, and at small gaps it is along the normal. Raises MechanismError in
        space, with friction, and if the roller moves on the cam other than by the driving angle and
        its lift.
        """
        lifting = self.release.followers.get(name)
        if lifting is None:
            return super().follower(name, on, cam, at, cam_axis, friction, across, rubbing, radius)
        self._in_plane(f"follower {name}")
        if friction != 0:
            raise MechanismError(f"follower {name}: lifts off without friction only")
        value, equals = self._find_driven(f"follower {name}", lifting.coordinate)
        (angle, speed), lift_rate, across = (
            self._driving,
            self.motion.rates[value],
            across or unit(self.world, Z),
        )
        velocity = self.motion.relative_derivative(
            displacement(cam_axis, at, across.frame), cam.frame
        )
        by_angle, by_lift = (
            Vec(velocity.frame, to_triple([c.diff(rate) for c in velocity.components]))
            for rate in (speed, lift_rate)
        )
        path = by_angle + self.motion.rate(equals).diff(speed) * by_lift
        normal = (switch(self._begun, 1, -1) / sp.sqrt(path.dot(path))) * path.cross(across)
        distance = normal.dot(by_lift) * (value - equals)
        gap = self.name_(f"gap_{name}", "m", f"distance of {on} from {cam} at {at.name}", distance)
        opening = self.motion.rate(distance)
        rest = [
            *(velocity - speed * by_angle - lift_rate * by_lift).components,
            opening.subs({speed: 0, lift_rate: 0}),
        ]
        if any(sp.simplify(term) != 0 for term in rest):
            raise MechanismError(
                f"follower {name}: moves on {cam} with more than {angle} and {value}"
            )
        law = self._push_at(gap, opening, lifting.law, f"contact of {name}")
        push = self.name_(name, "N", f"contact force of {cam} on {on} at {at.name}", law)
        turned = by_lift.cross(across)  # the force whose power is that of the gap, by both rates
        way = opening.diff(speed) * turned - opening.diff(lift_rate) * by_angle.cross(across)
        way = (1 / by_angle.dot(turned)) * way
        self.force(name, on, at, push * way, cam)
        self._report_force(name, push * way)
        self.report(f"P_{name}", "W", f"power of {name} on {on} and {cam}", push * opening)
        self._compliant.add(name)
        return push

    def system(self, reported: Sequence[str | Quantity] | None = None) -> System:
        """Derive the model as `Mechanism.system` does.

        Raises MechanismError also for an element that is not stated.
        """
        release = self.release
        if lacking := sorted({*release.teeth, *release.pins, *release.followers} - self._compliant):
            raise MechanismError(
                f"{self.name}: {', '.join(lacking)} should be compliant and is not stated"
            )
        return super().system(reported)
