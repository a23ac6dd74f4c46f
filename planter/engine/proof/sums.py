"""Sums of measures of a machine's results, as a proof bounds them over boxes of designs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, cast

from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure
from planter.engine.proof.enclosures import EnclosedResponse
from planter.engine.proof.objective import (
    BoundedLimit,
    BoundedMeasure,
    FindKinks,
    MeasureKind,
    ProvableObjective,
)
from planter.errors import InputError


@dataclass(frozen=True)
class ProvedQuantity:
    """A result by name, or its size; times the length of a cycle, whose mean is a work, if it
    `is_work`.
    """

    name: str
    size: bool = False
    is_work: bool = False

    @classmethod
    def from_measure(cls, measure: Measure) -> ProvedQuantity:
        """Return the quantity that a measure is of."""
        return cls(measure.name, measure.size, measure.kind == "work")

    def describe(self, machine: Machine) -> str:
        """Return its name and unit, for people."""
        quantity = machine.find_quantity(self.name)
        name = f"|{self.name}|" if self.size else self.name
        return f"work of {name}" if self.is_work else f"{name} [{quantity.unit}]"

    def convert(self, machine: Machine, xp: Any, value: Any, x: Sequence[Any]) -> Any:
        """Return the quantity in display units from the value of the result, in code of designs x
        (p,).
        """
        quantity = machine.find_quantity(self.name)
        value = xp.absolute(value) if self.size else xp.lift(value)
        value = value if quantity.factor == 1 else value / quantity.factor
        if not self.is_work:
            return value
        turn = 2 * xp.pi
        if quantity.unit == "N m":
            return value * turn
        if machine.speed in machine.moved:
            return value * turn / xp.absolute(x[machine.moved.index(machine.speed)])
        return value * turn / abs(float(machine.data[machine.speed]))


EncloseQuantities = Callable[[Sequence[ProvedQuantity]], EnclosedResponse]
"""Gives the enclosure of quantities of a machine."""


def build_provable_objective(
    machine: Machine,
    terms: Sequence[Measure],
    count: int | None,
    enclose: EncloseQuantities,
    limits: Sequence[Limit] = (),
    find_kinks: FindKinks | None = None,
) -> ProvableObjective:
    """Return a sum of measures over `count` samples, or the true one, as a proof bounds it.

    Of the limits, those at angles that the design moves are left out.
    """
    fixed = [limit for limit in limits if is_fixed(machine, limit.measure)]
    measures = [*terms, *(limit.measure for limit in fixed)]
    quantities = list(dict.fromkeys(map(ProvedQuantity.from_measure, measures)))

    def bound(measure: Measure, sign: int = 1) -> BoundedMeasure:
        kinds = {"work": "mean", "all": "max" if sign > 0 else "min"}
        kind = cast(MeasureKind, kinds.get(measure.kind, measure.kind))
        index = quantities.index(ProvedQuantity.from_measure(measure))
        return BoundedMeasure(kind, index, measure.size, measure.weight, measure.angle)

    return ProvableObjective(
        enclose(quantities),
        [bound(term) for term in terms],
        [
            BoundedLimit(bound(limit.measure, limit.sign), limit.sign, limit.number)
            for limit in fixed
        ],
        count,
        find_kinks,
        heeds_all=len(fixed) == len(limits),
        labels=[quantity.describe(machine) for quantity in quantities],
    )


def is_fixed(machine: Machine, measure: Measure) -> bool:
    """Return whether a measure is of a result at angles that do not move with the design."""
    return not measure.is_moving and machine.find_quantity(measure.name).role == "result"


def check_provable(machine: Machine, terms: Sequence[Measure], label: str) -> None:
    """Raise InputError, which begins with `label`, for a sum of which no proof is known."""
    for measure in terms:
        if measure.is_moving:
            word = "jump" if measure.kind == "jump" else "while" if measure.during else "where"
            raise InputError(
                f"{label}: {measure}: a proof takes angles that are fixed, so leave out `{word}`"
            )
        quantity = machine.find_quantity(measure.name)
        if quantity.role != "result":
            raise InputError(
                f"{label}: {measure}: a proof bounds results, and {quantity.name} is a "
                f"{quantity.role}"
            )
    if not machine.moved:
        raise InputError(
            f"{label}: {machine.source}: it has no [bounds], so there is no box to prove anything "
            f"of"
        )
