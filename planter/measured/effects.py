"""What stands between a rigid machine and its sensor, as operators on curves over a cycle, for
every machine.

A curve has columns (S, c) at equal angles: its values, then their derivatives in the inputs of the
machine. Every operator is linear in the curves of the machine, so that it moves all columns alike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import ClassVar, Literal

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from planter.kernels import Array, Integers
from planter.numerics.arrays import TURN

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


class SensorEffect:
    """An operator on a curve, with parameters, and names of the curves of the machine that it needs
    besides.

    `name` is unique among the operators of an explanation; `meaning` is a clause that describes it.
    """

    rank: ClassVar[int]
    """Place between machine and amplifier: the speed acts on the machine, before what the sensor
    adds.
    """
    keys: ClassVar[tuple[str, ...]] = ()
    """Keys of [measurement] that state the parameters: a key for each, or one for a list."""

    def __init__(
        self, name: str, meaning: str, *parameters: Parameter, needed: tuple[str, ...] = ()
    ) -> None:
        self.name, self.meaning, self.parameters, self.needed = name, meaning, parameters, needed

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal (S, c) for values of the parameters."""
        return signal


class SpeedHarmonics(SensorEffect):
    """A speed that swings with harmonics of the drive: F = W + omega^2 a + omega' b, with parts a,
    b of the machine.
    """

    rank, keys, orders = 0, ("speed_harmonics",), (1, 2)

    def __init__(self) -> None:
        names = [f"{part}{order}" for order in self.orders for part in ("cos", "sin")]
        swings = (Parameter(name, "1", -LARGEST_SWING, LARGEST_SWING) for name in names)
        meaning = "the speed swings within a turn"
        super().__init__("speed harmonics", meaning, *swings, needed=(SQUARE, RATE))

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal at the swinging speed."""
        count = len(signal)
        swing, slope = np.zeros(count), np.zeros(count)
        for order, cosine, sine in zip(self.orders, values[::2], values[1::2], strict=True):
            cosines, sines = _sample_wave(order, count, curves.turn)
            swing += cosine * cosines + sine * sines
            slope += order * (sine * cosines - cosine * sines)
        square = curves.speed**2
        more = square * (2 * swing + swing**2)
        rate = square * (1 + swing) * slope
        return signal + more[:, None] * curves.rows[SQUARE] + rate[:, None] * curves.rows[RATE]


class AddedCurve(SensorEffect):
    """A multiple of another curve of the machine, `key`, which the sensor sees besides."""

    def __init__(self, key: str, name: str, meaning: str, parameter: Parameter) -> None:
        super().__init__(name, meaning, parameter, needed=(key,))
        self.key = key

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal with the multiple of the curve."""
        return signal + values[0] * curves.rows[self.key]


class TurnedAxis(AddedCurve):
    """A sensor in the plane of x and y: a force along x is turned towards y, along which another
    one acts.
    """

    rank, keys = 1, ("axis_deg",)

    def __init__(self, key: str) -> None:
        meaning = "the axis of the sensor is turned from x towards y"
        super().__init__(key, "axis", meaning, Parameter("angle", "deg", -180.0, 180.0))

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the force along the axis of the sensor."""
        angle = np.radians(values[0])
        turned: Array = np.cos(angle) * signal + np.sin(angle) * curves.rows[self.key]
        return turned


class LeakedForce(AddedCurve):
    """A share of another force of the machine, which the sensor sees besides."""

    rank = 2

    def __init__(self, key: str) -> None:
        share = Parameter("share", "1", -LARGEST_SHARE, LARGEST_SHARE)
        meaning = f"the sensor also sees a share of {key}"
        super().__init__(key, f"enclosed {key}", meaning, share)


class LeakedTorque(AddedCurve):
    """The force of a torque of the machine at a lever, which the sensor sees besides."""

    rank, keys = 3, ("lever_mm",)

    def __init__(self, key: str) -> None:
        largest = 1 / SHORTEST_LEVER_M
        lever = Parameter("lever", "mm", -largest, largest, "reciprocal", 1e3)
        meaning = f"the sensor also sees the reaction of {key} at a lever"
        super().__init__(key, f"lever {key}", meaning, lever)


class Imbalance(SensorEffect):
    """The force of a mass that turns with the drive off its axis, of at most `largest` [kg m]."""

    rank, keys = 4, ("imbalance_kg_m",)

    def __init__(self, largest: float) -> None:
        parts = (Parameter(axis, "kg m", -largest, largest) for axis in ("along", "across"))
        super().__init__("imbalance", "the drive carries an imbalance", *parts)

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal with the turning force."""
        turned = signal.copy()
        square, phi = curves.speed**2, curves.angles
        turned[:, 0] += square * (values[0] * np.cos(phi) + values[1] * np.sin(phi))
        return turned


