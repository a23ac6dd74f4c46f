"""What is drawn of a mechanism besides its bodies: marks of the ground, springs, struts, sliders in
guides, cams with their rollers, and pitch curves of gears.

Their measures are graphs over the moments of a cycle: reports evaluate them, pages without a server
run them as part of their program.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import casadi as ca
import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import unit_vector
from planter.report.scene import Body, Outline

COILS = 6
"""Coils of a spring."""
THICKNESS = 0.022
"""Half width of springs, struts, blocks and guides, relative to the extent of the drawing."""
ROLLER = 0.7
"""Radius of a roller whose radius is not stated, relative to this half width."""
MARK_SHARE = 30
"""Extent of a mechanism over the size of the marks of its ground."""
HATCHES = 9
"""Strokes that mark a guide as fixed."""
STILL = 1e-9
"""Change of a direction below which a guide does not turn."""
DEGREES = 180 / np.pi
MILLIMETRES = 1e3
CIRCLE = unit_vector(np.radians(np.arange(0.0, 360.0, 3.0))).T
GROUND_MARK = np.array([[0.0, 0.0], [-0.6, -1.0], [0.6, -1.0]])
"""Triangle below a point of the ground, in parts of its size."""
BLOCK = np.array([[-1.6, -1.0], [1.6, -1.0], [1.6, 1.0], [-1.6, 1.0]])
"""A slider, in half widths."""
CYLINDER = np.array([[0.2, -1.0], [1.0, -1.0], [1.0, 1.0], [0.2, 1.0]])
"""The cylinder of a strut, along its length and in half widths."""
CYLINDER_SHARE = 0.6
"""Length of a cylinder, relative to the least length of its strut."""

Kinds = Mapping[str, Mapping[str, str]]
"""Kind and bodies of each element by name, as the functions of a machine tell them."""
Meshes = Mapping[str, Sequence[str]]
"""Names of the gears of each mesh by its tag."""
Graphs = Mapping[str, ca.MX]
"""Columns (n, 1) or single numbers by name."""


def measure_elements(kinds: Kinds, meshes: Meshes, shapes: Graphs, extent: ca.MX) -> Graphs:
    """Return what elements are drawn from: columns (n, 1) and single numbers, [mm] and [deg].

    `shapes` (n, 1) [SI] are the outputs of the functions `elements` and `meshes`, and `extent` [mm]
    is that of the drawing.
    """
    measures = {"half width": THICKNESS * extent, "ground mark": extent / MARK_SHARE}
    half = measures["half width"]
    for name, element in _select_plane(kinds, shapes):
        ends = _collect_ends(name, shapes)
        graphs = (
            _measure_cam(ends, _roller_radius(name, shapes, half))
            if element["kind"] == "cam"
            else _measure_line(ends, half)
        )
        measures |= {f"{name} {key}": graph for key, graph in graphs.items()}
    for tag in _select_meshes(meshes, shapes):
        graphs = _measure_mesh({key: shapes[f"mesh_{tag}_{key}"] for key in MESH_KEYS})
        measures |= {f"mesh {tag} {key}": graph for key, graph in graphs.items()}
    return measures


def evaluate_measures(
    kinds: Kinds, meshes: Meshes, shapes: Mapping[str, Array], extent: float
) -> dict[str, Array]:
    """Return the values of `measure_elements` for coordinates (n,) [SI] by name."""
    symbols = {name: ca.MX.sym(name, len(values)) for name, values in shapes.items()}
    size = ca.MX.sym("extent")
    graphs = measure_elements(kinds, meshes, symbols, size)
    function = ca.Function("measures", [*symbols.values(), size], list(graphs.values()))
    values = function.call([*shapes.values(), extent])
    return {name: value.full().ravel() for name, value in zip(graphs, values, strict=True)}


def draw_elements(kinds: Kinds, meshes: Meshes, measures: Mapping[str, Array]) -> Iterator[Body]:
    """Yield gears by their pitch curves, then springs, struts, guides with their sliders, and cams
    with their rollers.
    """
    yield from _draw_gears(meshes, measures)
    half = float(measures["half width"][0])
    for name, element in kinds.items():
        if f"{name} x" not in measures:
            continue
        keys = [key for key in measures if key.startswith(f"{name} ")]
        values = {key.removeprefix(f"{name} "): measures[key] for key in keys}
        words = name.replace("_", " ")
        if element["kind"] == "guide":
            yield from _draw_slider(words, element["on"], values, half)
        elif element["kind"] == "cam":
            yield from _draw_cam(element["on"], element["by"], values)
        elif element["kind"] == "spring":
            yield _place_line(words, Outline(_coil(), "line", closed=False, shade=3), values, half)
        else:
            rod = Outline(np.array([[0.0, 0.0], [1.0, 0.0]]), "line", closed=False, shade=3)
            yield _place_line(words, rod, values, half)
            at = values["x"], values["y"]
            scale = float(values["cylinder"][0]), half
            yield Body(words, (Outline(CYLINDER, shade=3),), at, values["turn"], scale=scale)


def mark_ground(points: Mapping[str, Array], size: float) -> Iterator[Body]:
    """Yield a mark of a `size` [mm] at each point (2, n) [m] of the ground that does not move."""
    for at in points.values():
        if not np.ptp(at, axis=1).any():
            x, y = MILLIMETRES * at[:, 0]
            outline = Outline(GROUND_MARK, "ground")
            yield Body("ground", (outline,), (x, y), scale=(size, size))


def _select_plane(kinds: Kinds, shapes: Graphs) -> Iterator[tuple[str, Mapping[str, str]]]:
    """Yield the elements with coordinates in a plane."""
    for name, element in kinds.items():
        if f"{name}_y_1" in shapes and f"{name}_z_1" not in shapes:
            yield name, element


def _select_meshes(meshes: Meshes, shapes: Mapping[str, object]) -> list[str]:
    return [tag for tag in meshes if f"mesh_{tag}_x" in shapes]


def _collect_ends(name: str, shapes: Graphs) -> list[tuple[ca.MX, ca.MX]]:
    """Return coordinates of the ends of an element [mm]."""
    numbers = [number for number in range(1, 5) if f"{name}_x_{number}" in shapes]
    pairs = ((shapes[f"{name}_x_{number}"], shapes[f"{name}_y_{number}"]) for number in numbers)
    return [(MILLIMETRES * x, MILLIMETRES * y) for x, y in pairs]


def _roller_radius(name: str, shapes: Graphs, half: ca.MX) -> ca.MX:
    """Return the stated radius of a roller [mm], or one that can be seen."""
    stated = shapes.get(f"{name}_radius")
    return ROLLER * half if stated is None else MILLIMETRES * stated[0]


def _measure_line(ends: Sequence[tuple[ca.MX, ca.MX]], half: ca.MX) -> dict[str, ca.MX]:
    """Return the place, direction and length of a spring, a strut or a guide, the length of a
    cylinder, and the rails over which a slider moves.
    """
    (x, y), (end_x, end_y) = ends
    dx, dy = end_x - x, end_y - y
    length = ca.sqrt(dx**2 + dy**2)
    c, s = dx / length, dy / length
    travel, across = c * x + s * y, c * y - s * x
    low = ca.mmin(travel) - 3 * half
    return {
        "x": x,
        "y": y,
        "turn": DEGREES * ca.atan2(dy, dx),
        "length": length,
        "across": across,
        "cylinder": CYLINDER_SHARE * ca.mmin(length),
        "rail x": c[0] * low - s[0] * across[0],
        "rail y": s[0] * low + c[0] * across[0],
        "rail": ca.mmax(travel) + 3 * half - low,
    }


def _measure_cam(ends: Sequence[tuple[ca.MX, ca.MX]], radius: ca.MX) -> dict[str, ca.MX]:
    """Return places and direction of a cam and its roller, and the points of the cam that touch
    it.
    """
    (x, y), (roller_x, roller_y), (mark_x, mark_y), (out_x, out_y) = ends
    share = radius / MILLIMETRES  # of the normal, which is a length of one
    arm_x = roller_x - x - share * (out_x - roller_x)
    arm_y = roller_y - y - share * (out_y - roller_y)
    c, s = (mark_x - x) / MILLIMETRES, (mark_y - y) / MILLIMETRES
    return {
        "x": x,
        "y": y,
        "turn": DEGREES * ca.atan2(s, c),
        "roller x": roller_x,
        "roller y": roller_y,
        "radius": radius,
        "contour x": c * arm_x + s * arm_y,
        "contour y": c * arm_y - s * arm_x,
    }


MESH_KEYS = "x", "y", "line", "polar_1", "r_1", "polar_2", "r_2"
"""What the function `meshes` gives of a mesh: an axis of the second gear, the direction to it, and
direction and radius of the pitch point in either gear.
"""


def _measure_mesh(mesh: Graphs) -> dict[str, ca.MX]:
    """Return places, directions and pitch curves of both gears of a mesh."""
    line, distance = mesh["line"], MILLIMETRES * (mesh["r_1"] + mesh["r_2"])
    x, y = MILLIMETRES * mesh["x"], MILLIMETRES * mesh["y"]
    measures = {
        "1 x": x - distance * ca.cos(line),
        "1 y": y - distance * ca.sin(line),
        "1 turn": DEGREES * (line - mesh["polar_1"]),
        "2 x": x,
        "2 y": y,
        "2 turn": DEGREES * (line + np.pi - mesh["polar_2"]),
    }
    for gear in "12":
        polar, radius = mesh[f"polar_{gear}"], MILLIMETRES * mesh[f"r_{gear}"]
        measures |= {
            f"{gear} polar": DEGREES * polar,
            f"{gear} radius": radius[0],
            f"{gear} curve x": radius * ca.cos(polar),
            f"{gear} curve y": radius * ca.sin(polar),
        }
    return measures


def _coil() -> Array:
    """Return the points (k, 2) of a spring along its length, in half widths across."""
    inner = 2 * COILS
    shares = [0.0, 0.15, *(0.15 + 0.7 * (k + 0.5) / inner for k in range(inner)), 0.85, 1.0]
    sides = [0.0, 0.0, *((-1.0) ** k for k in range(inner)), 0.0, 0.0]
    return np.column_stack([shares, sides])


def _place_line(name: str, outline: Outline, values: Mapping[str, Array], half: float) -> Body:
    """Return a body that reaches from one end of an element to the other."""
    at = values["x"], values["y"]
    return Body(name, (outline,), at, values["turn"], scale=(values["length"], half))


def _draw_slider(
    name: str, slider: str, values: Mapping[str, Array], half: float
) -> Iterator[Body]:
    """Yield the guide of a slider if it is at rest, and the slider as a block."""
    turn = np.radians(values["turn"])
    change = max(np.ptp(np.cos(turn)), np.ptp(np.sin(turn)))
    place = np.array([values["x"], values["y"]])
    if change < STILL and np.ptp(values["across"]) < STILL * (1 + np.ptp(place)):
        at = float(values["rail x"][0]), float(values["rail y"][0])
        scale = float(values["rail"][0]), half
        yield Body(name, _rails(), at, values["turn"], scale=scale)
    yield Body(slider, (Outline(BLOCK, shade=4),), tuple(place), values["turn"], scale=(half, half))


def _rails() -> list[Outline]:
    """Return two rails along a guide, hatched on their outer sides; along its length, and in half
    widths across.
    """
    lines: list[Sequence[tuple[float, float]]] = []
    for side in (1.1, -1.1):
        lines.append([(0.0, side), (1.0, side)])
        feet = np.linspace(0.05, 1.0, HATCHES).tolist()
        lines += [[(foot, side), (foot - 0.05, side + 0.7 * np.sign(side))] for foot in feet]
    return [Outline(np.array(line), "ground", closed=False) for line in lines]


def _draw_cam(follower: str, cam: str, values: Mapping[str, Array]) -> Iterator[Body]:
    """Yield a cam by the contour on which its roller rolls, and the roller, a part of the
    follower.
    """
    contour = np.column_stack([values["contour x"], values["contour y"]])
    at, roller = (values["x"], values["y"]), (values["roller x"], values["roller y"])
    radius = float(values["radius"][0])
    yield Body(cam, (_trace_contour(contour, values["turn"], 1),), at, values["turn"])
    circle = Outline(CIRCLE, shade=4)
    yield Body(follower, (circle,), roller, scale=(radius, radius))


def _draw_gears(meshes: Meshes, measures: Mapping[str, Array]) -> Iterator[Body]:
    """Yield gears by their pitch curves, which turn with them; each gear once."""
    names: set[str] = set()
    tags = [tag for tag in meshes if f"mesh {tag} 1 x" in measures]
    for shade, tag in enumerate(tags):
        for k, name in enumerate(meshes[tag]):
            start = f"mesh {tag} {k + 1} "
            keys = [key for key in measures if key.startswith(start)]
            values = {key.removeprefix(start): measures[key] for key in keys}
            if name not in names:
                names.add(name)
                yield _draw_gear(name, values, (2 * shade + k) % 6)


def _draw_gear(name: str, values: Mapping[str, Array], shade: int) -> Body:
    """Return a gear by its pitch curve: a circle, or what the motion passes of it."""
    at, turn = (values["x"], values["y"]), values["turn"]
    curve = np.column_stack([values["curve x"], values["curve y"]])
    radii = np.hypot(*curve.T)
    if np.ptp(radii) <= STILL * radii.max():
        scale = float(values["radius"][0]), float(values["radius"][0])
        return Body(name, (Outline(CIRCLE, "gear", shade=shade),), at, turn, scale=scale)
    return Body(name, (_trace_contour(curve, values["polar"], shade),), at, turn)


def _trace_contour(points: Array, angles: Array, shade: int) -> Outline:
    """Return a line through points (n, 2), closed if their directions `angles` (n,) [deg] pass a
    turn.
    """
    passed = np.abs(np.unwrap(angles, period=360.0) - angles[0])
    closed = bool(passed.max() > 360.0 - 1.5 * np.diff(passed).max())
    return Outline(points, "gear" if closed else "line", closed, shade)
