"""Motion as named steps: rotations, places, velocities and accelerations of frames and points.

Each step follows from that of the frame's parent or of the point's base, so that what is derived of
a chain grows with its length. Vectors are along the axes of the world. Loads go back over the same
steps (`MotionSteps.collect_power`): with inertia among them that is the recursive Newton-Euler
method (Luh, Walker and Paul, J. Dyn. Sys. Meas. Control 102, 1980), for frames that turn and points
that move by any expression of the coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp
from sympy import Expr, S

from ..functions import partial_derivative
from ..model import Let
from ..quantity import Quantity, word
from .bodies import AXES
from .frames import Frame, Motion, Point, Quaternion, Rows, Triple, Vec, multiply_cross
from .loops import Coordinate

Slopes = dict[int, Triple]
"""Slopes of three components in the rates of coordinates, by the places of these."""
NOTHING: Triple = (S.Zero, S.Zero, S.Zero)
IDENTITY: Rows = ((S.One, S.Zero, S.Zero), (S.Zero, S.One, S.Zero), (S.Zero, S.Zero, S.One))
TURNS = "angles of frames, with cosine and sine, and rows R of their axes in the world"
MOTION = (
    "motion in the world, w and dw of frames (e against another); of points d and u against the "
    "base, r, v, a"
)
INERTIA = "inertia I in the world, angular momentum L"
LOADS = "loads of bodies: i of inertia and weight, forces p and moments q of actions"
CARRIED = "what is carried: forces f by points, moments n by frames"
ARTICULATED = (
    "articulated inertias A and loads P; along a coordinate inertia U and D, shares S, "
    "acceleration s; B and H for the body before"
)
GIVEN = "accelerations g that coordinates give (h by the body before)"
NOTES = {
    **dict.fromkeys(("angle", "cos", "sin", "R", "Q"), TURNS),
    **dict.fromkeys(("w", "e", "dw", "d", "u", "r", "v", "a"), MOTION),
    **dict.fromkeys("IL", INERTIA),
    **dict.fromkeys("ipq", LOADS),
    **dict.fromkeys("fn", CARRIED),
    **dict.fromkeys("APUDSsBH", ARTICULATED),
    **dict.fromkeys("gh", GIVEN),
}
"""What the names of steps begin with, and what that means."""
NEAR = 2
"""Offsets that are added up between two points; of points farther apart places are subtracted."""


def add_triples(*vectors: Iterable[Expr]) -> Triple:
    """Return the sum of some components."""
    x, y, z = (sp.Add(*parts) for parts in zip(*vectors, strict=True))
    return x, y, z


def scale_triple(factor: Expr, vector: Iterable[Expr]) -> Triple:
    """Return a multiple of some components."""
    x, y, z = (factor * c for c in vector)
    return x, y, z


def dot_product(first: Iterable[Expr], second: Iterable[Expr]) -> Expr:
    """Return the scalar product of components."""
    return sp.Add(*(a * b for a, b in zip(first, second, strict=True)))


def multiply_rows(rows: Rows, vector: Sequence[Expr]) -> Triple:
    """Return a matrix times some components."""
    x, y, z = (dot_product(row, vector) for row in rows)
    return x, y, z


def transpose_rows(rows: Rows) -> Rows:
    """Return the rows of a matrix's transpose."""
    first, second, third = zip(*rows, strict=True)
    return first, second, third


def add_slopes(parts: Iterable[Slopes]) -> Slopes:
    """Return the sum of slopes."""
    total: Slopes = {}
    for part in parts:
        for i, way in part.items():
            total[i] = add_triples(total[i], way) if i in total else way
    return total


@dataclass(frozen=True)
class FrameSteps:
    """A frame: its `parent`, the angular velocity against it and the rate of that as the frame sees
    it, along its own axes, and the `rows` that resolve its vectors in the world.

    From `root` on it turns about one axis, of a number, by the `angle` [rad].
    """

    parent: Frame | None
    rows: Rows
    spin: Triple = NOTHING
    change: Triple = NOTHING
    root: Frame | None = None
    axis: int | None = None
    angle: Expr = S.Zero


