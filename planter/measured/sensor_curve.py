"""A measured curve as what a sensor shows of a machine: operators between the rigid curve and the
signal.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from planter.engine.machine import Machine
from planter.engine.response import MachineResponse
from planter.errors import InputError
from planter.files import units
from planter.kernels import Array
from planter.measured.curve import EFFECT, SAMPLES, Chosen, MeasuredCurve, factor_of, find_measured
from planter.measured.findings import MeasurementResult
from planter.measured.reading import Channel, Measurement
from planter.measured.sensor_view import (
    RATE,
    SQUARE,
    Curves,
    SensorEffect,
    SensorView,
    StatedEffect,
    ZeroDrift,
    find_sensor_view,
    is_sensor_input,
)
from planter.numerics.arrays import TURN

DIFFERENCE = 1e-5
"""Step of differences in parameters of operators, in widths of their bounds, and in the speed, in
parts of it.
"""
SPEED_STEP = 0.25
"""Relative change of the speed's square from which its share of a curve follows."""
MEAN_SPEED = (
    "what the sensor sees holds at the mean speed of the record, whose swing is a part "
    "of the residuals"
)


_Operator = tuple[StatedEffect, Mapping[int, tuple[int, float | None]]]
"""An effect, and which of its values chosen inputs have, by their places: the index of the input,
which is the value itself, or, with a factor, the value in the display unit times the factor.
"""


