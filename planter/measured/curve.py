"""Quantities of a machine at measured angles as functions of chosen inputs, with exact
derivatives.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
import scipy

from planter import paths
from planter.engine.machine import Machine, Quantity
from planter.engine.response import open_response
from planter.errors import ComputationError, InputError
from planter.files import units
from planter.kernels import Array, Integers
from planter.measured.reading import Measurement
from planter.measured.sensor_view import check_sensor_bounds, is_sensor_input, list_sensor_inputs
from planter.numerics.arrays import TURN

OFFSET, PHASE, SHIFT = "offset_N", "phase_deg", "shift_s"
"""Names of nuisance parameters: the zero of the gauge, with any unit, that of the angle, and that of
the time of what moves freely.
"""
FRAME = ("frame_deg", "frame_x_mm", "frame_y_mm")
"""Names of those of a measured path: the rotation and the origin of its frame in the machine's."""
EFFECT = "effect: "
"""Beginning of the names of parameters of what stands between the machine and its sensor."""
SAMPLES = 720
"""Angles of a revolution at which a curve is sampled; a multiple of 1 to 6, 8, 9, 10 and 12."""
SMALLEST_NOISE, TINIEST_NOISE = 1e-6, 1e-30
"""Share of the range of the values below which noise is rounding of digits in the file, and its
smallest size.
"""
STEADY = 0.002
"""Share of the mean speed by which a steady one may vary."""
PERIOD_TOLERANCE = 1e-9
"""Relative deviation up to which a curve is periodic."""

BEGINNINGS = (1 / 27, 1 / 9, 1 / 3)
"""Shares of a record of what moves freely that are fitted first."""
POINTS_OF_AN_INPUT = 4
"""Least points of such a share for each input."""

Side = Literal["lower", "upper"]


@dataclass(frozen=True)
class Chosen:
    """Fitted inputs, by their paths in the machine file, an offset or a phase, with bounds (n,).

    Bounds are in SI, those of an offset in the display unit of the measured quantity.
    """

    names: tuple[str, ...]
    lower: Array
    upper: Array
    priors: tuple[tuple[int, float, float], ...] = ()
    """Index, mean and standard deviation of inputs with a normal prior; others are uniform within
    their bounds.
    """

    @classmethod
    def from_bounds(
        cls,
        machine: Machine,
        bounds: Mapping[str, tuple[float, float]],
        priors: Mapping[str, tuple[float, float]] | None = None,
    ) -> Chosen:
        """Return inputs with bounds and normal priors (mean, standard deviation) in display units.

        Raises InputError for an unknown name, empty bounds, or a prior that does not fit.
        """
        paths_of_inputs = [*(value.path for value in machine.values), *list_sensor_inputs(machine)]
        input_names = paths.Names(paths_of_inputs)
        selected: dict[str, tuple[float, float]] = {}
        for name, (low, high) in bounds.items():
            matches = [name] if is_nuisance(name) else input_names.candidates(name)
            if len(matches) != 1:
                hint = paths.suggest_names(name, [*paths_of_inputs, OFFSET, PHASE, *FRAME])
                raise InputError(f"--fit {name}: {hint}")
            if not low < high:
                raise InputError(
                    f"--fit {name}={low:g}:{high:g}: the lower bound must be below the upper"
                )
            _check_origin(machine, name, low)
            if is_sensor_input(matches[0]):
                check_sensor_bounds(machine, matches[0], (low, high))
            selected[matches[0]] = (low, high)
        factors = np.array([factor_of(name) for name in selected])
        ends = np.array(list(selected.values())).reshape(-1, 2) * factors[:, None]
        names = tuple(selected)
        normal = []
        for name, (mean, std) in (priors or {}).items():
            matches = [name] if is_nuisance(name) else input_names.candidates(name)
            if len(matches) != 1 or matches[0] not in names:
                raise InputError(
                    f"--prior {name}: it must be one of the inputs of --fit: {', '.join(names)}"
                )
            if not (std > 0 and np.isfinite([mean, std]).all()):
                raise InputError(
                    f"--prior {name}={mean:g}:{std:g}: it must be MEAN:STD with STD greater than 0"
                )
            index = names.index(matches[0])
            normal.append((index, mean * factors[index], std * factors[index]))
        return cls(names, ends[:, 0], ends[:, 1], tuple(normal))

    def prior_rows(self, values: Array) -> tuple[Array, Array]:
        """Return the deviations (j,) of values (n,) from their normal priors, and their Jacobian
        (j, n).
        """
        rows = np.array([(values[index] - mean) / std for index, mean, std in self.priors])
        slopes = np.zeros((len(self.priors), len(values)))
        for row, (index, _, std) in enumerate(self.priors):
            slopes[row, index] = 1 / std
        return rows, slopes

    def to_display(self, values: Array) -> dict[str, float]:
        """Return values (n,) by name, in display units."""
        return {
            name: float(value / factor_of(name))
            for name, value in zip(self.names, values, strict=True)
        }


