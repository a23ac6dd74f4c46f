"""A mechanism of one's own as it is drawn: every body by the points where forces act on it, and its centroids."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from planter.files import units
from planter.kernels import Array
from planter.mechanism.report.figures import Course
from planter.numerics.arrays import Integers
from planter.view.scene import Body, Chain, Curve, Outline, Point, Scene

GROUND = "ground"
MOST = 400
"""Moments that are shown."""
MOST_CURVES = 16
MARK = np.array([[0.0, 0.0], [-0.6, -1.0], [0.6, -1.0]])
"""Of a point of the ground."""
MARKS = 30
"""So many go into the drawing side by side."""
OBLIQUE = 0.35
"""How far a length towards the viewer is drawn to the left and down: the cabinet view of a mechanism in space."""


def scene(
    title: str, course: Course, seconds: float, columns: Mapping[str, Array], places: Mapping[str, Array]
) -> Scene:
    """A course with columns (n,) in shown units by key; `places` (n,) [m] are those of the generated functions."""
    chosen = shown(len(course.values))
    points: list[Point] = []
    numbers: dict[tuple[str, bytes], int] = {}
    chains: list[Chain] = []
    bodies = _bodies(places)
    extent = 1e3 * float(max(np.ptp([at for of in bodies.values() for at in of.values()], axis=(0, 2))))
    for shade, (body, corners) in enumerate(bodies.items()):
        found = [_number(points, numbers, name, 1e3 * at[:, chosen]) for name, at in corners.items()]
        if body != GROUND and len(found) > 1:
            chains.append(Chain(body.replace("_", " "), found, len(found) > 2, shade % 6))
    name, _, unit = course.label.partition(" / ")
    return Scene(
        title=title,
        place=name,
        unit=unit,
        places=course.values[chosen],
        seconds=seconds,
        bodies=_ground(bodies.get(GROUND, {}), extent / MARKS),
        points=points,
        again=course.repeats,
        chains=chains,
        curves=[Curve(key, units.unit(key), column[chosen])
                for key, column in list(columns.items())[:MOST_CURVES]],
    )  # fmt: skip


def shown(count: int) -> Integers:
    """Which of so many moments are shown."""
    return np.unique(np.linspace(0, count - 1, min(MOST, count)).astype(np.int64))


def _bodies(places: Mapping[str, Array]) -> dict[str, dict[str, Array]]:
    """Points (2, n) [m] of the drawing, by body and by name."""
    by_name: dict[str, dict[str, dict[str, Array]]] = {}
    for name, values in places.items():
        axis, _, rest = name.partition("_")
        body, _, point = rest.partition("__")
        by_name.setdefault(body, {}).setdefault(point, {})[axis] = values
    return {body: {name: _seen(at) for name, at in points.items()} for body, points in by_name.items()}


def _seen(at: Mapping[str, Array]) -> Array:
    towards = at.get("z", np.zeros_like(at["x"]))
    return np.array([at["x"] - OBLIQUE * towards, at["y"] - OBLIQUE * towards])


def _number(points: list[Point], numbers: dict[tuple[str, bytes], int], name: str, at: Array) -> int:
    """The number of a point: bodies that meet share theirs."""
    key = name, at.tobytes()
    if key not in numbers:
        numbers[key] = len(points)
        points.append(Point(name, at[0], at[1]))
    return numbers[key]


def _ground(points: Mapping[str, Array], size: float) -> list[Body]:
    """A mark at each point of the ground that stands still."""
    still = {name: 1e3 * at[:, 0] for name, at in points.items() if not np.ptp(at, axis=1).any()}
    return [Body(f"ground at {name}", (Outline(at + size * MARK, "ground"),)) for name, at in still.items()]
