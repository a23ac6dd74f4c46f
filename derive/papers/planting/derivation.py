"""The planting device with a two-stage non-circular planetary gear train, from first principles
(wang2017, figs. 1-7).

One side is derived; the other is the same, half a revolution behind. Frames, bodies and their
contacts are stated here; every acceleration, inertia term and balance is derived by
``derive.mechanics``.
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp
from sympy import Expr, S, pi

from ...chain import Chain
from ...functions import wrap
from ...mechanics.bodies import Part, about_pin
from ...mechanics.contacts import GearContact, PitchPoint, pitch_places, polar_sense, tangent_angle
from ...mechanics.driven_motion import Sides
from ...mechanics.frames import Axis, Frame, Point, Vec, Y, Z, displacement, unit
from ...mechanics.kinematics import GearStage, Kinematics
from ...mechanics.mechanism import Mechanism
from ...model import ClosedForm, Event, Lane, Let, System, let_all
from ...quantity import Quantity, Vector
from . import quantities as q
from .flanks import FLANK

CAM_TURN = "cam, begin of its turn"
"""Name of the event at which the cam's angle within its turn is zero again."""
ASSUMPTIONS = (
    "rigid bodies, no clearance, no backlash",
    "constant carrier speed",
    "balanced carrier",
    "tooth force at the pitch point, where nothing slides: friction turns it outwards by its "
    "angle, a convention of "
    "wang2017, and does no work",
    "friction does work at the cam alone",
    "one cam drives both halves of a side by an ideal coupling, which does no work (the paper "
    "does not state it)",
    "point follower: the roller has no radius",
    "the cam's normal lies in the plane of the swing, as on a cylindrical roller parallel to the "
    "hinge; sliding along "
    "the hinge is left out of the friction",
    "return spring and coupling of the nozzle halves without mass",
    "no soil forces, no air drag",
)

WORLD = Frame("frame")
CARRIER = Frame("carrier", WORLD, Z, q.phi)
LINE1 = Frame("line O-A1", CARRIER, Z, pi / 2)
LINE2 = Frame("line A1-B1", CARRIER, Z, pi / 2 + q.gamma)
MIDDLE = Frame("middle body", CARRIER, Z, q.phi52)
PLANET = Frame("planet", CARRIER, Z, -q.alpha - q.phi)

O = Point("O")  # noqa: E741
A1 = Point("A1", O, Vec(LINE1, (q.a1, S.Zero, S.Zero)))
B1 = Point("B1", A1, Vec(LINE2, (q.a2, S.Zero, S.Zero)))
P = Point("P", O, Vec(LINE1, (q.r3, S.Zero, S.Zero)))
CO = Point(
    "CO", O, Vec(WORLD, (q.rho_CO * sp.cos(q.beta_CO), q.rho_CO * sp.sin(q.beta_CO), S.Zero))
)
FROM_A1 = Vec(MIDDLE, (q.rho_CA * sp.cos(q.beta_CA), q.rho_CA * sp.sin(q.beta_CA), S.Zero))
FROM_B1 = Vec(PLANET, (q.c_CBx, q.c_CBy, S.Zero))
CA = Point("CA", A1, FROM_A1)
CB = Point("CB", B1, FROM_B1)
Q = Point("Q", A1, Vec(LINE2, (q.r6, S.Zero, S.Zero)))
A = Point("A", B1, Vec(PLANET, (q.x_A, q.y_A, q.z_A)))
TIP = Point("tip", B1, Vec(PLANET, (q.L_tip, S.Zero, S.Zero)))

CONTACT_P = GearContact(LINE1, A1, q.r5, q.alpha_n, q.mu2, q.xi1)
CONTACT_Q = GearContact(LINE2, B1, q.r7, q.alpha_n, q.mu2, q.xi2)
BALANCED = Part(q.m4, O, (S.Zero, S.Zero, S.Zero))
"""The carrier, as it is assumed."""

STAGE1 = GearStage(1, q.PARAMETERS1, q.HOISTED1)
STAGE2 = GearStage(2, q.PARAMETERS2, q.HOISTED2)


@dataclass(frozen=True)
class Half:
    """One half of the nozzle with its rocker: a frame that swings on the planet, and points fixed
    in it.
    """

    frame: Frame
    hinge: Point
    C1: Point
    C2: Point
    E: Point
    F: Point

    @classmethod
    def build(cls, name: str, hinge: Point, side: int, axis: Axis) -> Half:
        """Build the inner half (side +1) or its mirror image (-1), which swings about ``axis`` of
        the planet.
        """
        frame = Frame(name, PLANET, axis, side * q.theta1)
        roller = (-q.L_AE * sp.cos(q.psi0), q.R_b - q.y_A, q.L_AE * sp.sin(q.psi0))

        def body_point(label: str, position: tuple[Expr, Expr, Expr]) -> Point:
            x, y, z = position
            return Point(f"{label} {name}", hinge, Vec(frame, (x, y, side * z)))

        return cls(
            frame,
            hinge,
            *(
                body_point(*p)
                for p in (("C1", q.c_C1), ("C2", q.c_C2), ("E", roller), ("F", q.c_F))
            ),
        )

    @property
    def parts(self) -> tuple[Part, Part]:
        """Rocker and nozzle half."""
        return Part(q.m_C1, self.C1, q.I_C1), Part(q.m_C2, self.C2, q.I_C2)


