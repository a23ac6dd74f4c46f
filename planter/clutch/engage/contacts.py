"""Which contacts the clutches have, those that carry the load first, and what they do together.

Distances, slips, the law and its generalised forces are generated; a function of one of several equal contacts takes
its number.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from planter.clutch.geometry import SIDES, VERTICES
from planter.kernels import formulas

MOTION, REULEAUX, DOG = "clutch_motion", "clutch_contact_reuleaux", "clutch_contact_dog"
"""Generated models: of what both clutches share, and of the contacts of each."""
Known = Mapping[str, ca.SX]


@dataclass(frozen=True)
class Contact:
    """A kind of contact: its model, the function of one, and how many there are."""

    model: str
    name: str
    count: int = 1


SHARED = (Contact(MOTION, "bearing"), Contact(MOTION, "linkage"))


def reuleaux() -> tuple[Contact, ...]:
    """Teeth on the shaft, the outline in the sleeve's hole."""
    return Contact(REULEAUX, "tooth", VERTICES), Contact(REULEAUX, "side", SIDES), *SHARED


def dog(jaws: int) -> tuple[Contact, ...]:
    """Jaws on jaws, the driving half in its fit."""
    return Contact(DOG, "jaw", jaws), Contact(DOG, "fit"), *SHARED


@dataclass(frozen=True)
class Together:
    """Signed distances [m] and normal forces [N] of all contacts, and the sums of all else that they do, by name."""

    gaps: ca.SX
    normal: ca.SX
    sums: dict[str, ca.SX]


def together(contacts: Sequence[Contact], known: Known) -> Together:
    """All contacts at what is known by name: places, rates, the law and the clutch's sizes."""
    found = [
        formulas.load(contact.model).composed(contact.name, {**known, "index": ca.SX(index)})
        for contact in contacts
        for index in range(contact.count)
    ]
    gaps, normal = (ca.vertcat(*(one.pop(name) for one in found)) for name in ("gap", "normal"))
    return Together(gaps, normal, {name: sum(one[name] for one in found) for name in found[0]})
