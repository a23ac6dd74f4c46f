"""Contacts that only push: teeth of gears, a follower on a cam; gearing without loss; contours of
cams for rollers.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import sympy as sp
from sympy import Expr, S

from ..functions import partial_derivative, switch
from ..model import Event, Let
from ..quantity import Quantity
from .bodies import Body
from .frames import Frame, Motion, Point, Vec, Z, displacement, unit, zero
from .kinematics import Kinematics
from .statement import Element


@dataclass(frozen=True)
class GearContact:
    """Teeth of two gears that touch at the pitch point, on the line of centres, which is x of
    ``frame``.

    The line points from the inner gear's centre to ``outer``, the centre of the outer gear, whose
    pitch radius is ``outer_radius`` [m]. ``pressure_angle`` [rad] is that between the normal force
    and the tangent of the pitch curves; ``friction`` [rad] the angle of friction, which acts
    outwards on the inner gear; ``tangent`` [rad], in (0, pi), the angle from the line to the
    tangent, counter-clockwise, a right angle for round gears (`derive.tangent_angle`).

    ``internal`` gears mesh inside each other: the inner gear is the planet, the outer the ring
    around it, and the line points from the planet's centre to the ring's. An infinite radius
    (``sympy.oo``) is that of a rack: the line is perpendicular to it, and ``outer`` is the pitch
    point, at a fixed distance from the inner gear's centre.
    """

    frame: Frame
    outer: Point
    outer_radius: Expr
    pressure_angle: Expr
    friction: Expr = S.Zero
    tangent: Expr = sp.pi / 2
    internal: bool = field(default=False, kw_only=True)

    @property
    def is_rack(self) -> bool:
        """Whether the outer gear is a rack."""
        return self.outer_radius == sp.oo

    def normal(self, bearing: int) -> Expr:
        """Return the direction [rad] of the normal force on the inner gear, from its radius vector:
        into the gear.

        ``bearing`` is 1 for the flank that turns the outer gear counter-clockwise, -1 for the
        other.
        """
        angle = -self.pressure_angle if self.internal else self.pressure_angle
        return self.tangent + angle if bearing > 0 else self.tangent + sp.pi - angle

    def across(self, bearing: int) -> Expr:
        """Return the direction [rad] of friction on the inner gear, from its radius vector:
        outwards.
        """
        return self.normal(bearing) - (-bearing if self.internal else bearing) * sp.pi / 2

    def flank(self, bearing: int) -> tuple[Expr, Expr, Expr]:
        """Return the force on the inner gear per normal force, without unit, along x, y and z of
        the contact's frame.

        ``bearing`` is 1 for the flank that turns the outer gear counter-clockwise, -1 for the
        other. The normal makes the pressure angle with the tangent and points into the inner gear;
        friction is perpendicular to it, outwards.
        """
        normal, across = self.normal(bearing), self.across(bearing)
        drag = self.drag(bearing)
        return (
            sp.cos(normal) + drag * sp.cos(across),
            sp.sin(normal) + drag * sp.sin(across),
            S.Zero,
        )

    def drag(self, bearing: int) -> Expr:
        """Return friction per normal force, without unit, positive outwards."""
        return sp.tan(self.friction)

    @property
    def pitch_point(self) -> Point:
        """The point where the pitch curves touch, ``outer_radius`` [m] from the outer gear's
        centre.
        """
        if self.is_rack:
            return self.outer
        return Point(
            "pitch point", self.outer, Vec(self.frame, (-self.outer_radius, S.Zero, S.Zero))
        )

    def lever(self, bearing: int) -> Expr:
        """Return the moment of the teeth on the outer gear about its centre per normal force [m].

        Of a rack, the force of the teeth on the inner gear along the rack per normal force, without
        unit.
        """
        return (
            self.flank(bearing)[1] if self.is_rack else self.outer_radius * self.flank(bearing)[1]
        )


@dataclass(frozen=True)
class SlidingContact(GearContact):
    """Teeth that touch a distance ``beyond`` [m] from the pitch point along the line of action, and
    slide there.

    The distance counts along the normal force on the inner gear. ``turning`` [rad/s] is the speed
    of the inner gear against the outer one. ``share`` of 1 has friction act against the sliding, of
    0 outwards.
    """

    beyond: Expr = S.Zero
    turning: Expr = S.Zero
    share: Expr = S.One

    def lead(self, bearing: int) -> Expr:
        """Return the share of the normal force beyond the pitch point less the share before it,
        without unit.
        """
        return sp.sign(self.beyond)

    def away(self, bearing: int) -> Expr:
        """Return the mean distance of the normal force from the pitch point [m]."""
        return self.beyond * sp.sign(self.beyond)

    def drag(self, bearing: int) -> Expr:
        """Return the friction per normal force [1] on the flank of ``bearing``, which is 1 or
        -1.
        """
        against = bearing * sp.sign(self.turning) * self.lead(bearing)
        return sp.tan(self.friction) * (1 + self.share * (against - 1))

    def lever(self, bearing: int) -> Expr:
        """Return the moment of the teeth on the outer gear about its centre per normal force [m].

        Friction acts beyond the pitch point; the normal force has the lever of the pitch point.
        """
        return super().lever(bearing) + sp.sign(self.turning) * self._rubbing(bearing)

    def loss(self, bearing: int) -> Expr:
        """Return the power lost to friction per normal force [m/s]."""
        return self.turning * sp.sign(self.turning) * self._rubbing(bearing)

    def _rubbing(self, bearing: int) -> Expr:
        """Moment of friction about the pitch point per normal force, against the turning."""
        return self.share * sp.tan(self.friction) * self.away(bearing)


@dataclass(frozen=True)
class SharedContact(SlidingContact):
    """Contact of several pairs of teeth on one line of action that share the normal force in any
    way.

    ``leads``, without unit, and ``aways`` [m] are what `lead` and `away` are over all pairs, on the
    flank that turns the outer gear counter-clockwise, then on the other.
    """

    leads: tuple[Expr, Expr] = (S.Zero, S.Zero)
    aways: tuple[Expr, Expr] = (S.Zero, S.Zero)

    def lead(self, bearing: int) -> Expr:
        """Return the lead [1] of the pairs of teeth on the flank of ``bearing``."""
        return self.leads[bearing < 0]

    def away(self, bearing: int) -> Expr:
        """Return the distance from the pitch point [m] of the pairs of teeth on the flank of
        ``bearing``.
        """
        return self.aways[bearing < 0]


def tangent_angle(
    motion: Motion, line: Frame, gear: Frame, parameter: Expr, radius: Expr, slope: Expr
) -> Expr:
    """Return the angle [rad] from a gear's radius vector at the contact to its pitch curve's
    tangent, in (0, pi).

    It counts counter-clockwise. ``radius`` [m] and ``slope`` [m/rad] are the pitch radius and its
    slope over ``parameter`` [rad], the polar angle of the contact on the gear, in either sense,
    which follows from the motion. ``line`` is the frame of the line of centres, ``gear`` that of
    the gear.
    """
    return sp.atan2(radius, polar_sense(motion, line, gear, parameter) * slope)


def polar_sense(motion: Motion, line: Frame, gear: Frame, parameter: Expr) -> Expr:
    """1 where a curve's parameter at the contact runs with the polar angle of its gear, -1 where
    against it.
    """
    return -slope_by_turning(motion, line, gear, motion.rate(parameter))


def slope_by_turning(motion: Motion, line: Frame, gear: Frame, rate: Expr) -> Expr:
    """Return a rate per angular velocity of a gear about z, counted from the line of centres [unit
    of rate s/rad].
    """
    turning = turning_rate(motion, line, gear)
    # a coefficient of a long sum takes `cancel` seconds
    if turning.is_Symbol and rate.xreplace({turning: S.Zero}) == 0:
        slope = partial_derivative(rate, turning)
        if turning not in slope.free_symbols:
            return slope
    return sp.cancel(rate / turning)


def turning_rate(motion: Motion, line: Frame, gear: Frame) -> Expr:
    """Return the angular velocity of a gear about z, counted from the line of centres [rad/s]."""
    return (motion.spin(gear).resolved(line) - motion.spin(line))[2]


@dataclass(frozen=True)
class PitchPoint:
    """A point of a pitch curve: polar angle, radius, and how far its conjugate has turned when it
    is in contact.
    """

    polar: Expr
    radius: Expr
    turned: Expr


def pitch_places(
    line: Frame, distance: Expr, sense: Expr, point: PitchPoint, now: PitchPoint
) -> tuple[Vec, Vec]:
    """A point of the inner gear and its mate on the outer one while ``now`` is in contact, from the
    inner's centre.

    Both are as far from the line of centres as their gears have still to turn, or have turned
    since, the one against the other.
    """
    inner = Frame("radius of the inner gear", line, Z, sense * (point.polar - now.polar))
    outer = Frame("radius of the outer gear", line, Z, sp.pi - sense * (point.turned - now.turned))
    mate = Vec(outer, (distance - point.radius, S.Zero, S.Zero)).resolved(line)
    place = Vec(inner, (point.radius, S.Zero, S.Zero)).resolved(line)
    return place, Vec(line, (distance, S.Zero, S.Zero)) + mate


class Contacts(Kinematics):
    """Contacts between bodies: a force each, by laws where it is of a kind, and the events where a
    law changes.
    """

    def contact(self, name: str, on: Body, by: Body, at: Point, way: Vec) -> Quantity:
        r"""State a smooth contact that can only push, and return its force N_name [N] of ``by`` on
        ``on``.

        The force acts along ``way``, a unit vector that points out of ``by``. It is positive where
        ``by`` pushes; a negative value is reported as it is: there the bodies would separate.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("g | m/s2 | free fall | 9.81\nm | kg | block | 2")
        >>> m = Mechanism("block", q, gravity=q.g)
        >>> block = m.body("block", m.world, q.m, m.O)
        >>> m.contact("floor", block, m.ground, m.O, m.vector(m.world, 0, 1))
        N_floor
        >>> m.equations()[0].residual
        N_floor - g*m
        """
        normal = self.assembly.unknown(
            f"N_{name}", "N", f"force of {by} on {on} at {at.name}, along the normal"
        )
        self.pushing.append(normal)
        self.assembly.act(name, on, by, at, normal * way, workless=True)
        return normal

    def mesh(
        self,
        tag: str,
        inner: Body,
        outer: Body,
        contact: GearContact,
        equal_to: Quantity | None = None,
    ) -> Quantity:
        """State the teeth of two gears; the flank that gives the required moment bears the load.

        Returns the moment.

        M_tag [N m] is the moment of ``inner`` on ``outer`` about the outer gear's centre, positive
        counter-clockwise. Of a rack, T_tag [N] is returned instead: its force on ``inner`` along y
        of the contact's frame. ``equal_to`` is the moment or force of another mesh that is as
        large, as equal planets share a load: balances alone do not say how rigid planets share it.
        F_Ntag [N] is the normal force, positive where it presses the teeth together, F_tagx and
        F_tagy [N] are the force of ``outer`` on ``inner`` along the axes of the world, friction
        included. With `derive.SlidingContact`, F_tag_loss [W] is the power lost to friction. The
        pitch curves must roll on each other: the residuals law_roll_tagx, law_roll_tagy [m/s]
        vanish if the stated motion does so. An event marks where M_tag changes its sign. In free
        motion `constrain` states the rolling, and `system` raises MechanismError without it; teeth
        with a `derive.SlidingContact` are stated as compliant ones there.

        >>> from derive import GearContact, Mechanism, quantities
        >>> q = quantities('''
        ...     phi   | rad   | pinion
        ...     omega | rad/s | its speed      | 10
        ...     r     | m     | pinion         | 0.02
        ...     R     | m     | wheel          | 0.04
        ...     alpha | rad   | pressure angle | 0.35
        ...     T     | N m   | load           | 1
        ... ''')
        >>> m = Mechanism("gears", q, angle=q.phi, speed=q.omega)
        >>> D = m.point("D", m.O, m.world, q.r + q.R)
        >>> pinion = m.body("pinion", m.frame("pinion", q.phi))
        >>> wheel = m.body("wheel", m.frame("wheel", -q.phi * q.r / q.R))
        >>> m.pin("O", pinion, m.ground, m.O)
        >>> m.pin("D", wheel, m.ground, D)
        >>> m.mesh("P", pinion, wheel, GearContact(m.world, D, q.R, q.alpha))
        M_P
        >>> m.torque("load", wheel, m.ground, q.T)
        >>> m.motor("M_in", pinion, m.ground, m.O)
        M_in
        >>> lane = m.system(reported=["M_P"]).lane
        >>> lane.steps[-1].symbol, lane.steps[-1].expr
        (M_P, -T)
        """
        mechanism, teeth = self.assembly, f"the teeth of {inner} and {outer}"
        self.rolling[tag] = inner, outer, contact.pitch_point
        if not (self.spatial or contact.is_rack):
            self.meshing[tag] = self.rolling[tag]  # with pitch curves to draw and to cut
        if contact.is_rack:
            moment = mechanism.unknown(
                f"T_{tag}", "N", f"force of {outer} on {inner} along {outer}"
            )
        else:
            moment = mechanism.unknown(
                f"M_{tag}", "N m", f"moment about {contact.outer.name} of {inner} on {outer}"
            )
        deciding = moment if equal_to is None else equal_to
        if equal_to is not None:
            mechanism.laws.append(
                Let(moment, equal_to, f"derived: {moment.meaning}, an equal share")
            )
        plus, minus = contact.flank(1), contact.flank(-1)
        normal = mechanism.unknown(f"F_N{tag}", "N", f"normal force between {teeth}")
        lever = switch(deciding, contact.lever(1), contact.lever(-1))
        mechanism.laws.append(Let(normal, moment / lever, f"derived: {normal.meaning}"))
        force = Vec(
            contact.frame,
            tuple(normal * switch(deciding, p, m) for p, m in zip(plus, minus, strict=True)),
        )
        named = mechanism.name_vector(
            f"F_{tag}", force.resolved(self.world), "N", f"tooth force of {outer} on {inner}"
        )
        couple = None if contact.is_rack else (-moment) * unit(self.world, Z)
        rolls = not isinstance(contact, SlidingContact)
        mechanism.act(f"F_{tag}", inner, outer, contact.outer, named, couple, workless=rolls)
        self.events.append(Event(f"teeth at {tag}, change of flank", deciding, S.Zero, order=1))
        if isinstance(contact, SlidingContact):
            loss = mechanism.unknown(
                f"F_{tag}_loss", "W", f"power lost to friction between {teeth}"
            )
            power = normal * switch(deciding, contact.loss(1), contact.loss(-1))
            mechanism.laws.append(Let(loss, power, f"derived: {loss.meaning}"))
        return moment

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
        """State the contact of a follower with a cam that can only push, and return the size
        ``name`` [N] of its force.

        ``at`` is the centre of the follower's roller, ``cam_axis`` a point of the cam's axis. The
        force of ``cam`` on ``on`` acts at ``at``, along the normal of the centre's path on the cam,
        in the plane across ``across`` (a unit vector, the world's z unless it is passed): positive
        where it pushes to the side v cross ``across`` of the velocity v of the centre against the
        cam. For a cam that turns counter-clockwise inside its follower, ``across`` is therefore -z.
        ``namex`` and its like [N] are its components along the axes of ``across``'s frame.

        ``friction`` [rad] is the angle of friction, by which the force turns against the sliding: v
        in that plane, and the share ``rubbing``, without unit, of the velocity along ``across``;
        ``name_loss`` [W] is the power lost. ``radius`` [m] is that of the roller, for drawings.
        Raises ValueError if the centre does not move against
        the cam, so that there is no normal.

        >>> from derive import Mechanism, Y, quantities
        >>> q = quantities('''
        ...     phi   | rad   | cam
        ...     omega | rad/s | its speed     | 10
        ...     h     | m     | lift per turn | 0.01
        ...     b     | m     | base radius   | 0.05
        ...     F     | N     | load          | 20
        ... ''')
        >>> m = Mechanism("cam", q, angle=q.phi, speed=q.omega)
        >>> P = m.point("P", m.O, m.world, 0, q.b + m.coordinate("s", "m", "lift", equals=q.h * q.phi))
        >>> cam, tappet = m.body("cam", m.frame("cam", q.phi)), m.body("tappet", m.world)
        >>> m.follower("N_cam", tappet, cam, P, m.O, across=m.vector(m.world, z=-1))
        N_cam
        >>> m.force("load", tappet, P, m.vector(m.world, 0, -q.F))
        >>> m.slide("guide", tappet, m.ground, P, along=Y)
        >>> [equation.residual for equation in m.equations()][-2]
        -F + N_camy
        """
        mechanism, across = self.assembly, across or unit(self.world, Z)
        self.rollers[name] = on, cam, displacement(cam_axis, at, self.world)
        axis, roller = (displacement(self.O, point, self.world) for point in (cam_axis, at))
        mark = axis + Vec(cam.frame, (S.One, S.Zero, S.Zero)).resolved(self.world)
        velocity = self.motion.relative_derivative(
            displacement(cam_axis, at, across.frame), cam.frame
        )
        in_plane = velocity - velocity.dot(across) * across
        if not any(in_plane.components):
            raise ValueError(
                f"{name}: {on} does not slide on {cam} at {at.name}, so the contact has no normal"
            )
        sliding = in_plane + (rubbing * velocity.dot(across)) * across
        force = f"contact force of {cam} on {on} at {at.name}"
        size = mechanism.unknown(name, "N", force)
        self.pushing.append(size)
        normal = (S.One / sp.sqrt(in_plane.dot(in_plane))) * in_plane.cross(across)
        ends = axis, roller, mark, roller + normal.resolved(self.world)
        self.elements[name] = Element("cam", on.name, cam.name, ends, radius)
        direction = (sp.cos(friction) / sp.sqrt(in_plane.dot(in_plane))) * in_plane.cross(across)
        direction -= (sp.sin(friction) / sp.sqrt(sliding.dot(sliding))) * sliding
        components = mechanism.name_vector(name, size * direction, "N", force)
        mechanism.act(name, on, cam, at, components, workless=friction == 0)
        if friction != 0:
            loss = mechanism.unknown(
                f"{name}_loss", "W", f"power lost to friction between {cam} and {on} at {at.name}"
            )
            mechanism.laws.append(Let(loss, -components.dot(sliding), f"derived: {loss.meaning}"))
        return size

    def couple(
        self,
        name: str,
        first: Body,
        second: Body,
        carrier: Body,
        hinges: tuple[Point, Point],
        axis: Vec,
        ratio: Expr,
    ) -> Quantity:
        r"""State ideal gearing of two hinges on ``carrier``, and return the moment ``name`` [N m]
        on ``second``.

        ``second`` turns ``ratio`` times as fast as ``first``, both against the carrier about
        ``axis``, a unit vector. No work is done, so the moment on ``first`` is -ratio times that on
        ``second``; the carrier takes the reverse of both at the ``hinges`` of ``first`` and
        ``second``. The motion itself is stated elsewhere, by `coordinate`.

        >>> from derive import Mechanism, quantities, unit, Z
        >>> q = quantities("T | N m | torque | 1\nS | N m | load | 2\ni | 1 | ratio | -0.5")
        >>> m = Mechanism("differential", q)
        >>> first, second = m.body("first", m.world), m.body("second", m.world)
        >>> m.pin("A", first, m.ground, m.O)
        >>> m.pin("B", second, m.ground, m.O)
        >>> m.couple("M_K", first, second, m.ground, (m.O, m.O), unit(m.world, Z), ratio=q.i)
        M_K
        >>> m.torque("drive", first, m.ground, q.T)
        >>> m.torque("load", second, m.ground, q.S)
        >>> [equation.residual for equation in m.equations() if "moment" in equation.number]
        [-M_K*i + T, M_K + S]
        """
        meaning = f"moment of the coupling on {second}"
        moment = self.assembly.torque(name, second, carrier, hinges[1], axis, meaning)
        self.assembly.act(
            name,
            first,
            carrier,
            hinges[0],
            zero(axis.frame),
            (-ratio * moment) * axis,
            workless=True,
        )
        return moment


PLANE = Frame("plane of the cam")
Plane = tuple[Expr, Expr]


def _contour_quantity(name: str, unit: str, meaning: str) -> Quantity:
    return Quantity(name, unit, meaning, "derived: cam for a roller")


reach = _contour_quantity(
    "reach",
    "m",
    "radius of the roller, negative where the cam lies to the right of the pitch curve",
)
contact_x, contact_y = (
    _contour_quantity(f"contact_{a}", "m", f"place of the contact in the plane of the cam, {a}")
    for a in "xy"
)
heading = _contour_quantity(
    "heading", "rad", "direction of the pitch curve in the plane of the cam, with the angle"
)
kappa = _contour_quantity(
    "kappa", "1/m", "curvature of the pitch curve, positive where it turns to the left"
)
room = _contour_quantity(
    "room", "1", "1 - radius of the roller / radius of curvature of the pitch curve towards the cam"
)
pressure = _contour_quantity(
    "pressure", "rad", "pressure angle: between the contact's normal and the motion of the centre"
)
CONTOUR = (contact_x, contact_y, heading, kappa, room, pressure)


def contour_steps(
    place: Plane, velocity: Plane, acceleration: Plane, moves: Plane
) -> tuple[Let, ...]:
    """Steps to a contour from the place of the roller's centre and how it moves as the cam sees it,
    by the angle.

    ``moves`` is along the motion of the centre that the follower leaves it.
    """
    x, y, dx, dy, ddx, ddy = (
        sp.Symbol(name, real=True) for name in ("x", "y", "dx", "dy", "ddx", "ddy")
    )
    motion = Motion({x: dx, y: dy, dx: ddx, dy: ddy})
    tangent = Vec(PLANE, (dx, dy, S.Zero))
    square = tangent.dot(tangent)
    parallel = Vec(
        PLANE, (x - reach * dy / sp.sqrt(square), y + reach * dx / sp.sqrt(square), S.Zero)
    )
    turning = sp.simplify(motion.rate(sp.atan2(dy, dx)) / sp.sqrt(square))
    share = sp.simplify(motion.derivative(parallel).dot(tangent) / square)
    if sp.simplify(share - (1 - reach * turning)) != 0:
        raise ValueError("a parallel curve is not as long as its distance and the curvature say")
    values = dict(zip((x, y, dx, dy, ddx, ddy), (*place, *velocity, *acceleration), strict=True))
    follower = Vec(PLANE, (*moves, S.Zero))
    across, with_ = tangent.cross(follower)[2], tangent.dot(follower)
    expressions = {
        contact_x: parallel[0],
        contact_y: parallel[1],
        heading: sp.atan2(dy, dx),
        kappa: turning,
        room: 1 - reach * kappa,
        pressure: sp.atan2(sp.Abs(with_), sp.Abs(across)),
    }
    return tuple(
        Let(symbol, expr.xreplace(values), f"derived: {symbol.meaning}")
        for symbol, expr in expressions.items()
    )