@dataclass(frozen=True)
class ChannelNoise:
    """Noise of a quantity: standard deviation in its display unit, and correlation of neighbouring
    points.
    """

    std: float
    rho: float = 0.0


class MeasuredCurve:
    """Quantities at the angles of a measurement, for values (n,) of the chosen inputs, in their
    display units.

    Points in use of all quantities stand one after another, (m,) together. measured(phi) =
    computed(phi + phase), or, of what moves freely, measured(t) = computed(t + shift). A phase
    whose bounds span the period or more is cyclic, without bounds.
    Where the record has the speed, quantities are those at its speed, by a parabola through those
    at three speeds: exact for weights, springs, dampers and inertia.
    """

    def __init__(
        self, machine: Machine, chosen: Chosen, measured: Measurement, quantity: str | Sequence[str]
    ) -> None:
        self.chosen = chosen
        self._check_names()
        quantities = (quantity,) if isinstance(quantity, str) else tuple(quantity)
        results = [find_measured(machine, each) for each in quantities]
        self.keys = tuple(result.key for result in results)
        self.units = tuple(units.display_unit(result.key) for result in results)
        self._factors = np.array([result.factor for result in results])
        used = [np.flatnonzero(channel.used) for channel in measured.channels]
        rows = np.unique(np.concatenate(used))
        self._angles, self._speeds = (
            measured.phi[rows],
            None if measured.speed is None else measured.speed[rows],
        )
        self._records = find_records(self._angles)
        self._set_points(
            [np.searchsorted(rows, each) for each in used],
            np.concatenate(
                [
                    channel.values[each]
                    for channel, each in zip(measured.channels, used, strict=True)
                ]
            ),
        )
        self.noises = tuple(
            ChannelNoise(
                max(
                    channel.noise,
                    SMALLEST_NOISE * float(np.ptp(channel.values[each])),
                    TINIEST_NOISE,
                )
            )
            for channel, each in zip(measured.channels, used, strict=True)
        )
        self._inputs = [
            i
            for i, name in enumerate(chosen.names)
            if not (is_nuisance(name) or is_sensor_input(name))
        ]
        self._offsets = {
            i: find_offset_channel(name, self.keys, self.units)
            for i, name in enumerate(chosen.names)
            if is_offset(name)
        }
        if self._speeds is not None:
            data = machine.data.copy()
            data[machine.speed] = np.copysign(float(self._speeds.mean()), data[machine.speed])
            machine = machine.with_data(data)
        if machine.motion is not None:
            assert measured.duration is not None
            shifts = [
                float(high)
                for name, high in zip(chosen.names, chosen.upper, strict=True)
                if name == SHIFT
            ]
            self._latest = sum(shifts)
            machine = machine.with_span(measured.duration + self._latest)
        self.machine, self.duration = machine, measured.duration
        self._names = [result.name for result in results]
        self._set_response()
        self._last: tuple[bytes, tuple[Array, Array]] | None = None

    def _check_names(self) -> None:
        """Raise InputError for an input that only the points of a path have."""
        for name in self.chosen.names:
            if name in FRAME:
                raise InputError(
                    f"--fit {name}: only the points of a path have a frame: name the columns of x "
                    f"and y, and neither an angle nor a time"
                )

    def _set_response(self) -> None:
        """Set the response of the machine to the inputs."""
        names = self.chosen.names
        moved = self.machine.with_moved({names[i]: (0.0, 1.0) for i in self._inputs})
        self._response = open_response(moved, self._names)
        self._machine_inputs = moved.design

    def _set_points(self, positions: Sequence[Integers], values: Array) -> None:
        """Set the points of each quantity, by their positions among the angles."""
        self._positions, self.values = tuple(positions), values
        self.phi = np.concatenate([self._angles[each] for each in positions])
        self._ends = np.cumsum([0, *map(len, positions)])
        # steps of the record between neighbouring points of each quantity
        self.gaps = tuple(_count_steps(self._angles[each], each) for each in positions)
        self._last = None

    def to_places(self, phi: Array) -> Array:
        """Return angles (n,) [rad] of the record in degrees, or, of what moves freely, as times (n,)
        [s].
        """
        if self.duration is None:
            return np.degrees(phi)
        return np.asarray(np.minimum(phi / TURN, 1.0) * self.duration)

    @property
    def unit(self) -> str:
        """Display unit of the first quantity."""
        return self.units[0]

    @property
    def channels(self) -> tuple[slice, ...]:
        """Points of each quantity among all."""
        return tuple(slice(int(a), int(b)) for a, b in pairwise(self._ends))

    def with_noises(self, noises: Sequence[ChannelNoise]) -> MeasuredCurve:
        """Return a copy with another noise of each quantity."""
        changed = copy(self)
        changed.noises = tuple(noises)
        return changed

    def with_angles_at(self, z: Array) -> MeasuredCurve:
        """Return the curve with the angles that its points have for values (n,): those of the
        record.
        """
        return self

    def find_starts(self, z: Array, count: int) -> list[tuple[Array, float]]:
        """Return the best minima of a scan around values (n,), as `find_phases`."""
        return find_phases(self, z, count)

    def with_bounds_moved(self, moves: Mapping[int, tuple[Side, float]]) -> MeasuredCurve:
        """Return a copy with bounds moved inwards, by shares of their width."""
        lower, upper = self.chosen.lower.copy(), self.chosen.upper.copy()
        for i, (side, share) in moves.items():
            step = share * (self.chosen.upper[i] - self.chosen.lower[i])
            lower[i], upper[i] = (
                (lower[i] + step, upper[i]) if side == "lower" else (lower[i], upper[i] - step)
            )
        changed = copy(self)
        changed.chosen = replace(self.chosen, lower=lower, upper=upper)
        return changed

    def machine_values(self) -> Array:
        """Return the values (n,) of the machine, clipped to the bounds; zero for nuisance
        parameters.
        """
        values = np.zeros(len(self.chosen.names))
        values[self._inputs] = self._machine_inputs
        return np.clip(values, self.chosen.lower, self.chosen.upper)

    def with_points(self, limit: int) -> MeasuredCurve:
        """Return a copy with at most `limit` points of each quantity, evenly selected, with white
        noise.
        """
        return self._select(
            [
                np.unique(np.linspace(0, len(p) - 1, min(limit, len(p))).astype(int))
                for p in self._positions
            ]
        )

    def list_beginnings(self) -> Iterator[MeasuredCurve]:
        """Yield copies with the first points, of growing shares, of what moves freely.

        A search along them does not settle on an oscillation too many or too few.
        """
        if self.duration is None:
            return
        for share in BEGINNINGS:
            selected = [np.flatnonzero(self._angles[p] <= share * TURN) for p in self._positions]
            if min(map(len, selected)) >= POINTS_OF_AN_INPUT * len(self.chosen.names):
                part = self._select(selected)
                part.machine = self.machine.with_span(share * self.duration + self._latest)
                part._set_response()
                yield part

    def _select(self, selected: Sequence[Integers]) -> MeasuredCurve:
        """Return a copy with some points of each quantity."""
        thin = copy(self)
        if self.phase_index is not None:
            thin.period = self.period  # which takes samples of the curves
        positions = [p[rows] for p, rows in zip(self._positions, selected, strict=True)]
        values = [
            self.values[points][rows] for points, rows in zip(self.channels, selected, strict=True)
        ]
        rows = np.unique(np.concatenate(positions))
        thin._angles, thin._records = self._angles[rows], self._records[rows]
        thin._speeds = None if self._speeds is None else self._speeds[rows]
        thin._set_points([np.searchsorted(rows, p) for p in positions], np.concatenate(values))
        return thin

    def restart(self) -> None:
        """Discard earlier values, near which loops are closed, so that all processes compute the
        same digits.
        """
        self.bounds(self.machine_values())  # closes loops at the first call, for the period
        self._response.restart()
        self._last = None

    @property
    def phase_index(self) -> int | None:
        """Index of the phase among the chosen inputs, if any."""
        return self.chosen.names.index(PHASE) if PHASE in self.chosen.names else None

    @cached_property
    def period(self) -> float:
        """Period [rad] of the curves for all inputs: a cycle or a part of it."""
        curves: list[Array] = []
        for z in (self.machine_values(), (self.chosen.lower + self.chosen.upper) / 2):
            with suppress(ComputationError):  # inputs whose loops do not close
                curves += list(self.sample(z)[0])
        for parts in (12, 10, 9, 8, 6, 5, 4, 3, 2):
            if curves and all(_repeats(curve, parts) for curve in curves):
                return self.machine.turn / parts
        return self.machine.turn

    @property
    def is_cyclic(self) -> bool:
        """Return whether the bounds allow any phase."""
        i = self.phase_index
        return i is not None and bool(
            self.chosen.upper[i] - self.chosen.lower[i] >= self.period * (1 - PERIOD_TOLERANCE)
        )

    def bounds(self, z: Array) -> tuple[Array, Array]:
        """Return the bounds (n,) of the chosen inputs; of a cyclic phase half a period on each
        side.
        """
        lower, upper, i = self.chosen.lower.copy(), self.chosen.upper.copy(), self.phase_index
        if i is not None and self.is_cyclic:
            lower[i], upper[i] = z[i] - self.period / 2, z[i] + self.period / 2
        return lower, upper

    def sample(self, z: Array) -> tuple[Array, Array]:
        """Return the quantities (k, SAMPLES) without phase over a cycle, and their Jacobians (k,
        SAMPLES, n).
        """
        at_zero = z.copy()
        if self.phase_index is not None:
            at_zero[self.phase_index] = 0.0
        return self.evaluate(at_zero, self.sample_angles)

    @property
    def sample_angles(self) -> Array:
        """Angles (SAMPLES,) [rad] of a cycle."""
        return np.linspace(0, self.machine.turn, SAMPLES, endpoint=False)

    def __call__(self, z: Array) -> tuple[Array, Array]:
        """Return the values at the measured points (m,) and their Jacobian (m, n).

        The last result is cached, since a search requests values and Jacobian separately.
        """
        key = z.tobytes()
        if self._last is None or self._last[0] != key:
            rows, slopes = self.evaluate(z, self._angles, self._speeds)
            picked = [(rows[k, p], slopes[k, p]) for k, p in enumerate(self._positions)]
            cycle, cycle_slopes = (np.concatenate(parts) for parts in zip(*picked, strict=True))
            drift, drift_slopes = self.drift(z)
            self._last = key, (cycle + drift, cycle_slopes + drift_slopes)
        return self._last[1]

    def drift(self, z: Array) -> tuple[Array, Array]:
        """Return what the record adds to the curves of a cycle at the points (m,), and its Jacobian
        (m, n).
        """
        return np.zeros(len(self.phi)), np.zeros((len(self.phi), len(z)))

    @property
    def records(self) -> Integers:
        """Record of each point (m,), counted from 0."""
        return np.concatenate([self._records[each] for each in self._positions])

    def whiten(self, rows: Array) -> Array:
        """Return values at the points, (m,) or (m, j), such that noise becomes white with standard
        deviation 1.
        """
        parts = [
            whiten_rows(rows[points], gaps, noise.rho) / noise.std
            for points, gaps, noise in zip(self.channels, self.gaps, self.noises, strict=True)
        ]
        return np.concatenate(parts)

    def residuals(self, z: Array) -> tuple[Array, Array]:
        """Return white residuals, computed less measured, and deviations from priors (m + j,) with
        their Jacobian.
        """
        values, slopes = self(z)
        prior, prior_slopes = self.chosen.prior_rows(z)
        both = self.whiten(np.column_stack([values - self.values, slopes]))
        return np.concatenate([both[:, 0], prior]), np.vstack([both[:, 1:], prior_slopes])

    def evaluate(self, z: Array, phi: Array, speeds: Array | None = None) -> tuple[Array, Array]:
        """Return the quantities (k, m) and their Jacobians (k, m, n) at angles [rad], at `speeds`
        (m,) if they vary.
        """
        origin, pace, rate = self._origin
        angles = pace * phi + (0.0 if origin is None else rate * z[origin])
        if self.duration is None:
            angles = np.mod(angles, self.machine.turn)
        values, slopes_of_inputs = self._evaluate_machine(z[self._inputs], angles, speeds)
        slopes = np.zeros((*values.shape, len(z)))
        slopes[:, :, self._inputs] = slopes_of_inputs[:, :, 1:]
        for index, channel in self._offsets.items():
            slopes[channel, :, index] = 1.0
            values[channel] += z[index]
        if origin is not None:
            slopes[:, :, origin] = rate * slopes_of_inputs[:, :, 0]
        return values, slopes

    @property
    def _origin(self) -> tuple[int | None, float, float]:
        """The index of the phase or of the shift, if any; angles of the machine for each of the
        record, and for each unit of that parameter.
        """
        if self.machine.motion is None or self.duration is None:
            return self.phase_index, 1.0, 1.0
        names, span = self.chosen.names, self.machine.motion.span
        index = names.index(SHIFT) if SHIFT in names else None
        return index, self.duration / span, self.machine.turn / span

    def _evaluate_machine(self, x: Array, phi: Array, speeds: Array | None) -> tuple[Array, Array]:
        if speeds is None or np.ptp(speeds) <= STEADY * np.abs(speeds).mean():
            rows, slopes = self._response.slopes(self._response.at(x), phi)
        else:
            nodes = np.array([speeds.min(), (speeds.min() + speeds.max()) / 2, speeds.max()])
            d = self._response.machine.build_data(x)
            rows, slopes = 0.0, 0.0  # type: ignore[assignment]
            for i, node in enumerate(nodes):
                d[self.machine.speed] = np.copysign(node, self.machine.data[self.machine.speed])
                weight = np.prod(
                    [(speeds - other) / (node - other) for other in np.delete(nodes, i)], axis=0
                )
                at_node = self._response.slopes(self._response.at_data(d), phi)
                rows, slopes = rows + weight * at_node[0], slopes + weight[:, None] * at_node[1]
        return rows / self._factors[:, None], slopes / self._factors[:, None, None]


