"""What `planter drive` returns, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.planting.results.stated import Statistics
from planter.records import Record


@dataclass(frozen=True)
class MotorGiven(Record):
    """A motor and what turns with it, as the carrier feels them."""

    stall_Nm: float
    idle_rpm: float
    flywheel_kgm2: float


@dataclass(frozen=True)
class Speed(Record):
    """The carrier's speed over a turn that repeats itself; the fluctuation is the range over the mean."""

    mean_rpm: float
    max_rpm: float
    min_rpm: float
    fluctuation: float
    max_deg: float
    min_deg: float


@dataclass(frozen=True)
class DriveFound(Record):
    """`planter drive`: a turn that repeats itself, and the same at its mean speed, held constant.

    `change_N` is the most by which the support force differs between them; `imbalance_W` the most by which the motor's
    power misses the rate of all energies and the power of friction; `turns_rpm` are speeds at the starts of turns.
    """

    machine: str
    motor: MotorGiven
    samples: int
    speed: Speed
    support_force: Statistics
    constant_speed: Statistics
    change_N: float
    motor_work_J: float
    friction_work_J: float
    imbalance_W: float
    turns_rpm: list[float]
