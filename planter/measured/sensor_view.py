"""What a machine file's [measurement] states, as effects of known size on a quantity of the machine, and back."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from planter.engine.machine import Machine, Quantity
from planter.errors import InputError
from planter.files import paths, units
from planter.files.document import Document
from planter.files.fields import find_section as find_table
from planter.files.fields import value_error
from planter.measured.effects import (
    ElasticMount,
    ElectricCoupling,
    Imbalance,
    LeakedForce,
    LeakedTorque,
    SensorEffect,
    SpeedHarmonics,
    rank_effect,
)
from planter.measured.section import SECTION, MeasurementSection

FORCE, TORQUE = "N", "N m"


@dataclass(frozen=True)
class StatedEffect:
    """An effect between machine and sensor with the values of its parameters, as they are searched."""

    effect: SensorEffect
    values: tuple[float, ...]

    @classmethod
    def from_display(cls, effect: SensorEffect, values: Sequence[float]) -> StatedEffect:
        """Return an effect with values of its parameters in their display units."""
        searched = (p.from_display(value) for p, value in zip(effect.parameters, values, strict=True))
        return cls(effect, tuple(searched))

    @property
    def display_values(self) -> tuple[float | None, ...]:
        """The values in the display units of the parameters, None for an infinite one."""
        return tuple(p.to_display(value) for p, value in zip(self.effect.parameters, self.values, strict=True))

    def __str__(self) -> str:
        named = zip(self.effect.parameters, self.display_values, strict=True)
        values = (f"{p.name} {value or 0:.6g} {p.unit}".removesuffix(" 1") for p, value in named)
        return f"{self.effect.meaning}: {', '.join(values)}"


@dataclass(frozen=True)
class SensorView:
    """A quantity of a machine and the effects behind which a sensor sees it, in the order in which they act."""

    quantity: Quantity
    effects: tuple[StatedEffect, ...]

    @property
    def needed(self) -> tuple[str, ...]:
        """Keys of all quantities of the machine that reach the sensor."""
        leaked = (e.effect.key for e in self.effects if isinstance(e.effect, LeakedForce | LeakedTorque))
        return (self.quantity.key, *leaked)


def find_section(document: Document) -> MeasurementSection | None:
    """Return the [measurement] of a machine file, or None if it has none."""
    section: MeasurementSection | None = getattr(document, SECTION, None)
    return section


def list_measured(
    document: Document, quantity: str | Sequence[str] | None, default: Sequence[str] = ()
) -> tuple[str, ...]:
    """Return the names of measured quantities: those given, else that of the file's [measurement], else `default`."""
    if quantity:
        return (quantity,) if isinstance(quantity, str) else tuple(quantity)
    section = find_section(document)
    return tuple(default) if section is None else (section.quantity,)


def find_sensor_view(machine: Machine) -> SensorView | None:
    """Return the view of the sensor that the file of a machine states, or None if it states none.

    Raises InputError for a quantity that the machine lacks, or that the sensor cannot see in this way.
    """
    section = find_section(machine.document)
    if section is None:
        return None
    speed = abs(float(machine.data[machine.speed]))
    return build_sensor_view(section, machine.results, machine.source, speed, machine.acceleration is not None)


