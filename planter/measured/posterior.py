"""Log density of inputs given measured curves, with its gradient: what samplers such as PyMC's or
NumPyro's ask for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy

from planter.engine.machine import Machine
from planter.errors import ComputationError, InputError
from planter.kernels import Array, Flags
from planter.measured.calibration import find_unit, read_measurement
from planter.measured.curve import Chosen, MeasuredCurve, factor_of
from planter.measured.fit import fit_curve
from planter.measured.noise import RHO_PRIOR, compute_log_determinants, sum_white_products
from planter.measured.reading import Columns
from planter.measured.sensor_curve import build_curve

DRAWS, FREEDOM, SPREAD = 8192, 4.0, 2.0
"""Number of draws for moments, their degrees of freedom, and their scale, in covariances at the
mode.
"""


@dataclass(frozen=True)
class NormalPosterior:
    """A posterior as a normal density: its mean (n,) and covariance (n, n), in the units of
    `Posterior`.
    """

    mean: Array
    covariance: Array

    @property
    def std(self) -> Array:
        """Standard deviations (n,)."""
        deviations: Array = np.sqrt(np.diag(self.covariance))
        return deviations


class Posterior:
    """Density of inputs x (n,) of a machine, given measured curves; x is in the `units` of `names`.

    Inputs are uniform within `lower` and `upper`, or normal where they have a prior. The noise of
    each quantity is an autoregression of first order; its size, with the prior 1 / size, and its
    correlation, with the prior (1 - rho^2)^-1/2 from 0 on, are integrated. A phase whose bounds
    span its period has none: densities repeat.
    """

    def __init__(self, curve: MeasuredCurve) -> None:
        self.curve = curve
        self.names = curve.chosen.names
        self._scale = np.array([factor_of(name) for name in self.names])
        self.lower, self.upper = curve.chosen.lower / self._scale, curve.chosen.upper / self._scale
        self._bounded = np.full(len(self.names), True)
        if curve.is_cyclic:
            self._bounded[curve.phase_index] = False
        self._log_weights = [
            np.log(RHO_PRIOR) - compute_log_determinants(gaps) / 2 for gaps in curve.gaps
        ]

    @property
    def units(self) -> tuple[str, ...]:
        """Units (n,) of the inputs."""
        return tuple(find_unit(self.curve, name) for name in self.names)

    def log_density(self, x: Array) -> float:
        """Return the logarithm of the density at x (n,) [`units`], but for a constant; -inf outside
        the bounds.
        """
        return self.evaluate(x)[0]

    def gradient(self, x: Array) -> Array:
        """Return the gradient (n,) of the logarithm at x (n,) [`units`], per unit; zero where that
        is -inf.
        """
        return self.evaluate(x)[1]

    def evaluate(self, x: Array) -> tuple[float, Array]:
        """Return the logarithm of the density at x (n,) [`units`] and its gradient (n,); -inf
        without a cycle.
        """
        x = np.asarray(x, dtype=float)
        outside = -np.inf, np.zeros(len(self.names))
        if not self._is_inside(x):
            return outside
        z = x * self._scale
        try:
            values, slopes = self.curve(z)
        except ComputationError:
            return outside
        prior, prior_slopes = self.curve.chosen.prior_rows(z)
        total, gradient = -float(prior @ prior) / 2, -(prior @ prior_slopes)
        for points, gaps, log_weights in zip(
            self.curve.channels, self.curve.gaps, self._log_weights, strict=True
        ):
            residuals = values[points] - self.curve.values[points]
            logs, log_slopes = _integrate_size(residuals, slopes[points], gaps)
            logs = logs + log_weights
            largest = float(logs.max())
            shares = np.exp(logs - largest)
            total += largest + float(np.log(shares.sum()))
            gradient = gradient + shares @ log_slopes / shares.sum()
        return total, gradient * self._scale

    def _is_inside(self, x: Array) -> Flags:
        """Return whether points (..., n) are within the bounds."""
        inside: Flags = (((x >= self.lower) & (x <= self.upper)) | ~self._bounded).all(axis=-1)
        return inside

    def approximate(self, seed: int = 0) -> NormalPosterior:
        """Return the normal density with mean and covariance of the posterior for a curve that is
        linear in its inputs.

        It is linear about the mode, which is searched from the best fit of several starts. The
        curvature there alone (Laplace's method) would be too large: the noise's size and
        correlation are uncertain, which widens the tails. Raises ComputationError if the data do
        not determine all inputs, and if no search ends at a cycle.
        """
        width = self.upper - self.lower
        start = fit_curve(self.curve, seed).values / self._scale
        ends = [(0.0, 1.0) if bounded else (None, None) for bounded in self._bounded]
        lowest, highest = (
            np.where(self._bounded, end, infinite)
            for end, infinite in ((0.0, -np.inf), (1.0, np.inf))
        )

        def descend(u: Array) -> tuple[float, Array]:
            value, slopes = self.evaluate(self.lower + np.clip(u, lowest, highest) * width)
            return (
                (-value, -slopes * width)
                if np.isfinite(value)
                else (np.finfo(float).max, np.zeros(len(u)))
            )

        end = scipy.optimize.minimize(
            descend,
            np.clip((start - self.lower) / width, lowest, highest),
            jac=True,
            bounds=ends,
            method="L-BFGS-B",
        )
        mode = self.lower + np.clip(end.x, lowest, highest) * width
        phase = self.curve.phase_index
        if phase is not None and not self._bounded[phase]:
            period = self.curve.period / self._scale[phase]
            mode[phase] -= period * np.floor((mode[phase] - self.lower[phase]) / period)
        return self._match_moments(mode, seed)

    def _match_moments(self, mode: Array, seed: int) -> NormalPosterior:
        """Return mean and covariance about a mode (n,), by weighted draws from Student's t."""
        z, count = mode * self._scale, len(mode)
        values, slopes = self.curve(z)
        prior, prior_slopes = self.curve.chosen.prior_rows(z)
        prior_slopes = prior_slopes * self._scale
        precision, products = prior_slopes.T @ prior_slopes, []
        for points, gaps, log_weights in zip(
            self.curve.channels, self.curve.gaps, self._log_weights, strict=True
        ):
            rows = np.column_stack(
                [slopes[points] * self._scale, values[points] - self.curve.values[points]]
            )
            products.append(sum_white_products(rows, gaps))
            sums = np.maximum(products[-1][:, -1, -1], np.finfo(float).tiny)
            weights = (
                scipy.special.softmax(log_weights - len(rows) / 2 * np.log(sums)) * len(rows) / sums
            )
            precision = precision + np.einsum("g,gij->ij", weights, products[-1][:, :-1, :-1])
        width = self.upper - self.lower
        if (
            not np.linalg.eigvalsh(precision * np.outer(width, width))[0] > 1
        ):  # a deviation of a whole width
            raise ComputationError(
                f"the data do not determine all of {', '.join(self.names)} within their bounds"
            )
        spread = np.asarray(SPREAD * np.linalg.inv(precision), dtype=float)
        steps = draw_student(np.asarray(np.linalg.cholesky(spread), dtype=float), seed)
        squares = np.einsum("mi,ij,mj->m", steps, precision / SPREAD, steps)
        logs = (FREEDOM + count) / 2 * np.log1p(squares / FREEDOM)
        ends = np.column_stack([steps, np.ones(len(steps))])
        for points, log_weights, product in zip(
            self.curve.channels, self._log_weights, products, strict=True
        ):
            sums = np.einsum("mi,gij,mj->mg", ends, product, ends, optimize=True)
            logs += scipy.special.logsumexp(
                log_weights
                - (points.stop - points.start) / 2 * np.log(np.maximum(sums, np.finfo(float).tiny)),
                axis=1,
            )
        logs -= ((prior + steps @ prior_slopes.T) ** 2).sum(axis=1) / 2
        logs[~self._is_inside(mode + steps)] = -np.inf
        weights = scipy.special.softmax(logs)
        mean = weights @ steps
        deviations = steps - mean
        matched: Array = (deviations * weights[:, None]).T @ deviations
        return NormalPosterior(mode + mean, matched)


def draw_student(root: Array, seed: int) -> Array:
    """Return draws (`DRAWS`, n) of Student's t with `FREEDOM` degrees, for the root (n, n) of its
    scale matrix.
    """
    uniform = scipy.stats.qmc.Sobol(len(root) + 1, seed=seed).random(DRAWS)
    normal: Array = scipy.stats.norm.ppf(uniform[:, 1:]) @ root.T
    return normal / np.sqrt(scipy.stats.chi2.ppf(uniform[:, :1], FREEDOM) / FREEDOM)


def load_posterior(
    machine: Machine,
    data: str | Path,
    columns: Columns | str,
    quantity: str | Sequence[str],
    bounds: Mapping[str, tuple[float, float]],
    priors: Mapping[str, tuple[float, float]] | None = None,
) -> Posterior:
    """Return the posterior of inputs of a machine given the curves in a CSV file.

    `columns` are the columns of the file, or the name of that with the values; `quantity` says what
    they are. `bounds` holds the inputs by path, as `--fit` does, "offset" and "phase_deg" too,
    `priors` means and standard deviations, all in the units that the paths end in, as
    "mass.planet_kg" [kg]. Raises InputError for a file, columns or inputs that cannot be used.
    """
    if not bounds:
        raise InputError("bounds: they must name at least one input")
    quantities = (quantity,) if isinstance(quantity, str) else tuple(quantity)
    columns = Columns(columns) if isinstance(columns, str) else columns
    chosen = Chosen.from_bounds(machine, bounds, priors)
    return Posterior(
        build_curve(
            machine, chosen, read_measurement(machine, data, columns, quantities), quantities
        )
    )


def _integrate_size(residuals: Array, slopes: Array, gaps: Array) -> tuple[Array, Array]:
    """Return the log density of white residuals for each correlation (g,), and its gradient, the
    size integrated.
    """
    count = len(residuals)
    products = sum_white_products(np.column_stack([slopes, residuals]), gaps)
    sums, sides = np.maximum(products[:, -1, -1], np.finfo(float).tiny), products[:, :-1, -1]
    logs: Array = -count * np.log(sums) / 2
    return logs, -count * sides / sums[:, None]