class SensorCurve(MeasuredCurve):
    """Quantities at the angles of a measurement, of which a sensor sees one behind effects.

    Effects are those that the machine file states for a quantity in [measurement], with the values
    there, and `effects` more, whose parameters are among the chosen inputs, by `EFFECT` before
    their names. Curves over a cycle are sampled at `SAMPLES` angles, changed by each effect in
    turn, and interpolated by a periodic cubic spline. The sensor's quantity is that at the mean
    speed of a record.

    Raises InputError for more than one quantity with `effects`, and as `find_sensor_view`.
    """

    def __init__(
        self,
        machine: Machine,
        chosen: Chosen,
        measured: Measurement,
        quantity: str | Sequence[str],
        effects: Sequence[SensorEffect] = (),
    ) -> None:
        self.effects = tuple(effects)
        super().__init__(machine, _with_effects(chosen, effects), measured, quantity)
        if effects and len(self.keys) != 1:
            raise InputError("--explain takes one quantity: give --column and --quantity once")
        view = find_sensor_view(machine)
        self.stated = view.effects if view is not None and view.quantity.key in self.keys else ()
        key = view.quantity.key if view is not None and self.stated else self.keys[0]
        self._seen = [k for k, other in enumerate(self.keys) if other == key]
        self._operators = sorted(
            [*map(self._read_stated, self.stated), *map(self._read_fitted, self.effects)],
            key=lambda operator: operator[0].effect.rank,
        )
        needed = {name: None for stated, _ in self._operators for name in stated.effect.needed}
        self._needed = {
            name: find_measured(self.machine, name) for name in needed if name not in (SQUARE, RATE)
        }
        parts = set(needed) & {SQUARE, RATE}
        self._parts = parts | ({SQUARE} if RATE in parts else set())
        target = find_measured(machine, key)
        if (
            RATE in parts
            and self.machine.acceleration is None
            and not (target.total and target.unit == "N")
        ):
            raise InputError(
                f"{machine.name}: {target.key} has no part of the acceleration that could be "
                f"computed"
            )
        self._grid_response = MachineResponse(
            self._response.machine,
            [target.name, *(result.name for result in self._needed.values())],
        )
        self._grid_factors = np.array(
            [target.factor, *(result.factor for result in self._needed.values())]
        )
        self._grid: tuple[bytes, Curves] | None = None

    @classmethod
    def at_angles(
        cls, machine: Machine, quantity: str, phi: Array, effects: Sequence[SensorEffect] = ()
    ) -> Self:
        """Return the curve of a machine at angles (n,) [rad] without data; all that is chosen are
        `effects`.
        """
        unit = units.display_unit(find_measured(machine, quantity).key)
        empty = Channel(quantity, unit, np.zeros(len(phi)), np.ones(len(phi), dtype=bool), 1.0)
        return cls(
            machine, Chosen.from_bounds(machine, {}), Measurement(phi, (empty,)), quantity, effects
        )

    def restart(self) -> None:
        """Discard earlier values."""
        depends_on_earlier = self.machine.loops is not None
        self._grid = None if depends_on_earlier else self._grid
        super().restart()
        self._grid_response.restart()
        self._grid = None if depends_on_earlier else self._grid

    def machine_values(self) -> Array:
        """Return the values (n,) of the machine and of its file, and those of the effects at which
        they do least.
        """
        values, names = super().machine_values(), self.chosen.names
        for effect in self.effects:
            values[self._find_indices(effect)] = [p.neutral for p in effect.parameters]
        for stated in self.stated:
            for path, (_, value) in stated.parameters.items():
                if path in names:
                    values[names.index(path)] = value * factor_of(path)
        return np.clip(values, self.chosen.lower, self.chosen.upper)

    def evaluate(self, z: Array, phi: Array, speeds: Array | None = None) -> tuple[Array, Array]:
        """Return the quantities (k, m) and their Jacobians (k, m, n) at angles [rad], the sensor's
        at mean speed.
        """
        if len(self._seen) < len(self.keys):
            values, slopes = super().evaluate(z, phi, speeds)
        else:
            values, slopes = (
                np.empty((len(self.keys), len(phi))),
                np.empty((len(self.keys), len(phi), len(z))),
            )
        signal, signal_slopes = self._evaluate_signal(z, phi)
        for channel in self._seen:
            values[channel], slopes[channel] = signal, signal_slopes
            for index in (index for index, other in self._offsets.items() if other == channel):
                slopes[channel, :, index] = 1.0
                values[channel] += z[index]
        return values, slopes

    def drift(self, z: Array) -> tuple[Array, Array]:
        """Return the drift of the zero at the points (m,), and its Jacobian (m, n)."""
        values, slopes = super().drift(z)
        for effect in self.effects:
            if isinstance(effect, ZeroDrift):
                slopes[:, self._find_indices(effect)] = effect.columns(self.phi, self.records)
        return values + slopes @ z, slopes

    def find_view(self, z: Array) -> SensorView:
        """Return the view of the sensor: stated effects, and fitted ones with their values among
        the inputs (n,).

        A drift belongs to a record and is left out.
        """
        effects = (each for each in self._read_effects(z) if not isinstance(each.effect, ZeroDrift))
        return SensorView(find_measured(self.machine, self.keys[self._seen[0]]), tuple(effects))

    @property
    def has_speeds(self) -> bool:
        """Whether the record has the speed of the drive."""
        return self._speeds is not None

    def _evaluate_signal(self, z: Array, phi: Array) -> tuple[Array, Array]:
        """Return the signal without offset (m,) and its Jacobian (m, n) at angles [rad]."""
        x = z[self._inputs]
        curves = self._compute_curves(x)
        indices = [index for _, moved in self._operators for index, _ in moved.values()]
        values = _drop_slopes(curves)
        columns = [self._apply(curves, z)]
        if self.machine.speed in self._grid_response.machine.moved:
            # operators depend on the speed in other ways than by their curves
            index = self._grid_response.machine.moved.index(self.machine.speed)
            columns[0][:, 1 + index] = self._differentiate_in_speed(z, x, index)
        for i in indices:
            step = DIFFERENCE * (self.chosen.upper[i] - self.chosen.lower[i])
            ends = [z.copy(), z.copy()]
            ends[0][i], ends[1][i] = z[i] + step, z[i] - step
            columns.append(
                (self._apply(values, ends[0]) - self._apply(values, ends[1])) / (2 * step)
            )
        stacked = np.column_stack(columns)
        angles = phi + (0.0 if self.phase_index is None else z[self.phase_index])
        rows, rates = interpolate_periodic(stacked, curves.turn, angles)
        slopes = np.zeros((len(phi), len(z)))
        slopes[:, [*self._inputs, *indices]] = rows[:, 1:]
        if self.phase_index is not None:
            slopes[:, self.phase_index] = rates[:, 0]
        return rows[:, 0], slopes

    def _differentiate_in_speed(self, z: Array, x: Array, index: int) -> Array:
        """Return the derivative (SAMPLES,) of the signal in the speed, the input `index` of the
        machine (p,).
        """
        step = DIFFERENCE * max(abs(float(x[index])), DIFFERENCE)
        signals = []
        for end in (x[index] + step, x[index] - step):
            at_end = x.copy()
            at_end[index] = end
            signals.append(self._apply(_drop_slopes(self._sample_curves(at_end)), z)[:, 0])
        slope: Array = (signals[0] - signals[1]) / (2 * step)
        return slope

    def _read_stated(self, stated: StatedEffect) -> _Operator:
        """Return an effect of the machine file, of whose values the chosen inputs may have some."""
        names = self.chosen.names
        moved = {
            place: (names.index(path), factor_of(path))
            for place, path in enumerate(stated.paths)
            if path in names
        }
        return stated, moved

    def _read_fitted(self, effect: SensorEffect) -> _Operator:
        """Return an effect whose parameters are among the chosen inputs."""
        neutral = tuple(parameter.neutral for parameter in effect.parameters)
        moved = {place: (index, None) for place, index in enumerate(self._find_indices(effect))}
        return StatedEffect(effect, neutral), moved

    def _read_effects(self, z: Array) -> Iterator[StatedEffect]:
        """Yield the effects with the values of their parameters for chosen inputs z (n,)."""
        for stated, moved in self._operators:
            values = list(stated.values)
            for place, (index, factor) in moved.items():
                chosen = float(z[index])
                if factor is not None:
                    chosen = stated.effect.parameters[place].from_display(chosen / factor)
                values[place] = chosen
            yield StatedEffect(stated.effect, tuple(values))

    def _find_indices(self, effect: SensorEffect) -> list[int]:
        """Return the places of an effect's parameters among the chosen inputs."""
        return [
            self.chosen.names.index(name_parameter(effect, parameter.name))
            for parameter in effect.parameters
        ]

    def _apply(self, curves: Curves, z: Array) -> Array:
        signal = curves.rows[""].copy()
        for stated in self._read_effects(z):
            signal = stated.effect.apply(signal, curves, stated.values)
        return signal

    def _compute_curves(self, x: Array) -> Curves:
        """Return the curves of the machine for its inputs, of which the last are cached."""
        key = x.tobytes()
        if self._grid is None or self._grid[0] != key:
            self._grid = key, self._sample_curves(x)
        return self._grid[1]

    def _sample_curves(self, x: Array) -> Curves:
        """Return the curves of the machine for its inputs; that of the quantity has an empty
        name.
        """
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
        return Curves(rows, machine.turn, speed)

    def _sample(self, d: Array) -> Array:
        """Return the quantities (q, SAMPLES, 1 + p) with derivatives in the inputs, in display
        units.
        """
        rows, slopes = self._grid_response.slopes(
            self._grid_response.at_data(d), self.sample_angles
        )
        both: Array = (
            np.concatenate([rows[:, :, None], slopes[:, :, 1:]], axis=2)
            / self._grid_factors[:, None, None]
        )
        return both


