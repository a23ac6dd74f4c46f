"""Planting devices as machines of the engine, with deviations of their centre distances.

A pair whose centres are displaced by a deviation rolls on similar pitch curves, scaled with the
centre distance: as with circular involute gears the ratio stays, the arms and the working curves
grow. All lengths of a stage's parameters take the same factor, 1 + deviation / distance.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.machine import Machine, Value
from planter.papers.planting import file
from planter.papers.planting.functions import Model
from planter.papers.planting.model import Device
from planter.papers.planting.requirements import RequirementConstraints

DEVIATIONS = ("deviation.a1_mm", "deviation.a2_mm")
"""Deviations of the centre distances of stage 1 and 2, as inputs."""
LENGTH = "m"


def add_deviations(machine: Machine, device: Device) -> Machine:
    """Return the machine of a device with the deviations of its centre distances as values more,
    which are zero.
    """
    assert machine.totals is not None
    assert machine.events is not None
    totals, size = machine.totals, len(machine.values)
    meaning = "centre distance of stage {} less that of its pitch curves"
    values = [
        Value(f"deviation_a{number}", LENGTH, meaning.format(number), path)
        for number, path in enumerate(DEVIATIONS, 1)
    ]
    phi, _, h, q = machine.symbols
    d = ca.SX.sym("d", size + len(values))
    distances = [h[place] - d[size + k] for k, place in enumerate(device.distance_places)]
    mounted = _mount_values(device, d, distances)
    first, second, _ = (
        ca.SX.sym(name, totals.size1_in(i)) for i, name in enumerate(("one", "two", "d"))
    )

    def compose(name: str, function: ca.Function) -> ca.Function:
        return ca.Function(
            name, [phi, d, h, q], [function(phi, mounted, h, q)], ["phi", "d", "h", "q"], ["y"]
        )

    design = _mounted_function(device, size)
    both = ca.MX.sym("d", d.numel())
    return replace(
        machine,
        values=(*machine.values, *values),
        data=np.append(machine.data, np.zeros(len(values))),
        prologue=ca.Function("prologue", [both], [machine.prologue(design(both))], ["d"], ["h"]),
        lane=compose("lane", machine.lane),
        totals=ca.Function("totals", [first, second, d], [totals(first, second, d[:size])]),
        events=compose("events", machine.events),
        tangent=lambda moved: _differentiate(machine, design, moved),
    )


def _mount_values(device: Device, d: Any, distances: Sequence[Any]) -> Any:
    """Return the values (v,) that work like those of d (v + 2,), whose last two are deviations
    [m].
    """
    parts, begin, size = (
        [],
        device.size - sum(len(stage.names) for stage in device.stages),
        len(device.data),
    )
    parts.append(d[:begin])
    for number, (stage, distance) in enumerate(zip(device.stages, distances, strict=True)):
        factor = 1 + d[size + number] / distance
        for index, entry in enumerate(stage.sidecar["parameters"]):
            parts.append(d[begin + index] * factor if entry["unit"] == LENGTH else d[begin + index])
        begin += len(stage.names)
    return ca.vertcat(*parts, d[begin:size])


def _mounted_function(device: Device, size: int) -> ca.Function:
    """Return d (v + 2,) -> equivalent values (v,), from the centre distances of its pitch
    curves.
    """
    d = ca.SX.sym("d", size + len(DEVIATIONS))
    ends = device.size - np.cumsum([len(stage.names) for stage in reversed(device.stages)])[::-1]
    distances = [
        stage.prologue.function(d[begin : begin + len(stage.names)])[0]
        for begin, stage in zip(ends.tolist(), device.stages, strict=True)
    ]
    return ca.Function("mounted", [d], [ca.densify(_mount_values(device, d, distances))])


def _differentiate(machine: Machine, design: ca.Function, moved: tuple[int, ...]) -> ca.Function:
    """Return (d) -> h, dh of the mounted machine, by the chain rule from the tangent of the
    machine.
    """
    assert machine.tangent is not None
    tangent = machine.tangent(tuple(range(len(machine.values))))
    d = design.sx_in(0)
    slopes = ca.Function("mounted_slopes", [d], [ca.jacobian(design(d), d)[:, list(moved)]])
    both = ca.MX.sym("d", d.numel())
    h, jacobian = tangent(design(both))
    return ca.Function("tangent", [both], [h, jacobian @ slopes(both)], ["d"], ["h", "dh"])


def load(source: str, changes: Mapping[str, float], model: Model = "exact") -> Machine:
    """Return the machine of a planting device; raises InputError and GeometryError as its file and
    device do.
    """
    return _build_with_requirements(model, file.load(source, changes))


def _build_with_requirements(model: Model, machine: file.PlantingMachine) -> Machine:
    device = Device(machine, model)
    built = device.engine
    if not machine.limits_motion:
        return built
    return replace(
        built,
        build=partial(_build_with_requirements, model),
        requirements=partial(RequirementConstraints, device),
    )
