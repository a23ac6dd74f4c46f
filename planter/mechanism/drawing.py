"""Drawings of a mechanism: curves of its quantities, its moving scene, and the program that computes it in a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from planter.engine.machine import LEAST_PIVOT
from planter.files import units
from planter.kernels import Array
from planter.kernels.formulas import HOISTED, Formulas
from planter.kernels.programs.program import Program, Step
from planter.mechanism.file import MechanismFile
from planter.mechanism.machines import build_machine
from planter.numerics.arrays import Integers
from planter.report import labels, style
from planter.view.scene import Body, Chain, Curve, Outline, Point, Scene
from planter.view.subject import Input, Portable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.mechanism.cycle import Turn

MOST_CURVES = 6
"""Curves in one figure."""


@dataclass(frozen=True)
class Course:
    """What curves are drawn over: values (n,), their name with its unit, and whether they are angles of a turn.

    Of a turn `end` is its last angle, `ends` are the curves' values there by key, and `repeats` says whether it ends as
    it began.
    """

    values: Array
    label: str
    turn: bool
    ends: Mapping[str, float] = field(default_factory=dict)
    repeats: bool = False
    end: float = 360.0

    @classmethod
    def from_cycle(cls, cycle: Turn) -> Course:
        """Return what the curves of a cycle are drawn over."""
        end = float(np.degrees(cycle.machine.turn))
        return cls(cycle.angles_deg, f"{cycle.machine.angle} / deg", True, cycle.ends, cycle.repeats, end)


def curves(columns: Mapping[str, Array], course: Course) -> Iterator[tuple[str, Figure]]:
    """Figures of all columns, by the names of their files."""
    by_unit: dict[str, list[str]] = {}
    for key in columns:
        by_unit.setdefault(units.unit(key), []).append(key)
    for unit, keys in by_unit.items():
        for first in range(0, len(keys), MOST_CURVES):
            some = {key: columns[key] for key in keys[first : first + MOST_CURVES]}
            word = "".join(c if c.isalnum() else "_" for c in unit or "number")
            yield f"{word}_{first // MOST_CURVES + 1}", _figure(some, unit, course)


@style.drawn
def _figure(columns: Mapping[str, Array], unit: str, course: Course) -> Figure:
    figure = style.new_figure(2.8)
    axes = figure.subplots()
    if course.turn:
        style.over_a_turn(axes, end=course.end)
    axes.set_xlabel(course.label)
    axes.set_ylabel(unit or "1")
    ends = []
    for index, (key, values) in enumerate(columns.items()):
        shade = style.colour(key, index)
        x, y = _with_end(course, key, values)
        axes.plot(x, y, color=shade, linewidth=1.2)
        ends.append((float(y[-1]), labels.name(key), shade))
    if not course.turn:
        axes.set_xlim(course.values[0], course.values[-1])
    axes.autoscale_view()
    style.label_ends(axes, ends, 0.07)
    return figure


def _with_end(course: Course, key: str, values: Array) -> tuple[Array, Array]:
    """A curve (n,), of a turn with its value at the end, as far as that is known."""
    if key not in course.ends:
        return course.values, values
    return np.append(course.values, course.end), np.append(values, course.ends[key])


GROUND = "ground"
MOST = 400
"""Moments that are shown."""
MOST_SCENE_CURVES = 16
"""Curves of a scene, those of the first quantities."""
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
    place, _, unit = course.label.partition(" / ")
    return Scene(
        title=title,
        place=place,
        unit=unit,
        places=course.values[chosen],
        seconds=seconds,
        bodies=_ground(bodies.get(GROUND, {}), extent / MARKS),
        points=points,
        again=course.repeats,
        chains=chains,
        curves=[Curve(key, units.unit(key), column[chosen])
                for key, column in list(columns.items())[:MOST_SCENE_CURVES]],
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


STEPS = 8
"""Of Newton's method at an angle, from where the angle before has led."""
STARTS = 6
"""How many times as many at the first."""


