"""The planting device with assumptions lifted: speed varies, teeth slide, the roller rubs along the hinge.

Each lifted assumption is an input of its own; with all of them zero the forces are those of the exact model.
"""

from __future__ import annotations

from dataclasses import fields

from sympy import Expr

from ...mechanics.contacts import GearContact, SlidingContact
from ...mechanics.twins import Sides
from ...model import System
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
s_P = Quantity("s_P", "m", "distance of the contact from P along the line of action, along the normal force", _SOURCE)
s_Q = Quantity("s_Q", "m", "distance of the contact from Q along the line of action, along the normal force", _SOURCE)
LIFTED = Vector("lifted", (speed_rate, against, along_hinge, s_P, s_Q))

TURNING_P = -(q.omega + q.phi52_dot)
"""Rate of the sun relative to the middle body."""
TURNING_Q = q.phi52_dot - q.phi72_dot
"""Rate of the middle body relative to the planet."""
LOSSES = tuple(
    Quantity(f"F_{tag}_loss", "W", f"power lost to friction between the teeth at {tag}", _SOURCE) for tag in "PQ"
)
ASSUMPTIONS = (
    "as the exact model, but for what the inputs lift: constant speed, tooth friction outwards at the pitch point, "
    "no friction along the hinge",
)


def sliding(contact: GearContact, beyond: Expr, turning: Expr) -> SlidingContact:
    """A contact of teeth that slides."""
    own = {field.name: getattr(contact, field.name) for field in fields(contact)}
    return SlidingContact(**own, beyond=beyond, turning=turning, share=against)


def lifted() -> System:
    """The device from first principles, with assumptions lifted."""
    contacts = derivation.Contacts(
        sliding(derivation.CONTACT_P, s_P, TURNING_P), sliding(derivation.CONTACT_Q, s_Q, TURNING_Q), along_hinge
    )
    sides = Sides(q.twin, (*q.REPORTED_EXACT, *LOSSES), q.TOTALS)
    lane = derivation.device(contacts, speed_rate).twin_lane(sides, (*q.INPUTS, LIFTED))
    title = "Planting device, from first principles, assumptions lifted"
    return System("planting_lifted", title, "derived (Newton-Euler)", ASSUMPTIONS, lane)


SYSTEMS = (lifted,)
