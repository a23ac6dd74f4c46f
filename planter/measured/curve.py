"""A quantity of a machine at measured angles as a function of chosen inputs, with exact derivatives."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import lsq_linear

from planter.engine.machine import Machine, Quantity
from planter.engine.response import MachineResponse
from planter.errors import ComputationError, InputError
from planter.files import paths, units
from planter.kernels import Array
from planter.measured.reading import Measurement

OFFSET, PHASE = "offset_N", "phase_deg"
"""Names of nuisance parameters: the zero of the gauge, with any unit, and the zero of the angle."""
SAMPLES = 720
"""Angles of a revolution at which a curve is sampled; a multiple of 1 to 6, 8, 9, 10 and 12."""
PERIOD_TOLERANCE = 1e-9
"""Relative deviation up to which a curve is periodic."""


@dataclass(frozen=True)
class Chosen:
    """Fitted inputs, by their paths in the machine file, an offset or a phase, with bounds (n,).

    Bounds are in SI, those of an offset in the display unit of the measured quantity.
    """

    names: tuple[str, ...]
    lower: Array
    upper: Array

    @classmethod
    def from_bounds(cls, machine: Machine, bounds: Mapping[str, tuple[float, float]]) -> Chosen:
        """Return inputs with bounds in display units. Raises InputError for an unknown name or empty bounds."""
        paths_of_inputs = [value.path for value in machine.values]
        selected: dict[str, tuple[float, float]] = {}
        for name, (low, high) in bounds.items():
            matches = [name] if is_nuisance(name) else paths.Names(paths_of_inputs).candidates(name)
            if len(matches) != 1:
                hint = paths.suggest_names(name, [*paths_of_inputs, OFFSET, PHASE])
                raise InputError(f"--fit {name}: {hint}")
            if not low < high:
                raise InputError(f"--fit {name}={low:g}:{high:g}: the lower bound must be below the upper")
            selected[matches[0]] = (low, high)
        factors = np.array([factor_of(name) for name in selected])
        ends = np.array(list(selected.values())) * factors[:, None]
        return cls(tuple(selected), ends[:, 0], ends[:, 1])

    def to_display(self, values: Array) -> dict[str, float]:
        """Return values (n,) by name, in display units."""
        return {name: float(value / factor_of(name)) for name, value in zip(self.names, values, strict=True)}


class MeasuredCurve:
    """The quantity at the angles of a measurement, for values (n,) of the chosen inputs, in its display unit.

    measured(phi) = computed(phi + phase). A phase whose bounds span the period or more is cyclic, without bounds.
    """

    def __init__(self, machine: Machine, chosen: Chosen, measured: Measurement, quantity: str) -> None:
        self.machine, self.chosen = machine, chosen
        self.phi, self.values = measured.phi[measured.used], measured.values[measured.used]
        self._inputs = [i for i, name in enumerate(chosen.names) if not is_nuisance(name)]
        inputs = [chosen.names[i] for i in self._inputs]
        self._offset = next((i for i, name in enumerate(chosen.names) if is_offset(name)), None)
        result = find_measured(machine, quantity)
        self.quantity, self.unit, self._factor = quantity, units.display_unit(result.key), result.factor
        moved = machine.with_moved(dict.fromkeys(inputs, (0.0, 1.0)))
        self._response = MachineResponse(moved, [result.name])
        self._machine_inputs = moved.design
        self._last: tuple[bytes, tuple[Array, Array]] | None = None

    def machine_values(self) -> Array:
        """Return the values (n,) of the machine, clipped to the bounds; zero for nuisance parameters."""
        values = np.zeros(len(self.chosen.names))
        values[self._inputs] = self._machine_inputs
        return np.clip(values, self.chosen.lower, self.chosen.upper)

    def with_points(self, limit: int) -> MeasuredCurve:
        """Return a copy with at most `limit` points, evenly selected."""
        rows = np.unique(np.linspace(0, len(self.phi) - 1, min(limit, len(self.phi))).astype(int))
        thin = copy(self)
        thin.phi, thin.values, thin._last = self.phi[rows], self.values[rows], None
        return thin

    def restart(self) -> None:
        """Discard earlier values, near which loops are closed, so that all processes compute the same digits."""
        self.bounds(self.machine_values())  # closes loops at the first call, for the period
        self._response.restart()
        self._last = None

    @property
    def phase_index(self) -> int | None:
        """Index of the phase among the chosen inputs, if any."""
        return self.chosen.names.index(PHASE) if PHASE in self.chosen.names else None

    @cached_property
    def period(self) -> float:
        """Period [rad] of the curve for all inputs: a revolution or a part of it."""
        curves = []
        for z in (self.machine_values(), (self.chosen.lower + self.chosen.upper) / 2):
            with suppress(ComputationError):  # inputs whose loops do not close
                curves.append(self.sample(z)[0])
        for parts in (12, 10, 9, 8, 6, 5, 4, 3, 2):
            if curves and all(_repeats(curve, parts) for curve in curves):
                return 2 * np.pi / parts
        return 2 * np.pi

    @property
    def is_cyclic(self) -> bool:
        """Return whether the bounds allow any phase."""
        i = self.phase_index
        return i is not None and bool(
            self.chosen.upper[i] - self.chosen.lower[i] >= self.period * (1 - PERIOD_TOLERANCE)
        )

    def bounds(self, z: Array) -> tuple[Array, Array]:
        """Return the bounds (n,) of the chosen inputs; of a cyclic phase half a period on each side."""
        lower, upper, i = self.chosen.lower.copy(), self.chosen.upper.copy(), self.phase_index
        if i is not None and self.is_cyclic:
            lower[i], upper[i] = z[i] - self.period / 2, z[i] + self.period / 2
        return lower, upper

    def sample(self, z: Array) -> tuple[Array, Array]:
        """Return the quantity (SAMPLES,) without phase over a revolution, and its Jacobian (SAMPLES, n)."""
        at_zero = z.copy()
        if self.phase_index is not None:
            at_zero[self.phase_index] = 0.0
        return self(at_zero, np.linspace(0, 2 * np.pi, SAMPLES, endpoint=False))

    def __call__(self, z: Array, phi: Array | None = None) -> tuple[Array, Array]:
        """Return the quantity (m,) and its Jacobian (m, n), at the measured angles or at `phi` [rad].

        The last result is cached, since a search requests values and Jacobian separately.
        """
        key = z.tobytes() if phi is None else b""
        if key and self._last is not None and self._last[0] == key:
            return self._last[1]
        result = self._evaluate(z, self.phi if phi is None else phi)
        if key:
            self._last = key, result
        return result

    def _evaluate(self, z: Array, phi: Array) -> tuple[Array, Array]:
        angles = phi + (0.0 if self.phase_index is None else z[self.phase_index])
        point = self._response.at(z[self._inputs])
        values, slopes_of_inputs = (
            rows[0] / self._factor for rows in self._response.slopes(point, np.mod(angles, 2 * np.pi))
        )
        slopes = np.zeros((len(angles), len(z)))
        slopes[:, self._inputs] = slopes_of_inputs[:, 1:]
        if self._offset is not None:
            slopes[:, self._offset] = 1.0
            values = values + z[self._offset]
        if self.phase_index is not None:
            slopes[:, self.phase_index] = slopes_of_inputs[:, 0]
        return values, slopes


def is_nuisance(name: str) -> bool:
    """Return whether a fitted value is a nuisance parameter, not an input of the machine."""
    return name == PHASE or is_offset(name)


def factor_of(name: str) -> float:
    """Return the unit in which a fitted value is computed, per display unit: SI, but for an offset."""
    return 1.0 if is_offset(name) else units.unit_factor(name)


def _repeats(curve: Array, parts: int) -> bool:
    """Return whether a sampled curve varies and repeats `parts` times in a revolution."""
    allowed = PERIOD_TOLERANCE * float(np.abs(curve).max())
    return bool(np.ptp(curve) > allowed and np.abs(curve - np.roll(curve, len(curve) // parts)).max() <= allowed)


def find_measured(machine: Machine, quantity: str) -> Quantity:
    """Return the quantity that was measured, by its key or name. Raises InputError if the machine lacks it."""
    results = {result.name: result for result in machine.results} | {result.key: result for result in machine.results}
    if quantity not in results:
        hint = paths.suggest_names(quantity, [result.key for result in machine.results])
        raise InputError(f"--quantity = {quantity} is not a quantity of {machine.name}: {hint}")
    return results[quantity]


def is_offset(name: str) -> bool:
    """Return whether a name is that of the zero of the gauge, in the unit of the measured quantity."""
    return re.fullmatch(r"offset(_\w+)?", name) is not None


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
