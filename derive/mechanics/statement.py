"""What is stated of a mechanism: coordinates, loops, bodies, actions, and the names that expressions get."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from difflib import get_close_matches

import sympy as sp
from sympy import Expr, S

from ..dimensions import DimensionError, dimension, of_unit
from ..equations import Balance, Equation, Kind
from ..model import Event, Let, Step, let
from ..quantity import Quantity, Vector, word
from ..table import Quantities
from .bodies import AXES, EVERY, PLANE, Action, Asked, Assembly, Body, Pin
from .frames import Frame, Motion, Point, Triple, Vec
from .loops import Loops


class MechanismError(ValueError):
    """A mechanism is stated so that nothing can be derived of it."""


class Statement:
    """A mechanism as it was stated, for the derivations; `Mechanism` is how it is stated."""

    def __init__(
        self, name: str, given: Quantities, angle: Quantity | None, motion: Motion, gravity: Sequence[Expr],
        spatial: bool, world: Frame,
    ) -> None:  # fmt: skip
        self.name, self.given, self.angle, self.motion, self.spatial = name, given, angle, motion, spatial
        self.world, self.O = world, Point("O")
        self.assembly = Assembly(motion, Vec(self.world, triple(gravity)))
        self.ground = self.assembly.add(Body("ground", self.world))
        self.loops = Loops()
        self.slips: dict[str, Expr] = {}
        self.start: dict[sp.Symbol, Expr] = {} if angle is None else {angle: S.Zero}
        self.potentials: list[Expr] = []
        self.steps: list[Step] = []
        self.reports: list[Let] = []
        self.events: list[Event] = []
        self.shared: list[Body] = []
        self.rolling: dict[str, tuple[Body, Body, Point]] = {}
        self.pushing: list[Quantity] = []
        self.rollers: dict[str, tuple[Body, Vec]] = {}
        self.turned: dict[str, tuple[str, str, Vec]] = {}

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes of the world along which anything moves."""
        return AXES if self.spatial else AXES[:2]

    @property
    def meshing(self) -> dict[str, tuple[Body, Body, Point]]:
        """Gears that mesh in a plane, inner and outer, with their pitch point, by the tag of their mesh."""
        return {} if self.spatial else self.rolling

    @property
    def named(self) -> list[Let]:
        """The expressions of the motion that have names."""
        return [step for step in self.steps if isinstance(step, Let)]

    @property
    def common(self) -> list[Action]:
        """What acts between the ground and what equal sides share."""
        still = {self.ground, *self.shared}
        return [action for action in self.assembly.actions if {action.on, action.by} <= still]

    @property
    def unknowns(self) -> list[Quantity]:
        """The unknown actions that the mechanism's own balances give: those that equal sides share are left out."""
        shared = frozenset().union(*(action.needs for action in self.common))
        return [unknown for unknown in self.assembly.unknowns if unknown not in shared]

    def data(self, *besides: Quantity | None) -> Vector:
        """The quantities of the table as a packed input, less some."""
        return Vector("data", tuple(q for q in self.given.values() if q not in besides))

    def name_(self, name: str, unit: str, meaning: str, expr: Expr) -> Quantity:
        """Name an expression of the motion."""
        return self.let(quantity(name, unit, meaning), expr)

    def let(self, symbol: Quantity, expr: Expr) -> Quantity:
        """Name an expression of the motion by a quantity of one's own; how it changes in time is not followed."""
        self.steps.append(let(symbol, expr))
        return symbol

    def report(self, name: str, unit: str, meaning: str, expr: Expr) -> Quantity:
        """Name an expression, so that it is told with the results."""
        symbol = quantity(name, unit, meaning)
        self.reports.append(let(symbol, expr))
        return symbol

    @property
    def component_axes(self) -> dict[str, str]:
        """Names of the frames by which components of joints' actions are told, by the components' names.

        The components of all others, and those that say so in their name, are the world's.
        """
        return {
            str(component): action.frame.name
            for _, _, action in self.turned.values()
            for component in action.components
            if component != 0
        }

    def world_components(self) -> list[Let]:
        """The world's components, ``NAME_world_AXIS``, of the joints' actions that are told by other axes."""
        return [
            let(quantity(f"{name}_world_{axis}", unit, f"{meaning}, {axis} of the world"), component)
            for name, (unit, meaning, action) in self.turned.items()
            for axis, component in zip(AXES, action.resolved(self.world).components, strict=True)
            if component != 0
        ]

    def balance(self, body: Body, kind: Kind, axis: str = "z") -> Balance:
        """What an equation may claim to be: a body's balance of forces or moments, along an axis of the world."""
        pin = self.pin_of(body)
        return Balance(body.name, kind, axis, pin.axes.name, pin.at.name if kind == "moment" else "")

    def constrain(self, name: str, gap: Expr, start: Mapping[Quantity, Expr | float]) -> None:
        """An expression of coordinates vanishes, always: a rolling, a toothing, a rope."""
        if f"gap_{name}" in self.loops.gaps:
            raise MechanismError(f"two loops are called {name}")
        self.loops.gaps[f"gap_{name}"] = gap
        self.loops.start |= {value: sp.sympify(at) for value, at in start.items()}

    def roll(self, name: str, slip: Expr) -> None:
        """A speed vanishes, always, that is no rate of a gap: a wheel rolls, a blade does not slip. In free motion."""
        self.slips[f"slip_{name}"] = slip

    def equations(self) -> list[Equation]:
        """The laws of contacts, and the balances of every body but the ground and what equal sides share.

        Raises DimensionError.
        """
        bodies = [body for body in self.assembly.bodies if body not in (self.ground, *self.shared)]
        found = [e for body in bodies for e in self.assembly.balances(body, self.pin_of(body))]
        return [_consistent(e) for e in (*self.assembly.definitions(), *found) if e.residual != 0]

    def pin_of(self, body: Body) -> Pin:
        """How a body's balances are written: as was told, else about a joint (the ground's first) or its centroid."""
        if body.pin is not None:
            return body.pin
        joints = sorted((a for a in self.assembly.actions if a.sign(body)), key=lambda a: not a.sign(self.ground))
        at = next(iter((*(a.at for a in joints), *(part.centroid for part in body.parts))), None)
        if at is None:
            raise MechanismError(f"body {body.name} has neither a joint nor a mass")
        return Pin(at, self.world, self.asked)

    @property
    def asked(self) -> Asked:
        """The balances of a body that says nothing else."""
        return EVERY if self.spatial else PLANE

    def anchor(self, body: Body) -> Point:
        """A point that is fixed in a body: its centroid, or the point of its first joint."""
        return body.parts[0].centroid if body.parts else self.pin_of(body).at

    def name_accelerations(self) -> None:
        """Give the accelerations of all centroids names of their own, but of those whose places have names."""
        told = self.motion.accelerations.keys() | self.motion.places.keys()
        for body in self.assembly.bodies:
            for number, part in enumerate(body.parts, 1):
                if part.centroid not in told:
                    self._name_acceleration(body, part.centroid, f"_{number}" if number > 1 else "")

    def _name_acceleration(self, body: Body, centroid: Point, number: str) -> None:
        named: list[Expr] = []
        for axis, component in zip(AXES, self.motion.acceleration(centroid, self.world).components, strict=True):
            meaning = f"acceleration of the centroid of {body}, {axis}"
            name = f"a_{word(body.name)}{number}_{axis}"
            named.append(S.Zero if component == 0 else self.name_(name, "m/s2", meaning, component))
        self.motion.accelerations[centroid] = Vec(self.world, triple(named))

    def told_in(self, speeds: Collection[Quantity]) -> dict[Quantity, Expr]:
        """Named steps that hold some rates or accelerations, each told in those."""
        found: dict[Quantity, Expr] = {}
        for step in (*self.named, *self.reports):
            plain = step.expr.xreplace(found)
            if plain.free_symbols & set(speeds):
                found[step.symbol] = plain
        return found

    def chosen(self, known: Iterable[Quantity], asked: Sequence[str | Quantity] | None) -> tuple[Quantity, ...]:
        """What is asked for among what is known, all of it without a question; raises MechanismError."""
        by_name: dict[str, Quantity] = {q.name: q for q in known}
        names = list(by_name) if asked is None else list(map(str, asked))
        for name in names:
            if name not in by_name:
                close = get_close_matches(name, by_name, 1)
                hint = f"did you mean {close[0]}?" if close else f"there are {', '.join(by_name)}"
                raise MechanismError(f"{self.name}: nothing is called {name}; {hint}")
        by_name |= {q.name: q for q in asked or () if isinstance(q, Quantity)}
        return tuple(by_name[name] for name in names)

    @property
    def defined(self) -> tuple[Step, ...]:
        """The named steps of the motion, each in the unit of its name. Raises DimensionError."""
        return tuple(_in_unit(step) if isinstance(step, Let) else step for step in self.steps)


def quantity(name: str, unit: str, meaning: str) -> Quantity:
    of_unit(unit)
    return Quantity(name, unit, meaning, f"derived: {meaning}")


def triple(components: Sequence[Expr]) -> Triple:
    x, y, z = map(sp.sympify, components)
    return x, y, z


def _in_unit(step: Let) -> Let:
    try:
        found = dimension(step.expr)
    except DimensionError as error:
        raise DimensionError(f"{step.symbol}: {error}") from None
    if found is not None and found != of_unit(step.symbol.unit):
        raise DimensionError(f"{step.symbol} is in {step.symbol.unit}, and {step.expr} is not")
    return step


def _consistent(equation: Equation) -> Equation:
    try:
        dimension(equation.residual)
    except DimensionError as error:
        raise DimensionError(f"{equation.number}: {error}") from None
    return equation
