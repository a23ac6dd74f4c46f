"""Global search of the phase by a scan, with the other inputs fitted to the linearised curve at each phase."""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from planter.kernels import Array
from planter.measured.curve import SAMPLES, MeasuredCurve

STEP_DEG = 1.0
"""Step between phases of the scan [deg]."""


def find_phases(curve: MeasuredCurve, z: Array, count: int) -> list[tuple[Array, float]]:
    """Return the best minima over the phase, best first: inputs (n,) and the linearised sum of squares.

    The other inputs are fitted, within their bounds, to the curve linearised at `z` (n,). Returns `z` alone, with an
    infinite sum, if no phase is fitted.
    """
    index = curve.phase_index
    if index is None:
        return [(z, float("inf"))]
    free = [i for i in range(len(z)) if i != index]
    lower, upper = curve.bounds(z)
    phases = np.linspace(lower[index], upper[index], max(3, round(np.degrees(upper[index] - lower[index]) / STEP_DEG)))
    fits = _fit_at_phases(curve, z, free, phases, (lower[free], upper[free]))
    sums = np.array([total for _, total in fits])
    ends = (sums[-1], sums[0]) if curve.is_cyclic else (np.inf, np.inf)
    neighbours = np.concatenate([[ends[0]], sums, [ends[1]]])
    minima = np.flatnonzero((sums <= neighbours[:-2]) & (sums <= neighbours[2:]))
    starts = []
    for k in minima[np.argsort(sums[minima], kind="stable")][:count]:
        values = z.copy()
        values[free], values[index] = fits[k][0], phases[k]
        starts.append((values, float(sums[k])))
    return starts


def _fit_at_phases(
    curve: MeasuredCurve, z: Array, free: list[int], phases: Array, bounds: tuple[Array, Array]
) -> list[tuple[Array, float]]:
    """Return the other inputs at each phase (k,), with the sum of squares of the linearised curve."""
    values, slopes = curve.sample(z)
    angles = np.linspace(0, 2 * np.pi, SAMPLES, endpoint=False)
    width = bounds[1] - bounds[0]
    ends = ((bounds[0] - z[free]) / width, (bounds[1] - z[free]) / width)
    fits = []
    for phase in phases:
        at = curve.phi + phase
        residuals = curve.values - np.interp(at, angles, values, period=2 * np.pi)
        if not free:
            fits.append((z[free], float(residuals @ residuals)))
            continue
        columns = [np.interp(at, angles, slopes[:, i], period=2 * np.pi) for i in free]
        # the triangular factor of points and residual together has the same least squares in n + 1 rows
        triangle = np.linalg.qr(np.column_stack([np.transpose(columns) * width, residuals])).R
        step = lsq_linear(triangle[:, :-1], triangle[:, -1], ends, method="bvls")
        fits.append((np.clip(z[free] + step.x * width, *bounds), 2 * float(step.cost)))
    return fits
