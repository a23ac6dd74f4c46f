"""Whole teeth that a design is to have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Wanted:
    """Modules [m] and teeth of the inner gears of stages 1 and 2.

    A stage without a module is left as it is; one with a module and without teeth has those that are best.
    """

    modules: tuple[float | None, ...]
    teeth: tuple[int | None, ...]

    @property
    def stages(self) -> tuple[int, ...]:
        """The stages, 0 and 1, that have a module."""
        return tuple(k for k, module in enumerate(self.modules) if module is not None)

    @property
    def settled(self) -> bool:
        """Whether all teeth are known."""
        return all(self.teeth[k] is not None for k in self.stages)

    def of(self, teeth: Sequence[int]) -> Wanted:
        """With so many teeth on the gears of the stages that have a module."""
        found = list(self.teeth)
        for k, z in zip(self.stages, teeth, strict=True):
            found[k] = z
        return replace(self, teeth=tuple(found))

    def pitch(self, stage: int) -> float:
        """Arc of the pitch curve that a tooth takes [m], for a stage that has a module."""
        return float(np.pi * (self.modules[stage] or 0.0))

    def __str__(self) -> str:
        """As a sentence says it: 31 teeth of 2 mm on stage 1 and 33 teeth of 2 mm on stage 2."""
        told = [
            f"{self.teeth[k]} teeth of {1e3 * (self.modules[k] or 0.0):.6g} mm on stage {k + 1}" for k in self.stages
        ]
        return " and ".join(told)

    def length(self, stage: int) -> float:
        """Length of the pitch curve [m], for a stage whose teeth are known."""
        return self.pitch(stage) * (self.teeth[stage] or 0)
