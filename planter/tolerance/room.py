"""Adapters of machines for tolerances: the protocol of `planter.sweeps.room` with slopes, curves and robust designs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from planter.kernels import Array
from planter.progress import Listener
from planter.sweeps import room
from planter.tolerance.results import RobustFound
from planter.tolerance.spread import Spread


@dataclass(frozen=True)
class Settings:
    """Settings of a robust design: standard deviations added to the mean, random machines, starts, a seed.

    `sum_text` replaces the sum of the machine file, `holds` are further limits, `ranges` the bounds of further design
    variables, by path, in display units.
    """

    sigmas: float = 3.0
    machines: int = 128
    starts: int = 2
    seed: int = 0
    sum_text: str | None = None
    holds: tuple[str, ...] = ()
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def is_stated(self) -> bool:
        """Return whether options, not the file alone, define the search."""
        return self.sum_text is not None or bool(self.holds or self.ranges)


class Subject(room.Subject, Protocol):
    """A machine that evaluates rows of inputs, and slopes at one point."""

    def slopes(self, point: Array) -> tuple[Array, Array] | None:
        """Return outputs (k,) at a point (n,) and their exact slopes (k, n), in display units; None without slopes."""

    def curves(self, keys: Sequence[str], points: Array) -> Mapping[str, Array]:
        """Return quantities over a cycle, (m, angles) each, at points (m, n), and their angles `phi_deg`."""


class Room(room.Room, Protocol):
    """Adapter of a kind of machines."""

    banded: Sequence[str]
    """Default outputs."""
    curves: Sequence[str]
    """Quantities with figures over a cycle."""
    paths: Sequence[tuple[str, str]]
    """Pairs of quantities with figures of a path."""

    def nominal(self, machine: Any) -> Mapping[str, float]:
        """Return the values of the inputs in the file, in display units."""

    def tolerances(self, machine: Any) -> Mapping[str, Mapping[str, Any]]:
        """Return the default tolerances as the table of a file, empty if the kind has none."""

    def robust(
        self, machine: Any, choices: Mapping[str, str], spreads: Mapping[str, Spread], settings: Settings,
        progress: Listener | None,
    ) -> RobustFound | None:  # fmt: skip
        """Return the design with the smallest mean plus `sigmas` standard deviations of the objective.

        None if the machine has no objective or no design variables.
        """
