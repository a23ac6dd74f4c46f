"""A machine as values and composed functions, in SI units and radians: the input of every general
computation.

d (v,) are all values of a machine, x (p,) those of them that a search may move, h (k,) what no
angle changes, q (c,) the coordinates of its closed loops, and phi the angle of its drive. Equal
sides are at `offsets` from each other.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Protocol

import casadi as ca
import numpy as np

from planter import paths
from planter.engine.loops import KinematicLoops
from planter.engine.measures import Limit, Measure, PointDistance, parse_distance
from planter.engine.piecewise import build_clearance, build_distance, build_separation, read_curve
from planter.errors import InputError
from planter.files import examples, units
from planter.files.examples import find_kind, load_part
from planter.files.spelling import find_spelled, list_spellings
from planter.kernels import Array, Kernel

if TYPE_CHECKING:
    from planter.engine.sections import GeneticAlgorithm
    from planter.engine.solvers.constraints import Constraints
    from planter.engine.solvers.curve_sum import Sampling
    from planter.files.document import Document

Role = Literal["result", "law", "pivot", "states", "place", "distance", "size"]
"""What a quantity is: a result, the residual of a law, the least pivot of an elimination, a number
of states, a coordinate of a point of a body, the distance of a point, or the size of a vector.
"""
COMPOSED: tuple[Role, ...] = ("place", "distance", "size")
"""Roles of quantities that a machine adds when they are asked for."""
SIZE_EPS = 1e-12
"""Regularises the size of a vector at zero, where it has no derivative: sqrt(s^2 + eps^2) [SI]."""
LEAST_PIVOT = 1e-12
"""Simultaneous equations with a smaller pivot determine nothing."""
PLACES = "places"
"""Name of the stage with the coordinates of points of bodies."""
MOST_SAMPLES = 100_000
"""Largest number of samples of a cycle."""


@dataclass(frozen=True)
class Value:
    """A number that a machine takes; `path` is its place in the machine's file and ends in the unit
    there.

    `source` says where the symbol is from, such as an equation of a paper. `limits` are the least
    and the greatest number that the file may hold, in its unit, None if the file has no limits.
    """

    name: str
    unit: str
    meaning: str
    path: str
    source: str = ""
    limits: tuple[float | None, float | None] = (None, None)

    @property
    def key(self) -> str:
        """The last part of the path."""
        return self.path.rpartition(".")[2]

    @property
    def factor(self) -> float:
        """SI units per unit of the file."""
        return units.unit_factor(self.path)


@dataclass(frozen=True)
class Quantity:
    """A result or check of a machine at an angle: of one side, or, if it is a `total`, of all sides
    together.

    `key` is its name in results and ends in the unit there. `axes` names the frame by whose axes a
    component is given, unless it is the world's. `is_push` holds for the force of a contact that
    cannot pull. `reference` is the source of its equation.
    """

    name: str
    unit: str
    meaning: str
    key: str
    total: bool = False
    role: Role = "result"
    axes: str | None = None
    is_push: bool = False
    source: str = ""

    @property
    def factor(self) -> float:
        """SI units per unit of the key."""
        return units.unit_factor(self.key)


@dataclass(frozen=True)
class Vector:
    """A vector by the names of its components, which have one unit and one frame."""

    name: str
    meaning: str
    components: tuple[str, ...]


@dataclass(frozen=True)
class MachineStage:
    """A function (phi, d, h, q) -> values (m,) along the angle of a machine, and what these are."""

    function: ca.Function
    quantities: tuple[Quantity, ...]


@dataclass(frozen=True)
class FreeMotion:
    """The motion of a machine that no angle drives: a turn of it is the time from 0 to `span` [s].

    `respond` makes the responses of its quantities (as `planter.engine.response.MachineResponse`),
    whose states follow from `motions`, which are integrated; `extend` gives the machine over
    another span [s].
    """

    span: float
    motions: Any
    respond: Callable[..., Any]
    extend: Callable[[float], Machine]


@dataclass(frozen=True)
class Documentation:
    """Texts about a machine: its title, the reference of its model, and its equations.

    `variant` is the name of another model of the same machine; it is empty for the usual one.
    """

    title: str
    reference: str
    equations: tuple[str, ...] = ()
    variant: str = ""


@dataclass(frozen=True)
class Machine:
    """A machine that an angle drives, or whose free `motion` the time takes through its states q.

    Functions: `prologue` d -> h, `lane` (phi, d, h, q) -> quantities of a side, `totals` (one, two,
    d) -> quantities of both sides, `events` (phi, d, h, q) -> values whose zeros are kinks,
    `tangent` moved values -> (d -> h, dh). `speed` is the index of the drive's speed [rad/s] among
    the values; `period` [rad] is that of the totals. `turn` [rad] is the angle of a cycle, after
    which a side repeats. A drive over a limited range goes there and back in a cycle: its lane
    takes any angle, and it has no loops. `vectors` are the quantities whose size counts; `motors`
    names the torques of motors. `acceleration` is the index of the drive's acceleration [rad/s2]
    among the values, if it is one; `losses` names powers of friction, `energies` quantities that
    add up to all energy, if they are reported. `document` is the file that it was read from, and
    `build` makes the machine of a file of its kind; pickles can be made of both. `objective` is the
    sum of measures that the file minimises under `limits`, over true extremes or samples as
    `sampling` says; `genetic` are its settings of the genetic algorithm. `angle` is the name of the
    drive's angle. `requirements` makes the constraints on its own design that the file states
    besides limits, if it has any; `subject` is the object that states the machine, if its package
    adds to the results of commands (`planter.mechanism.extension`). `stages` are further functions
    along the angle: `places` of points of bodies, `followers` and `meshes` of cams and gears.
    """

    document: Document
    build: Callable[[Any], Machine]
    assumptions: tuple[str, ...]
    values: tuple[Value, ...]
    data: Array
    moved: tuple[int, ...]
    lower: Array
    upper: Array
    quantities: tuple[Quantity, ...]
    prologue: ca.Function
    lane: ca.Function
    speed: int
    loops: KinematicLoops | None = None
    totals: ca.Function | None = None
    events: ca.Function | None = None
    event_kinds: tuple[Mapping[str, Any], ...] = ()
    offsets: tuple[float, ...] = (0.0,)
    samples: int = 360
    turn: float = 2 * np.pi
    tangent: Callable[[tuple[int, ...]], ca.Function] | None = None
    vectors: tuple[Vector, ...] = ()
    motors: tuple[str, ...] = ()
    acceleration: int | None = None
    losses: tuple[str, ...] = ()
    energies: tuple[str, ...] = ()
    stages: Mapping[str, MachineStage] = field(default_factory=dict)
    objective: tuple[Measure, ...] = ()
    limits: tuple[Limit, ...] = ()
    sampling: Sampling = "refined"
    genetic: GeneticAlgorithm | None = None
    requirements: Callable[[], Constraints] | None = None
    subject: object = None
    angle: str = "phi"
    documentation: Documentation = Documentation("", "")
    motion: FreeMotion | None = None
    states: int = 0

    @property
    def name(self) -> str:
        """The name in the file."""
        return self.document.name

    @property
    def source(self) -> str:
        """The file, or the built-in name, that the machine was loaded from."""
        return self.document.source

    @property
    def meanings(self) -> dict[str, str]:
        """Meanings of the values, by path."""
        return {value.path: value.meaning for value in self.values}

    @property
    def objective_samples(self) -> int:
        """Samples of a cycle that stand for the file's objective where true extremes do not."""
        return self.samples if self.sampling == "refined" else self.sampling

    @property
    def design(self) -> Array:
        """The machine's own design (p,)."""
        return self.data[list(self.moved)]

    @property
    def design_names(self) -> tuple[str, ...]:
        """Names of the moved values, each of which ends in its unit in the file: keys, or paths if
        keys are shared.
        """
        keys = [value.key for value in self.values]
        moved = [self.values[index] for index in self.moved]
        return tuple(value.key if keys.count(value.key) == 1 else value.path for value in moved)

    @property
    def moved_paths(self) -> tuple[str, ...]:
        """Paths of the moved values."""
        return tuple(self.values[index].path for index in self.moved)

    @property
    def scale(self) -> Array:
        """SI units per unit of the file, of the moved values (p,)."""
        return np.array([self.values[index].factor for index in self.moved])

    @property
    def period(self) -> float:
        """The angle after which totals of equal sides repeat [rad]."""
        return self.turn / len(self.offsets)

    @property
    def results(self) -> tuple[Quantity, ...]:
        """The quantities that are results."""
        return tuple(quantity for quantity in self.quantities if quantity.role == "result")

    def find_quantity(self, name: str) -> Quantity:
        """Return a quantity, the size of a vector, or the distance or clearance of a point, by any
        spelling of a name.

        Spellings are those of `planter.files.spelling`; coordinates of points of bodies have the
        names x_BODY__POINT and y_BODY__POINT. Raises InputError, with names that are close, if it
        is unknown or fits several, and for a file without a curve.
        """
        distance = parse_distance(name)
        if distance is not None:
            return self._add_distance(distance)
        quantity = self._find_coordinate(name)
        if quantity is not None:
            return quantity
        matches = find_spelled(name, self.spellings)
        if len(matches) != 1:
            raise self._refuse("quantity", name, matches or list(self.spellings))
        vector = next((vector for vector in self.vectors if vector.name == matches[0]), None)
        if vector is not None:
            return self._add_size(vector, self._find_size(vector))
        return next(quantity for quantity in self.quantities if quantity.name == matches[0])

    @cached_property
    def spellings(self) -> dict[str, tuple[str, ...]]:
        """The spellings of quantities and of sizes of vectors, by their names; a quantity's come
        before a vector's.
        """
        named = {vector.name: self._find_size(vector) for vector in self.vectors}
        parts = {vector.name: vector.components for vector in self.vectors}
        named = {quantity.name: quantity for quantity in self.quantities} | named
        ways = {
            name: list_spellings(name, q.key, q.meaning, parts.get(name, ()))
            for name, q in named.items()
        }
        taken = {way for name, spelled in ways.items() if name not in parts for way in spelled}
        return {
            name: spelled
            if name not in parts
            else tuple(way for way in spelled if way == name or way not in taken)
            for name, spelled in ways.items()
        }

    def _find_coordinate(self, name: str) -> Quantity | None:
        """Return a quantity of the machine or a coordinate of a point of a body by its name or key,
        or None.
        """
        for quantity in self.quantities:
            if name in (quantity.name, quantity.key):
                return quantity
        stage = self.stages.get(PLACES)
        for index, quantity in enumerate(stage.quantities if stage else ()):
            if name in (quantity.name, quantity.key):
                if quantity.name not in self._composed:
                    self._composed[quantity.name] = self._places[index]
                return replace(quantity, role="place")
        return None

    @cached_property
    def _places(self) -> ca.SX:
        """The graph of the coordinates of points of bodies, where the lane closes the loops.

        It is the lane that carries the derivatives of the loops' coordinates, which are inputs.
        """
        phi, d, h, q = self.symbols
        closed = q if self.loops is None else ca.vertcat(*map(self.graph, self.loops.names))
        return self.stages[PLACES].function(phi, d, h, closed)

    def find_point(self, point: Sequence[str]) -> tuple[Quantity, ...]:
        """Return the coordinates x, y and, in space, z of a point by its name, or x and y by
        theirs.

        Raises InputError, with names that are close, if it is unknown.
        """
        if len(point) == 2:
            return tuple(self.find_quantity(name) for name in point)
        (name,) = point
        for form in ("{axis}_{name}", "{name}_{axis}"):
            named = (self._find_coordinate(form.format(axis=axis, name=name)) for axis in "xyz")
            coordinates = tuple(quantity for quantity in named if quantity is not None)
            if len(coordinates) > 1:
                return coordinates
        raise self._refuse("point", name, self.list_points())

    def list_points(self) -> list[str]:
        """Return the names of the points whose coordinates x and y are results, then of those of
        bodies.
        """
        stage = self.stages.get(PLACES)
        names = [
            q.name for q in (*self.results, *(stage.quantities if stage else ())) if q.unit == "m"
        ]
        points = [name[2:] for name in names if name.startswith("x_") and f"y_{name[2:]}" in names]
        return points + [
            name[:-2] for name in names if name.endswith("_x") and f"{name[:-2]}_y" in names
        ]

    def list_parts(self, name: str) -> tuple[str, ...]:
        """Return the names of the quantities that one is made of: itself, or those of a distance or
        a vector.
        """
        distance = parse_distance(name)
        if distance is not None:
            points = [self.find_point(point) for point in (distance.point, distance.other) if point]
            return tuple(quantity.name for point in points for quantity in point)
        vector = next(
            (vector for vector in self.vectors if vector.name == self.find_quantity(name).name),
            None,
        )
        return tuple(
            self.find_quantity(part).name
            for part in ((name,) if vector is None else vector.components)
        )

    def _find_size(self, vector: Vector) -> Quantity:
        first = next(
            quantity for quantity in self.quantities if quantity.name == vector.components[0]
        )
        key = units.display_key(vector.name, first.unit)
        return Quantity(vector.name, first.unit, vector.meaning, key, role="size")

    def _add_size(self, vector: Vector, size: Quantity) -> Quantity:
        """Return the size of a vector as a quantity, and add its graph."""
        if vector.name not in self._composed:
            square = ca.sumsqr(ca.vertcat(*map(self.graph, vector.components)))
            self._composed[vector.name] = ca.sqrt(square + SIZE_EPS**2)
        return size

    def _add_distance(self, distance: PointDistance) -> Quantity:
        """Return a distance as a quantity, and add its graph.

        Raises InputError as `find_quantity`.
        """
        coordinates = self.find_point(distance.point)
        other_coordinates = self.find_point(distance.other) if distance.other else ()
        for quantity in (*coordinates, *other_coordinates):
            if quantity.unit != "m":
                unit = quantity.unit or "1"
                reason = (
                    f"{quantity.name} is in {unit}, but it must be a length, a coordinate of "
                    f"a point"
                )
                raise InputError(f"{self.source}: {distance}: {reason}")
        if len(coordinates) != (len(other_coordinates) or 2):
            other = (
                "a curve in a file"
                if not other_coordinates
                else f"the {len(other_coordinates)} of the other point"
            )
            reason = (
                f"{' '.join(distance.point)} has {len(coordinates)} coordinates, which do "
                f"not go with {other}"
            )
            raise InputError(
                f"{self.source}: {distance}: {reason}: give points in the plane by x and y of both"
            )
        distance = replace(distance, point=_name_point(distance.point, coordinates))
        if other_coordinates:
            distance = replace(distance, other=_name_point(distance.other, other_coordinates))
        point = _describe_point(distance.point)
        other = (
            _describe_point(distance.other) if distance.other else f"the curve of {distance.file}"
        )
        meaning = f"distance of {point} from {other}"
        if distance.word == "clearance":
            meaning = f"height of {point} over the ground of {distance.file}"
        if str(distance) not in self._composed:
            graphs, separated = (
                [self.graph(quantity.name) for quantity in quantities]
                for quantities in (coordinates, other_coordinates)
            )
            if separated:
                graph = build_separation(graphs, separated)
            else:
                keys = coordinates[0].key, coordinates[1].key
                points = read_curve(
                    distance.find_file(self.source), keys, distance.word == "clearance"
                )
                build = build_clearance if distance.word == "clearance" else build_distance
                graph = build(graphs[0], graphs[1], points)
            self._composed[str(distance)] = graph
        return Quantity(str(distance), "m", meaning, f"{distance.word}_mm", role="distance")

    @cached_property
    def _composed(self) -> dict[str, ca.SX]:
        return {}

    def find_index(self, path: str) -> int:
        """Return the index of a value by its path or key.

        Raises InputError, with names that are close, for none.
        """
        for attribute in ("path", "key"):
            indices = [
                i for i, value in enumerate(self.values) if getattr(value, attribute) == path
            ]
            if len(indices) == 1:
                return indices[0]
        raise self._refuse("value", path, [value.path for value in self.values])

    def _refuse(self, kind: str, name: str, names: Sequence[str]) -> InputError:
        """Return the error for an unknown name, with names that are close."""
        close = paths.find_similar(name, names)
        hint = (
            f"did you mean {' or '.join(close)}?"
            if close
            else f"it must be one of {', '.join(names)}"
        )
        return InputError(f"{self.source}: {self.name} has no {kind} {name}: {hint}")

    def with_moved(self, bounds: Mapping[str, tuple[float, float]]) -> Machine:
        """Return the machine with other values to move, by path, each with its bounds in the unit
        of the file.
        """
        moved = tuple(self.find_index(path) for path in bounds)
        factors = np.array([self.values[index].factor for index in moved])
        ends = np.array(list(bounds.values()), dtype=float).reshape(-1, 2) * factors[:, None]
        return replace(self, moved=moved, lower=ends[:, 0], upper=ends[:, 1])

    def with_ranges(
        self, ranges: Mapping[str, tuple[float, float]], label: str = "--vary"
    ) -> Machine:
        """Return the machine with other values to move, as `with_moved`, or itself without ranges.

        Raises InputError, which names the range, for an end that its file refuses, for an unknown
        value, and for a file with requirements, which are on its own design.
        """
        if ranges and self.requirements is not None:
            reason = (
                "they are on the values of its design; leave out the section, or state "
                "limits by --hold"
            )
            raise InputError(
                f"{label} does not go with the [requirements] of {self.source}: {reason}"
            )
        for path, (low, high) in ranges.items():
            if not low < high:
                raise InputError(f"{label} {path}={low:g}:{high:g}: LOW must be below HIGH")
            full = self.values[self.find_index(path)].path
            for end in (low, high):
                self.document.with_numbers({full: end})
        return self.with_moved(ranges) if ranges else self

    @property
    def searched(self) -> dict[str, Any]:
        """The fields that a search may set otherwise than the file does: values, which of them
        move, between what.
        """
        return {name: getattr(self, name) for name in ("data", "moved", "lower", "upper")}

    def with_span(self, span: float) -> Machine:
        """Return the machine that moves freely over another span of time [s]."""
        assert self.motion is not None
        return replace(self.motion.extend(span), **self.searched)

    def with_data(self, data: Array) -> Machine:
        """Return the machine with other values (v,) in SI."""
        return replace(self, data=np.asarray(data, dtype=float))

    def with_numbers(self, changes: Mapping[str, float]) -> Machine:
        """Return the machine of its file with some numbers set, by path in the unit of the file.

        Raises as the file.
        """
        return self.build(self.document.with_numbers(changes))

    def with_speed(self, speed_rpm: float) -> Machine:
        """Return the machine of its file with another speed of the drive [r/min].

        Raises InputError if no angle drives it.
        """
        if self.motion is not None:
            raise InputError(f"--speed-rpm does not apply to {self.name}: no angle drives it")
        speed = self.values[self.speed]
        return self.with_numbers(
            {speed.path: speed_rpm * units.unit_factor("speed_rpm") / speed.factor}
        )

    def list_angles(self, count: int | None = None) -> Array:
        """Return the angles (n,) [rad] of a cycle in equal steps, `samples` unless a count is
        given.
        """
        count = self.samples if count is None else count
        return self.turn * np.arange(count) / count

    @property
    def guards(self) -> tuple[Quantity, ...]:
        """The quantities that show whether forces are determined: pivots, then numbers of
        states.
        """
        return tuple(q for role in ("pivot", "states") for q in self.quantities if q.role == role)

    def build_data(self, x: Array) -> Array:
        """Return all values (v,) at a design x (p,)."""
        data = self.data.copy()
        data[list(self.moved)] = x
        return data

    def create_symbol(self, name: str, size: int) -> Any:
        """Return a column of symbols of the type, SX or MX, that the prologue takes."""
        return (ca.SX if self.prologue.is_a("SXFunction") else ca.MX).sym(name, size)

    @cached_property
    def symbols(self) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """Symbols of phi, d, h and q."""
        coordinates = self.loops.size if self.loops else self.states
        sizes = {"phi": 1, "d": len(self.values), "h": self.prologue.numel_out(0), "q": coordinates}
        phi, d, h, q = (ca.SX.sym(name, size) for name, size in sizes.items())
        return phi, d, h, q

    def rows(self, names: Sequence[str]) -> tuple[ca.SX, tuple[bool, ...]]:
        """Return the graph of quantities (m,) at an angle, and which of them are to be added up
        over the sides.

        Added up are totals that are sums of equal shares of the sides: their row is the share of
        one side.
        """
        totals = [quantity.name for quantity in self.quantities if quantity.total]
        rows, shared = [], []
        for name in (self.find_quantity(name).name for name in names):
            share = self._share(totals.index(name)) if name in totals else None
            rows.append(self.graph(name) if share is None else share)
            shared.append(share is not None)
        return ca.densify(ca.vertcat(*rows)), tuple(shared)

    def graph(self, name: str) -> ca.SX:
        """Return the graph of a quantity at an angle, of all sides if it is a total."""
        quantity = self.find_quantity(name)
        if quantity.role in COMPOSED:
            return self._composed[quantity.name]
        names = [other.name for other in self.quantities if other.total == quantity.total]
        graph: ca.SX = (self._both if quantity.total else self._side)[names.index(quantity.name)]
        return graph

    @cached_property
    def _side(self) -> ca.SX:
        return self.lane(*self.symbols)

    @cached_property
    def _both(self) -> ca.SX:
        phi, d, h, q = self.symbols
        assert self.totals is not None
        return self.totals(*(self.lane(phi + offset, d, h, q) for offset in self.offsets), d)

    def _share(self, index: int) -> ca.SX | None:
        """Return the share of a side in a total, or None if the total is not a sum of equal
        shares.
        """
        assert self.totals is not None
        phi, d, h, q = self.symbols
        first, second = (
            ca.SX.sym(name, self.totals.size1_in(i)) for i, name in enumerate(("one", "two"))
        )
        total = self.totals(first, second, d)[index]
        if ca.jacobian(ca.gradient(total, first), second).nnz():
            return None
        function = ca.Function("total", [first, second, d], [total], ["one", "two", "d"], ["total"])
        if not _is_symmetric(function):
            return None
        none = ca.SX.zeros(first.numel())
        return function(self.lane(phi, d, h, q), none, d) - function(none, none, d) / 2


