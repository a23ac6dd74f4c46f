"""The planting device with assumptions lifted: speed varies, teeth slide, the roller rubs along the hinge.

Each lifted assumption is an input of its own; with all of them zero the forces are those of the exact model.
"""

from __future__ import annotations

from dataclasses import fields

from sympy import Expr

from ...mechanics.contacts import GearContact, SharedContact
from ...mechanics.twins import Sides
from ...model import Let, System
from ...quantity import Quantity, Vector
from . import derivation
from . import quantities as q

_SOURCE = "derived: assumption lifted"
speed_rate = Quantity("speed_rate", "rad/s2", "angular acceleration of the carrier", _SOURCE)
against = Quantity(
    "against", "1", "1: friction of the teeth acts against the sliding; 0: outwards, as in wang2017", _SOURCE
)
along_hinge = Quantity(
    "along_hinge", "1", "share of the roller's sliding along the hinge that rubs on the cam", _SOURCE
)


def _of_flanks(name: str, unit: str, meaning: str, tag: str) -> tuple[Quantity, Quantity]:
    """A quantity of both flanks of a mesh: of the one that turns the outer gear with (+1), and against (-1)."""
    plus, minus = (
        Quantity(
            f"{name}_{tag}_{flank}", unit, f"{meaning} {tag}, on the flank that turns the outer gear {way}", _SOURCE
        )
        for flank, way in (("plus", "anticlockwise"), ("minus", "clockwise"))
    )
    return plus, minus


LEADS = {
    tag: _of_flanks("lead", "1", "normal force on the inner gear that acts ahead of, less that behind, by share,", tag)
    for tag in "PQ"
}
AWAYS = {tag: _of_flanks("away", "m", "mean distance of the normal force from", tag) for tag in "PQ"}
LIFTED = Vector("lifted", (
    speed_rate, against, along_hinge, *(q for tag in "PQ" for pair in (LEADS[tag], AWAYS[tag]) for q in pair)
))  # fmt: skip

TURNING_P = -(q.omega + q.phi52_dot)
"""Rate of the sun relative to the middle body."""
TURNING_Q = q.phi52_dot - q.phi72_dot
"""Rate of the middle body relative to the planet."""
LOSSES = tuple(
    Quantity(f"F_{tag}_loss", "W", f"power lost to friction between the teeth at {tag}", _SOURCE) for tag in "PQ"
)
POWERS = {
    tag: Quantity(
        f"F_{tag}_power", "W", f"power of the inner gear on the outer one at {tag}, seen from the carrier", _SOURCE
    )
    for tag in "PQ"
}
ASSUMPTIONS = (
    "as the exact model, but for what the inputs lift: constant speed, tooth friction outwards at the pitch point, "
    "no friction along the hinge",
    "friction angle of the teeth the same all along their flanks",
)


def shared(contact: GearContact, tag: str, turning: Expr) -> SharedContact:
    """A contact of teeth that slide, in pairs that share the load."""
    own = {field.name: getattr(contact, field.name) for field in fields(contact)}
    return SharedContact(**own, turning=turning, share=against, leads=LEADS[tag], aways=AWAYS[tag])


def lifted() -> System:
    """The device from first principles, with assumptions lifted."""
    contacts = derivation.Contacts(
        shared(derivation.CONTACT_P, "P", TURNING_P), shared(derivation.CONTACT_Q, "Q", TURNING_Q), along_hinge
    )
    device = derivation.device(contacts, speed_rate)
    for power, moment, rate in ((POWERS["P"], q.M_P, q.phi52_dot), (POWERS["Q"], q.M_Q, q.phi72_dot)):
        device.assembly.unknowns.append(power)
        device.assembly.laws.append(Let(power, moment * rate, f"derived: {power.meaning}"))
    sides = Sides(q.twin, (*q.REPORTED_EXACT, *LOSSES, *POWERS.values()), q.TOTALS)
    lane = device.twin_lane(sides, (*q.INPUTS, LIFTED))
    title = "Planting device, from first principles, assumptions lifted"
    return System("planting_lifted", title, "derived (Newton-Euler)", ASSUMPTIONS, lane)


SYSTEMS = (lifted,)
