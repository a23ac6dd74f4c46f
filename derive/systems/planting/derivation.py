"""The planting device with a two-stage non-circular planetary gear train, from first principles (wang2017, figs. 1-7).

One side is derived; the other is the same half a turn behind. Frames, bodies and what touches what are stated here;
every acceleration, inertia term and balance comes out of ``derive.mechanics``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp
from sympy import Expr, S, pi

from ...branches import wrap
from ...chain import Chain, ordered
from ...equations import Equation
from ...mechanics.bodies import Assembly, Body, Part, Pin, about_pin
from ...mechanics.contacts import (
    GearContact,
    PitchPoint,
    follower,
    mesh,
    pitch_places,
    polar_sense,
    tangent_angle,
)
from ...mechanics.frames import Axis, Frame, Motion, Point, Vec, Y, Z, displacement, unit
from ...mechanics.kinematics import GearStage, Kinematics
from ...model import ClosedForm, Event, Lane, Let, Shared, Step, System, needed
from ...quantity import Quantity, Vector
from . import quantities as q
from .flanks import FLANK, JOINTS

ASSUMPTIONS = (
    "rigid bodies, no clearance, no backlash",
    "constant carrier speed",
    "balanced carrier",
    "tooth force at the pitch point, where nothing slides: friction turns it outwards by its angle, a convention of "
    "wang2017, and does no work",
    "friction does work at the cam alone",
    "one cam drives both halves of a side by an ideal coupling, which does no work (the paper does not state it)",
    "point follower: the roller has no radius",
    "the cam's normal lies in the plane of the swing, as on a cylindrical roller parallel to the hinge; sliding along "
    "the hinge is left out of the friction",
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

CONTACT_P = GearContact(WORLD, LINE1, A1, q.r5, q.xi1, q.alpha_n, q.mu2)
CONTACT_Q = GearContact(WORLD, LINE2, B1, q.r7, q.xi2, q.alpha_n, q.mu2)


STAGE1 = GearStage(1, q.PARAMETERS1, q.HOISTED1)
STAGE2 = GearStage(2, q.PARAMETERS2, q.HOISTED2)


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


def kinematics(inner: Half, speed_rate: Expr = S.Zero) -> Kinematics:
    """Angles of the train, swing of the cam, places and accelerations of the points (wang2017 2-3; digest of [10])."""
    k = Kinematics.along(q.phi, q.omega)
    if speed_rate != 0:
        k.motion.rates[q.omega] = speed_rate
    k.stage(STAGE1, q.t1, q.phi + q.alpha3, r=q.r3, dr=q.dr3, ratio=q.i1, dratio=q.di1, turned=q.T1, start=q.T1_0)
    k.coordinate((q.phi52, q.phi52_dot, q.phi52_ddot), q.T1 - q.T1_0, at_start=S.Zero)
    k.stage(STAGE2, q.t2, q.beta6 + q.phi52, r=q.r6, dr=q.dr6, ratio=q.i2, dratio=q.di2, turned=q.T2, start=q.T2_0)
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
    k.flank(FLANK, q.delta, q.delta_r, q.x_rise, q.dx_rise, (q.p_rise, q.dp_rise, q.ddp_rise))
    k.flank(FLANK, q.delta, q.delta_f, q.x_fall, q.dx_fall, (q.p_fall, q.dp_fall, q.ddp_fall))
    k.let(q.dpsi_ddelta, q.H * (q.dp_rise * q.dx_rise - q.dp_fall * q.dx_fall))
    k.coordinate((q.theta1, q.theta1_dot, q.theta1_ddot), q.H * (q.p_rise - q.p_fall))

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
    k.let(q.x_tip_machine, displacement(B1, TIP, WORLD)[0] + q.x_B1)
    k.let(q.x_tip, q.x_tip_machine + q.v_f * q.phi / q.omega)
    k.let(q.y_tip, displacement(B1, TIP, WORLD)[1] + q.y_B1)
    k.let(q.S, q.S0 + q.k_s * 2 * (q.c_F[2] - displacement(A, inner.F, PLANET)[2]))
    return k


@dataclass(frozen=True)
class Side:
    """One side as a mechanism: its bodies, and the two that it shares with the other side."""

    kinematics: Kinematics
    mechanism: Assembly
    sun: Body
    carrier: Body
    middle: Body
    planet: Body
    inner: Body
    outer: Body


@dataclass(frozen=True)
class Contacts:
    """What touches what on a side: both meshes, and the share of the sliding along the hinge that rubs on the cam."""

    P: GearContact = CONTACT_P
    Q: GearContact = CONTACT_Q
    along_hinge: Expr = S.Zero


CONTACTS = Contacts()


def build_side(
    hinge: Point = A, hinge_axis: Axis = Y, contacts: Contacts = CONTACTS, speed_rate: Expr = S.Zero
) -> Side:
    """Bodies of one side and everything that acts between them (wang2017 2.1-2.2)."""
    opposite = Point(f"{hinge.name} outer", hinge, Vec(PLANET, (S.Zero, S.Zero, 2 * (q.z_mirror - q.z_A))))
    inner_half = half("inner half", hinge, 1, hinge_axis)
    outer_half = half("outer half", opposite, -1, hinge_axis)
    k = kinematics(inner_half, speed_rate)
    for image, original in ((outer_half.C1, inner_half.C1), (outer_half.C2, inner_half.C2)):
        k.mirror_place(image, original, B1, PLANET, q.z_mirror)
        k.hang(image, opposite)
        k.hang(original, hinge)
    middle_part = Part(q.m2, CA, about_pin(q.J_56, q.m2, FROM_A1))
    planet_part = Part(q.m3, CB, about_pin(q.J_7, q.m3, FROM_B1))

    mech = Assembly(k.motion, gravity=Vec(WORLD, (S.Zero, -q.g, S.Zero)))
    sun = mech.add(Body("sun", WORLD))
    carrier = mech.add(Body("carrier", CARRIER))
    middle = mech.add(Body("middle body", MIDDLE, (middle_part,), Pin(A1, WORLD, planar=True)))
    planet = mech.add(Body("planet", PLANET, (planet_part,), Pin(B1, WORLD, planar=True)))
    inner = mech.add(Body("inner half", inner_half.frame, inner_half.parts, Pin(hinge, PLANET)))
    outer = mech.add(Body("outer half", outer_half.frame, outer_half.parts, Pin(opposite, PLANET)))

    across, pull = unit(PLANET, hinge_axis), Vec(PLANET, (S.Zero, S.Zero, q.S))
    mesh(mech, "P", sun, middle, contacts.P)
    mech.joint("F_A1", middle, carrier, A1, WORLD, free=Z)
    mesh(mech, "Q", middle, planet, contacts.Q)
    mech.joint("F_B1", planet, carrier, B1, WORLD, free=Z)
    mech.joint("F_A", inner, planet, hinge, PLANET, free=hinge_axis)
    mech.joint("F_Ao", outer, planet, opposite, PLANET, free=hinge_axis)
    mech.couple("M_K", inner, outer, planet, (hinge, opposite), across, ratio=S.NegativeOne)
    mech.act("F_F", inner, outer, inner_half.F, pull)
    follower(mech, "F_E", inner, carrier, inner_half.E, B1, across=across, friction=q.mu1, rubbing=contacts.along_hinge)
    return Side(k, mech, sun, carrier, middle, planet, inner, outer)


def coupling() -> Quantity:
    """The moment by which one half of the nozzle drives the other."""
    return next(unknown for unknown in build_side().mechanism.unknowns if unknown.name == "M_K")


@dataclass(frozen=True)
class Support:
    """Sun and carrier in the frame, with what both sides do to them."""

    mechanism: Assembly
    sun: Body
    carrier: Body


def build_support(motion: Motion) -> Support:
    mech = Assembly(motion, gravity=Vec(WORLD, (S.Zero, -q.g, S.Zero)))
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


def joints(of_flank: tuple[Expr, ...] = JOINTS) -> tuple[Event, ...]:
    """Where a lane is not smooth: joints of the deformed curves and of the cam's flanks, changes of bearing flank.

    ``of_flank`` are positions in a flank; those of the law that a machine has are known at run time.
    """
    gears = [
        Event(f"gear {gear}, {where}", t, target, order=1, period=2 * pi)
        for gear, t, m in ((3, q.t1, q.m31), (6, q.t2, q.m61))
        for where, target in (("t = 0", S.Zero), ("t = pi/m", pi / m))
    ]
    cam = [event for name, ends in (("rise", q.delta_r), ("fall", q.delta_f))
           for event in _of_flank(name, *ends, of_flank)]  # fmt: skip
    teeth = [
        Event(f"teeth at {tag}, change of flank", moment, S.Zero, order=1)
        for tag, moment in (("P", q.M_P), ("Q", q.M_Q))
    ]
    return (*gears, *cam, *teeth)


def _of_flank(name: str, start: Expr, end: Expr, positions: tuple[Expr, ...]) -> list[Event]:
    wheres = {S.Zero: f"start of the {name}", S.One: f"end of the {name}"}
    return [
        Event(f"cam, {wheres.get(x, f'{x} of the {name}')}", -q.phi72, start + x * (end - start), 2, 2 * pi, x)
        for x in positions
    ]


def assemble(
    side_steps: tuple[Step, ...], reported: tuple[Quantity, ...], shared: Chain, inputs: tuple[Vector, ...] = ()
) -> Lane:
    """The lane of a model from the steps of a side and the chain of what both sides share; ``inputs`` come last."""
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
    return Lane(q.phi, (*q.INPUTS, *inputs), needed(side_steps, wanted), Vector("side", side), events, frame)


def weight() -> Expr:
    """Of everything that the frame carries: sun, carrier and both sides."""
    side = build_side()
    one, frame = side.mechanism.weight(), build_support(side.kinematics.motion).mechanism.weight()
    return sp.factor(-(frame + 2 * one)[1])


def parts() -> tuple[ClosedForm, ...]:
    """What every model gives beside its lane: the weight, and where points of the pitch curves of side 1 are."""
    carried = Let(q.weight, weight(), "derived: sun, carrier and both sides")
    return (
        ClosedForm("weight", (q.MACHINE,), (carried,), Vector("carried", (q.weight,))),
        _pair("pair1", LINE1, WORLD, O, (q.t1, q.T1, q.a1), (q.phi, q.t1, q.T1, q.a1, q.POINT)),
        _pair("pair2", LINE2, MIDDLE, A1, (q.t2, q.T2, q.a2), (q.phi, q.gamma, q.t2, q.T2, q.a1, q.a2, q.POINT)),
    )


def _pair(
    name: str, line: Frame, gear: Frame, centre: Point, now: tuple[Quantity, Quantity, Quantity],
    inputs: tuple[Vector | Quantity, ...],
) -> ClosedForm:  # fmt: skip
    """A point of an inner gear's pitch curve and its mate, at the contact that is now."""
    t, turned, distance = now
    sense = polar_sense(build_side().kinematics.motion, line, gear, t)
    point = PitchPoint(q.on_curve, q.on_radius, q.on_turned)
    places = pitch_places(line, distance, sense, point, PitchPoint(t, S.Zero, turned))
    start = displacement(O, centre, WORLD)
    found = [(start + place.resolved(WORLD))[i] for place in places for i in (0, 1)]
    steps = tuple(Let(symbol, expr, "derived: gears roll") for symbol, expr in zip(q.PAIR, found, strict=True))
    return ClosedForm(name, inputs, steps, Vector(f"{name}_points", q.PAIR))


