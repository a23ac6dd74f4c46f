"""The planting device with a two-stage non-circular planetary gear train, from first principles (wang2017, figs. 1-7).

One side is derived; the other is the same half a turn behind. Frames, bodies and what touches what are stated here;
every acceleration, inertia term and balance comes out of ``derive.mechanics.bodies``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import sympy as sp
from sympy import Expr, S, pi

from ...branches import clip, wrap
from ...chain import Chain, ordered
from ...equations import Equation
from ...mechanics.bodies import Body, Contact, Mechanism, Part, Pin, about_pin, tangent_angle
from ...mechanics.frames import Axis, Frame, Motion, Point, Vec, Y, Z, displacement, shorter, unit
from ...model import Call, Event, Lane, Let, RuntimeFunction, Shared, Step, System, needed
from ...quantity import Quantity, Vector
from . import quantities as q

ASSUMPTIONS = (
    "rigid bodies, no clearance, no backlash",
    "constant carrier speed",
    "balanced carrier",
    "no friction but at the teeth and at the cam",
    "tooth force at the pitch point",
    "point follower: the roller has no radius",
    "return spring and coupling of the nozzle halves without mass",
    "no soil forces, no air drag",
)

NO_SPIN = (S.Zero, S.Zero, S.Zero)

WORLD = Frame("frame")
CARRIER = Frame("carrier", WORLD, Z, q.phi)
LINE1 = Frame("line O-A1", CARRIER, Z, pi / 2)
LINE2 = Frame("line A1-B1", CARRIER, Z, pi / 2 + q.gamma)
MIDDLE = Frame("middle body", CARRIER, Z, q.phi52)
PLANET = Frame("planet", CARRIER, Z, -q.alpha - q.phi)

O = Point("O")  # noqa: E741
PIN = Pin(O, WORLD, planar=True)
A1 = Point("A1", O, Vec(LINE1, (q.a1, S.Zero, S.Zero)))
B1 = Point("B1", A1, Vec(LINE2, (q.a2, S.Zero, S.Zero)))
P = Point("P", O, Vec(LINE1, (q.r3, S.Zero, S.Zero)))
CO = Point("CO", O, Vec(WORLD, (q.rho_CO * sp.cos(q.beta_CO), q.rho_CO * sp.sin(q.beta_CO), S.Zero)))
FROM_A1 = Vec(MIDDLE, (q.rho_CA * sp.cos(q.beta_CA), q.rho_CA * sp.sin(q.beta_CA), S.Zero))
FROM_B1 = Vec(PLANET, (q.c_CBx, q.c_CBy, S.Zero))
CA = Point("CA", A1, FROM_A1)
CB = Point("CB", B1, FROM_B1)
Q = Point("Q", A1, Vec(LINE2, (q.r6, S.Zero, S.Zero)))
A = Point("A", B1, Vec(PLANET, (q.x_A, q.y_A, q.z_A)))
TIP = Point("tip", B1, Vec(PLANET, (q.L_tip, S.Zero, S.Zero)))

CONTACT_P = Contact(WORLD, LINE1, A1, q.r5, q.xi1, q.alpha_n, q.mu2)
CONTACT_Q = Contact(WORLD, LINE2, B1, q.r7, q.xi2, q.alpha_n, q.mu2)


CONTACTS = tuple(
    RuntimeFunction(
        f"stage{number}",
        "contact functions of pitch curves",
        ("t", "parameters", "hoisted"),
        ("r", "dr", "ddr", "ratio", "dratio", "turned"),
    )
    for number in (1, 2)
)


def cam_law(delta: Expr) -> Expr:
    """Swing over the cam angle: a 4-5-6-7 polynomial rise and fall (Norton, Cam Design, 2009)."""

    def flank(start: Expr, end: Expr) -> Expr:
        x = clip((delta - start) / (end - start), S.Zero, S.One)
        return x**4 * (35 + x * (-84 + x * (70 - 20 * x)))

    return q.H * (flank(*q.delta_r) - flank(*q.delta_f))


@dataclass
class Kinematics:
    """The prescribed motion of one side: named steps, and how the named quantities change in time."""

    motion: Motion = field(default_factory=Motion)
    steps: list[Step] = field(default_factory=list)

    def let(self, symbol: Quantity, expr: Expr) -> Quantity:
        self.steps.append(Let(symbol, expr, f"derived: {symbol.meaning}"))
        return symbol

    def coordinate(self, symbols: tuple[Quantity, Quantity, Quantity], expr: Expr) -> None:
        """Name a coordinate, its rate and its acceleration."""
        value, rate, acceleration = symbols
        self.let(value, expr)
        velocity = self.motion.rate(expr)
        self.let(rate, velocity)
        self.let(acceleration, self.motion.rate(velocity))
        self.motion.rates |= {value: rate, rate: acceleration}

    def stage(self, number: int, t: Quantity, argument: Expr, start: Quantity, outputs: tuple[Quantity, ...]) -> None:
        """Contact of a gear stage at the polar angle ``t`` of its inner gear; ``start`` is the rotation at phi = 0."""
        r, dr, ratio, dratio, turned = outputs
        vectors = ((q.PARAMETERS1, q.HOISTED1), (q.PARAMETERS2, q.HOISTED2))[number - 1]
        contact = partial(Call, function=CONTACTS[number - 1], vectors=vectors)
        self.let(t, argument)
        at_start = argument.xreplace({q.phi: S.Zero, q.phi52: S.Zero})
        self.steps.append(
            contact((None,) * 5 + (start,), argument=at_start, source=f"derived: stage {number}, phi = 0")
        )
        self.steps.append(contact((r, dr, None, ratio, dratio, turned), argument=t, source=f"derived: stage {number}"))
        rate = self.motion.rate(argument)
        self.motion.rates |= {t: rate, r: dr * rate, ratio: dratio * rate, turned: ratio * rate}

    def name_acceleration(self, point: Point, frame: Frame, symbols: tuple[Quantity, Quantity]) -> None:
        acceleration = self.motion.acceleration(point, frame)
        for symbol, component in zip(symbols, acceleration.components, strict=False):
            self.let(symbol, component)
        self.motion.accelerations[point] = Vec(frame, (*symbols, S.Zero))

    def name_place(self, point: Point, base: Point, frame: Frame, symbols: tuple[Quantity, ...]) -> None:
        """Name a point's coordinates from ``base`` along ``frame``."""
        place = displacement(base, point, frame)
        for symbol, component in zip(symbols, place.components, strict=False):
            self.let(symbol, component)
        named = Vec(frame, (*symbols, *place.components[len(symbols) :]))
        self.motion.places[point] = base, named
        drift = shorter(self.motion.drift(base, point, frame))
        self.motion.rates |= dict(zip(symbols, drift.components, strict=False))

    def hang(self, point: Point, hinge: Point) -> None:
        """Count a named place from the hinge that the point swings about, so that its motion is told from there."""
        base, named = self.motion.places[point]
        self.motion.places[point] = hinge, named - self.motion.arm(base, hinge, named.frame)

    def mirror_place(self, image: Point, point: Point, plane: Expr) -> None:
        """Name the place of a mirror image by that of its original, which it must be, in ``z = plane``."""
        place, meant = self.motion.arm(B1, point, PLANET), displacement(B1, point, PLANET)
        difference = displacement(B1, image, PLANET) - Vec(PLANET, (meant[0], meant[1], 2 * plane - meant[2]))
        if any(sp.simplify(c) != 0 for c in difference.components):
            raise ValueError(f"{image.name} is not the mirror image of {point.name}")
        self.motion.places[image] = B1, Vec(PLANET, (place[0], place[1], 2 * plane - place[2]))


