"""Statement of a mechanism: bodies, joints, named quantities, and points for drawings."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Literal

import sympy as sp
from sympy import Expr, S

from ..equations import Balance, Equation, Kind
from ..model import Event, Let, Step, let
from ..quantity import DimensionError, Quantities, Quantity, Vector, dimension, of_unit, word
from .bodies import AXES, EVERY, PLANE, Action, Asked, Assembly, Body, Pin
from .frames import Frame, Motion, Point, Triple, Vec, displacement, zero
from .loops import Loops


class MechanismError(ValueError):
    """A mechanism is stated so that nothing can be derived from it."""


@dataclass(frozen=True)
class Element:
    """Drawing between the bodies ``on`` and ``by``: of a spring or strut its ``ends``, of a guide
    a point on it and one a length of one farther along. Of a cam ``by``, they are its axis, the
    centre of its roller, a point a length of one from the axis that turns with it, and one a length
    of one from the centre, along the normal of the centre's path away from the cam; ``radius`` is
    that of its roller, zero if it is not stated.
    """

    kind: Literal["spring", "strut", "guide", "cam"]
    on: str
    by: str
    ends: tuple[Vec, ...]
    radius: Expr = S.Zero

    def describe(self) -> dict[str, str]:
        """Return the kind and the bodies."""
        return {"kind": self.kind, "on": self.on, "by": self.by}

    def list_components(self, name: str, axes: Sequence[str]) -> Iterator[Let]:
        """Yield ``NAME_x_1``, ``NAME_x_2`` and their like, and ``NAME_radius`` of a roller [m]."""
        for number, end in enumerate(self.ends, 1):
            for axis, component in zip(axes, end.components, strict=False):
                meaning = f"end {number} of the {self.kind} {name}, {axis}"
                yield let(quantity(f"{word(name)}_{axis}_{number}", "m", meaning), component)
        if self.radius != 0:
            yield let(quantity(f"{word(name)}_radius", "m", f"radius of {name}"), self.radius)


class Statement:
    """A mechanism as it was stated, for the derivations; `Mechanism` is how it is stated."""

    def __init__(
        self,
        name: str,
        given: Quantities,
        angle: Quantity | None,
        motion: Motion,
        gravity: Sequence[Expr],
        spatial: bool,
        world: Frame,
    ) -> None:
        self.name, self.given, self.angle, self.motion, self.spatial = (
            name,
            given,
            angle,
            motion,
            spatial,
        )
        self.world, self.O = world, Point("O")
        self.assembly = Assembly(motion, Vec(self.world, to_triple(gravity)))
        self.ground = self.assembly.add(Body("ground", self.world))
        self.origin, self.earth = (
            self.O,
            self.ground,
        )  # at rest, also where O and ground move on a mount
        self.loops = Loops()
        self.slips: dict[str, Expr] = {}
        self.reactive: dict[
            str, str
        ] = {}  # names of reactions, used where no joint carries the gap or slip
        self.inputs: dict[str, tuple[float | None, float | None]] = {}  # with their bounds
        self.start: dict[sp.Symbol, Expr] = {} if angle is None else {angle: S.Zero}
        self.held_entries: list[str] | None = None  # what of the start holds, if anything is said
        self.start_conditions: dict[
            str, tuple[Expr, Expr]
        ] = {}  # a gap and its speed, closed at the start only
        self.potentials: list[Expr] = []
        self.steps: list[Step] = []
        self.reports: list[Let] = []
        self.events: list[Event] = []
        self.impacts: dict[str, tuple[Expr, Expr]] = {}  # gaps, and restitutions
        self.shared: list[Body] = []
        self.rolling: dict[str, tuple[Body, Body, Point]] = {}
        self.meshing: dict[str, tuple[Body, Body, Point]] = {}
        self.pushing: list[Quantity] = []
        self.rollers: dict[str, tuple[Body, Body, Vec]] = {}
        self.turned: dict[str, tuple[str, str, Vec]] = {}
        self.elements: dict[str, Element] = {}

    @property
    def axes(self) -> tuple[str, ...]:
        """The names of the axes of the world along which bodies move: x and y, in space also z;
        without unit.
        """
        return AXES if self.spatial else AXES[:2]

    @property
    def named(self) -> list[Let]:
        """The expressions that have names, in the order in which they were stated, each in the unit
        of its name.
        """
        return [step for step in self.steps if isinstance(step, Let)]

    @property
    def common(self) -> list[Action]:
        """Return the actions between the ground and the bodies that equal sides share."""
        still = {self.ground, *self.shared}
        return [action for action in self.assembly.actions if {action.on, action.by} <= still]

    @property
    def unknowns(self) -> list[Quantity]:
        """The unknown forces [N] and moments [N m] that the balances determine, in the order of the
        joints.

        Those between bodies that equal sides share are left out.
        """
        shared = frozenset().union(*(action.needs for action in self.common))
        return [unknown for unknown in self.assembly.unknowns if unknown not in shared]

    def data(self, *besides: Quantity | None) -> Vector:
        """Return the quantities of the table, in SI, as the packed input ``data``, without those in
        ``besides``.
        """
        return Vector("data", tuple(q for q in self.given.values() if q not in besides))

    def name_(self, name: str, unit: str, meaning: str, expr: Expr) -> Quantity:
        r"""Name an expression of the motion and return the new quantity, to be used in other
        expressions.

        ``unit`` is of SI (kg, m, s, N, J, W, rad, 1 and their products); `system` raises
        DimensionError if the expression has another. Raises DimensionError for an unknown unit,
        ValueError for a name that generated code needs. How the quantity changes in time is not
        followed: `rate` takes it as constant. Use `coordinate` for what moves.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("phi | rad | crank angle\nr | m | crank | 0.05")
        >>> m = Mechanism("bar", q)
        >>> m.name_("area", "m2", "area of the crank circle", 3 * q.r**2).unit
        'm2'
        """
        return self.let(quantity(name, unit, meaning), expr)

    def let(self, symbol: Quantity, expr: Expr) -> Quantity:
        r"""Name an expression of the motion by ``symbol``, whose unit it must have, and return
        ``symbol``.

        Rates and errors are as in `name_`.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("phi | rad | crank angle\nr | m | crank | 0.05\nd | m | diameter")
        >>> m = Mechanism("bar", q)
        >>> m.let(q.d, 2 * q.r)
        d
        """
        self.steps.append(let(symbol, expr))
        return symbol

    def report(self, name: str, unit: str, meaning: str, expr: Expr) -> Quantity:
        r"""Report an expression with the results, in ``unit`` of SI, and return the new quantity;
        errors as `name_`.

        Unlike `name_` it is no step of the motion: it may depend on forces.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("phi | rad | crank angle\nomega | rad/s | its speed | 10\nr | m | crank | 0.05")
        >>> m = Mechanism("bar", q, angle=q.phi, speed=q.omega)
        >>> m.report("v", "m/s", "speed of the pin", q.r * q.omega)
        v
        """
        symbol = quantity(name, unit, meaning)
        self.reports.append(let(symbol, expr))
        return symbol

    @property
    def component_axes(self) -> dict[str, str]:
        """Names of the frames by which components of joints' actions are given, by the components'
        names.

        The components of all others, and those that say so in their name, are the world's.
        """
        return {
            str(component): action.frame.name
            for _, _, action in self.turned.values()
            for component in action.components
            if component != 0
        }

    def world_components(self) -> list[Let]:
        """The world's components, ``NAME_world_AXIS``, of the joints' actions that are given along
        other axes.
        """
        return [
            let(
                quantity(f"{name}_world_{axis}", unit, f"{meaning}, {axis} of the world"), component
            )
            for name, (unit, meaning, action) in self.turned.items()
            for axis, component in zip(AXES, action.resolved(self.world).components, strict=True)
            if component != 0
        ]

    def support_forces(self) -> dict[str, dict[str, Let]]:
        """The forces of the ground on each body that touches it [N], by body and axis of the world,
        if not zero.

        A component is an action of a joint under its own name, or else F_ground_BODY_AXIS.
        """
        supports: dict[str, dict[str, Let]] = {}
        for body in self.assembly.bodies[1:]:
            total = zero(self.world)
            for action in self.assembly.actions:
                if {action.on, action.by} == {self.ground, body}:
                    total = total + action.sign(body) * action.force.resolved(self.world)
            forces = {}
            for axis, component in zip(self.axes, total.components, strict=False):
                name, meaning = (
                    f"F_ground_{word(body.name)}_{axis}",
                    f"force of the ground on {body}, {axis}",
                )
                is_named = component in self.assembly.unknowns
                symbol = component if is_named else quantity(name, "N", meaning)
                if component != 0:
                    forces[axis] = Let(symbol, component, symbol.source)
            if forces:
                supports[body.name] = forces
        return supports

    def name_supports(self, outputs: Collection[Quantity]) -> dict[str, dict[str, str]]:
        """Return the names of the forces of the ground on bodies that are among ``outputs``, by
        body and axis.
        """
        named = {
            body: {
                axis: force.symbol.name for axis, force in forces.items() if force.symbol in outputs
            }
            for body, forces in self.support_forces().items()
        }
        return {body: names for body, names in named.items() if names}

    def balance(self, body: Body, kind: Kind, axis: str = "z") -> Balance:
        """Return what an equation of a paper claims to be: a body's balance of ``"force"`` [N] or
        ``"moment"`` [N m].

        The axis is "x", "y" or "z" of the world, or of the frame that the body was stated with;
        moments are taken about the point of the body (`body`). Raises MechanismError for a body
        without joint and mass.

        >>> from derive import Mechanism
        >>> m = Mechanism("bar")
        >>> bar = m.body("bar", m.world)
        >>> m.weld("A", bar, m.ground, m.O)
        >>> print(m.balance(bar, "moment"))
        bar: moment along z of world about O
        """
        pin = self.pin_of(body)
        return Balance(
            body.name, kind, axis, pin.axes.name, pin.at.name if kind == "moment" else ""
        )

    def constrain(self, name: str, gap: Expr, start: Mapping[Quantity, Expr | float]) -> None:
        """Keep an expression of coordinates at zero: a rope, a toothing, a rolling circle; ``name``
        names the gap.

        The gap is a length [m]: an angle is multiplied by a radius. ``start`` and errors are those
        of `close`.

        In free motion R_name [N], its reaction, is reported if no joint, `couple` or `mesh` carries
        it: on each coordinate it acts with R_name times the gap's slope, as a moment or force on a
        body that this coordinate moves, with the fewest others, in the direction in which it does.
        Forces that act elsewhere, as those of teeth, which load bearings, are stated by `mesh` or
        `contact`.

        >>> from derive import Mechanism, quantities
        >>> q = quantities('''
        ...     phi   | rad   | angle of the pinion
        ...     omega | rad/s | its speed   | 10
        ...     r     | m     | pitch radius | 0.02
        ... ''')
        >>> m = Mechanism("rack", q, angle=q.phi, speed=q.omega)
        >>> s = m.coordinate("s", "m", "place of the rack")
        >>> m.constrain("mesh", s - q.r * q.phi, start={s: 0})
        >>> m.loops.gaps
        {'gap_mesh': -phi*r + s}
        """
        self._add_gap(name, gap, start)
        self.reactive[f"gap_{name}"] = f"R_{name}"

    def _add_gap(self, name: str, gap: Expr, start: Mapping[Quantity, Expr | float]) -> None:
        if f"gap_{name}" in self.loops.gaps:
            raise MechanismError(f"two loops are called {name}")
        self.loops.gaps[f"gap_{name}"] = gap
        self.loops.start |= {value: sp.sympify(at) for value, at in start.items()}

    def refuse_shared_names(self) -> None:
        """Raise MechanismError if two of the table's quantities, actions, coordinates and results
        have one name.
        """
        coordinates = (q for c in self.loops.coordinates for q in (c.value, c.rate, c.acceleration))
        steps = (step.symbol for step in self.named if step.symbol not in self.given.values())
        reports = (report.symbol for report in self.reports)
        meanings: dict[str, str] = {}
        for symbol in (
            *self.given.values(),
            *coordinates,
            *steps,
            *self.assembly.unknowns,
            *reports,
        ):
            meaning = str(getattr(symbol, "meaning", symbol.name))
            if symbol.name in meanings:
                raise MechanismError(
                    f"{self.name}: two quantities are called {symbol.name} "
                    f"({meanings[symbol.name]}; {meaning}): "
                    "rename one of them"
                )
            meanings[symbol.name] = meaning

    def roll(self, name: str, slip: Expr) -> None:
        """Keep a speed [m/s] at zero that is not the rate of a gap, as the slip of a blade;
        ``name`` names the slip.

        It constrains free motion, with a reaction R_name [N] as that of `constrain`; a mechanism
        that an angle drives raises MechanismError in `system`.

        >>> from derive import Mechanism
        >>> from sympy import cos, sin
        >>> m = Mechanism("skate")
        >>> x, y, a = m.coordinate("x", "m", "x"), m.coordinate("y", "m", "y"), m.coordinate("a", "rad", "heading")
        >>> m.roll("blade", m.rate(y) * cos(a) - m.rate(x) * sin(a))
        >>> m.slips
        {'slip_blade': -x_dot*sin(a) + y_dot*cos(a)}
        """
        self.slips[f"slip_{name}"] = slip
        self.reactive[f"slip_{name}"] = f"R_{name}"

    def impact(self, name: str, gap: Expr, restitution: Expr | float) -> None:
        r"""Keep an expression of coordinates positive by impacts: an end stop, a floor, a hammer on
        its anvil.

        Where ``gap`` [m] closes, at the event ``impact of name``, all rates jump at once so that the
        rate of the gap becomes minus ``restitution`` times what it was (Newton), by an impulse along
        the gap: friction takes no part, and constraints hold. The restitution, without unit, is
        from 0 to 1. Impacts in ever shorter time, and a contact that stays closed, are refused by
        the integration: `compliant_contact` has them. Raises MechanismError along an angle, for a
        second impact of that name, or for a gap that depends on rates or inputs; DimensionError for
        another unit.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("m | kg | ball | 2\ng | m/s2 | free fall | 9.81\ne | 1 | rebound | 0.8")
        >>> m = Mechanism("ball", q, gravity=q.g)
        >>> h = m.coordinate("h", "m", "height")
        >>> ball = m.body("ball", m.world, q.m, m.point("P", m.O, m.world, 0, h))
        >>> m.impact("floor", h, q.e)
        >>> m.impacts
        {'floor': (h, e)}
        """
        gap, restitution = sp.sympify(gap), sp.sympify(restitution)
        if self.angle is not None:
            raise MechanismError(f"{name}: impacts are those of free motion, which no angle drives")
        if name in self.impacts:
            raise MechanismError(f"two impacts are called {name}")
        rates = {c.rate for c in self.loops.coordinates}
        if unknown := gap.free_symbols & {*rates, *self.motion.inputs}:
            names = ", ".join(sorted(map(str, unknown)))
            raise MechanismError(f"impact {name}: its gap depends on {names}, not on places alone")
        check_unit(f"impact {name}", gap, "m")
        check_unit(f"restitution of {name}", restitution, "1")
        self.impacts[name] = gap, restitution
        self.events.append(Event(f"impact of {name}", gap, S.Zero, 0))

    def equations(self, assembly: Assembly | None = None) -> list[Equation]:
        r"""Return the balances of all bodies but the ground as equations ``residual = 0`` [N, N m].

        ``assembly`` is that of the statement unless another motion is to be written in it. Laws of
        contacts come first. A residual is the sum of the outer forces, the weight and the
        inertia forces (moments) on a body: it shows the sign of each. Raises DimensionError if
        terms of different units are added.

        >>> from derive import Mechanism, quantities
        >>> q = quantities("g | m/s2 | free fall | 9.81\nm | kg | mass | 2\nl | m | centroid | 0.3")
        >>> m = Mechanism("beam", q, gravity=q.g)
        >>> m.weld("A", m.body("beam", m.world, q.m, m.point("C", m.O, m.world, q.l)), m.ground, m.O)
        >>> for equation in m.equations():
        ...     print(equation.number, "|", equation.residual)
        beam: force along x of world | F_Ax
        beam: force along y of world | F_Ay - g*m
        beam: moment along z of world about O | M_Az - g*l*m
        """
        assembly = assembly or self.assembly
        bodies = [body for body in assembly.bodies if body not in (self.earth, *self.shared)]
        balances = [e for body in bodies for e in assembly.balances(body, self.pin_of(body))]
        return [_consistent(e) for e in (*assembly.definitions(), *balances) if e.residual != 0]

    def pin_of(self, body: Body) -> Pin:
        """Return how a body's balances are written: as stated, else about a joint (the ground's
        first) or its centroid.

        Raises MechanismError for a body without joint and mass.
        """
        if body.pin is not None:
            return body.pin
        reactions = set(
            self.assembly.unknowns
        )  # a pole on a given load would leave joints' forces in the moments
        joints = sorted(
            (a for a in self.assembly.actions if a.sign(body)),
            key=lambda a: (not a.needs & reactions, not a.sign(self.earth)),
        )
        at = next(iter((*(a.at for a in joints), *(part.centroid for part in body.parts))), None)
        if at is None:
            raise MechanismError(f"body {body.name} has neither a joint nor a mass")
        return Pin(at, self.world, self._default_balances)

    @property
    def _default_balances(self) -> Asked:
        """The balances of a body that is stated without others."""
        return EVERY if self.spatial else PLANE

    def anchor(self, body: Body) -> Point:
        """Return a point that is fixed in a body: its centroid, or the point of its first joint."""
        if body == self.earth:
            return self.origin
        return body.parts[0].centroid if body.parts else self.pin_of(body).at

    def _carries(self, body: Body, point: Point) -> bool:
        """Whether a point does not move as a body sees it."""
        place = displacement(self.anchor(body), point, body.frame)
        return not any(self.motion.relative_derivative(place, body.frame).components)

    def list_centroids(self) -> Iterator[tuple[Point, list[Quantity]]]:
        """Yield all centroids except those whose places have names, each with names for its
        acceleration [m/s2] along the axes of the world.
        """
        with_names = self.motion.accelerations.keys() | self.motion.places.keys()
        for body in self.assembly.bodies:
            for number, part in enumerate(body.parts, 1):
                if part.centroid not in with_names:
                    label = f"a_{word(body.name)}" + (f"_{number}" if number > 1 else "")
                    meaning = f"acceleration of the centroid of {body}"
                    yield (
                        part.centroid,
                        [quantity(f"{label}_{a}", "m/s2", f"{meaning}, {a}") for a in AXES],
                    )

    def name_accelerations(self) -> None:
        """Name the accelerations of these centroids."""
        for centroid, symbols in self.list_centroids():
            components = self.motion.acceleration(centroid, self.world).components
            named = [
                S.Zero if component == 0 else self.let(symbol, component)
                for symbol, component in zip(symbols, components, strict=True)
            ]
            self.motion.accelerations[centroid] = Vec(self.world, to_triple(named))

    def told_in(self, speeds: Collection[Quantity]) -> dict[Quantity, Expr]:
        """Return the named expressions that depend on rates or accelerations, each expressed by
        these.
        """
        expressions: dict[Quantity, Expr] = {}
        for step in (*self.named, *self.reports):
            plain = step.expr.xreplace(expressions)
            if plain.free_symbols & set(speeds):
                expressions[step.symbol] = plain
        return expressions

    def chosen(
        self, available: Iterable[Quantity], requested: Sequence[str | Quantity] | None
    ) -> tuple[Quantity, ...]:
        """Return the quantities to report among those that are available, all of them for None.

        Raises MechanismError for a name that is not available.
        """
        by_name: dict[str, Quantity] = {q.name: q for q in available}
        names = list(by_name) if requested is None else list(map(str, requested))
        for name in names:
            if name not in by_name:
                close = get_close_matches(name, by_name, 1)
                hint = f"did you mean {close[0]}?" if close else f"there are {', '.join(by_name)}"
                raise MechanismError(f"{self.name}: nothing is called {name}; {hint}")
        by_name |= {q.name: q for q in requested or () if isinstance(q, Quantity)}
        return tuple(by_name[name] for name in names)

    @property
    def defined(self) -> tuple[Step, ...]:
        """The named steps of the motion, each in the unit of its name. Raises DimensionError."""
        for step in self.steps:
            if isinstance(step, Let):
                check_unit(str(step.symbol), step.expr, step.symbol.unit)
        return tuple(self.steps)


def quantity(name: str, unit: str, meaning: str) -> Quantity:
    """Return a derived quantity. Raises DimensionError for a unit that is not of SI."""
    try:
        of_unit(unit)
    except KeyError:
        raise DimensionError(
            f"{name}: unit = {unit}: write it in SI, such as m, rad/s or N m"
        ) from None
    return Quantity(name, unit, meaning, f"derived: {meaning}")


def to_triple(components: Sequence[Expr]) -> Triple:
    """Return three components as expressions. Raises ValueError if there are more or fewer."""
    x, y, z = map(sp.sympify, components)
    return x, y, z


def check_unit(name: str, expr: Expr, unit: str) -> None:
    """Raises DimensionError if an expression is not of a unit."""
    try:
        expr_dimension = dimension(expr)
    except DimensionError as error:
        raise DimensionError(f"{name}: {error}") from None
    if expr_dimension is not None and expr_dimension != of_unit(unit):
        raise DimensionError(f"{name} is in {unit}, and {expr} is not")


def _consistent(equation: Equation) -> Equation:
    try:
        dimension(equation.residual)
    except DimensionError as error:
        raise DimensionError(f"{equation.number}: {error}") from None
    return equation


def list_places(stated: Statement, locate: Callable[[Point], Vec]) -> list[Let]:
    """Return ``x_BODY__POINT`` and its like [m] for each body and each of its points, which are
    located in the world.
    """
    return [
        step
        for body in stated.assembly.bodies
        for point in _points(stated, body)
        for step in _place(stated.axes, locate(point), body, point)
    ]


def _points(stated: Statement, body: Body) -> Iterator[Point]:
    """Yield each point of a body at which a force acts, and its centroids, once."""
    acting = [
        action.at
        for action in stated.assembly.actions
        if action.sign(body) and any(action.force.components)
    ]
    yield from dict.fromkeys([*acting, *(part.centroid for part in body.parts)])


def _place(axes: Sequence[str], at: Vec, body: Body, point: Point) -> list[Let]:
    name = f"{word(body.name)}__{word(point.name)}"
    return [
        let(quantity(f"{axis}_{name}", "m", f"{point.name} of {body}, {axis}"), component)
        for axis, component in zip(axes, at.components, strict=False)
    ]
