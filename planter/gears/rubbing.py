"""What friction of teeth does to a machine: told, as a table, and over a turn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from planter.files import units
from planter.gears.results import Friction
from planter.kernels import Array

KINDS = {
    "without": "no friction of the teeth",
    "convention": "friction of the teeth by the paper's convention",
    "sliding": "friction of the teeth against their sliding",
}
"""Kinds of friction that are shown beside each other, and what they are."""
HEAD = ("friction", "without", "convention", "sliding", "nearest", "farthest", "at most")


@dataclass(frozen=True)
class Rubbing:
    """The result, and quantities (n,) at carrier angles (n,): by key in shown units, then by kind of friction."""

    found: Friction
    phi_deg: Array
    curves: Mapping[str, Mapping[str, Array]]

    def columns(self) -> dict[str, Array]:
        """All as a table: the kind of friction stands before the unit."""
        told = {"phi_deg": self.phi_deg}
        for key, kinds in self.curves.items():
            told |= {column(key, kind): values for kind, values in kinds.items()}
        return told


def column(key: str, kind: str) -> str:
    """The key of a quantity with one kind of friction.

    >>> column("F_A1_N", "sliding")
    'F_A1_sliding_N'
    """
    unit = units.suffix(key)
    return f"{key.removesuffix(unit)}_{kind}{unit}"


def rows(found: Friction) -> Iterator[tuple[str | float | None, ...]]:
    """What stands under HEAD."""
    turns = (found.without, found.convention, found.sliding, found.nearest, found.farthest)
    for name, bound in found.at_most_N.items():
        yield f"{name} largest / N", *(turn.largest_N[name] for turn in turns), bound
    for name in found.at_most_N:
        yield f"{name} rms / N", *(turn.rms_N[name] for turn in turns), None
    yield "torque largest / Nm", *(turn.torque_Nm.max for turn in turns), None
    yield "motor, work / J", *(turn.motor_work_J for turn in turns), None
    for place in found.without.lost_J:
        yield f"lost, {place} / J", *(turn.lost_J[place] for turn in turns), None
    for stage in range(len(found.pairs)):
        yield f"efficiency, mesh {stage + 1}", *(turn.efficiency[stage] for turn in turns), None