def closed(model: Formulas, name: str, angles: int) -> ca.Function:
    """(angles (n,), data) -> loops (n, k), open (n,), sense (n,).

    `loops` are the coordinates, `open` is what the next step would change, in parts of their size, and `sense` the
    Jacobian's determinant: where that changes its sign the walk has come into another assembly.
    """
    closure, assembly = model.function("closure"), model.function("assembly")
    at = _at(closure, assembly.numel_out(0))
    phi, data = ca.MX.sym("angles", angles), ca.MX.sym("data", closure.numel_in(1))
    start = assembly(data)
    for _ in range(STARTS):
        start = at(start, phi[0], data)[0]
    walk = at.mapaccum("walk", angles, [0], [0])
    found, left, sense = walk(start, phi.T, ca.repmat(data, 1, angles))
    return ca.Function(name, [phi, data], [found.T, left.T, sense.T], ["angles", "data"], ["loops", "open", "sense"])


def _at(closure: ca.Function, count: int) -> ca.Function:
    """(loops (k,), angle, data) -> those after all steps, what another would change, the determinant."""
    q, phi, data = ca.SX.sym("q", count), ca.SX.sym("phi"), ca.SX.sym("data", closure.numel_in(1))
    gaps = closure(phi, data, q)
    jacobian = ca.reshape(gaps[count:], count, count).T
    change = -ca.solve(jacobian, gaps[:count])
    left = ca.mmax(ca.fabs(change) / (1 + ca.fabs(q)))
    step = ca.Function("step", [q, phi, data], [q + change, left, ca.det(jacobian)])
    found, angle, known = ca.MX.sym("q", count), ca.MX.sym("phi"), ca.MX.sym("data", closure.numel_in(1))
    at = found
    for _ in range(STEPS):
        at = step(at, angle, known)[0]
    return ca.Function("at", [found, angle, known], [at, *step(at, angle, known)[1:]])


OPEN = 1e-11
"""A loop is closed where Newton's next step is below this share of the coordinates' size."""
NOTES = (
    "Laws that must be obeyed, contacts that lift, limits and optima are not told here: save the file beside its "
    "generated functions, and planter turn tells them.",
)
Known = Mapping[str, ca.SX]