class ElasticMount(SensorEffect):
    """A mount of one mass on a spring and a damper below a machine whose motion is prescribed, at a
    speed [rad/s].
    """

    rank, keys = 5, ("mount_Hz", "mount_damping")

    def __init__(self, speed: float) -> None:
        high = speed / TURN * MOUNT_RATIO[1]
        lowest = float(np.log(MOUNT_RATIO[0] / MOUNT_RATIO[1]))
        low, high_damping, usual = map(float, np.log([*MOUNT_DAMPING, 0.05]))
        super().__init__(
            "elastic mount",
            "the machine stands on an elastic mount",
            Parameter("frequency", "Hz", lowest, 0.0, "log", high),
            Parameter("damping", "1", low, high_damping, "log", neutral=usual),
        )

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal below the mount."""
        wn = TURN * self.parameters[0].reference * np.exp(values[0])
        s, damping = _list_rates(curves), np.exp(values[1])
        above = 2 * damping * wn * s + wn**2
        return _filter(signal, above / (s**2 + above))


class Gain(SensorEffect):
    """A sensor that magnifies its signal, as one does whose sensitivity is not that of its
    sheet.
    """

    rank, keys = 6, ("gain",)

    def __init__(self) -> None:
        end = float(np.log(LARGEST_GAIN))
        factor = Parameter("factor", "1", -end, end, "log")
        super().__init__("gain", "the sensor magnifies its signal", factor)

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the magnified signal."""
        return signal * float(np.exp(values[0]))


class ElectricCoupling(SensorEffect):
    """An amplifier without direct current, of first order, as charge amplifiers of piezoelectric
    sensors are.
    """

    rank, keys = 7, ("corner_Hz",)

    def __init__(self, speed: float) -> None:
        low = speed / TURN * CORNER_RATIO[0]
        end = float(np.log(CORNER_RATIO[1] / CORNER_RATIO[0]))
        corner = Parameter("corner", "Hz", 0.0, end, "log", low)
        super().__init__("coupling", "the amplifier passes no direct current", corner)

    def apply(self, signal: Array, curves: Curves, values: Sequence[float]) -> Array:
        """Return the signal behind the amplifier."""
        corner = self.parameters[0].reference * np.exp(values[0])
        s = _list_rates(curves)
        return _filter(signal, s / (s + TURN * corner))


class ZeroDrift(SensorEffect):
    """A zero that drifts over the record, by a polynomial over each of several records in `spans`
    [rad], two ends each.

    `largest` is the largest part of it, in the display `unit` of the quantity. Drift does not
    repeat with the cycle, so that it is no operator on the curve of one: `columns` has what the
    parameters multiply.
    """

    rank = 8

    def __init__(
        self, degree: int, spans: Sequence[tuple[float, float]], largest: float, unit: str
    ) -> None:
        self.degree, self.spans = degree, spans
        parameters = []
        for record, (first, last) in enumerate(spans, 1):
            number = f"{record}" if len(spans) > 1 else ""
            half = abs(last - first) / 2 / TURN  # revolutions
            if record > 1:
                parameters.append(Parameter(f"zero{number}", unit, -largest, largest))
            rate = largest / (half or 1.0)
            parameters.append(Parameter(f"slope{number}", f"{unit}/r", -rate, rate))
            parameters += [
                Parameter(f"bend{number}_{power}", unit, -largest, largest)
                for power in range(2, degree + 1)
            ]
        word = DRIFTS[degree]
        super().__init__(
            f"{word} drift of zero",
            f"the zero of the sensor drifts, by a {word} polynomial over each record",
            *parameters,
        )

    def columns(self, phi: Array, records: Integers) -> Array:
        """Return what the parameters multiply (m, p) at angles (m,) [rad] of records (m,), counted
        from 0.

        The slope is per revolution from the middle of a record; bends multiply Legendre's
        polynomials over it.
        """
        columns = []
        for record, (first, last) in enumerate(self.spans):
            from_middle = phi - (first + last) / 2
            share = np.clip(2 * from_middle / ((last - first) or 1.0), -1.0, 1.0)
            rows = legendre.legvander(share, self.degree)
            rows[:, 1] = from_middle / TURN
            columns.append(
                np.where((records == record)[:, None], rows[:, 0 if record else 1 :], 0.0)
            )
        return np.column_stack(columns)


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
