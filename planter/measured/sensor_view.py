"""What a machine file's [measurement] states, as effects of known size on a quantity of the
machine, and back.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from planter import paths
from planter.engine.machine import Machine, Quantity
from planter.errors import InputError
from planter.files import units
from planter.files.document import Document
from planter.files.fields import find_section as find_table
from planter.files.fields import value_error
from planter.files.spelling import find_spelled, list_spellings
from planter.measured.effects import (
    RATE,
    SQUARE,
    ElasticMount,
    ElectricCoupling,
    Gain,
    Imbalance,
    LeakedForce,
    LeakedTorque,
    Parameter,
    SensorEffect,
    SpeedHarmonics,
    TurnedAxis,
)
from planter.measured.section import SECTION, MeasurementSection, name_carried_force

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