class Turning:
    """A mechanism's turn at `samples` angles."""

    def __init__(self, file: MechanismFile) -> None:
        self.machine, self.formulas = build_machine(file), file.model
        self.samples = self.machine.samples
        self.angles = 2 * np.pi * np.arange(self.samples) / self.samples
        self.loops = self.machine.loops is not None

    def portable(self) -> Portable:
        """All that a page needs."""
        return Portable(
            inputs=[Input(value.path, "data", k, value.factor) for k, value in enumerate(self.machine.values)],
            seen=Program("turn", {"angles": self.angles, "data": self.machine.data}, self._steps()),
            rows={"rows": len(self._drawn)},
            singles=list(self._singles),
            assumptions=self.formulas.sidecar["assumptions"],
            notes=NOTES,
        )  # fmt: skip

    def _steps(self) -> list[Step]:
        found = [Step(closed(self.formulas, "turn_loops", self.samples))] if self.loops else []
        if HOISTED in self._lane.name_in():
            prologue = self.formulas.function("prologue")
            data = ca.MX.sym("data", prologue.numel_in(0))
            found.append(Step(ca.Function("turn_prologue", [data], [prologue(data)], ["data"], [HOISTED])))
        names = ["angles", *self._lane.name_in()[1:]]
        values = ca.vertcat(*self._rows.values())
        rows = ca.Function("turn_rows", self._inputs, [ca.cse(values)], names, ["all"])
        found.append(Step(rows, tuple(name for name in names if name in ("angles", "loops"))))
        all_, taken = self._all, shown(self.samples).tolist()
        drawn = ca.horzcat(*(all_[taken, list(self._rows).index(key)] for key in self._drawn))
        found.append(Step(ca.Function("turn_drawn", [all_], [drawn], ["all"], ["rows"])))
        singles = ca.vertcat(*self._singles.values())
        found.append(Step(ca.Function("turn_singles", list(self._given.values()), [singles], list(self._given),
                                      ["singles"])))  # fmt: skip
        return found

    # --- along the angle ------------------------------------------------------------------------------

    @cached_property
    def _lane(self) -> ca.Function:
        return self.formulas.function("lane")

    @cached_property
    def _inputs(self) -> list[ca.SX]:
        return list(self._lane.sx_in())

    @cached_property
    def _rows(self) -> Known:
        """Everything at an angle by name, results in shown units by their keys first."""
        values = ca.vertsplit(self._lane(*self._inputs))
        quantities = list(zip(self.machine.quantities, values, strict=True))
        told = {q.key: value / q.factor for q, value in quantities if q.role == "result"}
        checked = {q.name: value for q, value in quantities if q.role in ("pivot", "states")}
        return {**told, **checked, **self._points, "angle": self._inputs[0] / units.factor("angle_deg")}

    @property
    def _keys(self) -> list[str]:
        return [quantity.key for quantity in self.machine.results]

    @cached_property
    def _points(self) -> Known:
        """Where points of bodies are drawn [mm], as `x BODY__POINT` and `y BODY__POINT`."""
        places = self.formulas.function("places")
        given = dict(zip(self._lane.name_in(), self._inputs, strict=True))
        at = dict(zip(self.formulas.outputs("places"), ca.vertsplit(places(*(given[n] for n in places.name_in()))),
                      strict=True))  # fmt: skip
        return {
            f"{axis} {point}": 1e3 * (at[f"{axis}_{point}"] - OBLIQUE * at.get(f"z_{point}", 0.0))
            for name in at
            for axis, _, point in [name.partition("_")]
            if axis in "xy"
        }

    @cached_property
    def _drawn(self) -> Sequence[str]:
        return ["angle", *self._keys[:MOST_SCENE_CURVES], *self._points]

    # --- single numbers -------------------------------------------------------------------------------

    @cached_property
    def _all(self) -> ca.MX:
        return ca.MX.sym("all", self.samples, len(self._rows))

    @cached_property
    def _given(self) -> Mapping[str, ca.MX]:
        """What single numbers are made of."""
        loops = {name: ca.MX.sym(name, self.samples) for name in ("open", "sense")} if self.loops else {}
        return {"data": ca.MX.sym("data", len(self.machine.data)), "all": self._all, **loops}

    @cached_property
    def _singles(self) -> Mapping[str, ca.MX]:
        rows = dict(zip(self._rows, ca.horzsplit(self._all), strict=True))
        speed = self._given["data"][self.machine.speed]
        return {
            "seconds": 2 * np.pi / ca.fabs(speed),
            "sound": 1 / self._sound(rows),
            **{f"largest {key}": ca.mmax(rows[key]) for key in self._keys},
            **{f"least {key}": ca.mmin(rows[key]) for key in self._keys},
            **self._marks(rows),
        }

    def _sound(self, rows: Mapping[str, ca.MX]) -> ca.MX:
        """One where all loops are closed in one assembly and the equations determine their forces; else zero."""
        least = {"pivot": LEAST_PIVOT, "states": 0}
        checks = [ca.mmin(rows[q.name]) > least[q.role] for q in self.machine.quantities if q.role in least]
        if self.loops:
            sense = self._given["sense"]
            checks += [ca.mmax(self._given["open"]) < OPEN, ca.mmin(sense * sense[0]) > 0]
        found = ca.MX(1)
        for check in checks:
            found *= check
        return found

    def _marks(self, rows: Mapping[str, ca.MX]) -> Mapping[str, ca.MX]:
        """Corners of the marks at points of the ground."""
        both = [[row for name, row in rows.items() if name.startswith(f"{axis} ")] for axis in "xy"]
        apart = [ca.mmax(ca.vertcat(*of)) - ca.mmin(ca.vertcat(*of)) for of in both]
        size = ca.fmax(*apart) / MARKS
        return {
            f"{name} {k}": rows[name][0] + size * corner["xy".index(name[0])]
            for name in self._points
            if name[2:].startswith(f"{GROUND}__")
            for k, corner in enumerate(MARK)
        }