class MotionSteps(Motion):
    """The motion of a statement in names of its own; `steps` define them, in their order.

    `plain` writes expressions in the rates and accelerations of the `coordinates`. `taken` are
    names that others have. `frames` are those of the bodies: where one turns about
    the same axis as another by more terms, it turns against that one.
    """

    def __init__(
        self,
        motion: Motion,
        coordinates: Sequence[Coordinate],
        plain: Callable[[Expr], Expr],
        taken: Collection[str],
        frames: Iterable[Frame],
    ) -> None:
        super().__init__(motion.rates, inputs=motion.inputs)
        self.steps: list[Let] = []
        self.coordinates, self.plain = coordinates, plain
        self._motion, self._names = motion, set(taken)
        self._multiples: dict[Expr, tuple[Expr, Quantity]] = {}
        self._spin_ways: dict[Frame, Slopes] = {}
        self._velocity_ways: dict[Point, Slopes] = {}
        self._stretches: dict[Point, tuple[Triple, Triple]] = {}
        self._frames: dict[Frame, FrameSteps] = {}
        self._points: dict[Point, Triple] = {}
        self._cache: dict[tuple[str, object], Triple] = {}
        self._tensors: dict[tuple[Frame, Rows], Rows] = {}
        self._siblings: dict[tuple[Frame, int], list[tuple[Frame, set[Expr]]]] = {}
        self._turned: dict[tuple[Frame, int, Expr], Rows] = {}
        for frame in sorted(frames, key=_count_terms):
            self.frame(frame)

    # --- names ------------------------------------------------------------------------------------

    def name(self, stem: str, unit: str, expr: Expr) -> Expr:
        """Return a symbol for an expression; numbers, symbols and their opposites need none.

        What is a fraction or a multiple of what has a name is written by that.
        """
        factor, rest = expr.as_coeff_Mul()
        if factor.is_Rational and rest in self._multiples:
            before, symbol = self._multiples[rest]
            expr = factor / before * symbol
        if expr.is_Atom or (-expr).is_Symbol:
            return expr
        name = stem
        while name in self._names:
            name += "_"
        self._names.add(name)
        note = NOTES[stem.partition("_")[0]]
        symbol = self.define(Quantity(name, unit, note, f"derived: {note}"), expr, note)
        self._multiples.setdefault(rest, (factor, symbol))
        return symbol

    def define(self, symbol: Quantity, expr: Expr, note: str) -> Quantity:
        """Define a quantity by an expression, and return the quantity."""
        self.steps.append(Let(symbol, expr, f"derived: {note}"))
        return symbol

    def name_all(self, stem: str, unit: str, components: Iterable[Expr]) -> Triple:
        """Return symbols for components along the axes of the world."""
        x, y, z = (
            self.name(f"{stem}_{axis}", unit, component)
            for axis, component in zip(AXES, components, strict=True)
        )
        return x, y, z

    def _name_node(
        self, stem: str, node: Frame | Point, unit: str, components: Iterable[Expr]
    ) -> Triple:
        return self.name_all(f"{stem}_{word(node.name)}", unit, components)

    # --- frames -----------------------------------------------------------------------------------

    def frame(self, frame: Frame) -> FrameSteps:
        """Return the steps of a frame."""
        if frame not in self._frames:
            self._frames[frame] = self._find_frame(frame)
        return self._frames[frame]

    def _find_frame(self, frame: Frame) -> FrameSteps:
        if frame.parent is None:
            return FrameSteps(None, IDENTITY)
        if isinstance(frame.angle, Quaternion):
            return self._turn_freely(frame, frame.parent, frame.angle)
        axis = next(i for i, a in enumerate(frame.axis) if a)
        parent, angle = self._find_sibling(frame.parent, axis, frame.angle * frame.axis[axis])
        self._siblings.setdefault((frame.parent, axis), []).append(
            (frame, _terms(frame.angle * frame.axis[axis]))
        )
        before = self.frame(parent)
        root, total = parent, angle
        if before.axis == axis and before.root is not None:
            root, total = before.root, before.angle + angle
        label = word(frame.name)
        constant, varying = total.as_independent(*total.free_symbols, as_Add=True)
        varying = self.name(f"angle_{label}", "rad", varying)
        total = varying + constant  # so that right angles stay exact
        speed, change = self._differentiate((angle,))
        return FrameSteps(
            parent,
            self._turn(root, axis, total, label),
            _place_on(axis, speed[0]),
            _place_on(axis, change[0]),
            root,
            axis,
            total,
        )

    def _find_sibling(self, parent: Frame, axis: int, angle: Expr) -> tuple[Frame, Expr]:
        """Return the frame against which fewest terms are left of an angle, and these."""
        terms = _terms(angle)
        best, common = parent, set[Expr]()
        for sibling, its in self._siblings.get((parent, axis), ()):
            if its <= terms and len(its) > len(common):
                best, common = sibling, its
        return best, sp.Add(*(terms - common))

    def _turn(self, root: Frame, axis: int, angle: Expr, label: str) -> Rows:
        """Return the rows of a frame that is turned against another about an axis of both."""
        if angle == 0:
            return self.frame(root).rows
        if (root, axis, angle) not in self._turned:
            cos, sin = sp.cos(angle), sp.sin(angle)
            c = self.name(f"cos_{label}", "1", cos)
            s = self.name(f"sin_{label}", "1", sin)
            j, k = (axis + 1) % 3, (axis + 2) % 3
            rows = []
            for row in self.frame(root).rows:
                turned = list(row)
                turned[j], turned[k] = c * row[j] + s * row[k], c * row[k] - s * row[j]
                rows.append(turned)
            self._turned[root, axis, angle] = self._name_rows(f"R_{label}", rows)
        return self._turned[root, axis, angle]

    def _name_rows(self, stem: str, rows: Iterable[Iterable[Expr]]) -> Rows:
        first, second, third = (
            self.name_all(f"{stem}_{axis}", "1", row) for axis, row in zip(AXES, rows, strict=True)
        )
        return first, second, third

    def _turn_freely(self, frame: Frame, parent: Frame, turn: Quaternion) -> FrameSteps:
        """Of a quaternion q the spin is the vector of 2 q* q', its change that of 2 q* q''."""
        label, before = word(frame.name), self.frame(parent).rows
        inner = [tuple(turn.matrix().row(i)) for i in range(3)]
        if before != IDENTITY:
            columns = transpose_rows(self._name_rows(f"Q_{label}", inner))
            inner = [multiply_rows(columns, row) for row in before]
        rows = self._name_rows(f"R_{label}", inner)
        speeds = self._differentiate((turn.scalar, *turn.vector))
        spin, change = (
            self.write_plain(2 * c for c in (-turn * Quaternion(w, (x, y, z))).vector)
            for w, x, y, z in speeds
        )
        return FrameSteps(parent, rows, spin, change)

    def _differentiate(self, exprs: Sequence[Expr]) -> tuple[list[Expr], list[Expr]]:
        """Return first and second derivatives in time."""
        once = [self._motion.rate(sp.sympify(expr)) for expr in exprs]
        twice = [self._motion.rate(expr) for expr in once]
        return [self.plain(e) for e in once], [self.plain(e) for e in twice]

    def write_plain(self, vector: Iterable[Expr]) -> Triple:
        """Return components in the rates and accelerations of the coordinates."""
        x, y, z = map(self.plain, vector)
        return x, y, z

    def base(self, frame: Frame) -> Frame:
        """Return the frame farthest up that a frame does not move against."""
        while (parent := self.frame(frame).parent) is not None:
            if any(self.frame(frame).spin):
                break
            frame = parent
        return frame

    def spin_slopes(self, frame: Frame) -> Slopes:
        """Return the slopes of a frame's spin against its parent, in the world."""
        steps = self.frame(frame)
        return {i: multiply_rows(steps.rows, way) for i, way in self._slopes(steps.spin).items()}

    def _slopes(self, speed: Triple) -> Slopes:
        rates = [coordinate.rate for coordinate in self.coordinates]
        moving = frozenset[sp.Basic]().union(*(c.free_symbols for c in speed))
        return {
            i: (
                partial_derivative(speed[0], rate),
                partial_derivative(speed[1], rate),
                partial_derivative(speed[2], rate),
            )
            for i, rate in enumerate(rates)
            if rate in moving
        }

    def to_world(self, vector: Vec) -> Triple:
        """Return the components of a vector along the axes of the world."""
        return multiply_rows(self.frame(vector.frame).rows, vector.components)

    def resolve(self, vector: Vec, frame: Frame) -> Vec:
        """Return a vector by its components in a frame."""
        before, after = self.frame(vector.frame).rows, self.frame(frame).rows
        if before is after or before == after:
            return Vec(frame, vector.components)
        return Vec(
            frame, multiply_rows(transpose_rows(after), multiply_rows(before, vector.components))
        )

    @cached_property
    def world(self) -> Frame:
        """The frame at rest."""
        return next(frame for frame in self._frames if frame.parent is None)

    def spin(self, frame: Frame, seen_from: Frame | None = None) -> Vec:
        """Return the angular velocity [rad/s] of a frame, along the axes of the world."""
        return Vec(self.world, self._know("w", frame, self._find_spin))

    def turning(self, frame: Frame) -> Triple:
        """Return the angular acceleration [rad/s2] of a frame in the world."""
        return self._know("dw", frame, self._find_turning)

    def _know(self, kind: str, key: object, find: Callable[..., Triple]) -> Triple:
        if (kind, key) not in self._cache:
            self._cache[kind, key] = find(key)
        return self._cache[kind, key]

    def _find_relative_spin(self, frame: Frame) -> Triple:
        """Return the angular velocity against the parent, in the world."""
        steps = self.frame(frame)
        expr = multiply_rows(steps.rows, steps.spin)
        is_first = steps.parent is None or not any(self.spin(steps.parent).components)
        return self._name_node("w" if is_first else "e", frame, "rad/s", expr)

    def _find_spin(self, frame: Frame) -> Triple:
        parent = self.frame(frame).parent
        if parent is None:
            return NOTHING
        carried = self.spin(parent).components
        total = add_triples(carried, self._know("e", frame, self._find_relative_spin))
        return self._name_node("w", frame, "rad/s", total)

    def _find_turning(self, frame: Frame) -> Triple:
        steps = self.frame(frame)
        if steps.parent is None:
            return NOTHING
        relative = self._know("e", frame, self._find_relative_spin)
        swept = multiply_cross(self.spin(steps.parent).components, relative)
        change = multiply_rows(steps.rows, steps.change)
        total = add_triples(self.turning(steps.parent), swept, change)
        return self._name_node("dw", frame, "rad/s2", total)

    # --- points -----------------------------------------------------------------------------------

    def _offset(self, point: Point) -> Vec:
        assert point.offset is not None
        return point.offset

    def offset(self, point: Point) -> Triple:
        """Return the vector to a point from its base [m], in the world."""
        return self._know("d", point, self._find_offset)

    def _find_offset(self, point: Point) -> Triple:
        return self._name_node("d", point, "m", self.to_world(self._offset(point)))

    def stretch(self, point: Point) -> tuple[Triple, Triple]:
        """Return rate and second derivative of the components of a point's offset."""
        if point not in self._stretches:
            once, twice = self._differentiate(self._offset(point).components)
            self._stretches[point] = (once[0], once[1], once[2]), (twice[0], twice[1], twice[2])
        return self._stretches[point]

    def is_still(self, point: Point) -> bool:
        """Whether a point does not move against its base as the frame of its offset sees it."""
        return not any(self.stretch(point)[0])

    def stretch_slopes(self, point: Point) -> Slopes:
        """Return the slopes of that motion, in the world."""
        rows = self.frame(self._offset(point).frame).rows
        return {
            i: multiply_rows(rows, way) for i, way in self._slopes(self.stretch(point)[0]).items()
        }

    def position(self, point: Point) -> Triple:
        """Return the place of a point [m] in the world."""
        return self._know("r", point, self._find_position)

    def _find_position(self, point: Point) -> Triple:
        if point.base is None:
            return NOTHING
        total = add_triples(self.position(point.base), self.offset(point))
        return self._name_node("r", point, "m", total)

    def _swept(self, point: Point) -> Triple:
        """Return the velocity against the base that the turn of the offset's frame gives."""
        spin = self.spin(self._offset(point).frame).components
        swept = multiply_cross(spin, self.offset(point))
        return self._name_node("u", point, "m/s", swept)

    def velocity(self, point: Point, frame: Frame) -> Vec:
        """Return the velocity of a point [m/s] along the axes of a frame."""
        return self.resolve(Vec(self.world, self._know("v", point, self._find_velocity)), frame)

    def _find_velocity(self, point: Point) -> Triple:
        if point.base is None:
            return NOTHING
        swept = self._know("u", point, self._swept)
        rows = self.frame(self._offset(point).frame).rows
        stretch = multiply_rows(rows, self.stretch(point)[0])
        before = self.velocity(point.base, self.world).components
        return self._name_node("v", point, "m/s", add_triples(before, swept, stretch))

    def acceleration(self, point: Point, frame: Frame) -> Vec:
        """Return the absolute acceleration of a point [m/s2] along the axes of a frame."""
        return self.resolve(Vec(self.world, self._know("a", point, self._find_acceleration)), frame)

    def _find_acceleration(self, point: Point, names: Sequence[Quantity] = ()) -> Triple:
        if point.base is None:
            return NOTHING
        frame = self._offset(point).frame
        rows, (once, twice) = self.frame(frame).rows, self.stretch(point)
        relative = add_triples(
            self._know("u", point, self._swept), scale_triple(S(2), multiply_rows(rows, once))
        )
        total = add_triples(
            self.acceleration(point.base, self.world).components,
            multiply_cross(self.turning(frame), self.offset(point)),
            multiply_cross(self.spin(frame).components, relative),
            multiply_rows(rows, twice),
        )
        if names:
            pairs = zip(names, total, strict=True)
            x, y, z = (c if c == 0 else self.define(symbol, c, MOTION) for symbol, c in pairs)
            return x, y, z
        return self._name_node("a", point, "m/s2", total)

    def name_accelerations(self, points: Iterable[tuple[Point, Sequence[Quantity]]]) -> None:
        """Define names for the accelerations of points; components that are zero have none."""
        for point, symbols in points:
            self._cache["a", point] = self._find_acceleration(point, symbols)

    def spin_ways(self, frame: Frame) -> Slopes:
        """Return the slopes of a frame's angular velocity in the rates, in the world."""
        if frame not in self._spin_ways:
            parent = self.frame(frame).parent
            before = {} if parent is None else self.spin_ways(parent)
            self._spin_ways[frame] = add_slopes([before, self.spin_slopes(frame)])
        return self._spin_ways[frame]

    def velocity_ways(self, point: Point) -> Slopes:
        """Return the slopes of a point's velocity in the rates, in the world."""
        if point.base is None:
            return {}
        if point not in self._velocity_ways:
            spins = self.spin_ways(self._offset(point).frame).items()
            swept = {i: multiply_cross(spin, self.offset(point)) for i, spin in spins}
            parts = [self.velocity_ways(point.base), swept, self.stretch_slopes(point)]
            self._velocity_ways[point] = add_slopes(parts)
        return self._velocity_ways[point]

    def arm(self, start: Point, end: Point, frame: Frame) -> Vec:
        """Return the vector from one point to another [m] along the axes of a frame."""
        return self.resolve(Vec(self.world, self.reach(start, end)), frame)

    def reach(self, start: Point, end: Point) -> Triple:
        """Return the vector from one point to another [m] in the world."""
        before, after = start.chain(), end.chain()
        forward = [p for p in after if p not in before]
        back = [p for p in before if p not in after]
        if len(forward) + len(back) > NEAR:
            return add_triples(
                self.position(end), scale_triple(S.NegativeOne, self.position(start))
            )
        behind = [scale_triple(S.NegativeOne, self.offset(p)) for p in back]
        return add_triples(NOTHING, *(self.offset(p) for p in forward), *behind)

    # --- bodies -----------------------------------------------------------------------------------

    def tensor(self, tensor: Rows, frame: Frame) -> Rows:
        """Return an inertia [kg m2] along the axes of a frame by those of the world."""
        key = frame, tensor
        if key not in self._tensors:
            rows = self.frame(frame).rows
            carried = [multiply_rows(tensor, row) for row in rows]
            entries: dict[tuple[int, int], Expr] = {}
            for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
                stem = f"I_{word(frame.name)}_{AXES[i]}{AXES[j]}"
                entry = self.name(stem, "kg m2", dot_product(rows[i], carried[j]))
                entries[i, j] = entries[j, i] = entry
            x, y, z = ((entries[i, 0], entries[i, 1], entries[i, 2]) for i in range(3))
            self._tensors[key] = x, y, z
        return self._tensors[key]

    def angular_momentum(self, tensor: Rows, frame: Frame) -> Vec:
        """Return the angular momentum of an inertia [kg m2/s], in the world."""

        def find(_: object) -> Triple:
            spin = self.spin(frame).components
            momentum = multiply_rows(self.tensor(tensor, frame), spin)
            if spin[:2] == (0, 0):  # in the plane it is needed but once
                return momentum
            return self._name_node("L", frame, "kg m2/s", momentum)

        return Vec(self.world, self._know("L", (frame, tensor), find))

    def momentum_rate(self, tensor: Rows, frame: Frame) -> Vec:
        """Return the rate of that [N m]."""
        momentum = self.angular_momentum(tensor, frame).components
        swept = multiply_cross(self.spin(frame).components, momentum)
        return Vec(
            self.world,
            add_triples(multiply_rows(self.tensor(tensor, frame), self.turning(frame)), swept),
        )

    # --- loads ------------------------------------------------------------------------------------

    def collect_power(
        self, forces: dict[Point, list[Triple]], moments: dict[Frame, list[Triple]]
    ) -> list[Expr]:
        """Return the virtual power of forces [N] at points and moments [N m] on frames, on the rate
        of each coordinate: what acts on a point acts on its base, and turns the frame between them.
        """
        power: list[list[Expr]] = [[] for _ in self.coordinates]
        carriers = dict.fromkeys(base for point in forces for base in point.chain())
        for point in reversed(carriers):
            if point.base is None:
                continue
            force = self._name_node("f", point, "N", add_triples(*forces[point]))
            turned = multiply_cross(self.offset(point), force)
            forces.setdefault(point.base, []).append(force)
            moments.setdefault(self._offset(point).frame, []).append(turned)
            for i, way in self.stretch_slopes(point).items():
                power[i].append(dot_product(way, force))
        turning = dict.fromkeys(parent for frame in moments for parent in self.chain(frame))
        for frame in reversed(turning):
            parent = self.frame(frame).parent
            if parent is None:
                continue
            moment = self._name_node("n", frame, "N m", add_triples(*moments[frame]))
            moments.setdefault(parent, []).append(moment)
            for i, way in self.spin_slopes(frame).items():
                power[i].append(dot_product(way, moment))
        return [sp.Add(*parts) for parts in power]

    def chain(self, frame: Frame) -> list[Frame]:
        """Return the frames from the world to one."""
        parent = self.frame(frame).parent
        return [frame] if parent is None else [*self.chain(parent), frame]


def _place_on(axis: int, size: Expr) -> Triple:
    x, y, z = (size if i == axis else S.Zero for i in range(3))
    return x, y, z


def _terms(angle: Expr) -> set[Expr]:
    return set() if angle == 0 else set(sp.Add.make_args(angle))


def _count_terms(frame: Frame) -> int:
    """Return the terms of all angles up to the root."""
    count = 0
    while frame.parent is not None:
        count += 1 if isinstance(frame.angle, Quaternion) else len(_terms(frame.angle))
        frame = frame.parent
    return count
