"""Gears at centre distances that are not those of their pitch curves.

A pair whose centres stand apart by a deviation rolls on pitch curves of the same shape, larger by what the distance is:
as with circular involute gears the ratio stays, the arms and the working curves grow. All lengths of a stage's
parameters take the same factor, 1 + deviation / distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from planter.engine.machine import Machine, Value
from planter.planting.cycle import distance_places
from planter.planting.model import Device

DEVIATIONS = ("deviation.a1_mm", "deviation.a2_mm")
"""Deviations of the centre distances of stage 1 and 2, as inputs."""
LENGTH = "m"


def add_deviations(machine: Machine, device: Device) -> Machine:
    """Return the machine of a device with the deviations of its centre distances as values more, which are zero."""
    assert machine.totals is not None
    assert machine.events is not None
    totals, size = machine.totals, len(machine.values)
    meaning = "centre distance of stage {} less that of its pitch curves"
    values = [
        Value(f"deviation_a{number}", LENGTH, meaning.format(number), path) for number, path in enumerate(DEVIATIONS, 1)
    ]
    phi, _, h, q = machine.symbols
    d = ca.SX.sym("d", size + len(values))
    distances = [h[place] - d[size + k] for k, place in enumerate(distance_places(device))]
    mounted = _mount(device, d, distances)
    one, two, _ = (ca.SX.sym(name, totals.size1_in(i)) for i, name in enumerate(("one", "two", "d")))

    def compose(name: str, function: ca.Function) -> ca.Function:
        return ca.Function(name, [phi, d, h, q], [function(phi, mounted, h, q)], ["phi", "d", "h", "q"], ["y"])

    design = _mounted_function(device, size)
    both = ca.MX.sym("d", d.numel())
    return replace(
        machine,
        values=(*machine.values, *values),
        data=np.append(machine.data, np.zeros(len(values))),
        prologue=ca.Function("prologue", [both], [machine.prologue(design(both))], ["d"], ["h"]),
        lane=compose("lane", machine.lane),
        totals=ca.Function("totals", [one, two, d], [totals(one, two, d[:size])]),
        events=compose("events", machine.events),
        tangent=lambda moved: _differentiate(machine, design, moved),
    )


def _mount(device: Device, d: Any, distances: Sequence[Any]) -> Any:
    """Return the values (v,) that work like those of d (v + 2,), whose last two are deviations [m]."""
    parts, begin, size = [], device.size - sum(len(stage.names) for stage in device.stages), len(device.data)
    parts.append(d[:begin])
    for number, (stage, distance) in enumerate(zip(device.stages, distances, strict=True)):
        factor = 1 + d[size + number] / distance
        for index, entry in enumerate(stage.sidecar["parameters"]):
            parts.append(d[begin + index] * factor if entry["unit"] == LENGTH else d[begin + index])
        begin += len(stage.names)
    return ca.vertcat(*parts, d[begin:size])


def _mounted_function(device: Device, size: int) -> ca.Function:
    """Return d (v + 2,) -> the values (v,) that work like it, from the centre distances of its own pitch curves."""
    d = ca.SX.sym("d", size + len(DEVIATIONS))
    ends = device.size - np.cumsum([len(stage.names) for stage in reversed(device.stages)])[::-1]
    distances = [
        stage.prologue.function(d[begin : begin + len(stage.names)])[0]
        for begin, stage in zip(ends.tolist(), device.stages, strict=True)
    ]
    return ca.Function("mounted", [d], [ca.densify(_mount(device, d, distances))])


def _differentiate(machine: Machine, design: ca.Function, moved: tuple[int, ...]) -> ca.Function:
    """Return (d) -> h, dh of the mounted machine, by the chain rule from the tangent of the machine."""
    assert machine.tangent is not None
    tangent = machine.tangent(tuple(range(len(machine.values))))
    d = design.sx_in(0)
    slopes = ca.Function("mounted_slopes", [d], [ca.jacobian(design(d), d)[:, list(moved)]])
    both = ca.MX.sym("d", d.numel())
    h, along = tangent(design(both))
    return ca.Function("tangent", [both], [h, along @ slopes(both)], ["d"], ["h", "dh"])
