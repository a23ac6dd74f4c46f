"""The device on a motor as rows of tables, and on the screen."""

from __future__ import annotations

from planter.engine.tables import drive_tables
from planter.planting.results import DriveFound
from planter.terminal.console import Console

FORCES = ("vertical support force / N", "driven", "at constant speed")


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
    for table in drive_tables(found):
        console.table(table.title, table.head, table.rows)
    console.table("Forces", FORCES, forces(found))
