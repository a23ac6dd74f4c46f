"""What `planter drive` returns of a planting device, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.engine.drive import DriveResult
from planter.planting.results.stated import Statistics


@dataclass(frozen=True)
class DriveFound(DriveResult):
    """`planter drive`: the same of a planting device, with its support force in that turn and at constant speed.

    `change_N` is the most by which the support force differs between them.
    """

    support_force: Statistics
    constant_speed: Statistics
    change_N: float