class HasMachine(Protocol):
    """An object that states a machine of the engine."""

    @property
    def engine(self) -> Machine:
        """The machine."""


def to_machine(stated: Machine | HasMachine) -> Machine:
    """Return a machine, or the one that an object states."""
    return stated if isinstance(stated, Machine) else stated.engine


def build_vectors(
    components: Mapping[str, tuple[str, ...]], quantities: Sequence[Quantity]
) -> Iterator[Vector]:
    """Yield vectors by the names of their components, those of which all are there; the first says
    what they mean.
    """
    by_name = {quantity.name: quantity for quantity in quantities}
    for name, parts in components.items():
        if all(part in by_name for part in parts):
            yield Vector(name, describe_vector(name, by_name[parts[0]].meaning), parts)


def describe_vector(name: str, meaning: str) -> str:
    """Return the meaning of a vector from that of its first component."""
    return meaning.rpartition(", ")[0] or meaning.partition(" ")[2] or name


def _name_point(point: tuple[str, ...], coordinates: tuple[Quantity, ...]) -> tuple[str, ...]:
    """Return a point by its name if it has been given by that, else by the names, not the keys, of
    its coordinates.
    """
    return point if len(point) == 1 else tuple(quantity.name for quantity in coordinates)


def _describe_point(point: tuple[str, ...]) -> str:
    return f"the point {point[0]}" if len(point) == 1 else f"the point at {', '.join(point)}"