def whiten_rows(rows: Array, gaps: Array, rho: float) -> Array:
    """Return rows (m,) or (m, j) less what the row before tells of them, for a correlation `rho`
    over a step.

    `gaps` (m - 1,) are the numbers of steps between rows. Noise of an autoregression of first order
    becomes white.
    """
    if rho == 0:
        return rows
    share = rho**gaps
    scale = np.sqrt(1 - share**2)
    if rows.ndim > 1:
        share, scale = share[:, None], scale[:, None]
    return np.concatenate([rows[:1], (rows[1:] - share * rows[:-1]) / scale])


def _count_steps(phi: Array, rows: Integers) -> Array:
    """Return the number of steps of the record between neighbouring points, by their angles and by
    their rows.
    """
    steps = np.abs(np.diff(phi))
    if not len(steps):
        return steps
    by_angle = np.round(steps / max(float(np.median(steps)), 1e-300))
    return np.maximum(np.maximum(by_angle, np.diff(rows)), 1.0)


def find_records(phi: Array) -> Integers:
    """Return the record (n,) of each of the angles of a file [rad], counted from 0, in their order.

    A record ends where the angle leaves out a revolution, or goes back by half of one against its
    direction.
    """
    steps = np.diff(phi)
    forward = steps * (np.sign(np.median(steps)) if len(steps) else 1.0)
    return np.concatenate([[0], np.cumsum((forward > TURN) | (forward < -TURN / 2))]).astype(
        np.int64
    )


