"""Closed curves F(phi, x) in closed form that stand in for a device."""

from __future__ import annotations

from functools import cache

import casadi as ca
import numpy as np

from planter.engine.solvers.response import BreakpointEvent
from planter.kernels import Array


class ToyFunctions:
    """`AngleFunctions` of CasADi expressions (m,) in terms of phi and x."""

    def __init__(self, phi: ca.SX, x: ca.SX, rows: ca.SX) -> None:
        z, weights = ca.vertcat(phi, x), ca.SX.sym("weights", rows.numel())
        slopes = ca.densify(ca.jacobian(rows, z))
        second = ca.densify(ca.jacobian(slopes[:, 0], phi))
        hessian = ca.densify(ca.hessian(ca.dot(weights, rows), z)[0])
        outputs = {"rows": rows, "slopes": slopes, "second": second, "hessian": hessian}
        inputs = [phi, x, weights]
        self._functions = {name: ca.Function(name, inputs, [f]) for name, f in outputs.items()}
        self._over = cache(lambda name, count: self._functions[name].map(count))

    def _call(self, name: str, x: Array, phi: Array, weights: Array | None = None) -> Array:
        """One output at angles (n,): (rows, n, columns)."""
        f, count = self._functions[name], len(phi)
        rows, columns = f.size1_out(0), f.size2_out(0)
        if not count or not rows:
            return np.empty((rows, count, columns))
        weights = np.zeros((f.size1_in(2), count)) if weights is None else weights
        result = self._over(name, count)(phi[None], np.tile(x[:, None], count), weights)
        return np.asarray(result, dtype=float).reshape(rows, count, columns)

    def list_passages(self, at: Array) -> list[tuple[str, float]]:
        return []

    def values(self, at: Array, phi: Array) -> Array:
        return self._call("rows", at, phi)[:, :, 0]

    def slopes(self, at: Array, phi: Array, is_loose: bool = False) -> tuple[Array, Array]:
        return self.values(at, phi), self._call("slopes", at, phi)

    def derivatives(self, at: Array, phi: Array, is_loose: bool = False) -> tuple[Array, Array]:
        values, slopes = self.slopes(at, phi)
        return values, slopes[:, :, 0]

    def rates(self, at: Array, phi: Array, is_loose: bool = False) -> tuple[Array, Array]:
        return self.derivatives(at, phi)[1], self._call("second", at, phi)[:, :, 0]

    def curvature(self, at: Array, phi: Array, weights: Array) -> Array:
        return self.curvatures(at, phi, weights).sum(axis=0)

    def curvatures(self, at: Array, phi: Array, weights: Array) -> Array:
        return self._call("hessian", at, phi, weights).transpose(1, 0, 2)

    def curvature_along(self, at: Array, phi: Array, weights: Array, slopes: Array) -> Array:
        eye = np.tile(np.eye(len(at)), (len(phi), 1, 1))
        path = np.concatenate([slopes[:, None, :], eye], axis=1)
        return np.einsum("nap,nab,nbq->pq", path, self.curvatures(at, phi, weights), path)


class Toy:
    """A `CycleResponse` made of CasADi expressions: `force` and, with its events, `breakpoints` in terms
    of phi and x.
    """

    def __init__(
        self,
        phi: ca.SX,
        x: ca.SX,
        force: ca.SX,
        breakpoints: dict[BreakpointEvent, ca.SX] | None = None,
        lower: Array | None = None,
        upper: Array | None = None,
    ) -> None:
        p, breakpoints = x.numel(), breakpoints or {}
        self.names = tuple(f"x{j}" for j in range(p))
        self.lower = np.zeros(p) if lower is None else np.asarray(lower, dtype=float)
        self.upper = np.ones(p) if upper is None else np.asarray(upper, dtype=float)
        self.design = (self.lower + self.upper) / 2
        self.period = self.turn = 2 * np.pi
        self.shifts, self.count, self.is_closed = (0.0,), 1, True
        self.events = tuple(breakpoints)
        self.curves = ToyFunctions(phi, x, force)
        self.event_functions = ToyFunctions(phi, x, ca.vertcat(ca.SX(0, 1), *breakpoints.values()))

    def prologue(self, x: Array) -> Array:
        return np.array(x, dtype=float)

    def restart(self) -> None:
        """Forget nothing: a toy depends on its design alone."""

    def misses(self, at: Array, phi: Array) -> Array:
        return np.empty((0, len(phi)))