def _is_symmetric(total: ca.Function) -> bool:
    """Return whether a function of both sides stays the same when they are exchanged, at random
    values.
    """
    rng, kernel = np.random.default_rng(1), Kernel(total)
    first, second, d = (rng.uniform(0.5, 1.5, total.size1_in(i)) for i in range(3))
    pairs = ((first, second), (second, first))
    value, exchanged = (float(kernel(one=a, two=b, d=d)["total"][0, 0]) for a, b in pairs)
    return abs(value - exchanged) <= 1e-12 * abs(value)


def load_driven_machine(
    source: str,
    changes: Mapping[str, float] | None = None,
    speed_rpm: float | None = None,
    **choices: str,
) -> Machine:
    """Return the machine of a file, or of a built-in name, that an angle drives.

    Raises InputError as `load_machine`, and for one that moves freely.

    >>> load_driven_machine("wang2017", {"R3_mm": 31.0}).name
    'wang2017'
    """
    machine = load_machine(source, changes, speed_rpm, **choices)
    if machine.motion is not None:
        message = f"no angle drives {machine.name}; run `planter simulate` for its free motion"
        raise InputError(f"{source}: {message}")
    return machine


def load_machine(
    source: str,
    changes: Mapping[str, float] | None = None,
    speed_rpm: float | None = None,
    **choices: str,
) -> Machine:
    """Return the machine of a file, or of a built-in name, some numbers [in the units of their
    paths] changed.

    `changes` holds numbers by path or key, as ``{"r_mm": 50}``; `speed_rpm` is another speed of the
    drive [r/min]. Further keywords are choices that some machines leave, such as the model. Raises
    InputError if there is no such machine, for an invalid number, or for a choice that the machine
    does not leave.
    """
    module = find_kind(source) or load_part(source, "machines")  # which says what a file lacks
    if module is None:
        examples.refuse_machine(source)
    for name, choice in choices.items():
        if name not in inspect.signature(module.load).parameters:
            raise InputError(f"--{name} {choice} does not apply to {source}: it has one {name}")
    machine: Machine = module.load(source, changes or {}, **choices)
    return machine if speed_rpm is None else machine.with_speed(speed_rpm)


