"""Smooth objectives and constraints, also from CasADi expressions, with exact derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

import casadi as ca
import numpy as np

from planter.engine.solvers.constraints import ConstraintKind, Constraints
from planter.engine.solvers.objective import (
    NO_GROUPS,
    NO_ROWS,
    BreakpointHold,
    Conditions,
    ObjectiveSummary,
)
from planter.kernels import Array, Flags, Integers, Kernel
from planter.numerics.arrays import LastCallCache


class SmoothFunction(Protocol):
    """A function of designs x (p,), smooth in the domain of a search."""

    def value(self, x: Array) -> float:
        """Return the value at a design x (p,)."""

    def gradient(self, x: Array) -> Array:
        """Return the gradient (p,) at a design x (p,)."""

    def hessian(self, x: Array) -> Array:
        """Return the Hessian (p, p) at a design x (p,)."""


class SmoothObjective:
    """Objective of a smooth function of `size` parameters, which is also its own local model."""

    weights, units, groups, kinks, windows = NO_ROWS, NO_ROWS, NO_GROUPS, None, False

    def __init__(self, function: SmoothFunction, size: int, unit: float | None = None) -> None:
        self.function, self.unit = function, unit
        self.sensitive: Flags = np.ones(size, dtype=bool)
        self.bounds = np.empty((2, 0))
        self._nothing = np.empty((0, size))

    def restart(self) -> None:
        """Forget nothing: a function depends on its design alone."""

    def summarise(self, x: Array) -> ObjectiveSummary:
        """Return the summary of the objective at a design x (p,)."""
        return ObjectiveSummary(self.function.value(x))

    def local(self, x: Array, holds: Sequence[BreakpointHold] = ()) -> SmoothObjective:
        """Return the local model of the objective near a design x (p,)."""
        return self

    def coarse(self, x: Array) -> None:
        """Return None: there are no samples."""

    def extended(self, x: Array, tops: Array) -> SmoothObjective:
        """Return the model, which has no rows."""
        return self

    def values(self, x: Array) -> Array:
        """Return the value (1,) at a design x (p,)."""
        return np.array([self.function.value(x)])

    def slopes(self, x: Array) -> Array:
        """Return the gradient (1, p) at a design x (p,)."""
        return self.function.gradient(x)[None]

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the Hessian (p, p), times its weight (1,)."""
        total: Array = weights[0] * self.function.hessian(x)
        return total

    def conditions(self, x: Array) -> Conditions:
        """Return first-order data at a design x (p,)."""
        nothing = self._nothing
        return Conditions(NO_ROWS, NO_GROUPS, nothing, self.function.gradient(x), nothing)

    def null_space(self, x: Array) -> Array:
        """Return the directions (k, p) to which the objective is insensitive at a design, to first
        order.
        """
        return self._nothing


Symbols = TypeVar("Symbols", ca.SX, ca.MX)


class SymbolicFunction:
    """A `Function` given as a CasADi expression in the symbols x (p,)."""

    def __init__(self, x: Symbols, f: Symbols) -> None:
        second = ca.densify(ca.hessian(f, x)[0])
        value = Kernel(ca.Function("objective", [x], [f], ["x"], ["f"]))
        gradient = Kernel(
            ca.Function("gradient", [x], [ca.densify(ca.gradient(f, x))], ["x"], ["df"])
        )
        self._hessian = Kernel(ca.Function("curvature", [x], [second], ["x"], ["ddf"]))
        self._value = LastCallCache(lambda x: float(value(x=x)["f"][0, 0]))
        self._gradient = LastCallCache(lambda x: gradient(x=x)["df"][:, 0])

    def value(self, x: Array) -> float:
        """Return the value at a design x (p,)."""
        return self._value(x)

    def gradient(self, x: Array) -> Array:
        """Return the gradient (p,) at a design x (p,)."""
        return self._gradient(x)

    def hessian(self, x: Array) -> Array:
        """Return the Hessian (p, p) at a design x (p,)."""
        return self._hessian(x=x)["ddf"]


class SymbolicConstraints(Constraints):
    """`Constraints` whose rows (k,) are CasADi expressions in the symbols x (p,)."""

    def __init__(
        self,
        x: Symbols,
        g: Symbols,
        bounds: tuple[Array, Array],
        kinds: Sequence[ConstraintKind],
        owner: Integers,
    ) -> None:
        self.lower, self.upper = bounds
        self.kinds, self.owner = kinds, owner
        weights = type(x).sym("weights", g.numel())
        second = ca.densify(ca.hessian(ca.dot(weights, g), x)[0])
        values = Kernel(ca.Function("rows", [x], [g], ["x"], ["g"]))
        slopes = Kernel(ca.Function("slopes", [x], [ca.densify(ca.jacobian(g, x))], ["x"], ["dg"]))
        self._curvature = Kernel(
            ca.Function("bent", [x, weights], [second], ["x", "weights"], ["ddg"])
        )
        self._values = LastCallCache(lambda x: values(x=x)["g"][:, 0])
        self._slopes = LastCallCache(lambda x: slopes(x=x)["dg"])

    def values(self, x: Array) -> Array:
        """Return the components (k,) at a design x (p,)."""
        return self._values(x)

    def slopes(self, x: Array) -> Array:
        """Return the Jacobian (k, p) at a design x (p,)."""
        return self._slopes(x)

    def curvature(self, x: Array, weights: Array) -> Array:
        """Return the Hessian (p, p) of weights . constraints at a design x (p,)."""
        return self._curvature(x=x, weights=weights)["ddg"]
