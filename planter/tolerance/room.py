"""What a machine's room brings beside what `planter.sweeps.room` asks for, so that its machines can have tolerances."""

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

    `sum_text` replaces the sum of the machine's file, `holds` are further limits, `ranges` are other values to search
    in, by path between ends in their units.
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
        """Whether a call says what is searched, not the file alone."""
        return self.sum_text is not None or bool(self.holds or self.ranges)


class Subject(room.Subject, Protocol):
    """A machine whose turns are evaluated in rows, and at one point with slopes."""

    def slopes(self, point: Array) -> tuple[Array, Array] | None:
        """Outputs (k,) at a point (n,) and their exact slopes (k, n), in shown units; None where there are none."""

    def curves(self, keys: Sequence[str], points: Array) -> Mapping[str, Array]:
        """Quantities over a turn, (m, angles) each, at points (m, n), and the angles `phi_deg` themselves."""


class Room(room.Room, Protocol):
    """Machines of a kind."""

    banded: Sequence[str]
    """Outputs where none are asked for."""
    curves: Sequence[str]
    """Quantities that are drawn over a turn."""
    paths: Sequence[tuple[str, str]]
    """Pairs of quantities that are drawn as a path."""

    def nominal(self, machine: Any) -> Mapping[str, float]:
        """The value of each input in the file."""

    def tolerances(self, machine: Any) -> Mapping[str, Mapping[str, Any]]:
        """Tolerances where none are given, as a file has them; none where nothing can be assumed."""

    def robust(
        self, machine: Any, choices: Mapping[str, str], spreads: Mapping[str, Spread], settings: Settings,
        progress: Listener | None,
    ) -> RobustFound | None:  # fmt: skip
        """The design with the least mean plus some standard deviations of the objective; None where there is none."""