def _add_train_and_cam(k: Mechanism) -> None:
    """Add the angles of the train and the swing of the cam (wang2017 2-3; digest of [10])."""
    k.stage(
        STAGE1,
        q.t1,
        q.phi + q.alpha3,
        r=q.r3,
        dr=q.dr3,
        ratio=q.i1,
        dratio=q.di1,
        turned=q.T1,
        start=q.T1_0,
    )
    k.follow((q.phi52, q.phi52_dot, q.phi52_ddot), q.T1 - q.T1_0, at_start=S.Zero)
    k.stage(
        STAGE2,
        q.t2,
        q.beta6 + q.phi52,
        r=q.r6,
        dr=q.dr6,
        ratio=q.i2,
        dratio=q.di2,
        turned=q.T2,
        start=q.T2_0,
    )
    k.follow((q.phi72, q.phi72_dot, q.phi72_ddot), q.T2_0 - q.T2)
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
    # A turn of the cam begins in a dwell, so that nothing jumps there, whatever the law.
    k.events.append(Event(CAM_TURN, -q.phi72, S.Zero, order=2, period=2 * pi))
    swing = add_flanks(k, -q.phi72)
    k.let(q.dpsi_ddelta, q.H * (q.dp_rise * q.dx_rise - q.dp_fall * q.dx_fall))
    k.follow((q.theta1, q.theta1_dot, q.theta1_ddot), swing)


def add_flanks(k: Kinematics, grown: Expr) -> Expr:
    """Add both flanks of the cam, whose angle grows over turns as told, and return the swing."""
    angle = q.delta, grown
    rise, fall = (q.p_rise, q.dp_rise, q.ddp_rise), (q.p_fall, q.dp_fall, q.ddp_fall)
    k.flank(FLANK, "rise", angle, q.delta_r, q.x_rise, q.dx_rise, rise)
    k.flank(FLANK, "fall", angle, q.delta_f, q.x_fall, q.dx_fall, fall)
    return q.H * (q.p_rise - q.p_fall)


def _add_points(k: Mechanism, inner: Half) -> None:
    """Add coordinates and accelerations of the points."""
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


@dataclass(frozen=True)
class DeviceContacts:
    """Contacts of a side: both meshes, and the share of the sliding along the hinge with friction
    on the cam.
    """

    P: GearContact = CONTACT_P
    Q: GearContact = CONTACT_Q
    along_hinge: Expr = S.Zero


CONTACTS = DeviceContacts()


def build_device(
    contacts: DeviceContacts = CONTACTS,
    speed_rate: Expr = S.Zero,
    carrier: Part = BALANCED,
    hinge: Point = A,
    hinge_axis: Axis = Y,
) -> Mechanism:
    """Build one side with all its actions, and sun and carrier, which both sides share (wang2017
    2.1-2.2).
    """
    m = Mechanism("planting", angle=q.phi, speed=q.omega, gravity=q.g, spatial=True, world=WORLD)
    m.motion.rates |= {q.omega: speed_rate} if speed_rate != 0 else {}
    opposite = Point(
        f"{hinge.name} outer", hinge, Vec(PLANET, (S.Zero, S.Zero, 2 * (q.z_mirror - q.z_A)))
    )
    half, image = (
        Half.build("inner half", hinge, 1, hinge_axis),
        Half.build("outer half", opposite, -1, hinge_axis),
    )
    _add_train_and_cam(m)
    _add_points(m, half)
    for mirrored, original in ((image.C1, half.C1), (image.C2, half.C2)):
        m.mirror_place(mirrored, original, B1, PLANET, q.z_mirror)
        m.hang(mirrored, opposite)
        m.hang(original, hinge)

    sun = m.body("sun", WORLD, q.m1, CO, about=O, tilting=False, shared=True)
    arm = m.body("carrier", CARRIER, parts=(carrier,), about=O, tilting=False, shared=True)
    middle = m.body(
        "middle body", MIDDLE, q.m2, CA, about_pin(q.J_56, q.m2, FROM_A1), about=A1, tilting=False
    )
    planet = m.body(
        "planet", PLANET, q.m3, CB, about_pin(q.J_7, q.m3, FROM_B1), about=B1, tilting=False
    )
    inner = m.body("inner half", half.frame, parts=half.parts, about=hinge, axes=PLANET)
    outer = m.body("outer half", image.frame, parts=image.parts, about=opposite, axes=PLANET)

    m.mesh("P", sun, middle, contacts.P)
    m.pin("A1", middle, arm, A1)
    m.mesh("Q", middle, planet, contacts.Q)
    m.pin("B1", planet, arm, B1)
    m.pin("A", inner, planet, hinge, hinge_axis, axes=PLANET)
    m.pin("Ao", outer, planet, opposite, hinge_axis, axes=PLANET)
    across = unit(PLANET, hinge_axis)
    m.couple("M_K", inner, outer, planet, (hinge, opposite), across, ratio=S.NegativeOne)
    m.force("F_F", inner, half.F, Vec(PLANET, (S.Zero, S.Zero, q.S)), by=outer)
    m.follower("F_E", inner, arm, half.E, B1, q.mu1, across, rubbing=contacts.along_hinge)
    m.pin("O", sun, m.ground, O)
    m.motor("M_1", sun, m.ground, O)
    m.pin("O1", arm, m.ground, O)
    m.motor("M_L", arm, m.ground, O)
    m.reports += [
        Let(q.F_support, q.F_Oy + q.F_O1y, "wang2017 3.1"),
        Let(q.F_support_x, q.F_Ox + q.F_O1x, "derived: horizontal support force"),
    ]
    return m


