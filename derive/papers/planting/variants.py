"""Variants of the planting device's model: the support force alone, and relaxed assumptions.

Weight and momentum of a machine's parts make its support force; if action equals reaction, the
contact forces inside the machine cancel, and so do the accelerations that have opposite signs on
the two sides, half a revolution apart.

Each relaxed assumption (constant speed, tooth friction at the pitch point, no friction along the
hinge) is an input; if all of them are zero, the forces are those of the exact model. Energies
follow from the motion alone, so that the energy law tests the forces.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields, replace

from sympy import Expr, S, Symbol

from ...functions import Polynomial, clip
from ...influence import Influence, flatten_products, side_share
from ...mechanics.bodies import kinetic_energy, potential_energy
from ...mechanics.contacts import GearContact, SharedContact
from ...mechanics.driven_motion import Sides
from ...mechanics.free_bodies import build_load_function
from ...mechanics.mechanism import Mechanism
from ...model import Effects, Lane, Let, System, join_entries
from ...quantity import Quantity, Vector, read_quantities
from . import derivation, flanks
from . import quantities as q

s = read_quantities(
    """
derived: support force
F_share | N | contribution of one side to the vertical support force
x_r | 1 | completed share of the rise
x_f | 1 | completed share of the fall

derived: assumption lifted
speed_rate | rad/s2 | angular acceleration of the carrier
against | 1 | 1: friction of the teeth acts against the sliding; 0: outwards, as in wang2017
along_hinge | 1 | share of the roller's sliding along the hinge that causes friction on the cam

derived: drive
T_side | J | kinetic energy of a side
V_side | J | potential energy of a side: weights and return spring
"""
)
"""Quantities of this module."""
COORDINATES = frozenset(
    q.TABLE.select("phi52 phi52_dot phi52_ddot alpha Omega Omega_dot theta1 theta1_dot theta1_ddot")
)
"""Motion of a side, in terms of which its momentum is expressed."""


def cam_steps() -> tuple[Let, ...]:
    """Return swing and rates as polynomials in the shares of the flanks, which follow the default
    law.

    As a flank begins and ends at rest, the derivatives of the clipped law are those of the law at
    the clipped share.
    """
    x, laws = flanks.x, flanks.derive_flank_law(flanks.DEFAULT)
    if any(law.subs(x, end) != 0 for law in laws[1:] for end in (0, 1)):
        raise ValueError("a flank does not begin and end at rest")
    ends = ((s.x_r, *q.delta_r, 1), (s.x_f, *q.delta_f, -1))
    swing, slope, bend = (
        q.H
        * sum(
            sign * Polynomial.of(law, x, at) / (end - start) ** n for at, start, end, sign in ends
        )
        for n, law in enumerate(laws)
    )
    source = "derived: cam law"
    shares = (
        Let(at, clip((q.delta - start) / (end - start), S.Zero, S.One), source)
        for at, start, end, _ in ends
    )
    return (
        *shares,
        Let(q.theta1, swing, source),
        Let(q.dpsi_ddelta, slope, source),
        Let(q.theta1_dot, -q.phi72_dot * q.dpsi_ddelta, source),
        Let(q.theta1_ddot, q.phi72_dot**2 * bend - q.phi72_ddot * q.dpsi_ddelta, source),
    )


def with_polynomials(lane: Lane) -> Lane:
    """Return a lane with the cam's steps as polynomials."""
    steps = cam_steps()
    written = {symbol for step in steps for symbol in step.defines}
    first = next(i for i, step in enumerate(lane.steps) if written & set(step.defines))
    before, after = (
        tuple(step for step in part if not written & set(step.defines))
        for part in (lane.steps[:first], lane.steps[first:])
    )
    return replace(lane, steps=(*before, *steps, *after))


def build_share_system(model: System, flat: bool) -> System:
    """Build the model of a side's contribution to the support force.

    ``flat``: as a sum of products of functions of the coordinates. Raises ValueError for a model
    without a lane.
    """
    if model.lane is None:
        raise ValueError(f"{model.name} has no lane")
    polynomial = with_polynomials(model.lane)
    influence = Influence(polynomial, side_share(polynomial, q.F_support, s.F_share))
    steps = influence.reduced()
    if flat:
        steps = flatten_products(steps, s.F_share, COORDINATES)
    name = model.name.replace("planting_", "planting_support_")
    lane = Lane(q.phi, q.INPUTS, steps, Vector("share", (s.F_share,)))
    effects = Effects(_names(model.lane, influence.without), influence.felt)
    return System(
        name,
        f"{model.title}: support force",
        model.source,
        model.assumptions,
        lane,
        effects=effects,
    )


def _names(lane: Lane, symbols: Iterable[Symbol]) -> tuple[str, ...]:
    inputs = [quantity.name for vector in lane.inputs for quantity in join_entries(vector)]
    gone = {symbol.name for symbol in symbols}
    return tuple(name for name in inputs if name in gone)


def build_support_system() -> System:
    """Build the support force of the device from first principles."""
    return build_share_system(derivation.build_exact_system(), flat=True)


_RELAXED = "derived: assumption lifted"


