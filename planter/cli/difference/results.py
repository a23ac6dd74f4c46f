"""Results of `planter diff`, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.files.record import Record


@dataclass(frozen=True)
class ComparedMachine(Record):
    """A machine of a comparison, and the kind that all machines share."""

    name: str
    file: str
    kind: str


@dataclass(frozen=True)
class ComparedValue(Record):
    """A value of the files that differs, for each machine; null where a file has none."""

    name: str
    unit: str
    values: list[bool | float | str | None]


@dataclass(frozen=True)
class ComparedResult(Record):
    """A result of each machine, by true extremes and integrals over a cycle.

    `difference` is that of each further machine from the first. `better` is the index of the best
    machine where a direction is stated (the objective and its terms, margins of requirements), null
    if none is or none is best.
    """

    name: str
    unit: str
    values: list[float | None]
    difference: list[float | None]
    better: int | None


@dataclass(frozen=True)
class ComparedRequirement(Record):
    """A limit on each machine: the values, and whether they satisfy it; null where a machine has no
    such value.
    """

    limit_on: str
    limit: float
    unit: str
    values: list[float | None]
    met: list[bool | None]


@dataclass(frozen=True)
class ComparedCurve(Record):
    """A quantity of each machine (m, n) at the angles of the drive (n,) [deg]."""

    name: str
    unit: str
    phi_deg: list[float]
    values: list[list[float]]


@dataclass(frozen=True)
class MachineComparison(Record):
    """`planter diff`: machines of one kind, values that differ, results, requirements and curves
    side by side.
    """

    machines: list[ComparedMachine]
    values: list[ComparedValue]
    results: list[ComparedResult]
    requirements: list[ComparedRequirement]
    curves: list[ComparedCurve]


COMMANDS = {"diff": MachineComparison}
"""Results by command."""