@dataclass(frozen=True)
class Half:
    """One half of the nozzle with its rocker: a frame that swings on the planet, and points fixed in it."""

    frame: Frame
    hinge: Point
    C1: Point
    C2: Point
    E: Point
    F: Point

    @property
    def parts(self) -> tuple[Part, Part]:
        return Part(q.m_C1, self.C1, q.I_C1), Part(q.m_C2, self.C2, q.I_C2)


def half(name: str, hinge: Point, side: int, axis: Axis) -> Half:
    """The inner half (side +1) or its mirror image (-1), swinging about ``axis`` of the planet."""
    frame = Frame(name, PLANET, axis, side * q.theta1)
    roller = (-q.L_AE * sp.cos(q.psi0), q.R_b - q.y_A, q.L_AE * sp.sin(q.psi0))

    def fixed(label: str, closed: tuple[Expr, Expr, Expr]) -> Point:
        x, y, z = closed
        return Point(f"{label} {name}", hinge, Vec(frame, (x, y, side * z)))

    return Half(frame, hinge, *(fixed(*p) for p in (("C1", q.c_C1), ("C2", q.c_C2), ("E", roller), ("F", q.c_F))))


def kinematics(inner: Half) -> Kinematics:
    """Angles of the train, swing of the cam, places and accelerations of the points (wang2017 2-3; digest of [10])."""
    k = Kinematics()
    k.motion.rates[q.phi] = q.omega
    k.stage(1, q.t1, q.phi + q.alpha3, q.T1_0, (q.r3, q.dr3, q.i1, q.di1, q.T1))
    k.coordinate((q.phi52, q.phi52_dot, q.phi52_ddot), q.T1 - q.T1_0)
    k.stage(2, q.t2, q.beta6 + q.phi52, q.T2_0, (q.r6, q.dr6, q.i2, q.di2, q.T2))
    k.coordinate((q.phi72, q.phi72_dot, q.phi72_ddot), q.T2_0 - q.T2)
    k.let(q.r5, q.a1 - q.r3)
    k.let(q.r7, q.a2 - q.r6)
    k.let(q.xi1, tangent_angle(k.motion, LINE1, WORLD, q.t1, q.r3, q.dr3))
    k.let(q.xi2, tangent_angle(k.motion, LINE2, MIDDLE, q.t2, q.r6, q.dr6))
    k.let(q.alpha, pi - q.theta - q.phi - q.phi72)
    k.let(q.Omega, q.omega + q.phi72_dot)
    k.let(q.Omega_dot, k.motion.rate(q.omega + q.phi72_dot))
    k.motion.rates |= {q.alpha: -q.Omega, q.Omega: q.Omega_dot}
    k.let(q.delta, wrap(-q.phi72, 2 * pi))
    k.motion.rates[q.delta] = -q.phi72_dot
    k.let(q.dpsi_ddelta, cam_law(q.delta).diff(q.delta))
    k.coordinate((q.theta1, q.theta1_dot, q.theta1_ddot), cam_law(q.delta))

    k.name_place(P, O, WORLD, (q.x_P, q.y_P))
    k.name_place(A1, O, WORLD, (q.x_A1, q.y_A1))
    k.name_place(B1, O, WORLD, (q.x_B1, q.y_B1))
    k.name_place(inner.E, B1, PLANET, (q.x_E, q.y_E, q.z_E))
    k.name_place(inner.F, B1, PLANET, (q.x_F, q.y_F, q.z_F))
    k.name_place(inner.C1, B1, PLANET, (q.x_C1, q.y_C1, q.z_C1))
    k.name_place(inner.C2, B1, PLANET, (q.x_C2, q.y_C2, q.z_C2))
    k.name_acceleration(A1, WORLD, (q.ax_A1, q.ay_A1))
    k.name_acceleration(B1, WORLD, (q.ax_B1, q.ay_B1))
    k.name_acceleration(A, PLANET, (q.ax_A, q.ay_A))
    k.name_place(CA, O, WORLD, (q.x_CA, q.y_CA))
    k.hang(CA, A1)
    k.name_place(CB, O, WORLD, (q.x_CB, q.y_CB))
    k.hang(CB, B1)
    k.let(q.x_tip, displacement(B1, TIP, WORLD)[0] + q.x_B1 + q.v_f * q.phi / q.omega)
    k.let(q.y_tip, displacement(B1, TIP, WORLD)[1] + q.y_B1)
    k.let(q.S, q.S0 + q.k_s * 2 * (q.c_F[2] - displacement(A, inner.F, PLANET)[2]))
    return k