def exact_lane() -> Lane:
    """The device from first principles, along the carrier angle."""
    return derived_lane(build_side(), q.REPORTED_EXACT)


def derived_lane(side: Side, reported: tuple[Quantity, ...], inputs: tuple[Vector, ...] = ()) -> Lane:
    """The lane of a side whose balances are solved for everything that acts; ``inputs`` are those besides the usual."""
    kinematic = tuple(side.kinematics.steps)
    lane = ordered(side.mechanism.equations(), side.mechanism.unknowns, reported)
    steps = (*kinematic, *lane.lets())
    support = build_support(side.kinematics.motion)
    other = OtherSide(frozenset(s for step in steps for s in step.defines))
    frame = ordered(support_equations(side, support, other), support.mechanism.unknowns, q.TOTALS)
    return assemble(steps, reported, frame, inputs)


def exact() -> System:
    """The device from first principles."""
    title, source = "Planting device, from first principles", "derived (Newton-Euler)"
    return System("planting_exact", title, source, ASSUMPTIONS, exact_lane(), parts())


def printed(paper: Chain, frame: Chain) -> System:
    """The device as a paper prints it: its equations on the kinematics of this module."""
    side = build_side()
    lane = assemble((*side.kinematics.steps, *paper.lets(), side.mechanism.law(q.F_E_loss)), q.REPORTED, frame)
    title, source = "Planting device, as printed", "wang2017 (1)-(31), taken literally"
    return System("planting_printed", title, source, ASSUMPTIONS, lane, parts())


SYSTEMS = (exact,)
