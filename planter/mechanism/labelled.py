"""Drawing of a user-defined mechanism with its symbols: visible values and angles, found by
comparing numbers.

A length of the file is drawn between two points of a body, or a point and an axis of the world,
whose distance equals it over the whole cycle and follows when the length is changed; an angle at a
body that has its direction.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from planter.errors import InputError
from planter.kernels import Array
from planter.mechanism import machines
from planter.mechanism.file import load
from planter.mechanism.model import Model
from planter.mechanism.show import MechanismView
from planter.numerics.arrays import wrap_angle
from planter.report.free_body import BodyLoad, FreeBodies, FreeBody
from planter.report.sheet import Angle, Length, Mark, Sheet, Spot

LOADS = "loads"
"""Generated function of the loads on all bodies."""
DRAWN_DEG = 50.0
"""Angle of the drive at which a mechanism is drawn, where most of them are open."""
COMPARED = np.radians(np.arange(7.0, 360.0, 48.5))
"""Angles at which distances and directions are compared, besides the one that is drawn."""
SHARE_TOLERANCE = 1e-9
"""Share of the mechanism's size within which two lengths are equal."""
CHANGE = 1e-3
"""Share by which a length is changed, to exclude distances that equal it by chance."""
RADIUS = 0.12
"""Radius of an angle's arc, in parts of the drawing."""

Bodies = dict[str, dict[str, Array]]
"""Points (2, n) [m] by body and name, at the angle that is drawn and at those that are compared."""


def draw(source: str, changes: Mapping[str, float]) -> list[Sheet]:
    """Return the drawing of a file's mechanism, nothing for one that moves freely or has no points
    in a plane.

    Raises InputError as the file does, ComputationError if the mechanism cannot be moved.
    """
    file = load(source, changes)
    if not file.is_driven:
        return []
    model, view = Model(machines.build_machine(file)), MechanismView(file)
    scene = view.scenes({control.path: control.value for control in view.controls}, "exact")[0]
    moment = int(np.argmin(np.abs(scene.places - DRAWN_DEG)))
    angles = np.append(np.radians(scene.places[moment]), COMPARED)
    if not (bodies := find_points(model.places(angles))):
        return []
    marks = find_marks(model, angles, bodies)
    title = f"{file.name} at {scene.places[moment]:g} deg"
    return [Sheet("mechanism", title, scene, marks, moment)]


def cut_bodies(source: str, changes: Mapping[str, float], angle_deg: float) -> FreeBodies:
    """Return the bodies of a file's mechanism, cut free at an angle of its drive.

    Raises InputError for a mechanism that no angle drives, or whose functions have no loads,
    ComputationError if it cannot be moved.
    """
    file = load(source, changes)
    if not file.is_driven:
        raise InputError(
            f"{source}: no angle drives {file.name}: bodies are cut free at an angle of a drive"
        )
    if LOADS not in file.model.sidecar["functions"]:
        raise InputError(
            f"{source}: the functions of {file.name} have no loads on its bodies: derive them "
            f"again, with all results, by `planter derive`"
        )
    machine = machines.build_machine(file)
    rows = Model(machine)(np.radians([angle_deg]))
    data = {value.name: float(x) for value, x in zip(machine.values, machine.data, strict=True)}
    values = {name: float(row[0]) for name, row in rows.items()} | data
    components = file.model.pick(LOADS, values | {machine.angle: float(np.radians(angle_deg))})
    return FreeBodies(file.name, angle_deg, group_loads(file.model.sidecar["loads"], components))


def group_loads(
    entries: Sequence[Mapping[str, Any]], components: Mapping[str, float]
) -> list[FreeBody]:
    """Return bodies with their loads: entries of the sidecar, numbered from 1, and their
    components by name.
    """
    bodies: dict[str, list[BodyLoad]] = {}
    for number, entry in enumerate(entries, 1):
        place, force, moment = (
            np.array([components.get(f"load_{number}_{part}{axis}", 0.0) for axis in "xyz"])
            for part in ("", "F", "M")
        )
        load = BodyLoad(entry["name"], entry["by"], entry["point"], place, force, moment)
        bodies.setdefault(entry["body"], []).append(load)
    return [FreeBody(name, loads) for name, loads in bodies.items()]