def _flank_pair(name: str, unit: str, meaning: str, tag: str) -> tuple[Quantity, Quantity]:
    """Return a quantity of both flanks of a mesh: that which turns the outer gear anticlockwise
    (+1), or not (-1).
    """
    plus, minus = (
        Quantity(
            f"{name}_{tag}_{flank}",
            unit,
            f"{meaning} {tag}, on the flank that turns the outer gear {way}",
            _RELAXED,
        )
        for flank, way in (("plus", "anticlockwise"), ("minus", "clockwise"))
    )
    return plus, minus


LEADS = {
    tag: _flank_pair(
        "lead",
        "1",
        "normal force on the inner gear that acts ahead of, less that behind, by share,",
        tag,
    )
    for tag in "PQ"
}
AWAYS = {
    tag: _flank_pair("away", "m", "mean distance of the normal force from", tag) for tag in "PQ"
}
LIFTED = Vector(
    "lifted",
    (
        s.speed_rate,
        s.against,
        s.along_hinge,
        *(q for tag in "PQ" for pair in (LEADS[tag], AWAYS[tag]) for q in pair),
    ),
)

TURNING_P = -(q.omega + q.phi52_dot)
"""Rate of the sun relative to the middle body."""
TURNING_Q = q.phi52_dot - q.phi72_dot
"""Rate of the middle body relative to the planet."""
LOSSES = tuple(
    Quantity(f"F_{tag}_loss", "W", f"power lost to friction between the teeth at {tag}", _RELAXED)
    for tag in "PQ"
)
POWERS = {
    tag: Quantity(
        f"F_{tag}_power",
        "W",
        f"power of the inner gear on the outer one at {tag}, seen from the carrier",
        _RELAXED,
    )
    for tag in "PQ"
}
RELAXED_ASSUMPTIONS = (
    "as the exact model, but for what the inputs lift: constant speed, tooth friction outwards at "
    "the pitch point, "
    "no friction along the hinge",
    "friction angle of the teeth the same all along their flanks",
)


def _shared_contact(contact: GearContact, tag: str, turning: Expr) -> SharedContact:
    """Return a contact of sliding teeth, whose pairs share the load."""
    parameters = {field.name: getattr(contact, field.name) for field in fields(contact)}
    return SharedContact(
        **parameters, turning=turning, share=s.against, leads=LEADS[tag], aways=AWAYS[tag]
    )


ACROSS_SHAFTS = ("x", "y")
"""Axes of places of loads: along the shafts no input says where the outer half of the nozzle is."""


def _add_energies(m: Mechanism) -> None:
    """Add the energies of the bodies of a side and of its spring, whose force is S0 + k_s times its
    stretch.
    """
    side = [body for body in m.bodies if body not in m.shared]
    (force,) = (step.expr for step in m.named if step.symbol == q.S)
    stretch = force.diff(q.k_s)
    stored = q.S0 * stretch + q.k_s * stretch**2 / 2
    m.let(s.T_side, kinetic_energy(m.motion, side, m.world))
    m.let(s.V_side, potential_energy(m.assembly, side, m.O, m.world) + stored)


def build_relaxed_system() -> System:
    """Build the model of the device from first principles, with relaxed assumptions, energies and
    the loads on all bodies, of side 1 and of what both sides share.
    """
    contacts = derivation.DeviceContacts(
        _shared_contact(derivation.CONTACT_P, "P", TURNING_P),
        _shared_contact(derivation.CONTACT_Q, "Q", TURNING_Q),
        s.along_hinge,
    )
    device = derivation.build_device(contacts, s.speed_rate)
    for power, moment, rate in (
        (POWERS["P"], q.M_P, q.phi52_dot),
        (POWERS["Q"], q.M_Q, q.phi72_dot),
    ):
        device.assembly.unknowns.append(power)
        device.assembly.laws.append(Let(power, moment * rate, f"derived: {power.meaning}"))
    _add_energies(device)
    reported = (*q.REPORTED_EXACT, *LOSSES, *POWERS.values(), s.T_side, s.V_side)
    inputs, rates = (*q.INPUTS, LIFTED), sorted(COORDINATES.difference(reported), key=str)
    entries = (q.phi, *(entry for packed in inputs for entry in join_entries(packed)))
    (loads,), texts = build_load_function(
        device, (*entries, *q.TOTALS, *reported, *rates), ACROSS_SHAFTS
    )
    state = [symbol for symbol in join_entries(loads.inputs[0]) if symbol not in entries]
    shared = set(device.assembly.unknowns).difference(device.unknowns)
    of_side = (*reported, *(symbol for symbol in state if symbol not in shared))
    of_both = dict.fromkeys((*q.TOTALS, *(symbol for symbol in state if symbol in shared)))
    lane = device.twin_lane(Sides(q.twin, of_side, tuple(of_both)), inputs)
    title = "Planting device, from first principles, assumptions lifted"
    return System(
        "planting_lifted",
        title,
        "derived (Newton-Euler)",
        RELAXED_ASSUMPTIONS,
        lane,
        (loads,),
        loads=tuple(load.describe() for load in texts),
    )


SYSTEMS = (build_support_system, build_relaxed_system)
