"""What stands between a rigid machine and its sensor, as operators on curves over a cycle, for
every machine.

A curve has columns (S, c) at equal angles: its values, then their derivatives in the inputs of the
machine. Every operator is linear in the curves of the machine, so that it moves all columns alike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Literal, Protocol

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from planter.kernels import Array
from planter.numerics.arrays import TURN, Integers

ComplexArray = npt.NDArray[np.complex128]
Scale = Literal["linear", "log", "reciprocal"]
SQUARE, RATE = "speed squared", "acceleration"
"""Names of the parts of a curve that the square of the speed and the acceleration of the drive
multiply.
"""
LARGEST_SHARE = 1.5
"""Largest share of another force in a signal."""
SHORTEST_LEVER_M = 0.005
"""Shortest lever of a torque [m]."""
LARGEST_SWING = 0.3
"""Largest share of the speed by which a harmonic moves it."""
MOUNT_RATIO, MOUNT_DAMPING = (1.2, 60.0), (0.003, 0.7)
"""Natural frequency of a mount in turns of the drive, and its share of critical damping."""
CORNER_RATIO = (1e-3, 3.0)
"""Corner frequency of a coupling without direct current, in turns of the drive."""
LARGEST_GAIN = 2.0
"""Largest factor, and reciprocal of the least, by which a sensor magnifies its signal."""
DRIFTS = {1: "linear", 2: "quadratic", 3: "cubic"}
"""Degrees of the polynomials by which the zero of a sensor drifts, with their names."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of an operator, between bounds that it is searched in; `reference` is its display
    value there.

    A search has the value itself, its logarithm, or its reciprocal; `neutral` is where the operator
    does least.
    """

    name: str
    unit: str
    lower: float
    upper: float
    scale: Scale = "linear"
    reference: float = 1.0
    neutral: float = 0.0

    def to_display(self, value: float) -> float | None:
        """Return a searched value in the display unit, None for the reciprocal of zero."""
        if self.scale == "reciprocal":
            return self.reference / value if value else None
        return self.reference * (float(np.exp(value)) if self.scale == "log" else value)

    def from_display(self, value: float) -> float:
        """Return the searched value of one in the display unit, which is not zero unless its scale
        is linear.
        """
        if self.scale == "reciprocal":
            return self.reference / value
        return (
            float(np.log(value / self.reference)) if self.scale == "log" else value / self.reference
        )


@dataclass(frozen=True)
class Curves:
    """Curves of a machine by name, with columns (S, c), at equal angles of a cycle `turn` [rad] at
    a speed [rad/s].
    """

    rows: Mapping[str, Array]
    turn: float
    speed: float

    @property
    def angles(self) -> Array:
        """Angles (S,) [rad]."""
        count = len(next(iter(self.rows.values())))
        return np.linspace(0, self.turn, count, endpoint=False)


class SensorEffect(Protocol):
    """An operator with parameters, and the curves of the machine that it needs besides."""

    @property
    def name(self) -> str:
        """The name, unique among the operators of an explanation."""

    @property
    def meaning(self) -> str:
        """The clause that describes the operator."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters."""

    @property
    def needed(self) -> tuple[str, ...]:
        """Names of curves of the machine."""

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal (S, c) for values of the parameters."""


@dataclass(frozen=True)
class TurnedAxis:
    """A sensor in the plane of x and y: a force along x is turned towards y, along which another
    one acts.
    """

    key: str
    name: str = "axis"
    meaning: str = "the axis of the sensor is turned from x towards y"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (Parameter("angle", "deg", -180.0, 180.0),)

    @property
    def needed(self) -> tuple[str, ...]:
        return (self.key,)

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the force along the axis of the sensor."""
        angle = np.radians(values[0])
        turned: Array = np.cos(angle) * signal + np.sin(angle) * curves.rows[self.key]
        return turned