def find_offset_channel(name: str, keys: Sequence[str], display_units: Sequence[str]) -> int:
    """Return the index of the quantity whose zero an offset is.

    Raises InputError if that is not clear.
    """
    if len(keys) == 1:
        return 0
    suffix = name.removeprefix("offset").removeprefix("_")
    matches = [i for i, key in enumerate(keys) if key == suffix]
    matches = matches or [
        i for i, unit in enumerate(display_units) if suffix and unit == units.display_unit(name)
    ]
    if len(matches) != 1:
        names = ", ".join(f"offset_{key}" for key in keys)
        raise InputError(f"--fit {name}: it is not clear whose zero this is: use {names}")
    return matches[0]


def is_nuisance(name: str) -> bool:
    """Return whether a fitted value is a nuisance parameter, not an input of the machine."""
    return name in (PHASE, SHIFT, *FRAME) or is_offset(name) or name.startswith(EFFECT)


def _check_origin(machine: Machine, name: str, low: float) -> None:
    """Raise InputError for the zero of an angle of what moves freely, for that of the time of what
    an angle drives, and for a time before the start.
    """
    wrong, right = (SHIFT, PHASE) if machine.motion is None else (PHASE, SHIFT)
    if name == wrong:
        reason = "an angle drives" if machine.motion is None else "no angle drives"
        raise InputError(f"--fit {name}: {reason} {machine.name}; its zero is {right}")
    if name == SHIFT and low < 0:
        raise InputError(
            f"--fit {SHIFT}={low:g}:...: the motion starts at 0 s, so that the record begins "
            f"there or later: LOW must be at least 0"
        )


