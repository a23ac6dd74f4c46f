"""An objective as a smooth programme: epigraph form where it has rows.

Over z = (u of the free parameters, t_max, t_min), with the rows measured from a reference level in units of the range:

    minimise  weight (t_max - t_min) + outer(smooth(u))
    subject to  upper rows(u) <= t_max,  lower rows(u) >= t_min,  holds(u) in their bounds,  u in the box.

Where there are no rows there are no t_max and t_min either: z = u.

The epigraph form of a sampled turn for IPOPT without Python in the loop.

Prologue and lanes of the response are compiled CasADi functions; what the objective makes of them is a few matrix
operations of CasADi's, whose derivatives CasADi finds. The same programme as `planter.optimise.epigraph.Epigraph` in
plain functions, for rows without holds.
"""

from __future__ import annotations

from functools import cached_property

import casadi as ca
import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Integers, LastCallCache
from planter.optimise.objective import LocalModel, ModelValues
from planter.optimise.problem import Problem
from planter.optimise.range_variance import RangeVarianceObjective
from planter.optimise.response import CompiledResponse
from planter.optimise.sampled_cycle import SampledRows
from planter.optimise.variance import Weights


class Epigraph:
    """A `Programme` for `planter.optimise.ipopt` of a problem's objective on a local model with fixed rows."""

    def __init__(self, problem: Problem, local: LocalModel, u: Array) -> None:
        self.problem, self.local = problem, local
        self.free, self.n = problem.free, len(problem.free)
        first = local.values(problem.design(u))
        self.a, self.b, self.k = len(first.upper), len(first.lower), len(first.holds)
        self.ends = 2 if self.a + self.b else 0
        look = problem.reference.look
        self.unit, self.level = (look.range or 1.0, look.mean) if self.ends else (1.0, 0.0)
        free = np.full(self.ends, np.inf)
        self.lower = np.append(problem.box.bottom[self.free], -free)
        self.upper = np.append(problem.box.top[self.free], free)
        self.g_lower = np.append(np.full(self.a + self.b, -np.inf), local.bounds[0])
        self.g_upper = np.append(np.zeros(self.a + self.b), local.bounds[1])
        self.start = np.append(u[self.free], self._ends(first))
        self._values = LastCallCache(lambda z: local.values(self.design(z)))

    def _ends(self, values: ModelValues) -> Array:
        """t_max and t_min of the rows."""
        if not self.ends:
            return np.empty(0)
        return (np.array([values.upper.max(), values.lower.min()]) - self.level) / self.unit

    def point(self, z: Array) -> Array:
        """The point u (p,)."""
        return self.problem.point(z[: self.n])

    def limits(self, z: Array, more: float = 0.0) -> tuple[float, float]:
        """t_max and t_min in the unit of the rows, both wider by `more` of the range; no limits without rows."""
        if not self.ends:
            return np.inf, -np.inf
        return self.level + self.unit * (float(z[-2]) + more), self.level + self.unit * (float(z[-1]) - more)

    def design(self, z: Array) -> Array:
        return self.problem.design(self.point(z))

    def f(self, z: Array) -> float:
        """Return the objective at z (n,)."""
        self.problem.counts.objective += 1
        objective = self.problem.objective
        self.problem.record(self.point(z), self.local.look(self.design(z)))
        span = self.unit * (z[-2] - z[-1]) if self.ends else 0.0
        return float(objective.weight * span + objective.outer(self._values(z).smooth)[0]) / self.problem.scale

    def gradient(self, z: Array) -> Array:
        """Return the gradient (n,) of the objective at z (n,)."""
        self.problem.counts.gradient += 1
        objective = self.problem.objective
        rate = objective.outer(self._values(z).smooth)[1]
        smooth = rate * self._scaled(self.local.slopes(self.design(z)).smooth)
        ends = objective.weight * self.unit * np.array([1.0, -1.0])
        return np.append(smooth, ends[: self.ends]) / self.problem.scale

    def g(self, z: Array) -> Array:
        """Return the constraints (m,) at z (n,)."""
        values = self._values(z)
        if not self.ends:
            return values.holds
        upper = (values.upper - self.level) / self.unit - z[-2]
        lower = z[-1] - (values.lower - self.level) / self.unit
        return np.concatenate([upper, lower, values.holds])

    def jacobian(self, z: Array) -> Array:
        """Return the Jacobian (m, n) of g at z (n,)."""
        slopes = self.local.slopes(self.design(z))
        if not self.ends:
            return self._scaled(slopes.holds)
        rows = np.zeros((self.a + self.b + self.k, self.n + 2))
        parts = np.split(rows, [self.a, self.a + self.b])
        parts[0][:, :-2], parts[0][:, -2] = self._scaled(slopes.upper) / self.unit, -1
        parts[1][:, :-2], parts[1][:, -1] = -self._scaled(slopes.lower) / self.unit, 1
        parts[2][:, :-2] = self._scaled(slopes.holds)
        return rows

    def hessian(self, z: Array, weight: float, multipliers: Array) -> Array:
        """Return the Hessian (n, n) of weight * f + multipliers . g at z (n,)."""
        self.problem.counts.hessian += 1
        x, width = self.design(z), self.problem.box.unit
        _, first, second = self.problem.objective.outer(self._values(z).smooth)
        upper, lower, holds = np.split(multipliers, [self.a, self.a + self.b])
        share = weight / self.problem.scale
        weights = ModelValues(share * first, upper / self.unit, -lower / self.unit, holds)
        curvature = self.local.curvature(x, weights)
        slope = self.local.slopes(x).smooth
        curvature = (curvature + share * second * np.outer(slope, slope)) * np.outer(width, width)
        total = np.zeros((len(z), len(z)))
        total[: self.n, : self.n] = curvature[np.ix_(self.free, self.free)]
        return total

    def _scaled(self, slopes: Array) -> Array:
        """Derivatives in the free coordinates from derivatives in x."""
        scaled: Array = (slopes * self.problem.box.unit)[..., self.free]
        return scaled