@dataclass(frozen=True)
class LeakedForce:
    """A share of another force of the machine, which the sensor sees besides."""

    key: str

    @property
    def name(self) -> str:
        return f"enclosed {self.key}"

    @property
    def meaning(self) -> str:
        return f"the sensor also sees a share of {self.key}"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return (Parameter("share", "1", -LARGEST_SHARE, LARGEST_SHARE),)

    @property
    def needed(self) -> tuple[str, ...]:
        return (self.key,)

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal with the share of the force."""
        return signal + values[0] * curves.rows[self.key]


@dataclass(frozen=True)
class LeakedTorque:
    """The force of a torque of the machine at a lever, which the sensor sees besides."""

    key: str

    @property
    def name(self) -> str:
        return f"lever {self.key}"

    @property
    def meaning(self) -> str:
        return f"the sensor also sees the reaction of {self.key} at a lever"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        largest = 1 / SHORTEST_LEVER_M
        return (Parameter("lever", "mm", -largest, largest, "reciprocal", 1e3),)

    @property
    def needed(self) -> tuple[str, ...]:
        return (self.key,)

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal with the force at the lever."""
        return signal + values[0] * curves.rows[self.key]


@dataclass(frozen=True)
class Imbalance:
    """The force of a mass that turns with the drive off its axis, of at most `largest` [kg m]."""

    largest: float
    name: str = "imbalance"
    meaning: str = "the drive carries an imbalance"
    needed: tuple[str, ...] = ()

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(
            Parameter(axis, "kg m", -self.largest, self.largest) for axis in ("along", "across")
        )

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal with the turning force."""
        turned = signal.copy()
        square, phi = curves.speed**2, curves.angles
        turned[:, 0] += square * (values[0] * np.cos(phi) + values[1] * np.sin(phi))
        return turned


@dataclass(frozen=True)
class SpeedHarmonics:
    """A speed that swings with harmonics of the drive: F = W + omega^2 a + omega' b, with parts a,
    b of the machine.
    """

    orders: tuple[int, ...] = (1, 2)
    name: str = "speed harmonics"
    meaning: str = "the speed swings within a turn"
    needed: tuple[str, ...] = (SQUARE, RATE)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(
            Parameter(f"{part}{order}", "1", -LARGEST_SWING, LARGEST_SWING)
            for order in self.orders
            for part in ("cos", "sin")
        )

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal at the swinging speed."""
        count = len(signal)
        swing, slope = np.zeros(count), np.zeros(count)
        for order, (cosine, sine) in zip(
            self.orders, zip(values[::2], values[1::2], strict=True), strict=True
        ):
            cosines, sines = _sample_wave(order, count, curves.turn)
            swing += cosine * cosines + sine * sines
            slope += order * (sine * cosines - cosine * sines)
        square = curves.speed**2
        more = square * (2 * swing + swing**2)
        return (
            signal
            + more[:, None] * curves.rows[SQUARE]
            + (square * (1 + swing) * slope)[:, None] * curves.rows[RATE]
        )


@dataclass(frozen=True)
class ElasticMount:
    """A mount of one mass on a spring and a damper below a machine whose motion is prescribed, at a
    speed [rad/s].
    """

    speed: float
    name: str = "elastic mount"
    meaning: str = "the machine stands on an elastic mount"
    needed: tuple[str, ...] = ()

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        high = self.speed / TURN * MOUNT_RATIO[1]
        return (
            Parameter(
                "frequency", "Hz", float(np.log(MOUNT_RATIO[0] / MOUNT_RATIO[1])), 0.0, "log", high
            ),
            Parameter(
                "damping",
                "1",
                float(np.log(MOUNT_DAMPING[0])),
                float(np.log(MOUNT_DAMPING[1])),
                "log",
                neutral=float(np.log(0.05)),
            ),
        )

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal below the mount."""
        frequency, damping = (p.to_display(v) for p, v in zip(self.parameters, values, strict=True))
        assert frequency is not None
        assert damping is not None
        s, wn = _list_rates(curves), TURN * frequency
        return _filter(
            signal, (2 * damping * wn * s + wn**2) / (s**2 + 2 * damping * wn * s + wn**2)
        )


@dataclass(frozen=True)
class ElectricCoupling:
    """An amplifier without direct current, of first order, as charge amplifiers of piezoelectric
    sensors are.
    """

    speed: float
    name: str = "coupling"
    meaning: str = "the amplifier passes no direct current"
    needed: tuple[str, ...] = ()

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        low = self.speed / TURN * CORNER_RATIO[0]
        return (
            Parameter(
                "corner", "Hz", 0.0, float(np.log(CORNER_RATIO[1] / CORNER_RATIO[0])), "log", low
            ),
        )

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal behind the amplifier."""
        corner = self.parameters[0].to_display(values[0])
        assert corner is not None
        s = _list_rates(curves)
        return _filter(signal, s / (s + TURN * corner))


