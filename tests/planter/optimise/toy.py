"""Closed curves F(phi, x) in closed form that stand in for a device."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from planter.kernels import Array
from planter.optimise.response import BreakpointEvent


class Toy:
    """A `Response` made of CasADi expressions: `force` and, with its events, `joints` in terms of
    phi and x.
    """

    def __init__(
        self,
        phi: ca.SX,
        x: ca.SX,
        force: ca.SX,
        joints: dict[BreakpointEvent, ca.SX] | None = None,
        lower: Array | None = None,
        upper: Array | None = None,
        design: Array | None = None,
        period: float = 2 * np.pi,
    ) -> None:
        p = x.numel()
        self.names = tuple(f"x{j}" for j in range(p))
        self.lower = np.zeros(p) if lower is None else np.asarray(lower, dtype=float)
        self.upper = np.ones(p) if upper is None else np.asarray(upper, dtype=float)
        self.design = (
            (self.lower + self.upper) / 2 if design is None else np.asarray(design, dtype=float)
        )
        self.period, self.turn, self.shifts = period, 2 * np.pi, (0.0,)
        self.count, self.is_closed = 1, True
        self.events = tuple(joints or {})
        z = ca.vertcat(phi, x)
        g = ca.vertcat(*(joints or {}).values()) if joints else ca.SX(0, 1)
        weights = ca.SX.sym("weights", g.numel())
        outputs = {
            "force": force,
            "slope": ca.gradient(force, z),
            "second": ca.densify(ca.hessian(force, z)[0]),
            "g": g,
            "g_slope": ca.densify(ca.jacobian(g, z)),
            "g_second": ca.densify(ca.hessian(ca.dot(weights, g), z)[0]),
        }
        self._functions = {
            name: ca.Function(name, [phi, x, weights], [e]) for name, e in outputs.items()
        }
        self._mapped: dict[tuple[str, int], ca.Function] = {}

    def _call(self, name: str, x: Array, phi: Array, weights: Array | float = 0.0) -> Array:
        """One output at angles (n,): (rows, n * columns)."""
        f = self._functions[name]
        if not len(phi):
            return np.empty((f.size1_out(0), 0))
        values = self._over(name, len(phi))(phi[None, :], x[:, None], np.reshape(weights, (-1, 1)))
        return np.asarray(values, dtype=float)

    def _over(self, name: str, count: int) -> ca.Function:
        """One output over so many angles, x and weights alike at all of them."""
        if (name, count) not in self._mapped:
            f = self._functions[name]
            self._mapped[name, count] = f.map(f"{name}_{count}", "serial", count, [1, 2], [])
        return self._mapped[name, count]

    def _stacked(self, name: str, x: Array, phi: Array) -> Array:
        """One output at angles (n,): (n, rows, columns)."""
        f = self._functions[name]
        values = self._call(name, x, phi, np.zeros(f.size1_in(2)))
        return values.reshape(f.size1_out(0), len(phi), f.size2_out(0)).transpose(1, 0, 2)

    def prologue(self, x: Array) -> Array:
        return np.array(x, dtype=float)

    def restart(self) -> None:
        """Forget nothing: a toy depends on its design alone."""

    def value(self, at: Any, phi: Array) -> Array:
        return self._stacked("force", at, phi)[:, :, 0].T

    def ends(self, at: Any, phi: Array) -> tuple[Array, Array]:
        return self.rate(at, phi)

    def rate(self, at: Any, phi: Array) -> tuple[Array, Array]:
        force, slopes = self.slopes(at, phi)
        return force, slopes[:, :, 0]

    def rates(self, at: Any, phi: Array) -> tuple[Array, Array]:
        return self.slopes(at, phi)[1][:, :, 0], self._stacked("second", at, phi)[None, :, 0, 0]

    def slopes(self, at: Any, phi: Array) -> tuple[Array, Array]:
        return self.value(at, phi), self._stacked("slope", at, phi)[None, :, :, 0]

    def hessian(self, at: Any, phi: Array, weights: Array) -> Array:
        return np.tensordot(weights[0], self._stacked("second", at, phi), 1)

    def hessians(self, at: Any, phi: Array, weights: Array) -> Array:
        return weights[0][:, None, None] * self._stacked("second", at, phi)

    def hessian_along(self, at: Any, phi: Array, weights: Array, velocity: Array) -> Array:
        path = np.concatenate(
            [velocity[:, None, :], np.tile(np.eye(len(at)), (len(phi), 1, 1))], axis=1
        )
        return np.einsum("nap,nab,nbq->pq", path, self.hessians(at, phi, weights), path)

    def misses(self, at: Any, phi: Array) -> Array:
        return np.empty((0, len(phi)))

    def event_values(self, at: Any, phi: Array) -> tuple[Array, Array]:
        return self._stacked("g", at, phi)[:, :, 0].T, self.event_slopes(at, phi)[:, :, 0]

    def event_rates(self, at: Any, phi: Array) -> tuple[Array, Array]:
        count = len(self.events)
        second = [[self.event_hessian(at, angle, k)[0, 0] for angle in phi] for k in range(count)]
        return self.event_slopes(at, phi)[:, :, 0], np.array(second).reshape(count, len(phi))

    def event_slopes(self, at: Any, phi: Array) -> Array:
        return self._stacked("g_slope", at, phi).transpose(1, 0, 2)

    def event_hessian(self, at: Any, phi: float, event: int) -> Array:
        return self._call("g_second", at, np.array([phi]), np.eye(len(self.events))[event])
