"""What is drawn of a mechanism besides its bodies: springs, struts, sliders in guides, cams with
their rollers, and pitch curves of gears.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import unit_vector
from planter.report.scene import Body, Chain, Outline, Point

COILS = 6
"""Coils of a spring."""
THICKNESS = 0.022
"""Half width of springs, struts, blocks and guides, relative to the extent of the drawing."""
HATCHES = 9
"""Strokes that mark a guide as fixed."""
STILL = 1e-9
"""Change of a direction below which a guide does not turn."""
ROUND = np.radians(np.linspace(0.0, 360.0, 121))
TURN = 2 * np.pi


@dataclass
class DrawnElements:
    """Parts of a scene: bodies with outlines, hidden points, and lines through these by their
    numbers.
    """

    bodies: list[Body] = field(default_factory=list)
    points: list[Point] = field(default_factory=list)
    chains: list[Chain] = field(default_factory=list)

    def add_line(self, name: str, places: Array, first: int) -> None:
        """Add a line through points (k, 2, n) [mm]; `first` is the number of points before."""
        start = first + len(self.points)
        self.points += [Point("", x, y, hidden=True) for x, y in places]
        self.chains.append(Chain(name, list(range(start, start + len(places))), False, 3))


def draw_elements(
    kinds: Mapping[str, str], shapes: Mapping[str, Array], extent: float, first: int
) -> DrawnElements:
    """Return springs, struts, guides and cams by their kinds, from the coordinates (n,) [m] of their
    ends by name; `extent` [mm] is that of the drawing, `first` the number of its points.
    """
    elements, half = DrawnElements(), THICKNESS * extent
    for name, kind in kinds.items():
        words = name.replace("_", " ")
        ends = [
            1e3 * np.array([shapes[f"{name}_x_{number}"], shapes[f"{name}_y_{number}"]])
            for number in (1, 2, 3)
            if f"{name}_y_{number}" in shapes
        ]
        if len(ends) < 2 or f"{name}_z_1" in shapes:
            continue
        start, end = ends[:2]
        if kind == "guide":
            elements.bodies += _draw_slider(words, start, end, half)
        elif kind == "cam":
            elements.bodies += _draw_cam(words, start, end, ends[2], half)
        elif kind == "spring":
            elements.add_line(words, _coil(start, end, half), first)
        else:
            elements.add_line(words, np.array(ends), first)
            elements.bodies.append(_draw_cylinder(words, start, end, half))
    return elements


def _coil(start: Array, end: Array, half: float) -> Array:
    """Return the points (k, 2, n) of a spring between its ends (2, n)."""
    line = end - start
    across = half * np.array([-line[1], line[0]]) / (np.hypot(*line) + 1e-12)
    inner = 2 * COILS
    shares = [0.0, 0.15, *(0.15 + 0.7 * (k + 0.5) / inner for k in range(inner)), 0.85, 1.0]
    sides = [0.0, 0.0, *((-1.0) ** k for k in range(inner)), 0.0, 0.0]
    return np.array([start + s * line + a * across for s, a in zip(shares, sides, strict=True)])


def _draw_cylinder(name: str, start: Array, end: Array, half: float) -> Body:
    """Return the cylinder of a strut, which is fixed to its first end."""
    line = end - start
    length = 0.6 * float(np.hypot(*line).min())
    box = np.array([[0.2 * length, -half], [length, -half], [length, half], [0.2 * length, half]])
    turn = np.degrees(np.unwrap(np.arctan2(line[1], line[0])))
    return Body(name, (Outline(box, "body", shade=3),), tuple(start), turn)


def _draw_slider(name: str, at: Array, farther: Array, half: float) -> Iterator[Body]:
    """Yield the guide of a slider if it is at rest, and the slider as a block."""
    way = farther - at
    way = way / np.hypot(*way)
    turn = np.degrees(np.unwrap(np.arctan2(way[1], way[0])))
    block = half * np.array([[-1.6, -1.0], [1.6, -1.0], [1.6, 1.0], [-1.6, 1.0]])
    across = np.array([-way[1, 0], way[0, 0]])
    if np.ptp(way, axis=1).max() < STILL and np.ptp(across @ at) < STILL * (1 + np.ptp(at)):
        places = way[:, 0] @ at
        ends = places.min() - 3 * half, places.max() + 3 * half
        middle = across * float(across @ at[:, 0])
        yield _draw_guide(name, np.array([middle + x * way[:, 0] for x in ends]), across, half)
    yield Body(f"slider in {name}", (Outline(block, "body", shade=4),), tuple(at), turn)


def _draw_cam(name: str, axis: Array, roller: Array, mark: Array, half: float) -> Iterator[Body]:
    """Yield a cam, whose contour is the path of the roller's centre on it since no radius is
    stated, and its roller.
    """
    turn = np.unwrap(np.arctan2(*(mark - axis)[::-1]))
    arm = roller - axis
    c, s = np.cos(turn), np.sin(turn)
    path = np.column_stack([c * arm[0] + s * arm[1], c * arm[1] - s * arm[0]])
    passed = np.abs(turn - turn[0])
    closed = bool(passed.max() > TURN - 1.5 * np.diff(passed).max())
    outline = Outline(path[passed < TURN], "gear" if closed else "mark", closed, 1)
    yield Body(
        f"cam of {name}, path of the roller's centre", (outline,), tuple(axis), np.degrees(turn)
    )
    circle = 0.7 * half * unit_vector(ROUND).T
    yield Body(f"roller of {name}", (Outline(circle[:-1], "body", shade=4),), tuple(roller))


def _draw_guide(name: str, line: Array, across: Array, half: float) -> Body:
    """Return two rails along a line (2, 2), hatched on their outer sides."""
    outlines = []
    for side in (1.1, -1.1):
        rail = line + side * half * across
        outlines.append(Outline(rail, "ground", closed=False))
        slant = np.sign(side) * 0.7 * half * across - 0.5 * half * (line[1] - line[0]) / np.hypot(
            *(line[1] - line[0])
        )
        for share in np.linspace(0.05, 1.0, HATCHES):
            foot = rail[0] + share * (rail[1] - rail[0])
            outlines.append(Outline(np.array([foot, foot + slant]), "ground", closed=False))
    return Body(name, outlines)


def draw_pitch_curves(
    meshes: Mapping[str, Sequence[str]], shapes: Mapping[str, Array]
) -> Iterator[Body]:
    """Yield gears by their pitch curves, which turn with them, from the function `meshes` (n,)
    [SI]; each gear once.
    """
    names: set[str] = set()
    for shade, (tag, gears) in enumerate(meshes.items()):
        if f"mesh_{tag}_x" not in shapes:
            continue
        x, y, line, *pairs = (
            shapes[f"mesh_{tag}_{key}"]
            for key in ("x", "y", "line", "polar_1", "r_1", "polar_2", "r_2")
        )
        polar, radii = pairs[0::2], pairs[1::2]
        outer = 1e3 * np.array([x, y])
        distance = 1e3 * (radii[0] + radii[1])
        inner = outer - distance * unit_vector(line)
        turns = line - polar[0], line + np.pi - polar[1]
        for k, (gear, centre) in enumerate(zip(gears, (inner, outer), strict=True)):
            if gear not in names:
                names.add(gear)
                outline = _draw_pitch_curve(polar[k], 1e3 * radii[k], (2 * shade + k) % 6)
                yield Body(gear, (outline,), tuple(centre), np.degrees(np.unwrap(turns[k])))


def _draw_pitch_curve(polar: Array, radius: Array, shade: int) -> Outline:
    """Return a pitch curve in its gear: a circle, or what the motion passes of it, at most once."""
    if np.ptp(radius) <= STILL * np.abs(radius).max():
        circle = radius[0] * unit_vector(ROUND).T
        return Outline(circle[:-1], "gear", shade=shade)
    passed = np.abs(np.unwrap(polar) - polar[0])
    first_turn = passed < TURN
    points = radius[first_turn, None] * unit_vector(polar).T[first_turn]
    step = float(np.diff(passed).max())
    closed = bool(passed.max() > TURN - 1.5 * step)
    return Outline(points, "gear" if closed else "mark", closed, shade)
