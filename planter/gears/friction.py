"""Effect of tooth friction on a machine: results, table and curves over a turn."""

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
"""Kinds of friction that are compared, and their descriptions."""
HEAD = ("friction", "without", "convention", "sliding", "nearest", "farthest", "at most")


@dataclass(frozen=True)
class FrictionCurves:
    """Friction result, and quantities (n,) at carrier angles (n,) [deg] by key with display unit, then by kind."""

    result: Friction
    phi_deg: Array
    curves: Mapping[str, Mapping[str, Array]]

    def columns(self) -> dict[str, Array]:
        """Return all columns of the table; the kind of friction precedes the unit in the key."""
        columns = {"phi_deg": self.phi_deg}
        for key, kinds in self.curves.items():
            columns |= {name_column(key, kind): values for kind, values in kinds.items()}
        return columns


def name_column(key: str, kind: str) -> str:
    """Return the key of a quantity with one kind of friction.

    >>> name_column("F_A1_N", "sliding")
    'F_A1_sliding_N'
    """
    unit = units.suffix(key)
    return f"{key.removesuffix(unit)}_{kind}{unit}"


def tabulate_friction(friction: Friction) -> Iterator[tuple[str | float | None, ...]]:
    """Yield the rows of the table under `HEAD`."""
    turns = (friction.without, friction.convention, friction.sliding, friction.nearest, friction.farthest)
    for name, bound in friction.at_most_N.items():
        yield f"{name} largest / N", *(turn.largest_N[name] for turn in turns), bound
    for name in friction.at_most_N:
        yield f"{name} rms / N", *(turn.rms_N[name] for turn in turns), None
    yield "torque largest / Nm", *(turn.torque_Nm.max for turn in turns), None
    yield "motor, work / J", *(turn.motor_work_J for turn in turns), None
    for location in friction.without.lost_J:
        yield f"lost, {location} / J", *(turn.lost_J[location] for turn in turns), None
    for stage in range(len(friction.pairs)):
        yield f"efficiency, mesh {stage + 1}", *(turn.efficiency[stage] for turn in turns), None