def build_curve(
    machine: Machine, chosen: Chosen, measured: Measurement, quantity: str | Sequence[str]
) -> MeasuredCurve:
    """Return the curve of quantities, one of them as its sensor sees it if the machine file states
    that.
    """
    view = find_sensor_view(machine)
    quantities = (quantity,) if isinstance(quantity, str) else quantity
    keys = [find_measured(machine, each).key for each in quantities]
    is_seen = view is not None and bool(view.effects) and view.quantity.key in keys
    if view is not None and not is_seen and any(map(is_sensor_input, chosen.names)):
        name = next(filter(is_sensor_input, chosen.names))
        raise InputError(
            f"--fit {name}: the sensor of [measurement] measures {view.quantity.key}, not {keys[0]}"
        )
    return (SensorCurve if is_seen else MeasuredCurve)(machine, chosen, measured, quantity)


@dataclass(frozen=True)
class SensorSignal:
    """The signal of a sensor over a cycle, with its view, and the rigid curve at angles, (n,) each
    [display unit].
    """

    view: SensorView
    angles_deg: Array
    rigid: Array
    signal: Array

    @property
    def column(self) -> dict[str, Array]:
        """The signal (n,) by the key of its column in tables."""
        return {f"measured_{self.view.quantity.key}": self.signal}

    @property
    def name(self) -> str:
        """The name of the signal on a page."""
        return f"{self.view.quantity.name} as the sensor sees it"

    @property
    def result(self) -> MeasurementResult:
        """Statistics of the signal over its angles."""
        signal, key = self.signal, self.view.quantity.key
        return MeasurementResult(
            quantity=key,
            unit=units.display_unit(key),
            max=float(signal.max()),
            min=float(signal.min()),
            range=float(np.ptp(signal)),
            mean=float(signal.mean()),
            variance=float(signal.var()),
            seen=[str(effect) for effect in self.view.effects],
        )