@dataclass(frozen=True)
class Gain:
    """A sensor that magnifies its signal, as one does whose sensitivity is not that of its
    sheet.
    """

    name: str = "gain"
    meaning: str = "the sensor magnifies its signal"
    needed: tuple[str, ...] = ()

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        end = float(np.log(LARGEST_GAIN))
        return (Parameter("factor", "1", -end, end, "log"),)

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the magnified signal."""
        return signal * float(np.exp(values[0]))


@dataclass(frozen=True)
class ZeroDrift:
    """A zero that drifts over the record, by a polynomial over each of several records in `spans`
    [rad], two ends each.

    `largest` is the largest part of it, in the display `unit` of the quantity. Drift does not
    repeat with the cycle, so that it is no operator on the curve of one: `columns` has what the
    parameters multiply.
    """

    degree: int
    spans: tuple[tuple[float, float], ...]
    largest: float
    unit: str
    needed: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return f"{DRIFTS[self.degree]} drift of zero"

    @property
    def meaning(self) -> str:
        return (
            f"the zero of the sensor drifts, by a {DRIFTS[self.degree]} polynomial over each record"
        )

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        parameters = []
        for record, (first, last) in enumerate(self.spans, 1):
            number = f"{record}" if len(self.spans) > 1 else ""
            half = abs(last - first) / 2 / TURN  # revolutions
            if record > 1:
                parameters.append(
                    Parameter(f"zero{number}", self.unit, -self.largest, self.largest)
                )
            rate = self.largest / half if half else self.largest
            parameters.append(Parameter(f"slope{number}", f"{self.unit}/r", -rate, rate))
            parameters += [
                Parameter(f"bend{number}_{power}", self.unit, -self.largest, self.largest)
                for power in range(2, self.degree + 1)
            ]
        return tuple(parameters)

    def columns(self, phi: Array, records: Integers) -> Array:
        """Return what the parameters multiply (m, p) at angles (m,) [rad] of records (m,), counted
        from 0.

        The slope is per revolution from the middle of a record; bends multiply Legendre's
        polynomials over it.
        """
        columns = []
        for record, (first, last) in enumerate(self.spans):
            inside = records == record
            from_middle = phi - (first + last) / 2
            share = np.clip(2 * from_middle / ((last - first) or 1.0), -1.0, 1.0)
            rows = [np.ones(len(phi))] if record else []
            rows.append(from_middle / TURN)
            rows += [legendre.Legendre.basis(power)(share) for power in range(2, self.degree + 1)]
            columns += [np.where(inside, row, 0.0) for row in rows]
        return np.column_stack(columns)

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal as it is, since drift is no part of a cycle."""
        return signal


def rank_effect(effect: SensorEffect) -> int:
    """Return the place of an effect between machine and amplifier, in which effects act."""
    # the speed acts on the machine, before what the sensor adds
    return (
        SpeedHarmonics,
        TurnedAxis,
        LeakedForce,
        LeakedTorque,
        Imbalance,
        ElasticMount,
        Gain,
        ElectricCoupling,
        ZeroDrift,
    ).index(type(effect))


@cache
def _sample_wave(order: int, count: int, turn: float) -> tuple[Array, Array]:
    """Return cosine and sine (count,) of multiples of equal angles of a cycle."""
    phi = order * np.linspace(0, turn, count, endpoint=False)
    return np.cos(phi), np.sin(phi)


def _list_rates(curves: Curves) -> ComplexArray:
    """Return i omega of the harmonics of a cycle [rad/s], (S // 2 + 1,)."""
    count = len(curves.angles)
    return np.asarray(
        1j * np.arange(count // 2 + 1) * curves.speed * TURN / curves.turn, dtype=np.complex128
    )


def _filter(signal: Array, response: ComplexArray) -> Array:
    """Return a periodic signal (S, c) behind a filter with a response (S // 2 + 1,)."""
    filtered: Array = np.fft.irfft(
        np.fft.rfft(signal, axis=0) * response[:, None], len(signal), axis=0
    )
    return filtered
