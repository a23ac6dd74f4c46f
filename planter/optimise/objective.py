"""What a problem makes small: a weighted range of rows, if it has any, and a smooth function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise.conditions import Conditions, Functions, Look
from planter.optimise.samples import Hold


@dataclass(frozen=True)
class Evaluation:
    """The objective at a design and, of one over a turn, what the turn looks like."""

    objective: float
    look: Look = field(default_factory=Look)


class Local(Functions, Protocol):
    """An objective near a design as functions that are smooth there."""

    def evaluate(self, x: Array) -> Evaluation:
        """The objective itself, as far as it can be told here."""

    def grown(self, x: Array, high: float, low: float) -> Local:
        """With the rows that are missing if those at x are to stay within [low, high]."""


class Kinks(Protocol):
    """Where an objective has kinks: joints that pass its rows, to be kept on one side of them or on the kink."""

    def near(self, x: Array) -> list[tuple[Hold, float]]: ...

    def wall(self, pin: Hold, distance: float) -> Hold: ...


class Objective(Protocol):
    """weight * (largest upper row - least lower row) + a smooth function, over designs x (p,).

    `unit` is what counts as one in residuals and tolerances; None: its value at the design to start from. `felt` (p,)
    marks the parameters that it feels at all. `windows` says that its rows move with the design, so that a solve which
    failed is worth another with new ones. `kinks` is None where it is smooth but for its rows.
    """

    @property
    def weight(self) -> float: ...
    @property
    def unit(self) -> float | None: ...
    @property
    def felt(self) -> Flags: ...
    @property
    def windows(self) -> bool: ...
    @property
    def kinks(self) -> Kinks | None: ...

    def evaluate(self, x: Array) -> Evaluation: ...

    def local(self, x: Array, holds: Sequence[Hold] = ()) -> Local:
        """The objective near a design, joints held as told."""

    def conditions(self, x: Array) -> Conditions:
        """First-order data at a design; gradients in the design."""
