"""What stands between a rigid machine and its sensor: operators on curves over a cycle, those that
[measurement] of a machine file states, and the forces of the ground on bodies that a sensor carries.

A curve has columns (S, c) at equal angles: its values, then their derivatives in the inputs of the
machine. Every operator is linear in the curves of the machine, so that it moves all columns alike.
By d'Alembert the force of the ground on a body is the rate of its momentum less its weight and the
forces of all other bodies on it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, ClassVar, Literal

import casadi as ca
import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from planter import paths
from planter.engine.machine import Machine, Quantity
from planter.errors import InputError
from planter.files import units
from planter.files.document import Document
from planter.files.fields import find_section as find_table
from planter.files.fields import value_error
from planter.files.spelling import find_spelled, list_spellings
from planter.kernels import Array, Integers
from planter.measured.section import AXES, SECTION, MeasurementSection, name_carried_force
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


FORCE, TORQUE = "N", "N m"


@dataclass(frozen=True)
class StatedEffect:
    """An effect between machine and sensor with the values of its parameters, as they are searched.

    `paths` are their places in the machine file; none for values that it does not hold.
    """

    effect: SensorEffect
    values: tuple[float, ...]
    paths: tuple[str, ...] = ()

    @classmethod
    def from_display(
        cls, effect: SensorEffect, values: Sequence[float], keys: Sequence[str] = ()
    ) -> StatedEffect:
        """Return an effect with values of its parameters in their display units, at keys of
        [measurement].
        """
        searched = (
            p.from_display(value) for p, value in zip(effect.parameters, values, strict=True)
        )
        return cls(effect, tuple(searched), tuple(f"{SECTION}.{key}" for key in keys))

    @property
    def parameters(self) -> dict[str, tuple[Parameter, float]]:
        """The parameters by their paths in the machine file, with their values in display units."""
        values = (value or 0.0 for value in self.display_values)
        return dict(zip(self.paths, zip(self.effect.parameters, values, strict=True), strict=False))

    @property
    def display_values(self) -> tuple[float | None, ...]:
        """The values in the display units of the parameters, None for an infinite one."""
        return tuple(
            p.to_display(value)
            for p, value in zip(self.effect.parameters, self.values, strict=True)
        )

    def __str__(self) -> str:
        named = zip(self.effect.parameters, self.display_values, strict=True)
        values = (f"{p.name} {value or 0:.6g} {p.unit}".removesuffix(" 1") for p, value in named)
        return f"{self.effect.meaning}: {', '.join(values)}"


@dataclass(frozen=True)
class SensorView:
    """A quantity of a machine and the effects behind which a sensor sees it, in the order in which
    they act.
    """

    quantity: Quantity
    effects: tuple[StatedEffect, ...]

    @property
    def needed(self) -> tuple[str, ...]:
        """Keys of all quantities of the machine that reach the sensor."""
        further = (
            name
            for stated in self.effects
            for name in stated.effect.needed
            if name not in (SQUARE, RATE)
        )
        return (self.quantity.key, *further)

    @property
    def parameters(self) -> dict[str, tuple[Parameter, float]]:
        """The parameters of the effects by their paths in the machine file, with their values in
        display units.
        """
        return {path: entry for stated in self.effects for path, entry in stated.parameters.items()}


def find_section(document: Document) -> MeasurementSection | None:
    """Return the [measurement] of a machine file, or None if it has none."""
    section: MeasurementSection | None = getattr(document, SECTION, None)
    return section


def list_measured(
    document: Document, quantity: str | Sequence[str] | None, default: Sequence[str] = ()
) -> tuple[str, ...]:
    """Return the names of measured quantities: those given, else that of the file's [measurement],
    else `default`.
    """
    if quantity:
        return (quantity,) if isinstance(quantity, str) else tuple(quantity)
    section = find_section(document)
    return tuple(default) if section is None else (section.measured,)


def find_sensor_view(machine: Machine) -> SensorView | None:
    """Return the view of the sensor that the file of a machine states, or None if it states none.

    Raises InputError for a quantity that the machine lacks, or that the sensor cannot see in this
    way.
    """
    section = find_section(machine.document)
    if section is None:
        return None
    speed = abs(float(machine.data[machine.speed]))
    return build_sensor_view(
        section, machine.results, machine.source, speed, machine.acceleration is not None
    )


def is_sensor_input(name: str) -> bool:
    """Return whether a path is that of a number of [measurement]."""
    return name.startswith(f"{SECTION}.")


def list_sensor_inputs(machine: Machine) -> tuple[str, ...]:
    """Return the paths of the numbers of [measurement] that can be fitted."""
    view = find_sensor_view(machine)
    return () if view is None else tuple(view.parameters)


def describe_sensor_inputs(view: SensorView | None) -> dict[str, str]:
    """Return the meanings of the numbers of [measurement] that a user can change, by path."""
    return {
        path: f"{stated.effect.meaning}: {parameter.name}"
        for stated in (view.effects if view else ())
        for path, (parameter, _) in stated.parameters.items()
    }


def check_sensor_bounds(machine: Machine, path: str, bounds: tuple[float, float]) -> None:
    """Raise InputError if the file of a machine cannot hold a number of [measurement] anywhere
    between bounds.
    """
    for end in bounds:
        machine.document.with_numbers({path: end})
    view = find_sensor_view(machine)
    if (
        view is not None
        and view.parameters[path][0].scale == "reciprocal"
        and bounds[0] < 0 < bounds[1]
    ):
        raise InputError(
            f"--fit {path}={bounds[0]:g}:{bounds[1]:g}: it must not be 0, so both bounds need one "
            f"sign"
        )


def build_sensor_view(
    section: MeasurementSection,
    quantities: Sequence[Quantity],
    source: str,
    speed: float = 1.0,
    is_accelerated: bool = False,
) -> SensorView:
    """Return the view that a [measurement] states, of a machine with quantities, at a speed of the
    drive [rad/s].

    `is_accelerated` says whether the acceleration of the drive is a value. Raises InputError, which
    names file, key and value, as `find_sensor_view`.
    """

    def refuse(key: str, value: object, rule: str) -> InputError:
        return value_error(f"{SECTION}.{key}", value, rule, source)

    def find_quantity(
        key: str, name: str, allowed: Callable[[Quantity], bool], rule: str
    ) -> Quantity:
        keys = [quantity.key for quantity in quantities if allowed(quantity)]
        matches = find_spelled(
            name, {q.key: list_spellings(q.name, q.key, q.meaning) for q in quantities}
        )
        match = next((quantity for quantity in quantities if [quantity.key] == matches), None)
        if match is None:
            raise refuse(
                key,
                name,
                paths.suggest_names(name, [*keys, *_list_names(quantities, keys)], _join(keys)),
            )
        if match.key not in keys:
            raise refuse(key, name, f"{rule}: {_join(keys)}")
        return match

    target = find_quantity("quantity", section.measured, lambda _: True, "")
    unit = units.display_unit(target.key)
    if unit != FORCE:
        for key in ("lever_mm", "imbalance_kg_m"):
            if (value := getattr(section, key)) is not None:
                listed = list(value) if isinstance(value, tuple) else value
                raise refuse(
                    key,
                    listed,
                    f"quantity must be a force in N, but {target.key} is in {unit or '1'}",
                )
    if section.speed_harmonics is not None and not (
        is_accelerated or (target.total and unit == FORCE)
    ):
        reason = (
            f"{target.key} must be a total force, or the statement must have acceleration=, "
            f"since a swing has one"
        )
        raise refuse("speed_harmonics", list(section.speed_harmonics), reason)

    def is_other(quantity: Quantity) -> bool:
        return quantity.key != target.key and units.display_unit(quantity.key) == unit

    effects: list[StatedEffect] = []
    if section.axis_deg is not None:
        effects += _read_effects(section, TurnedAxis(name_carried_force(section.carried_axes[1])))
    for index, (name, share) in enumerate(
        zip(section.enclosed or (), section.shares_of_enclosed, strict=True)
    ):
        rule = f"it must be a quantity in {unit or '1'} other than {target.key}"
        leaked = find_quantity("enclosed", name, is_other, rule)
        if any(leaked.key in stated.effect.needed for stated in effects):
            raise refuse(
                "enclosed", name, f"{leaked.key} must be in it once, with the sum of its shares"
            )
        keys = [f"shares[{index}]"] if section.shares else []
        effects.append(StatedEffect.from_display(LeakedForce(leaked.key), [share], keys))
    if section.drive is not None and section.lever_mm is not None:
        torque = find_quantity("drive", section.drive, _is_torque, "it must be a torque in N m")
        effects += _read_effects(section, LeakedTorque(torque.key))
    scale = speed or 1.0  # of the bounds of a search, which a known value does not need
    largest = max(map(abs, section.imbalance_kg_m or (0.0,)))
    plain = (Imbalance(largest), SpeedHarmonics(), ElasticMount(scale), Gain())
    effects += _read_effects(section, *plain, ElectricCoupling(scale))
    return SensorView(target, tuple(sorted(effects, key=lambda stated: stated.effect.rank)))


def _read_effects(section: MeasurementSection, *effects: SensorEffect) -> Iterator[StatedEffect]:
    """Yield the effects whose parameters a [measurement] states under their keys."""
    for effect in effects:
        values = [getattr(section, key) for key in effect.keys]
        if None in values:
            continue
        keys: Sequence[str] = effect.keys
        if isinstance(values[0], tuple):
            (values,) = values
            keys = [f"{effect.keys[0]}[{index}]" for index in range(len(values))]
        yield StatedEffect.from_display(effect, values, keys)


def _is_torque(quantity: Quantity) -> bool:
    return units.display_unit(quantity.key) == TORQUE


def _list_names(quantities: Sequence[Quantity], keys: Sequence[str]) -> list[str]:
    return [quantity.name for quantity in quantities if quantity.key in keys]


def _join(keys: Sequence[str]) -> str:
    return f"it must be one of {', '.join(keys)}" if keys else "the machine has none"


def with_view(document: Document, view: SensorView) -> Document:
    """Return a copy of a machine file that states a view; a file of a kind without [measurement]
    stays the same.
    """
    field = type(document).model_fields.get(SECTION)
    kind = None if field is None else find_table(field.annotation)
    if kind is None:
        return document
    section = find_section(document)
    subject = {"quantity": view.quantity.key}
    if section is not None and section.bodies and view.quantity.key == section.measured:
        subject = section.model_dump(include={"bodies", "axis"}, exclude_none=True)
    return document.model_copy(
        update={SECTION: kind.model_validate({**subject, **write_effects(view)})}
    )


def write_effects(view: SensorView) -> dict[str, Any]:
    """Return the entries of [measurement] that state the effects of a view; one that does nothing
    is left out.
    """
    table: dict[str, Any] = {}
    for stated in view.effects:
        effect, values = stated.effect, stated.display_values
        if isinstance(effect, LeakedForce):
            table.setdefault("enclosed", []).append(effect.key)
            table.setdefault("shares", []).append(float(stated.values[0]))
        elif None not in values:
            if isinstance(effect, LeakedTorque):
                table["drive"] = effect.key
            is_list = len(values) > len(effect.keys)
            table |= zip(effect.keys, [list(values)] if is_list else values, strict=False)
    return table


Supports = Mapping[str, Mapping[str, str]]
"""Names of the forces of the ground on bodies, by body and axis of the world."""


def list_carried_forces(
    section: MeasurementSection, supports: Supports, quantities: Sequence[Quantity], source: str
) -> dict[Quantity, tuple[str, ...]]:
    """Return the forces on the bodies that a [measurement] names, each with the quantities that add
    up to it.

    There is none for a section without bodies. Raises InputError, which names file, key and value,
    for a body that the ground does not touch, for an axis along which it exerts no force, and for a
    quantity that already has the name.
    """
    totals = {quantity.name: quantity.total for quantity in quantities}

    def refuse(key: str, rule: str) -> InputError:
        return value_error(f"{SECTION}.{key}", getattr(section, key), rule, source)

    for body in section.bodies or ():
        if body not in supports:
            hint = paths.suggest_names(
                body, list(supports), f"the ground touches {', '.join(supports) or 'none'}"
            )
            raise refuse("bodies", f"the ground exerts no force on {body} that is a result: {hint}")
    forces = {}
    for axis in section.carried_axes:
        parts = tuple(
            supports[body][axis] for body in section.bodies or () if axis in supports[body]
        )
        if not parts:
            allowed = [
                other
                for other in AXES
                if any(other in supports[body] for body in section.bodies or ())
            ]
            raise refuse(
                section.axis_key,
                f"the bodies have forces of the ground along {', '.join(allowed)} alone",
            )
        key = name_carried_force(axis)
        name = key.removesuffix("_N")
        if name in totals:
            raise refuse("bodies", f"a quantity is called {name} already; rename it")
        meaning = f"force of the ground on {', '.join(section.bodies or ())}, {axis}"
        forces[
            Quantity(name, "N", meaning, key, totals[parts[0]], source="derived: sum of actions")
        ] = parts
    return forces


def add_carried_forces(
    machine: Machine, section: MeasurementSection | None, supports: Supports
) -> Machine:
    """Return a machine with the forces on the bodies that its [measurement] names.

    Raises as `list_carried_forces`.
    """
    if section is None:
        return machine
    forces = list_carried_forces(section, supports, machine.quantities, machine.source)
    if not forces:
        return machine
    are_totals = next(iter(forces)).total
    summed = [quantity for quantity in machine.quantities if quantity.total == are_totals]
    quantities = (*machine.quantities, *forces)
    if are_totals and machine.totals is not None:
        return replace(
            machine,
            totals=_append_sums(machine.totals, summed, forces.values()),
            quantities=quantities,
        )
    return replace(
        machine, lane=_append_sums(machine.lane, summed, forces.values()), quantities=quantities
    )


def _append_sums(
    function: ca.Function, quantities: Sequence[Quantity], sums: Iterable[Sequence[str]]
) -> ca.Function:
    """Return a function that gives quantities (m,) with further outputs, each the sum of some of
    them by name.
    """
    names, inputs = [quantity.name for quantity in quantities], function.sx_in()
    (output,) = function.call(inputs)
    totals = [ca.sum1(output[[names.index(part) for part in parts]]) for parts in sums]
    return ca.Function(
        function.name(),
        inputs,
        [ca.densify(ca.vertcat(output, *totals))],
        function.name_in(),
        function.name_out(),
    )