def coupling_moment() -> Quantity:
    """Return the moment by which one half of the nozzle drives the other."""
    return next(unknown for unknown in build_device().unknowns if unknown.name == "M_K")


def supported_weight() -> Expr:
    """Return the weight of sun, carrier and both sides, which the frame carries [N]."""
    m = build_device()
    masses = (
        part.mass * (1 if body in m.shared else 2) for body in m.bodies for part in body.parts
    )
    return sp.factor(q.g * sp.Add(*masses))


def closed_forms() -> tuple[ClosedForm, ...]:
    """Return the closed forms of every model: the weight, and points of the pitch curves of side
    1.
    """
    carried = Let(q.weight, supported_weight(), "derived: sun, carrier and both sides")
    return (
        ClosedForm("weight", (q.MACHINE,), (carried,), Vector("carried", (q.weight,))),
        _gear_pair(
            "pair1", LINE1, WORLD, O, (q.t1, q.T1, q.a1), (q.phi, q.t1, q.T1, q.a1, q.POINT)
        ),
        _gear_pair(
            "pair2",
            LINE2,
            MIDDLE,
            A1,
            (q.t2, q.T2, q.a2),
            (q.phi, q.gamma, q.t2, q.T2, q.a1, q.a2, q.POINT),
        ),
    )


def _gear_pair(
    name: str,
    line: Frame,
    gear: Frame,
    centre: Point,
    contact: tuple[Quantity, Quantity, Quantity],
    inputs: tuple[Vector | Quantity, ...],
) -> ClosedForm:
    """Return a point of an inner gear's pitch curve and the corresponding one of its mating gear.

    ``contact`` is the present contact: polar angle, rotation of the outer gear, centre distance.
    """
    t, turned, distance = contact
    sense = polar_sense(build_device().motion, line, gear, t)
    point = PitchPoint(q.on_curve, q.on_radius, q.on_turned)
    places = pitch_places(line, distance, sense, point, PitchPoint(t, S.Zero, turned))
    start = displacement(O, centre, WORLD)
    components = [(start + place.resolved(WORLD))[i] for place in places for i in (0, 1)]
    steps = let_all(q.PAIR, components, "gears roll")
    return ClosedForm(name, inputs, steps, Vector(f"{name}_points", q.PAIR))


def name_supports() -> dict[str, dict[str, str]]:
    """Return the names of the forces of the frame on sun and carrier, by body and axis."""
    return build_device().name_supports(q.TOTALS)


def exact_lane() -> Lane:
    """Return the lane of the device from first principles, over the carrier angle."""
    return build_device().twin_lane(Sides(q.twin, q.REPORTED_EXACT, q.TOTALS), q.INPUTS)


def build_exact_system() -> System:
    """Build the model of the device from first principles."""
    title, source = "Planting device, from first principles", "derived (Newton-Euler)"
    return System(
        "planting_exact",
        title,
        source,
        ASSUMPTIONS,
        exact_lane(),
        closed_forms(),
        supports=name_supports(),
    )


def build_printed_system(paper: Chain, frame: Chain) -> System:
    """Build the model of the device as a paper prints it: its equations with the kinematics of this
    module.
    """
    m = build_device()
    forces = (*paper.lets(), m.assembly.law(q.F_E_loss))
    lane = m.twin_lane(Sides(q.twin, q.REPORTED, q.TOTALS), q.INPUTS, forces, frame.lets())
    title, source = "Planting device, as printed", "wang2017 (1)-(31), taken literally"
    return System(
        "planting_printed",
        title,
        source,
        ASSUMPTIONS,
        lane,
        closed_forms(),
        supports=name_supports(),
    )


SYSTEMS = (build_exact_system,)