def build_sensor_view(
    section: MeasurementSection,
    quantities: Sequence[Quantity],
    source: str,
    speed: float = 1.0,
    is_accelerated: bool = False,
) -> SensorView:
    """Return the view that a [measurement] states, of a machine with quantities, at a speed of the drive [rad/s].

    `is_accelerated` says whether the acceleration of the drive is a value. Raises InputError, which names
    file, key and value, as `find_sensor_view`.
    """

    def refuse(key: str, value: object, rule: str) -> InputError:
        return value_error(f"{SECTION}.{key}", value, rule, source)

    def find_quantity(key: str, name: str, allowed: Callable[[Quantity], bool], rule: str) -> Quantity:
        keys = [quantity.key for quantity in quantities if allowed(quantity)]
        match = next((quantity for quantity in quantities if name in (quantity.key, quantity.name)), None)
        if match is None:
            raise refuse(key, name, paths.suggest_names(name, [*keys, *_list_names(quantities, keys)], _join(keys)))
        if match.key not in keys:
            raise refuse(key, name, f"{rule}: {_join(keys)}")
        return match

    target = find_quantity("quantity", section.quantity, lambda _: True, "")
    unit = units.display_unit(target.key)
    if unit != FORCE:
        for key in ("lever_mm", "imbalance_kg_m"):
            if (value := getattr(section, key)) is not None:
                listed = list(value) if isinstance(value, tuple) else value
                raise refuse(key, listed, f"quantity must be a force in N, but {target.key} is in {unit or '1'}")
    if section.speed_harmonics is not None and not (is_accelerated or (target.total and unit == FORCE)):
        reason = f"{target.key} must be a total force, or the statement must have acceleration=, since a swing has one"
        raise refuse("speed_harmonics", list(section.speed_harmonics), reason)

    def is_other(quantity: Quantity) -> bool:
        return quantity.key != target.key and units.display_unit(quantity.key) == unit

    effects: list[StatedEffect] = []
    for name, share in zip(section.enclosed or (), section.shares_of_enclosed, strict=True):
        rule = f"it must be a quantity in {unit or '1'} other than {target.key}"
        leaked = find_quantity("enclosed", name, is_other, rule)
        if any(isinstance(e.effect, LeakedForce) and e.effect.key == leaked.key for e in effects):
            raise refuse("enclosed", name, f"{leaked.key} must be in it once, with the sum of its shares")
        effects.append(StatedEffect.from_display(LeakedForce(leaked.key), [share]))
    if section.drive is not None and section.lever_mm is not None:
        torque = find_quantity("drive", section.drive, _is_torque, "it must be a torque in N m")
        effects.append(StatedEffect.from_display(LeakedTorque(torque.key), [section.lever_mm]))
    effects += _list_own_effects(section, speed)
    return SensorView(target, tuple(sorted(effects, key=lambda stated: rank_effect(stated.effect))))


def _list_own_effects(section: MeasurementSection, speed: float) -> Iterator[StatedEffect]:
    """Yield the effects of a [measurement] that need no other quantity of the machine."""
    scale = speed or 1.0  # of the bounds of a search, which a known value does not need
    if section.imbalance_kg_m is not None:
        largest = max(map(abs, section.imbalance_kg_m))
        yield StatedEffect.from_display(Imbalance(largest), section.imbalance_kg_m)
    if section.speed_harmonics is not None:
        yield StatedEffect.from_display(SpeedHarmonics(), section.speed_harmonics)
    if section.mount_Hz is not None and section.mount_damping is not None:
        yield StatedEffect.from_display(ElasticMount(scale), [section.mount_Hz, section.mount_damping])
    if section.corner_Hz is not None:
        yield StatedEffect.from_display(ElectricCoupling(scale), [section.corner_Hz])


def _is_torque(quantity: Quantity) -> bool:
    return units.display_unit(quantity.key) == TORQUE


def _list_names(quantities: Sequence[Quantity], keys: Sequence[str]) -> list[str]:
    return [quantity.name for quantity in quantities if quantity.key in keys]


def _join(keys: Sequence[str]) -> str:
    return f"it must be one of {', '.join(keys)}" if keys else "the machine has none"


def with_view(document: Document, view: SensorView) -> Document:
    """Return a copy of a machine file that states a view; a file of a kind without [measurement] stays the same."""
    field = type(document).model_fields.get(SECTION)
    kind = None if field is None else find_table(field.annotation)
    if kind is None:
        return document
    return document.model_copy(update={SECTION: kind.model_validate(write_view(view))})


def write_view(view: SensorView) -> dict[str, Any]:
    """Return the table [measurement] that states a view; an effect that does nothing is left out."""
    table: dict[str, Any] = {"quantity": view.quantity.key}
    leaked = [stated for stated in view.effects if isinstance(stated.effect, LeakedForce)]
    if leaked:
        table["enclosed"] = [stated.effect.key for stated in leaked if isinstance(stated.effect, LeakedForce)]
        table["shares"] = [float(stated.values[0]) for stated in leaked]
    for stated in view.effects:
        table |= _write_effect(stated.effect, [value for value in stated.display_values if value is not None])
    return table


def _write_effect(effect: SensorEffect, values: Sequence[float]) -> Mapping[str, Any]:
    if isinstance(effect, LeakedTorque):
        return {"drive": effect.key, "lever_mm": values[0]} if values else {}
    if isinstance(effect, Imbalance):
        return {"imbalance_kg_m": list(values)}
    if isinstance(effect, SpeedHarmonics):
        return {"speed_harmonics": list(values)}
    if isinstance(effect, ElasticMount):
        return {"mount_Hz": values[0], "mount_damping": values[1]}
    return {"corner_Hz": values[0]} if isinstance(effect, ElectricCoupling) else {}
