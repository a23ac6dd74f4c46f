"""Bodies of a mechanism, the joints between them, springs and forces."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Literal, TypeAlias

import sympy as sp
from sympy import Expr, S

from ..functions import switch
from ..model import Event
from ..quantity import Quantity
from .bodies import AXES, SHAFT, Body, Part, Pin
from .contacts import Contacts, GearContact, slope_by_turning, turning_rate
from .frames import Axis, Frame, Point, Vec, X, Y, Z, displacement, unit, zero
from .impact import creeping
from .statement import Element, MechanismError, to_triple

Scalar: TypeAlias = Expr | float


CENTRE = sp.Rational(1, 10**9)
"""Nearer to its centre than this share of the radius, a round surface has no normal."""


class Joints(Contacts):
    """Bodies of a mechanism, the joints between them, springs, motors and forces."""

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The ground, then every body in the order in which it was stated; bodies have no unit."""
        return tuple(self.assembly.bodies)

    def body(
        self,
        name: str,
        frame: Frame,
        mass: Quantity | None = None,
        centroid: Point | None = None,
        inertia: Scalar | Sequence[Scalar] = 0,
        about: Point | None = None,
        *,
        parts: Sequence[Part] = (),
        axes: Frame | None = None,
        tilting: bool = True,
        shared: bool = False,
    ) -> Body:
        r"""Return a rigid body that turns with ``frame``; without ``mass`` [kg] it only passes
        forces on.

        A mass needs a ``centroid``, a point.

        ``inertia`` [kg m2] is about the centroid, along the axes of the body's frame: in the plane
        the moment about z, in space the diagonal xx, yy, zz of the tensor or its entries xx, yy,
        zz, xy, xz, yz, with products of inertia as they stand in the tensor: xy is minus the
        integral of x y dm. ``parts`` are further rigid pieces (`derive.Part`).

        Moments are balanced about ``about``, else about a joint, the ground's before others, else
        about the centroid. With ``about``, balances are along ``axes``, the world's unless they are
        passed, and in space those of moments about x and y are left out unless ``tilting``. A
        ``shared`` body belongs to two equal sides (`twin_lane`). Raises MechanismError for a mass
        without a centroid or the reverse, for an inertia without them, or for a second body of the
        name.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("m | kg | mass | 2\nJ | kg m2 | about the centroid | 0.01\nl | m | centroid | 0.3")
        >>> m = Mechanism("beam", q)
        >>> beam = m.body("beam", m.world, mass=q.m, centroid=m.point("C", m.O, m.world, q.l), inertia=q.J)
        >>> [part.inertia for part in beam.parts]
        [(0, 0, J)]
        """
        if (mass is None) != (centroid is None):
            raise MechanismError(f"body {name}: a mass needs a centroid, and a centroid a mass")
        if inertia != 0 and mass is None:
            raise MechanismError(f"body {name}: an inertia needs a mass and a centroid")
        if name in {body.name for body in self.assembly.bodies}:
            raise MechanismError(f"two bodies are called {name}")
        tensor = inertia if isinstance(inertia, Sequence) else (0, 0, inertia)
        first_part = (
            (Part(mass, centroid, tuple(map(sp.sympify, tensor))),)
            if mass is not None and centroid
            else ()
        )
        pin = (
            None
            if about is None
            else Pin(about, axes or self.world, self._default_balances if tilting else SHAFT)
        )
        body = self.assembly.add(Body(name, frame, (*first_part, *parts), pin))
        self.shared += [body] if shared else []
        return body

    def pin(
        self, name: str, on: Body, by: Body, at: Point, axis: Axis = Z, axes: Frame | None = None
    ) -> None:
        r"""State a revolute joint at a point, about ``axis`` of ``by``'s frame; in the plane the
        axis is z.

        F_namex, F_namey (in space F_namez) [N] are the force of ``by`` on ``on``, along the axes of
        the world, or of the frame ``axes``; with ``axes``, F_name_world_x and its like are reported
        as well. In space M_name with the axis, as M_namex [N m], are the moments of ``by`` on
        ``on`` across the axis, along the axes of ``by``'s frame, unless these are left out of the
        balances of ``on`` (`body`); M_name_world_x and its like are along the world's.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("g | m/s2 | free fall | 9.81\nm | kg | mass | 2\nl | m | centroid | 0.3\nT | N m | load | 1")
        >>> m = Mechanism("beam", q, gravity=q.g)
        >>> beam = m.body("beam", m.world, q.m, m.point("C", m.O, m.world, q.l))
        >>> m.pin("A", beam, m.ground, m.O)
        >>> m.torque("load", beam, m.ground, q.T)
        >>> [equation.residual for equation in m.equations()]
        [F_Ax, F_Ay - g*m, T - g*l*m]
        """
        tilting = self.spatial and (on.pin is None or on.pin.asked != SHAFT)
        self._joint(name, on, by, at, self._directions, _across(axis) if tilting else (), axes)

    def weld(self, name: str, on: Body, by: Body, at: Point) -> None:
        """State a rigid joint: all forces and moments of ``by`` on ``on`` at a point.

        F_namex, F_namey, in space F_namez, [N] are along the axes of the world, M_namez, in space
        also M_namex and M_namey, [N m] along those of ``by``'s frame (in space also M_name_world_x
        and its like). Example: `equations`.
        """
        self._joint(name, on, by, at, self._directions, range(3) if self.spatial else (2,))

    def ball(self, name: str, on: Body, by: Body, at: Point) -> None:
        """State a spherical joint: the force F_name [N] of ``by`` on ``on`` and no moment.

        Its components F_namex, F_namey, in space F_namez, are along the axes of the world.

        >>> from derive import Mechanism, X, Y, Z
        >>> m = Mechanism("joints", spatial=True)
        >>> body = m.body("body", m.world)
        >>> m.ball("A", body, m.ground, m.O)
        >>> m.universal("B", body, m.ground, m.O, X, Y)
        >>> m.cylinder("C", body, m.ground, m.O, Z)
        >>> m.plane("D", body, m.ground, m.O, normal=Z)
        >>> m.unknowns
        [F_Ax, F_Ay, F_Az, F_Bx, F_By, F_Bz, M_B, F_Cx, F_Cy, M_Cx, M_Cy, F_Dz, M_Dx, M_Dy]
        """
        self._joint(name, on, by, at, self._directions, ())

    def universal(self, name: str, on: Body, by: Body, at: Point, axis: Axis, other: Axis) -> None:
        """State a universal joint about ``axis`` of ``by``'s frame and ``other`` of ``on``'s, which
        cross; in space.

        F_namex, F_namey, F_namez [N] are the force of ``by`` on ``on`` along the axes of the world,
        M_name [N m] times the cross product of both axes is the moment. Raises MechanismError in
        the plane. Example: `ball`.
        """
        self._in_space(name)
        cross = unit(by.frame, axis).cross(unit(on.frame, other).resolved(by.frame))
        self._joint(name, on, by, at, self._directions, ())
        moment = self.assembly.unknown(
            f"M_{name}", "N m", f"moment of {by} on {on} at {at.name}, across both axes"
        )
        self.assembly.act(
            f"{name}, moment", on, by, at, zero(by.frame), moment * cross, workless=True
        )

    def cylinder(self, name: str, on: Body, by: Body, at: Point, axis: Axis) -> None:
        """State a cylindrical joint, which turns about and slides along ``axis`` of ``by``'s frame;
        in space.

        Forces F_name [N] and moments M_name [N m] of ``by`` on ``on`` across the axis are along the
        axes of ``by``'s frame; if ``by`` is not at rest, F_name_world_x, M_name_world_x and their
        like are along the world's. Raises MechanismError in the plane. Example: `ball`.
        """
        self._in_space(name)
        self._joint(name, on, by, at, _across(axis), _across(axis), by.frame)

    def plane(self, name: str, on: Body, by: Body, at: Point, normal: Axis) -> None:
        """State a planar joint: ``on`` slides on a plane of ``by`` and turns about its ``normal``;
        in space.

        The normal is an axis of ``by``'s frame. Along the axes of that frame, F_name [N] is the
        force of ``by`` on ``on`` along the normal and M_name [N m] the moments across it. The joint
        pushes and pulls. Raises MechanismError in the plane. Example: `ball`.
        """
        self._in_space(name)
        self._joint(name, on, by, at, [i for i in range(3) if normal[i]], _across(normal), by.frame)

    def wheel(
        self, name: str, on: Body, centre: Point, radius: Scalar, axle: Axis, up: Axis
    ) -> None:
        """State a thin wheel that rolls without slip on the plane through the origin, in space, in
        free motion.

        ``radius`` [m]; ``centre`` is fixed in the body, ``axle`` an axis of its frame, ``up`` the
        axis of the world that points from the plane to the wheel, as Z or (0, 0, -1). F_namex,
        F_namey, F_namez [N] are the force of the plane on the wheel at the contact, along the axes
        of the world. It adds a gap and two slips as constraints. Raises MechanismError in the
        plane. The coordinate of the centre along ``up`` should begin at the radius (`begin`).

        >>> from derive import Mechanism, X, Y, Z, quantities
        >>> q = quantities('''
        ...     R | m     | radius                 | 0.3
        ...     m | kg    | wheel                  | 2
        ...     I | kg m2 | inertia, across        | 0.06
        ...     J | kg m2 | inertia, about the axle | 0.12
        ... ''')
        >>> m = Mechanism("disc", q, spatial=True)
        >>> x, y, z = (m.coordinate(axis, "m", f"centre, {axis}") for axis in "xyz")
        >>> yaw, lean, roll = (m.coordinate(angle, "rad", angle) for angle in ("yaw", "lean", "roll"))
        >>> upright = m.frame("upright", lean, X, m.frame("heading", yaw))
        >>> centre = m.point("centre", m.O, m.world, x, y, z)
        >>> disc = m.body("disc", m.frame("disc", roll, Y, upright), q.m, centre, (q.I, q.J, q.I))
        >>> m.wheel("W", disc, centre, q.R, axle=Y, up=Z)
        >>> list(m.loops.gaps), list(m.slips), m.unknowns
        (['gap_W'], ['slip_Wx', 'slip_Wy'], [F_Wx, F_Wy, F_Wz])
        """
        self._in_space(name)
        way, normal = unit(on.frame, axle).resolved(self.world), unit(self.world, up)
        tilt = way.dot(normal)
        upright = sp.sqrt(1 - tilt**2)
        contact = Point(f"{name}, contact", centre, (-radius / upright) * (normal - tilt * way))
        self._add_gap(
            name, displacement(self.O, centre, self.world).dot(normal) - radius * upright, {}
        )
        arm = displacement(centre, contact, self.world)
        spin = self.motion.spin(on.frame).resolved(self.world)
        slip = self.motion.velocity(centre, self.world) + spin.cross(arm)
        for i in _across(up):
            self.slips[f"slip_{name}{AXES[i]}"] = slip[i]
        self._joint(name, on, self.ground, contact, range(3), ())

    def slide(
        self,
        name: str,
        on: Body,
        by: Body,
        at: Point,
        along: Axis = X,
        friction: Scalar = 0,
        origin: Point | None = None,
        creep: Scalar = 0,
    ) -> None:
        """State a prismatic joint along an axis ``along`` of ``by``'s frame.

        In the plane N_name [N] is the force of ``by`` on ``on`` across the axis, positive to the
        left of it (z cross the axis), and M_name [N m] the moment of ``by`` on ``on`` about z. With
        ``friction``, Coulomb's coefficient without unit, friction |N_name| acts on ``on`` against
        its sliding v_name [m/s] along the axis, and P_name [W] is the power lost, never negative.
        The sliding is that of ``at`` against a point fixed in ``by``: ``origin``, which may be left
        out for the ground. Below the speed ``creep`` [m/s] friction is smooth (`derive.creeping`),
        which free motion needs.

        In space F_name [N] are the forces of ``by`` on ``on`` across the axis and M_name [N m] all
        moments, along the axes of ``by``'s frame; F_name_world_x, M_name_world_x and their like are
        along the world's. Raises MechanismError for friction in space, or without the ``origin`` of
        a moving ``by``; free motion raises it for friction without ``creep`` in `system`.

        >>> from derive import Mechanism, quantities
        >>> q = quantities('''
        ...     phi   | rad   | angle
        ...     omega | rad/s | speed     | 10
        ...     h     | m     | stroke    | 0.1
        ...     m     | kg    | slider    | 1.5
        ...     g     | m/s2  | free fall | 9.81
        ...     mu    | 1     | friction  | 0.1
        ...     F     | N     | drive     | 20
        ... ''')
        >>> m = Mechanism("slider", q, angle=q.phi, speed=q.omega, gravity=q.g)
        >>> at = m.point("P", m.O, m.world, m.coordinate("s", "m", "place", equals=q.h * q.phi))
        >>> slider = m.body("slider", m.world, q.m, at)
        >>> m.slide("guide", slider, m.ground, at, friction=q.mu)
        >>> m.force("drive", slider, at, m.vector(m.world, q.F))
        >>> for equation in m.equations():
        ...     print(equation.residual)
        F - m*s_ddot - mu*Piecewise((1, v_guide >= 0), (-1, True))*Abs(N_guide)
        N_guide - g*m
        M_guide
        """
        if self.spatial:
            if friction != 0:
                raise MechanismError(
                    f"{name}: a slide in space has no friction here; state it as a force"
                )
            self._joint(name, on, by, at, _across(along), range(3), by.frame)
            return
        normal = self.assembly.unknown(
            f"N_{name}", "N", f"normal force of {by} on {on} at {at.name}"
        )
        moment = self.assembly.unknown(f"M_{name}", "N m", f"moment of {by} on {on} at {at.name}")
        way = unit(by.frame, along)
        across = unit(by.frame, Z).cross(way)
        self.assembly.act(
            name, on, by, at, normal * across, moment * unit(by.frame, Z), workless=True
        )
        place = displacement(self.O, at, self.world)
        ends = place, place + way.resolved(self.world)
        self.elements[name] = Element("guide", on.name, by.name, ends)
        if friction != 0:
            sliding, limit = self._sliding(name, by, at, way, origin), friction * sp.Abs(normal)
            if creep != 0:
                drag = creeping(limit, [sliding], creep) * sliding
            else:
                drag = limit * switch(sliding, S.One, S.NegativeOne)
                self.events.append(Event(f"sliding of {name} turns", sliding, S.Zero, 0))
            self.assembly.act(f"friction of {name}", on, by, at, -drag * way)
            self.report(f"P_{name}", "W", f"power lost to friction at {at.name}", drag * sliding)

    def motor(self, name: str, on: Body, by: Body, at: Point, axis: Axis = Z) -> Quantity:
        """State the motor that keeps the motion along the angle, and return its torque ``name`` [N
        m].

        The balances determine the torque. It acts on ``on`` by ``by``, positive about ``axis`` of
        ``by``'s frame, counter-clockwise about z. P_name [W] is its power, positive where the motor
        drives: the torque times the speed of ``on`` against ``by``. Example: `Mechanism`.
        """
        way = unit(by.frame, axis)
        torque = self.assembly.torque(
            name, on, by, at, way, f"torque of {by} on {on}, which keeps the motion"
        )
        turning = self.motion.spin(on.frame).resolved(by.frame) - self.motion.spin(by.frame)
        self.report(f"P_{name}", "W", f"power of {name}", torque * turning.dot(way))
        return torque

    def actuator(self, name: str, on: Body, by: Body, ends: tuple[Point, Point]) -> Quantity:
        r"""State the linear drive that keeps the motion along the angle, and return its pull
        ``name`` [N].

        The balances determine the force. It acts between a point of ``on`` and one of ``by``,
        positive where it pulls the ``ends`` together; its stroke follows from the motion as stated,
        as a law of the angle or of time. P_name [W] is its power, positive where it drives. The
        force has no direction where the ends coincide.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("phi | rad | phase\nomega | rad/s | its speed | 1\nh | m | stroke | 0.1\nm | kg | load | 2")
        >>> m = Mechanism("lift", q, angle=q.phi, speed=q.omega)
        >>> P = m.point("P", m.O, m.world, q.h * (2 + q.phi))
        >>> load = m.body("load", m.world, q.m, P)
        >>> m.slide("guide", load, m.ground, P)
        >>> m.actuator("F_in", load, m.ground, (P, m.O))
        F_in
        """
        line = displacement(*ends, self.world)
        long = sp.sqrt(line.dot(line))
        pull = self.assembly.unknown(
            name, "N", f"pull between {on} and {by}, which keeps the motion"
        )
        self.assembly.act(name, on, by, ends[0], (pull / long) * line)
        self._draw_between("strut", name, (on, by), ends)
        self.report(
            f"P_{name}",
            "W",
            f"power of {name}",
            -pull * line.dot(self.motion.derivative(line)) / long,
        )
        return pull

    def spring(
        self,
        name: str,
        on: Body,
        by: Body,
        ends: tuple[Point, Point],
        stiffness: Scalar,
        length: Scalar,
        damping: Scalar = 0,
    ) -> Quantity:
        """State a spring between a point of ``on`` and one of ``by``, and return its pull F_name
        [N].

        F_name = ``stiffness`` [N/m] (l_name - ``length`` [m]) + ``damping`` [N s/m] times the rate
        of l_name [m], which is the distance of the ``ends``. A positive F_name pulls the ends
        together, a negative one pushes them apart. The force has no direction where the ends
        coincide.

        >>> from derive import Mechanism, quantities
        >>> q = quantities('''
        ...     k | N/m | stiffness   | 100
        ...     L | m   | free length | 0.1
        ...     m | kg  | block       | 2
        ...     w | m   | wall        | 0.3
        ... ''')
        >>> m = Mechanism("oscillator", q)
        >>> at = m.point("P", m.O, m.world, m.coordinate("s", "m", "place"))
        >>> block = m.body("block", m.world, q.m, at)
        >>> m.spring("spring", block, m.ground, (at, m.point("wall", m.O, m.world, q.w)), q.k, q.L)
        F_spring
        >>> m.equations()[0].residual
        F_spring*(-s + w)/l_spring - m*s_ddot
        """
        long, pull = self._strut(
            name,
            on,
            by,
            ends,
            lambda distance, rate: stiffness * (distance - length) + damping * rate,
        )
        self.potentials.append(stiffness * (long - length) ** 2 / 2)
        self._draw_between("spring", name, (on, by), ends)
        return pull

    def strut(
        self,
        name: str,
        on: Body,
        by: Body,
        ends: tuple[Point, Point],
        law: Callable[[Expr, Expr], Expr],
    ) -> Quantity:
        r"""State a light strut of any law between a point of ``on`` and one of ``by``, and return
        its pull F_name [N].

        ``law`` gives the pull of l_name, the distance of the ``ends`` [m], and of its rate [m/s]: a
        spring that stiffens, a gas spring, a damper, a belt that does not push, an actuator. Signs
        are those of `spring`.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("c | N s2/m2 | damper | 40\nw | m | wall | 0.3\nm | kg | block | 2")
        >>> m = Mechanism("damper", q)
        >>> at = m.point("P", m.O, m.world, m.coordinate("s", "m", "place"))
        >>> block = m.body("block", m.world, q.m, at)
        >>> ends = at, m.point("wall", m.O, m.world, q.w)
        >>> m.strut("damper", block, m.ground, ends, lambda distance, rate: q.c * rate * abs(rate))
        F_damper
        """
        return self._strut(name, on, by, ends, law)[1]

    def _strut(
        self,
        name: str,
        on: Body,
        by: Body,
        ends: tuple[Point, Point],
        law: Callable[[Expr, Expr], Expr],
    ) -> tuple[Quantity, Quantity]:
        """Return the length [m] of a strut and its pull [N]."""
        line = displacement(*ends, self.world)
        long = self.name_(f"l_{name}", "m", f"length of {name}", sp.sqrt(line.dot(line)))
        rate = line.dot(self.motion.derivative(line)) / long
        self.motion.rates[long] = rate
        pull = self.name_(f"F_{name}", "N", f"pull of {name}", law(long, rate))
        self.force(name, on, ends[0], (pull / long) * line, by)
        self._draw_between("strut", name, (on, by), ends)
        return long, pull

    def _draw_between(
        self,
        kind: Literal["spring", "strut"],
        name: str,
        bodies: tuple[Body, Body],
        ends: tuple[Point, Point],
    ) -> None:
        first, second = (displacement(self.O, end, self.world) for end in ends)
        self.elements[name] = Element(kind, bodies[0].name, bodies[1].name, (first, second))

    def bushing(
        self,
        name: str,
        on: Body,
        by: Body,
        ends: tuple[Point, Point],
        stiffness: Scalar,
        damping: Scalar = 0,
    ) -> None:
        r"""State an elastic joint: a force that draws a point of ``on`` back to one of ``by``.

        F_namex, F_namey, in space F_namez, [N] act on ``on`` along the axes of ``by``'s frame:
        minus ``stiffness`` [N/m] times the place of the first of the ``ends`` from the second, less
        ``damping`` [N s/m] times its rate, as ``by`` sees it. Turning meets no resistance.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("k | N/m | rubber | 9e4\nm | kg | block | 2")
        >>> m = Mechanism("mount", q)
        >>> at = m.point("P", m.O, m.world, m.coordinate("s", "m", "place"))
        >>> block = m.body("block", m.world, q.m, at)
        >>> m.bushing("mount", block, m.ground, (at, m.O), q.k)
        >>> m.equations()[0].residual
        F_mountx - m*s_ddot
        """
        place = displacement(ends[1], ends[0], by.frame)
        pull = (-stiffness) * place + (-damping) * self.motion.relative_derivative(place, by.frame)
        named = [
            self.name_(
                f"F_{name}{axis}", "N", f"force of {by} on {on} in {name}, {axis}", component
            )
            if component != 0
            else S.Zero
            for axis, component in zip(AXES, pull.components, strict=True)
        ]
        self.potentials.append(stiffness * place.dot(place) / 2)
        self.force(name, on, ends[0], Vec(by.frame, to_triple(named)), by)

    def compliant_contact(
        self,
        name: str,
        on: Body,
        by: Body,
        at: Point,
        surface: Point,
        law: Callable[[Expr, Expr], Expr],
        normal: Axis = Y,
        friction: Scalar = 0,
        creep: Scalar = 0,
        radius: Scalar = 0,
    ) -> Quantity:
        r"""State a compliant contact that can open: a point of ``on`` over a surface of ``by``.

        Returns N_name [N].

        The surface is the plane through the point ``surface`` across ``normal``, an axis of
        ``by``'s frame along which it pushes ``at``. With a ``radius`` [m] it is a circle, in space
        a sphere, about that point: a positive one pushes outwards, as a disc does (of two discs it
        is the sum of their radii), a negative one inwards, as a bush does (of a pin in it, minus
        the radial clearance). gap_name [m] is the distance from the surface, negative at a depth.
        ``law`` gives the force [N] of the depth [m] and of its rate [m/s]; it counts where there is
        a depth, and never pulls. Friction against the sliding of ``at`` has the coefficient
        ``friction``, without unit, and creeps below the speed ``creep`` [m/s] (`derive.creeping`).
        For soil, an end stop, clearance; with the law K d^(3/2) (1 + D d_dot) the contact of Hunt
        and Crossley (J. Appl. Mech. 42, 1975).

        >>> from derive import Mechanism, Y, quantities
        >>> q = quantities("K | N/m | soil | 9e4\nm | kg | block | 2\ng | m/s2 | free fall | 9.81")
        >>> m = Mechanism("drop", q, gravity=q.g)
        >>> at = m.point("P", m.O, m.world, 0, m.coordinate("h", "m", "height"))
        >>> block = m.body("block", m.world, q.m, at)
        >>> m.compliant_contact("floor", block, m.ground, at, m.O, lambda depth, rate: q.K * depth)
        N_floor
        """
        place, way = displacement(surface, at, by.frame), unit(by.frame, normal)
        motion, distance = self.motion.relative_derivative(place, by.frame), place.dot(way)
        if radius != 0:
            far = self.name_(
                f"l_{name}",
                "m",
                f"distance of {at.name} from {surface.name}",
                sp.sqrt(place.dot(place)),
            )
            side = switch(-sp.sympify(radius), -S.One, S.One)  # a bush also without clearance
            way, distance = (
                (side / sp.Max(far, CENTRE * sp.Abs(radius))) * place,
                side * far - radius,
            )
        opening = motion.dot(way)
        gap = self.name_(
            f"gap_{name}", "m", f"distance of {at.name} from the surface of {by}", distance
        )
        push = self.name_(
            f"N_{name}",
            "N",
            f"force of {by} on {on} at {at.name}, along the normal",
            self._push_at(gap, opening, law, f"contact of {name}"),
        )
        slip = motion - opening * way
        drag = creeping(friction * push, slip.components, creep) if friction != 0 else S.Zero
        self.force(name, on, at, push * way - drag * slip, by)
        return push

    def _push_at(
        self, gap: Quantity, opening: Expr, law: Callable[[Expr, Expr], Expr], event: str
    ) -> Expr:
        """Return the force [N] of a law where a gap, of a rate ``opening`` [m/s], is closed; state
        its event.
        """
        self.motion.rates[gap] = opening
        self.events.append(Event(event, gap, S.Zero, 0))
        return switch(gap, S.Zero, sp.Max(law(switch(gap, S.Zero, -gap), -opening), 0))

    def compliant_mesh(
        self,
        tag: str,
        inner: Body,
        outer: Body,
        contact: GearContact,
        lag: Expr,
        law: Callable[[Expr, Expr], Expr],
        backlash: Scalar = 0,
    ) -> Quantity:
        r"""State compliant teeth of two gears, which can separate, as `mesh` has them rigid.

        Returns F_Ntag [N].

        ``lag`` [rad] is the angle by which ``outer`` is behind the position that rigid teeth
        without backlash give it, counter-clockwise, with both flanks as far apart at zero; for
        round gears -inner r/R - outer. ``backlash`` [m] is the play along the line of action,
        ``law`` the normal force [N] of the depth [m] of a flank and of its rate [m/s], as for
        `compliant_contact`. F_Ntag is the normal force on the flank that bears, positive;
        gap_tag_ahead and gap_tag_behind [m] are the gaps along the line of action of the flank that
        turns ``outer`` counter-clockwise and of the other, negative at a depth. An event marks
        where each opens or closes. Without friction P_tag [W] is the power of the teeth on both
        gears, negative while they store or lose energy.

        Forces have the potential of the depth: gaps change at the rate of their flanks, also as the
        pitch radius of the inner gear changes, which the normal at the pitch point leaves out.
        Without damping the energy is constant. As the stiffness rises without backlash, forces
        approach those of `mesh`. Raises MechanismError for a rack, and if ``lag`` changes other
        than by the turning of both gears, which it must where the lever does.

        >>> from derive import GearContact, Mechanism, quantities
        >>> q = quantities('''
        ...     r     | m     | pinion         | 0.02
        ...     R     | m     | wheel          | 0.04
        ...     m     | kg    | each gear      | 1
        ...     J     | kg m2 | its inertia    | 1e-4
        ...     alpha | rad   | pressure angle | 0.35
        ...     K     | N/m   | stiffness      | 1e8
        ...     j     | m     | backlash       | 5e-5
        ... ''')
        >>> m = Mechanism("gears", q)
        >>> a, b = m.coordinate("a", "rad", "pinion"), m.coordinate("b", "rad", "wheel")
        >>> D = m.point("D", m.O, m.world, q.r + q.R)
        >>> pinion = m.body("pinion", m.frame("pinion", a), q.m, m.O, q.J)
        >>> wheel = m.body("wheel", m.frame("wheel", b), q.m, D, q.J)
        >>> teeth = GearContact(m.world, D, q.R, q.alpha)
        >>> m.compliant_mesh("P", pinion, wheel, teeth, -a * q.r / q.R - b, lambda depth, rate: q.K * depth, q.j)
        F_NP
        """
        if contact.is_rack:
            raise MechanismError(
                f"{self.name}: teeth {tag} of a rack cannot be compliant; state a compliant_contact"
            )
        smooth, pushes, power, turns = replace(contact, friction=S.Zero), [], S.Zero, S.Zero
        for bearing, side in ((1, "ahead"), (-1, "behind")):
            lever = smooth.lever(bearing)
            meaning, distance = (
                f"gap of the flanks of {inner} and {outer}, {side}",
                backlash / 2 - lever * lag,
            )
            gap = self.name_(f"gap_{tag}_{side}", "m", meaning, distance)
            opening = self.motion.rate(distance)
            pushes.append(self._push_at(gap, opening, law, f"teeth at {tag}, {side}"))
            power += pushes[-1] * opening
            turns -= (
                pushes[-1]
                * lag
                * slope_by_turning(self.motion, contact.frame, inner.frame, self.motion.rate(lever))
            )
        push = self.name_(
            f"F_N{tag}",
            "N",
            f"normal force between the teeth of {inner} and {outer}",
            sp.Add(*pushes),
        )
        sides = zip(contact.flank(1), contact.flank(-1), strict=True)
        force = Vec(
            contact.frame, tuple(pushes[0] * ahead + pushes[1] * behind for ahead, behind in sides)
        )
        if turns != 0:
            # a force through the outer gear's centre turns the inner gear alone
            follows = self.motion.rate(lag) + turning_rate(self.motion, contact.frame, outer.frame)
            ratio = slope_by_turning(self.motion, contact.frame, inner.frame, follows)
            if stray := ratio.free_symbols & {c.rate for c in self.loops.coordinates}:
                names = ", ".join(sorted(map(str, stray)))
                raise MechanismError(
                    f"teeth {tag}: lag changes with {names} other than by the turning of {inner} "
                    f"and {outer}; state it "
                    f"in terms of the angle of {inner}, not of what turns that"
                )
            across = Vec(
                contact.frame, (S.Zero, turns / (contact.outer_radius * (1 - ratio)), S.Zero)
            )
            self.force(f"F_{tag}, as the lever changes", inner, contact.outer, across, outer)
        self.force(
            f"F_{tag}", inner, replace(contact.pitch_point, name=f"pitch point {tag}"), force, outer
        )
        if contact.friction == 0:
            self.report(f"P_{tag}", "W", f"power of the teeth on {inner} and {outer}", power)
        return push

    def force(self, name: str, on: Body, at: Point, force: Vec, by: Body | None = None) -> None:
        """Apply a given force [N] to a body at a point, and its reverse there to ``by`` or else to
        the ground.

        The force is a vector of any frame, with which it turns (`vector`); its components may be
        expressions of coordinates, rates and named quantities. Its name is not among the results:
        report it by `report`. Example: `slide`.
        """
        self.assembly.act(name, on, by or self.ground, at, force)

    def torque(self, name: str, on: Body, by: Body, torque: Expr | Vec, axis: Axis = Z) -> None:
        """Apply a given torque [N m] to ``on`` about ``axis`` of ``by``'s frame, or a vector of any
        frame, and its reverse to ``by``.

        Counter-clockwise is positive about z. Its name is not among the results: report it by
        `report`. Example: `pin`.
        """
        moment = torque if isinstance(torque, Vec) else torque * unit(by.frame, axis)
        self.assembly.act(name, on, by, self.O, zero(by.frame), moment)

    @property
    def _directions(self) -> range:
        return range(3 if self.spatial else 2)

    def _in_space(self, name: str) -> None:
        if not self.spatial:
            raise MechanismError(
                f"{name}: a joint of space; say `spatial=True` where the mechanism is begun"
            )

    def _joint(
        self,
        name: str,
        on: Body,
        by: Body,
        at: Point,
        forces: Iterable[int],
        moments: Iterable[int],
        frame: Frame | None = None,
    ) -> None:
        """Forces by axes of the world or of a frame, moments by those of ``by``'s.

        Whatever is not by those of the world is reported in these as well.
        """
        force, moment = [S.Zero] * 3, [S.Zero] * 3
        for i in forces:
            force[i] = self.assembly.unknown(
                f"F_{name}{AXES[i]}", "N", f"force of {by} on {on} at {at.name}, {AXES[i]}"
            )
        for i in moments:
            meaning = f"moment of {by} on {on} at {at.name}, {AXES[i]} of {by.frame}"
            moment[i] = self.assembly.unknown(f"M_{name}{AXES[i]}", "N m", meaning)
        forces_, moments_ = (
            Vec(frame or self.world, to_triple(force)),
            Vec(by.frame, to_triple(moment)),
        )
        self.assembly.act(name, on, by, at, forces_, moments_, workless=True)
        self._along_other_axes(f"F_{name}", "N", f"force of {by} on {on} at {at.name}", forces_)
        self._along_other_axes(f"M_{name}", "N m", f"moment of {by} on {on} at {at.name}", moments_)

    def _along_other_axes(self, name: str, unit_: str, meaning: str, action: Vec) -> None:
        """Note an action of a joint in space, or a force in the plane, whose components are not the
        world's.
        """
        turned = action.frame != self.world and any(
            component != 0 for component in action.components
        )
        if turned and (self.spatial or unit_ == "N"):
            self.turned[name] = (unit_, meaning, action)

    def _sliding(self, name: str, by: Body, at: Point, way: Vec, origin: Point | None) -> Quantity:
        """Return the speed of a point along a direction, seen from a body."""
        if origin is None and by != self.ground:
            raise MechanismError(
                f"{name}: name the point of {by} that the sliding is counted from, `origin`"
            )
        place = displacement(origin or self.O, at, by.frame)
        speed = self.motion.relative_derivative(place, by.frame).dot(way)
        return self.name_(f"v_{name}", "m/s", f"sliding at {at.name} on {by}", speed)


def _across(axis: Axis) -> tuple[int, ...]:
    """The axes across one."""
    return tuple(i for i in range(3) if not axis[i])
