"""Where a design may lie, and the variables that a search sees."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.kernels import Array


@dataclass(frozen=True)
class Box:
    """Bounds (p,) on designs x (p,) with names, the design to start from, and the search's variables u (p,).

    x = origin + unit * u, so that u lies between `bottom` and `top`; `design` may lie outside the bounds.
    """

    names: tuple[str, ...]
    lower: Array
    upper: Array
    design: Array
    origin: Array
    unit: Array

    @classmethod
    def shares(cls, names: tuple[str, ...], lower: Array, upper: Array, design: Array) -> Box:
        """Searched in shares of the box: u in [0, 1]^p, whatever the units of the design."""
        return cls(names, lower, upper, design, lower, upper - lower)

    @classmethod
    def plain(cls, names: tuple[str, ...], lower: Array, upper: Array, design: Array) -> Box:
        """Searched as it is: u = x."""
        return cls(names, lower, upper, design, np.zeros(len(lower)), np.ones(len(lower)))

    @cached_property
    def bottom(self) -> Array:
        found: Array = (self.lower - self.origin) / self.unit
        return found

    @cached_property
    def top(self) -> Array:
        found: Array = (self.upper - self.origin) / self.unit
        return found

    @cached_property
    def start(self) -> Array:
        """The point u (p,) of the design to start from, taken into the box."""
        return self.point(self.design)

    def point(self, x: Array) -> Array:
        """Return the point u (p,) of a design x (p,), taken into the box."""
        return self.inside((x - self.origin) / self.unit)

    def at(self, u: Array) -> Array:
        """The design x (p,) at a point u (p,); on an upper bound it is that bound to the last bit."""
        return np.clip(np.where(u >= self.top, self.upper, self.origin + u * self.unit), self.lower, self.upper)

    def inside(self, u: Array) -> Array:
        """A point u (p,) taken into the box."""
        return np.clip(u, self.bottom, self.top)

    def room(self, u: Array) -> tuple[Array, Array]:
        """How far a point u (p,) is above the lower bounds and below the upper ones, (p,) each; negative outside."""
        return u - self.bottom, self.top - u

    def snapped(self, u: Array, margin: float) -> Array:
        """A point u (p,) with coordinates closer than `margin` to their bounds set onto them."""
        low, high = u < self.bottom + margin, u > self.top - margin
        return np.where(low, self.bottom, np.where(high, self.top, u))