@dataclass(frozen=True)
class Side:
    """One side as a mechanism: its bodies, and the two that it shares with the other side."""

    kinematics: Kinematics
    mechanism: Mechanism
    sun: Body
    carrier: Body
    middle: Body
    planet: Body
    inner: Body
    outer: Body


def build_side(hinge: Point = A, hinge_axis: Axis = Y) -> Side:
    """Bodies of one side and everything that acts between them (wang2017 2.1-2.2)."""
    opposite = Point(f"{hinge.name} outer", hinge, Vec(PLANET, (S.Zero, S.Zero, 2 * (q.z_mirror - q.z_A))))
    inner_half = half("inner half", hinge, 1, hinge_axis)
    outer_half = half("outer half", opposite, -1, hinge_axis)
    k = kinematics(inner_half)
    for image, original in ((outer_half.C1, inner_half.C1), (outer_half.C2, inner_half.C2)):
        k.mirror_place(image, original, q.z_mirror)
        k.hang(image, opposite)
        k.hang(original, hinge)
    middle_part = Part(q.m2, CA, about_pin(q.J_56, q.m2, FROM_A1))
    planet_part = Part(q.m3, CB, about_pin(q.J_7, q.m3, FROM_B1))

    mech = Mechanism(k.motion, gravity=Vec(WORLD, (S.Zero, -q.g, S.Zero)))
    sun = mech.add(Body("sun", WORLD))
    carrier = mech.add(Body("carrier", CARRIER))
    middle = mech.add(Body("middle body", MIDDLE, (middle_part,), Pin(A1, WORLD, planar=True)))
    planet = mech.add(Body("planet", PLANET, (planet_part,), Pin(B1, WORLD, planar=True)))
    inner = mech.add(Body("inner half", inner_half.frame, inner_half.parts, Pin(hinge, PLANET)))
    outer = mech.add(Body("outer half", outer_half.frame, outer_half.parts, Pin(opposite, PLANET)))

    across, pull = unit(PLANET, hinge_axis), Vec(PLANET, (S.Zero, S.Zero, q.S))
    mech.mesh("P", sun, middle, CONTACT_P)
    mech.joint("F_A1", middle, carrier, A1, WORLD, free=Z)
    mech.mesh("Q", middle, planet, CONTACT_Q)
    mech.joint("F_B1", planet, carrier, B1, WORLD, free=Z)
    mech.joint("F_A", inner, planet, hinge, PLANET, free=hinge_axis)
    mech.joint("F_Ao", outer, planet, opposite, PLANET, free=hinge_axis)
    mech.couple("M_K", inner, outer, planet, (hinge, opposite), across, ratio=S.NegativeOne)
    mech.act("F_F", inner, outer, inner_half.F, pull)
    mech.follower("F_E", inner, carrier, inner_half.E, B1, across=across, friction=q.mu1)
    return Side(k, mech, sun, carrier, middle, planet, inner, outer)


