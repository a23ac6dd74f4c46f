"""A global search of the phase: every phase is tried, with the other inputs fitted to a linearised curve at each."""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from planter.kernels import Array
from planter.measured.curve import SAMPLES, MeasuredCurve

STEP_DEG = 1.0
"""Between phases that are tried."""


def find_phases(curve: MeasuredCurve, z: Array, count: int) -> list[tuple[Array, float]]:
    """The best local minima over the phase, best first: inputs (n,) and the sum of squares of the linearised curve.

    The other inputs are fitted, within their bounds, to the curve linearised at `z` (n,). Returns `z` alone, with an
    infinite sum, if no phase is fitted.
    """
    index = curve.phase_index
    if index is None:
        return [(z, float("inf"))]
    others = [i for i in range(len(z)) if i != index]
    lower, upper = curve.bounds(z)
    phases = np.linspace(lower[index], upper[index], max(3, round(np.degrees(upper[index] - lower[index]) / STEP_DEG)))
    fits = _fit_at_phases(curve, z, others, phases, (lower[others], upper[others]))
    sums = np.array([total for _, total in fits])
    ends = (sums[-1], sums[0]) if curve.is_cyclic else (np.inf, np.inf)
    around = np.concatenate([[ends[0]], sums, [ends[1]]])
    minima = np.flatnonzero((sums <= around[:-2]) & (sums <= around[2:]))
    found = []
    for k in minima[np.argsort(sums[minima], kind="stable")][:count]:
        values = z.copy()
        values[others], values[index] = fits[k][0], phases[k]
        found.append((values, float(sums[k])))
    return found


def _fit_at_phases(
    curve: MeasuredCurve, z: Array, others: list[int], phases: Array, bounds: tuple[Array, Array]
) -> list[tuple[Array, float]]:
    """At each phase (k,) the other inputs, and the sum of squares that they leave of the linearised curve."""
    values, slopes = curve.sample(z)
    angles = np.linspace(0, 2 * np.pi, SAMPLES, endpoint=False)
    width = bounds[1] - bounds[0]
    ends = ((bounds[0] - z[others]) / width, (bounds[1] - z[others]) / width)
    fits = []
    for phase in phases:
        at = curve.phi + phase
        left = curve.values - np.interp(at, angles, values, period=2 * np.pi)
        if not others:
            fits.append((z[others], float(left @ left)))
            continue
        columns = [np.interp(at, angles, slopes[:, i], period=2 * np.pi) for i in others]
        # the triangular factor of points and residual together has the same least squares in n + 1 rows
        triangle = np.linalg.qr(np.column_stack([np.transpose(columns) * width, left])).R
        step = lsq_linear(triangle[:, :-1], triangle[:, -1], ends, method="bvls")
        fits.append((np.clip(z[others] + step.x * width, *bounds), 2 * float(step.cost)))
    return fits
