"""Bodies that a sensor carries: the force of the ground on them along axes of the world, as
quantities of a machine.

By d'Alembert it is the rate of their momentum less their weights and the forces of all other bodies
on them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import casadi as ca

from planter import paths
from planter.engine.machine import Machine, Quantity
from planter.errors import InputError
from planter.files.fields import value_error
from planter.measured.section import AXES, SECTION, MeasurementSection, name_carried_force

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
