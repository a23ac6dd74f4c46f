"""The chain from value points to requirements as one CasADi graph, so that every derivative is exact.

A value point has a fixed carrier angle and moves on the circle that the tip can describe about the planet's axis there:
its coordinate on it is the arm's angle phi1. (Along the path it would move without changing it.) Points in the dwell
share one angle. The law is the spline of the fifth degree through these angles, so linear in them; bars and the
direction of the farthest tip stay.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from planter.errors import InputError
from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics.arrays import TURN
from planter.pickup.inverse import LAW_DEGREE
from planter.pickup.law import MODEL, ArmLaw, SplineLaw
from planter.pickup.model import PickupTrain

APART = np.radians(2)
"""Value points closer than this to an end of the dwell are left out: the end stands for them."""


@dataclass(frozen=True)
class LawNodes:
    """Angles of value points on the teeth, and the linear map from the arm's angles there to the law.

    `t` (n,) are carrier angles from the dwell's end of the turn before to its start. The variables are the arm's
    angles there (n,), with a dwell without the first: it is the last less a turn.
    """

    law: ArmLaw
    t: Array

    @property
    def size(self) -> int:
        return len(self.t) - 1

    @property
    def values(self) -> Array:
        """The variables of the law itself (size,)."""
        return self.law.arm(self.t)[1:]

    def angles(self, v: Any) -> Any:
        """The arm's angle at every node from the variables."""
        return np.concatenate([[v[-1] - TURN], v])

    @cached_property
    def _basis(self) -> BSpline:
        """Splines through one for a node and zero for the others."""
        return _interpolant(self.t, np.eye(len(self.t)), self.law.dwell is None)

    def rows(self, t: Array, order: int) -> tuple[Array, Array]:
        """Matrix (m, size) and offset (m,) that give a derivative of the arm's angle at angles on the teeth.

        The splines act on the arm's lead over the carrier, which repeats after a turn.
        """
        values = self._basis(t, order)
        folded = values[:, 1:].copy()
        folded[:, -1] += values[:, 0]
        lead = -(values @ self.t) - TURN * values[:, 0]
        return folded, lead + (t if order == 0 else np.full_like(t, 1.0 if order == 1 else 0.0))

    def law_of(self, v: Array) -> SplineLaw:
        """The law through the variables."""
        curve = _interpolant(self.t, self.angles(v) - self.t, self.law.dwell is None)
        return SplineLaw(curve, self.law.dwell, float(v[-1]))


def _interpolant(t: Array, values: Array, closed: bool) -> BSpline:
    if closed:
        ring = values.copy()
        ring[-1] = ring[0]
        curve = make_interp_spline(t, ring, k=LAW_DEGREE, bc_type="periodic")
        curve.extrapolate = "periodic"
        return curve
    return make_interp_spline(t, values, k=LAW_DEGREE)


def build_nodes(train: PickupTrain, value_points: int) -> LawNodes:
    """Nodes at equal steps from the farthest tip, outside the dwell, and at the dwell's ends.

    Raises InputError for a dwell with smooth ends, which moving value points would not keep.
    """
    first, last = train.driven
    if train.law.transition:
        raise InputError(
            'law.ends = "smooth" cannot be used where value points are moved (--optimise), for these keep no '
            "smooth ends: it must be left out"
        )
    steps = np.arange(value_points) * TURN / value_points
    inside = np.sort(first + (steps - first) % TURN)
    inside = inside[(inside > first + APART) & (inside < last - APART)]
    return LawNodes(train.law, np.concatenate([[first], inside, [last]]))


@dataclass(frozen=True)
class SampledChain:
    """Symbols at sample angles (m,): arm, slopes, place and needle in the cell's frame, curvatures, all CasADi."""

    arm: ca.MX
    slopes: ca.MX
    depth: ca.MX
    across: ca.MX
    tilt: ca.MX
    curvatures: ca.MX


def sample_chain(train: PickupTrain, at: LawNodes, v: ca.MX, t: Array, axis: float, entry: float) -> SampledChain:
    """The chain over samples: law, tip, cell's frame and pitch curves as functions of the variables `v`."""
    model, count = load(MODEL), len(t)
    parts = [_product(at.rows(t, order), v) for order in range(4)]
    slopes = ca.vertcat(*(part.T for part in parts[1:]))
    phi5 = ca.DM(train.phi5_far + t).T
    motion = model.function("motion").map(count)(
        phi5, parts[0].T, slopes[0, :], ca.DM.ones(1, count) * train.omega,
        ca.repmat(ca.DM(train.geometry.triangle), 1, count),
    )  # fmt: skip
    tip = [motion[model.outputs("motion").index(name), :] for name in ("x_S", "y_S")]
    bottom = train.tip(np.zeros(1))[0]
    ones = ca.DM.ones(1, count)
    cell = model.function("entry").map(count)(*tip, bottom[0] * ones, bottom[1] * ones, axis * ones)
    pitch = model.function("pitch").map(count)(slopes, ca.DM(t).T, parts[0].T - np.pi, train.geometry.a1 * ones)
    bends = [pitch[model.outputs("pitch").index(name), :].T for name in ("kappa1", "kappa2")]
    return SampledChain(
        parts[0], slopes, cell[0, :].T + entry, cell[1, :].T, ca.DM(t) - parts[0] + np.pi, ca.horzcat(*bends)
    )


def _product(rows: tuple[Array, Array], v: ca.MX) -> ca.MX:
    matrix, offset = rows
    return ca.mtimes(ca.DM(matrix), v) + ca.DM(offset)
