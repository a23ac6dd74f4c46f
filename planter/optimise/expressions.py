"""Smooth functions and rows of constraints given as CasADi expressions, with exact derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import casadi as ca

from planter.kernels import Array, Kernel
from planter.numerics.arrays import Integers, LastCallCache
from planter.optimise.constraints import Constraints, Kind

Symbols = TypeVar("Symbols", ca.SX, ca.MX)


class Expression:
    """A `Function` given as a CasADi expression in the symbols x (p,)."""

    def __init__(self, x: Symbols, f: Symbols) -> None:
        second = ca.densify(ca.hessian(f, x)[0])
        value = Kernel(ca.Function("objective", [x], [f], ["x"], ["f"]))
        gradient = Kernel(ca.Function("gradient", [x], [ca.densify(ca.gradient(f, x))], ["x"], ["df"]))
        self._hessian = Kernel(ca.Function("curvature", [x], [second], ["x"], ["ddf"]))
        self._value = LastCallCache(lambda x: float(value(x=x)["f"][0, 0]))
        self._gradient = LastCallCache(lambda x: gradient(x=x)["df"][:, 0])

    def value(self, x: Array) -> float:
        return self._value(x)

    def gradient(self, x: Array) -> Array:
        return self._gradient(x)

    def hessian(self, x: Array) -> Array:
        return self._hessian(x=x)["ddf"]


class Expressions(Constraints):
    """`Constraints` whose rows (k,) are CasADi expressions in the symbols x (p,)."""

    def __init__(
        self, x: Symbols, g: Symbols, bounds: tuple[Array, Array], kinds: Sequence[Kind], owner: Integers
    ) -> None:
        self.lower, self.upper = bounds
        self.kinds, self.owner = kinds, owner
        weights = type(x).sym("weights", g.numel())
        second = ca.densify(ca.hessian(ca.dot(weights, g), x)[0])
        values = Kernel(ca.Function("rows", [x], [g], ["x"], ["g"]))
        slopes = Kernel(ca.Function("slopes", [x], [ca.densify(ca.jacobian(g, x))], ["x"], ["dg"]))
        self._curvature = Kernel(ca.Function("bent", [x, weights], [second], ["x", "weights"], ["ddg"]))
        self._values = LastCallCache(lambda x: values(x=x)["g"][:, 0])
        self._slopes = LastCallCache(lambda x: slopes(x=x)["dg"])

    def values(self, x: Array) -> Array:
        return self._values(x)

    def slopes(self, x: Array) -> Array:
        return self._slopes(x)

    def curvature(self, x: Array, weights: Array) -> Array:
        return self._curvature(x=x, weights=weights)["ddg"]