@dataclass(frozen=True)
class Support:
    """Sun and carrier in the frame, with what both sides do to them."""

    mechanism: Mechanism
    sun: Body
    carrier: Body


def build_support(motion: Motion) -> Support:
    mech = Mechanism(motion, gravity=Vec(WORLD, (S.Zero, -q.g, S.Zero)))
    frame = mech.add(Body("frame", WORLD))
    sun = mech.add(Body("sun", WORLD, (Part(q.m1, CO, NO_SPIN),), PIN))
    carrier = mech.add(Body("carrier", CARRIER, (Part(q.m4, O, NO_SPIN),), PIN))
    z = unit(WORLD, Z)
    mech.joint("F_O", sun, frame, O, WORLD, free=Z)
    mech.torque("M_1", sun, frame, O, z, "holding torque of the frame on the sun")
    mech.joint("F_O1", carrier, frame, O, WORLD, free=Z)
    mech.torque("M_L", carrier, frame, O, z, "torque of the motor on the carrier")
    return Support(mech, sun, carrier)


def support_equations(side: Side, support: Support, other: Callable[[Expr], Expr]) -> list[Equation]:
    """Balances of sun and carrier: their own, with the actions of side 1 and the same of side 2."""
    found: list[Equation] = []
    for own, shared in ((support.sun, side.sun), (support.carrier, side.carrier)):
        balances, loads = support.mechanism.balances(own, PIN), side.mechanism.balances(shared, PIN)
        for (claim, residual), (_, load) in zip(balances, loads, strict=True):
            found.append(Equation(str(claim), residual + load + other(load), f"derived: {claim}", claim))
    return found


