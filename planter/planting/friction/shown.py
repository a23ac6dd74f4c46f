"""Quantities that are shown over a turn with each kind of friction of the teeth, with what they mean."""

from __future__ import annotations

from planter.files import units
from planter.gears.results import KINDS, name_column

JOINTS = {
    "F_A1": "size of the carrier's force on the middle shaft",
    "F_B1": "size of the carrier's force on the planet's shaft, across it",
    "F_O": "size of the frame's force on the sun",
    "F_O1": "size of the force of the sun's shaft on the carrier, across it",
}
TORQUES = {"M_L": "torque of the motor on the carrier"}
LOSSES = {
    "F_P_loss": "power lost between the teeth of sun and gear 5, side 1",
    "F_Q_loss": "power lost between the teeth of gear 6 and planet, side 1",
}


def columns() -> dict[str, str]:
    """What each column of a table over a turn means."""
    return {
        name_column(units.key(name, unit), kind): f"{meaning}; {said}"
        for names, unit in ((JOINTS, "N"), (TORQUES, "N m"), (LOSSES, "W"))
        for name, meaning in names.items()
        for kind, said in KINDS.items()
    }
