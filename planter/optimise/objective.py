"""What a problem makes small: a weighted range of rows, if it has any, and what it makes of a smooth function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from planter.kernels import Array
from planter.numerics.arrays import Flags
from planter.optimise.conditions import Conditions, Local, Look
from planter.optimise.samples import Hold


@dataclass(frozen=True)
class Evaluation:
    """The objective at a design, and what it is made of."""

    objective: float
    look: Look


class Kinks(Protocol):
    """Where an objective has kinks: joints that pass its rows, to be kept on one side of them or on the kink."""

    def near(self, x: Array) -> list[tuple[Hold, float]]: ...

    def wall(self, pin: Hold, distance: float) -> Hold: ...


class Objective(Protocol):
    """weight * (largest upper row - least lower row) + outer(a smooth function), over designs x (p,).

    `unit` is what counts as one in residuals and tolerances; None: its value at the design to start from. `felt` (p,)
    marks the parameters that it feels at all. `windows` says that its rows move with the design, so that none of them
    serves a whole descent. `kinks` is None where it is smooth but for its rows.
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

    def outer(self, smooth: float) -> tuple[float, float, float]:
        """What the smooth function's value adds to the objective, with first and second derivative."""

    def look(self, x: Array) -> Look: ...

    def local(self, x: Array, holds: Sequence[Hold] = ()) -> Local:
        """The objective near a design, joints held as told."""

    def conditions(self, x: Array) -> Conditions:
        """First-order data at a design; gradients in the design."""

    def flat(self, x: Array) -> Array:
        """Directions (k, p) in the design that the objective does not feel at one, to first order."""


def evaluation(objective: Objective, look: Look) -> Evaluation:
    """What an objective makes of a look at a design."""
    return Evaluation(objective.weight * look.range + objective.outer(look.smooth)[0], look)