@dataclass(frozen=True)
class OtherSide:
    """Turns an expression in quantities of side 1 into the same in those of side 2, half a turn behind."""

    symbols: frozenset[Quantity]

    def __call__(self, expr: Expr) -> Expr:
        ours = sorted(expr.free_symbols & self.symbols, key=str)
        return expr.xreplace({s: q.twin(s) for s in ours} | {q.phi: q.phi - pi})


def joints() -> tuple[Event, ...]:
    """Where a lane is not smooth: joints of the deformed curves, ends of the cam's flanks, changes of bearing flank."""
    gears = [
        Event(f"gear {gear}, {where}", t, target, order=1, period=2 * pi)
        for gear, t, m in ((3, q.t1, q.m31), (6, q.t2, q.m61))
        for where, target in (("t = 0", S.Zero), ("t = pi/m", pi / m))
    ]
    cam = [Event(f"cam, {edge.meaning}", -q.phi72, edge, order=2, period=2 * pi) for edge in (*q.delta_r, *q.delta_f)]
    teeth = [
        Event(f"teeth at {tag}, change of flank", moment, S.Zero, order=1)
        for tag, moment in (("P", q.M_P), ("Q", q.M_Q))
    ]
    return (*gears, *cam, *teeth)


def assemble(side_steps: tuple[Step, ...], reported: tuple[Quantity, ...], shared: Chain) -> Lane:
    """The lane of a model from the steps of a side and the chain of what both sides share."""
    balances = (
        *shared.lets(),
        Let(q.F_support, q.F_Oy + q.F_O1y, "wang2017 3.1"),
        Let(q.F_support_x, q.F_Ox + q.F_O1x, "derived: horizontal support force"),
    )
    sums = needed(balances, frozenset(q.TOTALS))
    summed = frozenset().union(*(step.needs for step in sums))
    ours = [s for step in side_steps for s in step.defines]
    passed = [s for s in ours if s in summed or q.twin(s) in summed]
    side = tuple(dict.fromkeys((*reported, *passed)))
    events = joints()
    wanted = frozenset(side).union(*(e.argument.free_symbols for e in events))
    frame = Shared(q.twin, sums, Vector("totals", q.TOTALS))
    return Lane(q.phi, q.INPUTS, needed(side_steps, wanted), Vector("side", side), events, frame)


def exact_lane() -> Lane:
    """The device from first principles, along the carrier angle."""
    side = build_side()
    kinematic = tuple(side.kinematics.steps)
    lane = ordered(side.mechanism.equations(), side.mechanism.unknowns, q.REPORTED_EXACT)
    steps = (*kinematic, *lane.lets())
    support = build_support(side.kinematics.motion)
    other = OtherSide(frozenset(s for step in steps for s in step.defines))
    frame = ordered(support_equations(side, support, other), support.mechanism.unknowns, q.TOTALS)
    return assemble(steps, q.REPORTED_EXACT, frame)


def exact() -> System:
    """The device from first principles."""
    title, source = "Planting device, from first principles", "derived (Newton-Euler)"
    return System("planting_exact", title, source, ASSUMPTIONS, exact_lane())


def printed(paper: Chain, frame: Chain) -> System:
    """The device as a paper prints it: its equations on the kinematics of this module."""
    side = build_side()
    loss = next(law for law in side.mechanism.laws if law.symbol == q.F_E_loss)
    lane = assemble((*side.kinematics.steps, *paper.lets(), loss), q.REPORTED, frame)
    title, source = "Planting device, as printed", "wang2017 (1)-(31), taken literally"
    return System("planting_printed", title, source, ASSUMPTIONS, lane)
