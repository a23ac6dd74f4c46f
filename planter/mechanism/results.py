"""Results of the commands for mechanisms of one's own, as their JSON has them."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True)
class Quantity(Record):
    """A quantity over a turn: extremes with their angles [deg], mean, root mean square."""

    unit: str
    min: float
    max: float
    mean: float
    rms: float
    min_deg: float
    max_deg: float


@dataclass(frozen=True)
class Law(Record):
    """A law of mechanics, and the largest amount by which the results break it."""

    law: str
    violation: float
    unit: str


@dataclass(frozen=True)
class Turn(Record):
    """A turn of a mechanism; works [J] by what does them."""

    machine: str
    samples: int
    quantities: dict[str, Quantity]
    work: dict[str, float]
    laws: list[Law]


@dataclass(frozen=True)
class Course(Record):
    """A quantity over a time."""

    unit: str
    min: float
    max: float
    last: float


@dataclass(frozen=True)
class Energy(Record):
    """Energy of weights, springs and motion; given loads and dampers move it."""

    start_J: float
    least_J: float
    most_J: float


@dataclass(frozen=True)
class Motion(Record):
    """A free motion; eigenvalues are pairs of real and imaginary part, at the state of rest."""

    machine: str
    until_s: float
    quantities: dict[str, Course]
    energy: Energy
    redundant_constraints: int
    equilibrium: dict[str, float] | None = None
    eigenvalues_per_s: list[tuple[float, float]] | None = None


COMMANDS = {"turn": Turn, "move": Motion}
"""What the room's commands return."""