def compile_epigraph(programme: Epigraph) -> dict[str, ca.Function] | None:
    """CasADi functions `nlp`, `grad_f`, `jac_g`, `hess_lag` of a programme; None where it is not all compiled."""
    objective, local = programme.problem.objective, programme.local
    if not isinstance(objective, RangeVarianceObjective) or not isinstance(local, SampledRows) or local.holds:
        return None
    compiled = objective.response.compiled(len(local.angles))
    return None if compiled is None else _Graph(programme, local, objective.weights, compiled).functions()


class _Graph:
    """Expressions of a programme in z = (u of the free parameters, t_max, t_min)."""

    def __init__(self, programme: Epigraph, local: SampledRows, weights: Weights, compiled: CompiledResponse) -> None:
        self.programme, self.local, self.weights, self.compiled = programme, local, weights, compiled
        self.n, self.angles, self.shares = programme.n, len(local.angles), len(compiled.offsets)
        self.z = ca.MX.sym("x", self.n + 2)
        self.lam_f, self.lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", len(programme.g_lower))
        self.phi = ca.MX(ca.DM(np.add.outer(compiled.offsets, local.angles).ravel()))
        self.width = ca.DM(programme.problem.box.unit[programme.free])

    @cached_property
    def x(self) -> ca.MX:
        box = self.programme.problem.box
        u = ca.MX(ca.DM(box.start))
        u[self.programme.free.tolist()] = self.z[: self.n]
        return ca.fmin(ca.fmax(ca.DM(box.origin) + u * box.unit, ca.DM(box.lower)), ca.DM(box.upper))

    @cached_property
    def d(self) -> ca.MX:
        """All values of the machine."""
        d = ca.MX(ca.DM(self.compiled.data))
        d[list(self.compiled.moved)] = self.x
        return d

    @cached_property
    def prologue(self) -> tuple[ca.MX, ca.MX]:
        """h, and the entries of its tangent."""
        h, dh = self.compiled.prologue(self.d)
        return h, ca.vec(dh.nz[:])

    def _folded(self, lanes: ca.MX) -> ca.MX:
        """Rows of the lanes as rows of the angles."""
        parts = [lanes[k * self.angles : (k + 1) * self.angles, :] for k in range(self.shares)]
        total = parts[0]
        for part in parts[1:]:
            total = total + part
        return total

    @cached_property
    def curve(self) -> ca.MX:
        return self._folded(self.compiled.value(self.phi, self.d, self.prologue[0]))

    @cached_property
    def slopes(self) -> tuple[ca.MX, ca.MX]:
        """Curve (angles,) and its gradients in the free coordinates (angles, n)."""
        curve, g = self.compiled.slopes(self.phi, self.d, *self.prologue)
        columns = [1 + k for k in self.programme.free.tolist()]
        return self._folded(curve), self._folded(g)[:, columns] @ ca.diag(self.width)

    def _value(self, curve: ca.MX) -> ca.MX:
        p = self.programme
        span = self.weights.weight_range * p.unit * (self.z[-2] - self.z[-1])
        return (span + express_spread(self.weights, curve)[0]) / p.problem.scale

    def _rows(self, curve: ca.MX) -> ca.MX:
        p = self.programme
        scaled = (curve - p.level) / p.unit
        upper, lower = (scaled[rows.tolist()] for rows in (self.local.upper, self.local.lower))
        return ca.vertcat(upper - self.z[-2], self.z[-1] - lower)

    def functions(self) -> dict[str, ca.Function]:
        z, p = self.z, ca.MX.sym("p", 0, 0)
        curve, slopes = self.slopes
        inputs, names = [z, p], ["x", "p"]
        dual, dual_names = [z, p, self.lam_f, self.lam_g], ["x", "p", "lam_f", "lam_g"]
        return {
            "nlp": ca.Function("nlp", inputs, [self._value(self.curve), self._rows(self.curve)], names, ["f", "g"]),
            "grad_f": ca.Function("nlp_grad_f", inputs, [self._value(curve), self._gradient(curve, slopes)],
                                  names, ["f", "grad_f_x"]),
            "jac_g": ca.Function("nlp_jac_g", inputs, [self._rows(curve), self._jacobian(slopes)],
                                 names, ["g", "jac_g_x"]),
            "hess_lag": ca.Function("nlp_hess_l", dual, [ca.triu(self._hessian(curve, slopes))],
                                    dual_names, ["triu_hess_gamma_x_x"]),
        }  # fmt: skip

    def _gradient(self, curve: ca.MX, slopes: ca.MX) -> ca.MX:
        p = self.programme
        direction = slopes.T @ express_spread(self.weights, curve)[1]
        end = self.weights.weight_range * p.unit
        return ca.vertcat(direction, end, -end) / p.problem.scale

    def _jacobian(self, slopes: ca.MX) -> ca.MX:
        p, a, b = self.programme, len(self.local.upper), len(self.local.lower)
        upper, lower = (slopes[rows.tolist(), :] / p.unit for rows in (self.local.upper, self.local.lower))
        ones, nothing = ca.DM.ones, ca.DM.zeros
        return ca.vertcat(ca.horzcat(upper, -ones(a), nothing(a)), ca.horzcat(-lower, nothing(b), ones(b)))

    def _hessian(self, curve: ca.MX, slopes: ca.MX) -> ca.MX:
        p, a, n = self.programme, len(self.local.upper), self.angles
        _, slope, squared = express_spread(self.weights, curve, slopes)
        share = self.lam_f / p.problem.scale
        upper, lower = self.lam_g[:a] / p.unit, self.lam_g[a:] / p.unit
        rows = _scatter(self.local.upper, n) @ upper - _scatter(self.local.lower, n) @ lower
        return ca.diagcat(share * squared + self._bent(share * slope + rows), ca.DM.zeros(2, 2))

    def _bent(self, weights: ca.MX) -> ca.MX:
        """Weighted sum of the curve's Hessians in the free coordinates (n, n)."""
        lanes = ca.repmat(weights, self.shares, 1)
        h, dh = self.prologue
        packed, slope = self.compiled.bending(self.phi, self.d, h, dh, lanes)
        size = 1 + self.x.numel()
        hessian = ca.triu2symm(ca.MX(ca.Sparsity.upper(size), packed.T))[1:, 1:]
        hessian = hessian + self.compiled.curvature(self.d, slope.T)
        free = self.programme.free.tolist()
        return hessian[free, free] * (self.width @ self.width.T)


def express_spread(weights: Weights, values: ca.MX, slopes: ca.MX | None = None) -> tuple[ca.MX, ca.MX, ca.MX]:
    """The weighted spread of values (n,), its slope (n,) in them, and what their slopes (n, p) add to its Hessian."""
    count = values.numel()
    f, direction = ca.MX.sym("f", count), ca.MX.sym("direction", count, 0 if slopes is None else slopes.size2())
    spread = weights.weighted(ca.sumsqr(f - ca.sum1(f) / count) / count, ca.sqrt)
    slope = ca.gradient(spread, f)
    squared = direction.T @ ca.jtimes(slope, f, direction)
    function = ca.Function("spread", [f, direction], [spread, slope, squared])
    arguments = [values, ca.MX(count, 0) if slopes is None else slopes]
    value, rate, added = function.call(arguments, True, False)
    return value, rate, added


def _scatter(rows: Integers, count: int) -> ca.DM:
    """The matrix (count, rows) that puts each row's number in its place."""
    return ca.DM.triplet(rows.tolist(), list(range(len(rows))), ca.DM.ones(len(rows)), count, len(rows))
