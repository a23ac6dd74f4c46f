"""Closed curves F(phi, x) in closed form that stand in for a device."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from planter.kernels import Array
from planter.optimise.response import Event


class Toy:
    """A `Response` made of CasADi expressions: `force` and, with its events, `joints` in terms of phi and x."""

    def __init__(
        self,
        phi: ca.SX,
        x: ca.SX,
        force: ca.SX,
        joints: dict[Event, ca.SX] | None = None,
        lower: Array | None = None,
        upper: Array | None = None,
        design: Array | None = None,
        period: float = 2 * np.pi,
    ) -> None:
        p = x.numel()
        self.names = tuple(f"x{j}" for j in range(p))
        self.lower = np.zeros(p) if lower is None else np.asarray(lower, dtype=float)
        self.upper = np.ones(p) if upper is None else np.asarray(upper, dtype=float)
        self.design = (self.lower + self.upper) / 2 if design is None else np.asarray(design, dtype=float)
        self.period = period
        self.events = tuple(joints or {})
        z = ca.vertcat(phi, x)
        g = ca.vertcat(*(joints or {}).values())
        weights = ca.SX.sym("weights", g.numel())
        outputs = {
            "force": force, "slope": ca.gradient(force, z), "second": ca.densify(ca.hessian(force, z)[0]),
            "g": g, "g_slope": ca.densify(ca.jacobian(g, z)), "g_second": ca.densify(ca.hessian(ca.dot(weights, g), z)[0]),
        }  # fmt: skip
        self._functions = {name: ca.Function(name, [phi, x, weights], [e]) for name, e in outputs.items()}

    def _call(self, name: str, x: Array, phi: float, weights: Array | float = 0.0) -> Array:
        return np.asarray(self._functions[name](phi, x, weights), dtype=float)

    def prologue(self, x: Array) -> Array:
        return np.array(x, dtype=float)

    def support(self, at: Any, phi: Array) -> Array:
        return np.array([self._call("force", at, p)[0, 0] for p in phi])

    def support_rate(self, at: Any, phi: Array) -> tuple[Array, Array]:
        force, slopes = self.support_slopes(at, phi)
        return force, slopes[:, 0]

    def support_rates(self, at: Any, phi: Array) -> tuple[Array, Array]:
        return self.support_slopes(at, phi)[1][:, 0], self.support_hessians(at, phi)[:, 0, 0]

    def support_slopes(self, at: Any, phi: Array) -> tuple[Array, Array]:
        slopes = np.array([self._call("slope", at, p)[:, 0] for p in phi])
        return self.support(at, phi), slopes.reshape(len(phi), 1 + len(self.names))

    def support_hessian(self, at: Any, phi: Array, weights: Array) -> Array:
        return np.tensordot(weights, self.support_hessians(at, phi), 1)

    def support_hessians(self, at: Any, phi: Array) -> Array:
        size = 1 + len(self.names)
        return np.array([self._call("second", at, p) for p in phi]).reshape(len(phi), size, size)

    def event_values(self, at: Any, phi: Array) -> tuple[Array, Array]:
        g = np.array([self._call("g", at, p)[:, 0] for p in phi]).T
        return g.reshape(len(self.events), len(phi)), self.event_slopes(at, phi)[:, :, 0]

    def event_slopes(self, at: Any, phi: Array) -> Array:
        found = np.array([self._call("g_slope", at, p) for p in phi])
        return found.reshape(len(phi), len(self.events), 1 + len(self.names)).transpose(1, 0, 2)

    def event_hessian(self, at: Any, phi: float, event: int) -> Array:
        return self._call("g_second", at, phi, np.eye(len(self.events))[event])