def find_points(places: Mapping[str, Array]) -> Bodies:
    """Return the points of the bodies of a plane mechanism from the coordinates (n,) that its
    functions give.
    """
    bodies: Bodies = {}
    for name, x in places.items():
        axis, _, rest = name.partition("_")
        if axis == "x" and f"z_{rest}" not in places:
            body, _, point = rest.partition("__")
            bodies.setdefault(body, {})[point] = np.array([x, places[f"y_{rest}"]])
    return bodies


def find_marks(model: Model, angles: Array, bodies: Bodies) -> list[Mark]:
    """Return lengths, angles and points, each name once."""
    points = np.hstack([at for body in bodies.values() for at in body.values()])
    size = float(np.ptp(points, axis=1).max())
    lines: list[Mark] = [
        *_lengths(model, angles, bodies, size),
        *_angles(model, angles, bodies, size),
    ]
    marks: dict[str, Mark] = {}
    for mark in [*lines, *_spots(bodies)]:
        marks.setdefault(mark.names[0], mark)
    return list(marks.values())


def _lengths(model: Model, angles: Array, bodies: Bodies, size: float) -> Iterator[Length]:
    """Yield, for each length of the file, the first distance that has it and follows it."""
    spans = dict(_spans(bodies))
    for index, value in enumerate(model.machine.values):
        number = float(model.machine.data[index])
        if value.unit != "m" or not number:
            continue
        alike = [key for key, ends in spans.items() if _is_long(ends, number, size)]
        changed = model.machine.data.copy()
        changed[index] *= 1 + CHANGE
        moved = (
            dict(_spans(find_points(Model(model.machine, changed).places(angles)))) if alike else {}
        )
        for key in alike:
            if _is_long(moved[key], changed[index], size):
                start, end = spans[key]
                yield Length([value.name], 1e3 * start[:, 0], 1e3 * end[:, 0])
                break


def _spans(bodies: Bodies) -> Iterator[tuple[tuple[str, ...], tuple[Array, Array]]]:
    """Yield pairs of points (2, n): of a body, then each with its feet on the axes of the world."""
    for body, points in bodies.items():
        for (first, start), (second, end) in combinations(points.items(), 2):
            yield (body, first, second), (start, end)
    for body, points in bodies.items():
        for name, at in points.items():
            for axis, foot in zip("xy", (at * [[0], [1]], at * [[1], [0]]), strict=True):
                yield (body, name, axis), (foot, at)


def _is_long(ends: tuple[Array, Array], length: float, size: float) -> bool:
    return bool(
        np.abs(np.hypot(*(ends[1] - ends[0])) - abs(length)).max() <= SHARE_TOLERANCE * size
    )


def _angles(model: Model, angles: Array, bodies: Bodies, size: float) -> Iterator[Angle]:
    """Yield the angles along which two points of a body stand, from x on."""
    results = model(angles)
    turned = {model.machine.angle: angles} | {
        q.name: results[q.name] for q in model.machine.results if q.unit == "rad"
    }
    for points in bodies.values():
        for start, end in combinations(points.values(), 2):
            if np.hypot(*(end - start)).min() <= SHARE_TOLERANCE * size:
                continue
            for first, second in ((start, end), (end, start)):
                way = np.arctan2(*(second - first)[::-1])
                names = [
                    name
                    for name, value in turned.items()
                    if np.abs(wrap_angle(value - way)).max() <= SHARE_TOLERANCE
                ]
                if names:
                    turn = float(np.degrees(way[0]))
                    yield Angle(names, 1e3 * first[:, 0], 0.0, turn, 1e3 * RADIUS * size)


def _spots(bodies: Bodies) -> Iterator[Spot]:
    """Yield all points; bodies that meet share theirs, labels of other points with one name state
    the body.
    """
    owners: dict[str, dict[bytes, str]] = {}
    for body, points in bodies.items():
        for name, at in points.items():
            owners.setdefault(name, {}).setdefault(np.round(at, 12).tobytes(), body)
    for name, places in owners.items():
        for body in places.values():
            label = name if len(places) == 1 else f"{body}: {name}"
            yield Spot([label], 1e3 * bodies[body][name][:, 0])
