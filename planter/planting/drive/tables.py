"""The device on a motor as rows of tables, and on the screen."""

from __future__ import annotations

from planter.planting.results.driven import DriveFound
from planter.terminal.console import Console

Row = tuple[str, float, str]
FORCES = ("vertical support force / N", "driven", "at constant speed")


def motor(found: DriveFound) -> list[Row]:
    """Motor, flywheel, and what they do over a turn that repeats itself."""
    given = found.motor
    return [
        ("torque at rest", given.stall_Nm, "N m"),
        ("speed without load", given.idle_rpm, "r/min"),
        ("flywheel", given.flywheel_kgm2, "kg m2"),
        ("work of the motor over a turn", found.motor_work_J, "J"),
        ("work of friction over a turn", found.friction_work_J, "J"),
        ("power that is missing, at most", found.imbalance_W, "W"),
    ]


def speed(found: DriveFound) -> list[Row]:
    """The carrier's speed over that turn."""
    told = found.speed
    return [
        ("mean", told.mean_rpm, "r/min"),
        (f"largest, at {told.max_deg:.4g} deg", told.max_rpm, "r/min"),
        (f"least, at {told.min_deg:.4g} deg", told.min_rpm, "r/min"),
        ("range over mean", told.fluctuation, "1"),
    ]


def forces(found: DriveFound) -> list[tuple[str, float, float | None]]:
    """Support forces in that turn, and at its mean speed."""
    own, other = found.support_force, found.constant_speed
    return [
        ("largest", own.max_N, other.max_N),
        ("least", own.min_N, other.min_N),
        ("range", own.range_N, other.range_N),
        ("mean", own.mean_N, other.mean_N),
        ("largest difference", found.change_N, None),
    ]


def show(console: Console, found: DriveFound) -> None:
    """Motor, speed, forces."""
    console.table(f"{found.machine} on a motor", ("", "", "unit"), motor(found))
    console.table("Speed of the carrier over a turn that repeats itself", ("", "", "unit"), speed(found))
    console.table("Forces", FORCES, forces(found))