def factor_of(name: str) -> float:
    """Return the unit in which a fitted value is computed, per display unit: SI, but for an offset
    or an effect.
    """
    return 1.0 if is_offset(name) or name.startswith(EFFECT) else units.unit_factor(name)


def _repeats(curve: Array, parts: int) -> bool:
    """Return whether a sampled curve varies and repeats `parts` times in a revolution."""
    allowed = PERIOD_TOLERANCE * float(np.abs(curve).max())
    return bool(
        np.ptp(curve) > allowed
        and np.abs(curve - np.roll(curve, len(curve) // parts)).max() <= allowed
    )


def find_measured(machine: Machine, quantity: str) -> Quantity:
    """Return the quantity that was measured, by its key or name.

    Raises InputError if the machine lacks it.
    """
    results = {result.name: result for result in machine.results} | {
        result.key: result for result in machine.results
    }
    if quantity not in results:
        hint = paths.suggest_names(quantity, [result.key for result in machine.results])
        raise InputError(f"--quantity = {quantity} is not a quantity of {machine.name}: {hint}")
    return results[quantity]


def is_offset(name: str) -> bool:
    """Return whether a name is that of the zero of the gauge, in the unit of the measured
    quantity.
    """
    return re.fullmatch(r"offset(_\w+)?", name) is not None


STEP_DEG = 1.0
"""Step between phases of the scan [deg]."""
SCANNED = 30_000
"""Number of points and phases that a scan has at once."""
INDEPENDENT = 1e-12
"""Share of the largest product below which a column follows from the others."""


def find_phases(curve: MeasuredCurve, z: Array, count: int) -> list[tuple[Array, float]]:
    """Return the best minima over the phase, best first: inputs (n,) and the linearised sum of
    squares.

    The other inputs are fitted, within their bounds, to the curve linearised at `z` (n,). Returns
    `z` alone, with an infinite sum, if no phase is fitted.
    """
    index = curve.phase_index
    if index is None:
        return [(z, float("inf"))]
    free = [i for i in range(len(z)) if i != index]
    lower, upper = curve.bounds(z)
    phases = np.linspace(
        lower[index],
        upper[index],
        max(3, round(np.degrees(upper[index] - lower[index]) / STEP_DEG)),
    )
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
    """Return the other inputs at each phase (k,), with the sum of squares of the linearised
    curves.
    """
    values, slopes = curve.sample(z)
    drift, drift_slopes = curve.drift(z)
    angles, turn = curve.sample_angles, curve.machine.turn
    width = bounds[1] - bounds[0]
    ends = ((bounds[0] - z[free]) / width, (bounds[1] - z[free]) / width)
    prior, prior_slopes = curve.chosen.prior_rows(z)
    prior_rows = np.column_stack([-prior, prior_slopes[:, free] * width])
    fits: list[tuple[Array, float]] = []
    for part in np.array_split(phases, -(-len(phases) * len(curve.phi) // SCANNED)):
        columns = []
        for k, points in enumerate(curve.channels):
            at = np.add.outer(curve.phi[points], part)
            sampled = (values[k], *(slopes[k][:, i] * w for i, w in zip(free, width, strict=True)))
            columns.append(
                np.stack([np.interp(at, angles, row, period=turn) for row in sampled], axis=2)
            )
        stacked = np.concatenate(columns)
        stacked[:, :, 0] = (curve.values - drift)[:, None] - stacked[:, :, 0]
        stacked[:, :, 1:] += (drift_slopes[:, free] * width)[:, None, :]
        rows = curve.whiten(stacked.reshape(len(stacked), -1)).reshape(stacked.shape)
        products = np.einsum("mpi,mpj->pij", rows, rows, optimize=True) + prior_rows.T @ prior_rows
        steps, sums = _solve_within(products, ends)
        fits += [
            (np.clip(z[free] + step * width, *bounds), float(total))
            for step, total in zip(steps, sums, strict=True)
        ]
    return fits


def _solve_within(products: Array, ends: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return the least squares (k, j) of residuals and columns, by their products (k, 1 + j, 1 +
    j), and the sums (k,).

    Where a solution without bounds leaves them, what leaves is held at its bound; what is no
    optimum then, by its slope there, is solved one by one.
    """
    inner, side, total = products[:, 1:, 1:], products[:, 1:, 0], products[:, 0, 0]
    steps = _solve_products(inner, side)
    outside = (steps < ends[0]) | (steps > ends[1])
    bounded = np.where(outside, np.clip(steps, *ends), 0.0)
    free_pairs = ~outside[:, :, None] & ~outside[:, None, :]
    slopes = side - np.einsum("kij,kj->ki", inner, bounded)
    steps = _solve_products(inner * free_pairs, slopes * ~outside) + bounded
    slopes = side - np.einsum("kij,kj->ki", inner, steps)
    is_wrong = np.where(
        outside,
        slopes * np.where(bounded <= ends[0], 1, -1) > 0,
        (steps < ends[0]) | (steps > ends[1]),
    )
    for k in np.flatnonzero(is_wrong.any(axis=1)):
        values, vectors = np.linalg.eigh(products[k])
        rows = (
            np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
        )  # the same products in 1 + j rows
        steps[k] = scipy.optimize.lsq_linear(rows[:, 1:], rows[:, 0], ends, method="bvls").x
    sums = (
        total
        - 2 * np.einsum("ki,ki->k", steps, side)
        + np.einsum("ki,kij,kj->k", steps, inner, steps)
    )
    return steps, np.maximum(sums, 0.0)


def _solve_products(inner: Array, side: Array) -> Array:
    """Return the least squares (k, j) without bounds by products (k, j, j) of columns, and (k, j)
    with a residual.
    """
    inverse = np.linalg.pinv(inner, INDEPENDENT, hermitian=True)
    return np.einsum("kij,kj->ki", inverse, side)