def measure_cycle(
    machine: Machine, phi: Array, columns: Mapping[str, Array]
) -> SensorSignal | None:
    """Return what the sensor of a machine file sees at angles (n,) [rad] of a cycle, or None if it
    states none.

    `columns` are the quantities (n,) at these angles by key. Raises InputError as
    `find_sensor_view`.
    """
    view = find_sensor_view(machine)
    if view is None:
        return None
    key = view.quantity.key
    if key in columns:
        rigid = columns[key]
    else:
        response = MachineResponse(machine, [view.quantity.name])
        rigid = response.values(response.at_data(machine.data), phi)[0] / view.quantity.factor
    signal = rigid
    if view.effects:
        signal = SensorCurve.at_angles(machine, key, phi).evaluate(np.zeros(0), phi)[0][0]
    return SensorSignal(view, np.degrees(phi), rigid, signal)


def _drop_slopes(curves: Curves) -> Curves:
    """Return the values of curves, (SAMPLES, 1) each, without their derivatives."""
    return Curves(
        {key: rows[:, :1] for key, rows in curves.rows.items()}, curves.turn, curves.speed
    )


def _integrate(rows: Array, turn: float) -> Array:
    """Return the integral (SAMPLES, c) over the angle of a periodic curve, whose mean is zero.

    The part of the acceleration is the momentum per speed, whose derivative is the part of the
    speed's square.
    """
    spectrum = np.fft.rfft(rows, axis=0)
    orders = 1j * np.arange(len(spectrum)) * TURN / turn
    spectrum[0], orders[0] = 0.0, 1.0
    integral: Array = np.fft.irfft(spectrum / orders[:, None], SAMPLES, axis=0)
    return integral


def interpolate_periodic(rows: Array, period: float, at: Array) -> tuple[Array, Array]:
    """Return the cubic splines through rows (S, c) at equal steps of a period, and their slopes, at
    places (n,).

    Second derivatives solve a cyclic system, which is diagonal in the harmonics of the period.
    """
    count = len(rows)
    step = period / count
    cosines = np.cos(TURN * np.arange(count // 2 + 1) / count)
    response = 6 * (cosines - 1) / (2 + cosines)  # of the second derivatives, times step squared
    bends = np.fft.irfft(np.fft.rfft(rows, axis=0) * response[:, None], count, axis=0) / 6
    place = np.mod(at, period) / step
    left = place.astype(int) % count
    right, share = (left + 1) % count, (place - np.floor(place))[:, None]
    rest = 1 - share
    values = rest * rows[left] + share * rows[right]
    values += (rest**3 - rest) * bends[left] + (share**3 - share) * bends[right]
    slopes = (
        rows[right]
        - rows[left]
        - (3 * rest**2 - 1) * bends[left]
        + (3 * share**2 - 1) * bends[right]
    )
    return values, slopes / step


def name_parameter(effect: SensorEffect, parameter: str) -> str:
    """Return the name of a parameter among the chosen inputs."""
    return f"{EFFECT}{effect.name}.{parameter}"


def _with_effects(chosen: Chosen, effects: Sequence[SensorEffect]) -> Chosen:
    parameters: Mapping[str, tuple[float, float]] = {
        name_parameter(effect, p.name): (p.lower, p.upper)
        for effect in effects
        for p in effect.parameters
    }
    lower, upper = (np.array([ends[k] for ends in parameters.values()]) for k in (0, 1))
    return replace(
        chosen,
        names=(*chosen.names, *parameters),
        lower=np.concatenate([chosen.lower, lower]),
        upper=np.concatenate([chosen.upper, upper]),
    )


def describe_view(curve: MeasuredCurve, z: Array) -> list[str]:
    """Return sentences on what the machine file states of the sensor, and on the speed at which a
    signal holds.

    Values that are among the chosen inputs are those in z (n,).
    """
    sentences = []
    if isinstance(curve, SensorCurve):
        stated = {each.effect.name for each in curve.stated}
        effects = [each for each in curve.find_view(z).effects if each.effect.name in stated]
        sentences = [f"the machine file's [measurement]: {each}" for each in effects]
        if curve.has_speeds:
            sentences.append(MEAN_SPEED)
    view = find_sensor_view(curve.machine)
    if view is not None and view.quantity.key not in curve.keys:
        sentences.append(
            f"the machine file's [measurement] is one of {view.quantity.key}, and does not apply "
            f"here"
        )
    return sentences
