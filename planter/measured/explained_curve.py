"""A measured curve as what a sensor shows of a machine: operators between the rigid curve and the signal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from planter.engine.machine import Machine
from planter.engine.response import MachineResponse
from planter.errors import InputError
from planter.kernels import Array
from planter.measured.curve import EFFECT, SAMPLES, Chosen, MeasuredCurve, find_measured
from planter.measured.effects import RATE, SQUARE, Curves, SensorEffect
from planter.measured.reading import Measurement
from planter.numerics.arrays import TURN

DIFFERENCE = 1e-5
"""Step of differences in parameters of operators, in widths of their bounds."""
SPEED_STEP = 0.25
"""Relative change of the speed's square from which its share of a curve follows."""


class ExplainedCurve(MeasuredCurve):
    """The signal of a sensor on a machine behind `effects`, at the angles of a measurement of one quantity.

    Curves over a cycle are sampled at `SAMPLES` angles, changed by each effect in turn, and interpolated by a periodic
    cubic spline. The parameters of effects are among the chosen inputs, by `EFFECT` before their names.
    """

    def __init__(
        self, machine: Machine, chosen: Chosen, measured: Measurement, quantity: str, effects: Sequence[SensorEffect]
    ) -> None:
        self.effects = tuple(effects)
        super().__init__(machine, _with_effects(chosen, effects), measured, quantity)
        if len(self.keys) != 1:
            raise InputError("--explain takes one quantity: give --column and --quantity once")
        self._speeds = None
        needed = dict.fromkeys(key for effect in effects for key in effect.needed if key not in (SQUARE, RATE))
        self._needed = {key: find_measured(self.machine, key) for key in needed}
        parts = {key for effect in effects for key in effect.needed} & {SQUARE, RATE}
        self._parts = parts | ({SQUARE} if RATE in parts else set())
        target = find_measured(machine, quantity)
        if RATE in parts and self.machine.acceleration is None and not (target.total and target.unit == "N"):
            raise InputError(f"{machine.name}: {target.key} has no part of the acceleration that could be computed")
        self._grid_response = MachineResponse(
            self._response.machine, [target.name, *(result.name for result in self._needed.values())]
        )
        self._grid_factors = np.array([target.factor, *(result.factor for result in self._needed.values())])
        self._grid: tuple[bytes, Curves] | None = None

    def restart(self) -> None:
        """Discard earlier values."""
        self._grid = None
        super().restart()
        self._grid_response.restart()
        self._grid = None

    def machine_values(self) -> Array:
        """Return the values (n,) of the machine, and those of the effects at which they do least."""
        values, names = super().machine_values(), self.chosen.names
        for effect in self.effects:
            for parameter in effect.parameters:
                values[names.index(name_parameter(effect, parameter.name))] = parameter.neutral
        return np.clip(values, self.chosen.lower, self.chosen.upper)

    def evaluate(self, z: Array, phi: Array, speeds: Array | None = None) -> tuple[Array, Array]:
        """Return the signal (1, m) and its Jacobian (1, m, n) at angles [rad]."""
        curves = self._compute_curves(z[self._inputs])
        signal = self._apply(curves, z)
        names = self.chosen.names
        moved = [names.index(name_parameter(e, p.name)) for e in self.effects for p in e.parameters]
        values = Curves({key: rows[:, :1] for key, rows in curves.rows.items()}, curves.turn, curves.speed)
        columns = [signal]
        for i in moved:
            step = DIFFERENCE * (self.chosen.upper[i] - self.chosen.lower[i])
            ends = [z.copy(), z.copy()]
            ends[0][i], ends[1][i] = z[i] + step, z[i] - step
            columns.append((self._apply(values, ends[0]) - self._apply(values, ends[1])) / (2 * step))
        stacked = np.column_stack(columns)
        angles = phi + (0.0 if self.phase_index is None else z[self.phase_index])
        spline = CubicSpline(
            np.append(curves.angles, curves.turn), np.vstack([stacked, stacked[:1]]), bc_type="periodic"
        )
        at = np.mod(angles, curves.turn)
        rows = spline(at)
        slopes = np.zeros((1, len(phi), len(z)))
        slopes[0][:, [*self._inputs, *moved]] = rows[:, 1:]
        signal_values = rows[None, :, 0].copy()
        for index, channel in self._offsets.items():
            slopes[channel, :, index] = 1.0
            signal_values[channel] += z[index]
        if self.phase_index is not None:
            slopes[0, :, self.phase_index] = spline(at, 1)[:, 0]
        return signal_values, slopes

    def _apply(self, curves: Curves, z: Array) -> Array:
        signal, names = curves.rows[""], self.chosen.names
        for effect in self.effects:
            values = [float(z[names.index(name_parameter(effect, p.name))]) for p in effect.parameters]
            signal = effect.apply(signal, curves, values)
        return signal

    def _compute_curves(self, x: Array) -> Curves:
        """Return the curves of the machine for its inputs; that of the quantity has an empty name."""
        key = x.tobytes()
        if self._grid is None or self._grid[0] != key:
            machine = self._grid_response.machine
            d = machine.build_data(x)
            speed = float(d[machine.speed])
            base = self._sample(d)
            rows: dict[str, Array] = dict(zip(("", *self._needed), base, strict=True))
            if SQUARE in self._parts:
                faster = d.copy()
                faster[machine.speed] = speed * np.sqrt(1 + SPEED_STEP)
                rows[SQUARE] = (self._sample(faster)[0] - base[0]) / (SPEED_STEP * speed**2)
            if RATE in self._parts and machine.acceleration is not None:
                driven = d.copy()
                driven[machine.acceleration] += 1.0
                rows[RATE] = self._sample(driven)[0] - base[0]
            elif RATE in self._parts:
                rows[RATE] = _integrate(rows[SQUARE], machine.turn)
            self._grid = key, Curves(rows, machine.turn, speed)
        return self._grid[1]

    def _sample(self, d: Array) -> Array:
        """Return the quantities (q, SAMPLES, 1 + p) with derivatives in the inputs, in display units."""
        rows, slopes = self._grid_response.slopes(self._grid_response.at_data(d), self.sample_angles)
        both: Array = np.concatenate([rows[:, :, None], slopes[:, :, 1:]], axis=2) / self._grid_factors[:, None, None]
        return both


def _integrate(rows: Array, turn: float) -> Array:
    """Return the integral (SAMPLES, c) over the angle of a periodic curve, whose mean is zero.

    The part of the acceleration is the momentum per speed, whose derivative is the part of the speed's square.
    """
    spectrum = np.fft.rfft(rows, axis=0)
    orders = 1j * np.arange(len(spectrum)) * TURN / turn
    spectrum[0], orders[0] = 0.0, 1.0
    integral: Array = np.fft.irfft(spectrum / orders[:, None], SAMPLES, axis=0)
    return integral


def name_parameter(effect: SensorEffect, parameter: str) -> str:
    """Return the name of a parameter among the chosen inputs."""
    return f"{EFFECT}{effect.name}.{parameter}"


def _with_effects(chosen: Chosen, effects: Sequence[SensorEffect]) -> Chosen:
    parameters: Mapping[str, tuple[float, float]] = {
        name_parameter(effect, p.name): (p.lower, p.upper) for effect in effects for p in effect.parameters
    }
    lower, upper = (np.array([ends[k] for ends in parameters.values()]) for k in (0, 1))
    return replace(
        chosen,
        names=(*chosen.names, *parameters),
        lower=np.concatenate([chosen.lower, lower]),
        upper=np.concatenate([chosen.upper, upper]),
    )