def check_samples(samples: int | None, fewest: int = 4) -> None:
    """Raise InputError for a number of samples of a cycle that is out of range; None leaves it to
    the machine file.
    """
    if samples is not None and not fewest <= samples <= MOST_SAMPLES:
        raise InputError.for_value(
            "--samples", samples, f"it must be between {fewest} and {MOST_SAMPLES}"
        )


@dataclass(frozen=True)
class FunctionSignature:
    """A function of a machine: its inputs, and the numbers of its outputs and operations."""

    name: str
    inputs: tuple[str, ...]
    outputs: int
    operations: int | None = None


@dataclass(frozen=True)
class Description:
    """The description of a machine; `data` (v,) are its values in SI, `bounds` in the units of
    their paths.

    `origins` has the sources of values by path.
    """

    name: str
    title: str
    source: str
    assumptions: tuple[str, ...]
    values: tuple[Value, ...]
    data: Array
    bounds: Mapping[str, tuple[float, float]]
    origins: Mapping[str, str]
    quantities: tuple[Quantity, ...]
    functions: tuple[FunctionSignature, ...]
    vectors: tuple[Vector, ...] = ()


def describe_source(source: str, changes: Mapping[str, float]) -> Description:
    """Return the description of the machine of a file or a built-in name.

    Raises InputError as `load_machine`.

    A plug-in for machines without a driving angle describes them by a function
    `describe(source, changes)`.
    """
    module = find_kind(source)
    describe = getattr(module, "describe", None)
    description: Description = (
        describe(source, changes) if describe else describe_machine(load_machine(source, changes))
    )
    return description


def describe_machine(machine: Machine) -> Description:
    """Return the description of a machine that an angle drives."""
    functions = {
        "prologue": machine.prologue,
        "lane": machine.lane,
        "totals": machine.totals,
        "events": machine.events,
    }
    if machine.loops is not None:
        functions |= {"assembly": machine.loops.assembly, "closure": machine.loops.gaps}
    ends = zip(
        machine.moved, machine.lower / machine.scale, machine.upper / machine.scale, strict=True
    )
    return Description(
        name=machine.name,
        title=machine.name,
        source=machine.source,
        assumptions=machine.assumptions,
        values=machine.values,
        data=machine.data,
        bounds={machine.values[index].path: (float(low), float(high)) for index, low, high in ends},
        origins={},
        quantities=machine.quantities,
        functions=tuple(
            FunctionSignature(name, tuple(function.name_in()), function.numel_out(0))
            for name, function in functions.items()
            if function is not None
        ),
        vectors=machine.vectors,
    )
