"""A user's mechanism as an audit subject: what it claims, and the laws that a paper's equations
must satisfy.

Laws are power, momentum, angular momentum, virtual work on each coordinate, action and reaction on
each body; of a mechanism that an angle drives also rest, and forces that grow with the square of
the speed. What the paper does not state is as derived.
"""

from __future__ import annotations

import random
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, cached_property
from itertools import combinations, groupby

import mpmath
import numpy as np
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ...chain import Chain
from ...equations import (
    Balance,
    Claimed,
    Equation,
    by_claim,
    defining_equation,
    derived_equation,
    loop,
    what,
)
from ...evaluate import DIGITS, Point, si_factor, table_values
from ...functions import partial_derivative
from ...mechanics.driven_motion import LAW, VANISHES, build_law_residuals
from ...mechanics.mechanism import Mechanism
from ...mechanics.statement import MechanismError
from ...model import Let, LinearSolve, Step, System, Twin, needed, sorted_steps
from ...quantity import Quantities, Quantity, dimension, of_unit
from ..case import change_slightly
from ..laws import Formula
from ..paper import Cycle, Dynamics, Law, Subject
from ..paper import Values as Arrays

TRIALS = 50
"""Draws of data until one allows a motion."""
RELATIVE_RANGE = 0.2
"""Data without bounds vary within this share of their values."""
Values = dict[Quantity, mpf]


def value_ranges(table: Quantities, values: Values) -> dict[Quantity, tuple[mpf, mpf]]:
    """Return the range of each of the data: its bounds, or the neighbourhood of its value."""
    ranges = {}
    for quantity, value in values.items():
        low, high = value * (1 - RELATIVE_RANGE), value * (1 + RELATIVE_RANGE)
        if bounds := table.data[quantity.name].bounds:
            low, high = (mpf(str(end)) * si_factor(quantity.shown) for end in bounds)
        ranges[quantity] = low, high
    return ranges


def draw_values(table: Quantities, values: Values, rng: random.Random) -> Values:
    """Draw random data within their ranges."""
    return {
        q: mpf(rng.uniform(*map(float, pair))) for q, pair in value_ranges(table, values).items()
    }


def draw_near(values: Values, rng: random.Random) -> Values:
    """Draw values that differ slightly from those of a machine, so that none of them is special."""
    return {q: value + change_slightly(value, rng) for q, value in values.items()}


def mechanism_values(mechanism: Mechanism) -> Values:
    """Return the values of a mechanism except its angle.

    Raises MechanismError if its table lacks one.
    """
    for quantity in mechanism.given.values():
        if quantity != mechanism.angle and quantity.name not in mechanism.given.data:
            raise MechanismError(f"{mechanism.name}: the table gives no value of {quantity}")
    return {q: value for q, value in table_values(mechanism.given).items() if q != mechanism.angle}


def evaluate_steps(steps: Iterable[Step], values: Mapping[Quantity, mpf]) -> Values:
    """Return the values with those of the steps.

    Raises ZeroDivisionError for equations that determine nothing.
    """
    results = dict(values)
    for step in steps:
        point = Point(results)
        if isinstance(step, Let):
            results[step.symbol] = point(step.expr)
            continue
        assert isinstance(step, LinearSolve)
        matrix = mpmath.matrix([[point(entry) for entry in row] for row in step.matrix])
        right = mpmath.matrix([point(entry) for entry in step.right])
        results |= zip(step.symbols, mpmath.lu_solve(matrix, right), strict=True)
        results[step.pivot] = mpf(1)
    return results


MAX_ITERATIONS = 40


@cache
def _slope(expr: Expr, quantity: Quantity) -> Expr:
    return partial_derivative(expr, quantity)


def take_newton_step(
    values: Values, residuals: Sequence[Expr], variables: Sequence[Quantity], steps: Iterable[Step]
) -> tuple[Values, mpf]:
    """Return values after the shortest Newton step of variables towards zero residuals, and its
    length.

    ``steps`` give what the residuals need besides. Raises ZeroDivisionError if residuals follow
    from one another.
    """
    point = Point(evaluate_steps(steps, values))
    rows = mpmath.matrix([[point(_slope(expr, q)) for q in variables] for expr in residuals])
    gaps = mpmath.matrix([point(expr) for expr in residuals])
    step = rows.T * mpmath.lu_solve(rows * rows.T, -gaps)
    moved = {q: values[q] + change for q, change in zip(variables, step, strict=True)}
    return values | moved, mpmath.norm(step)


def close_gaps(
    values: Values, gaps: Sequence[Expr], variables: Sequence[Quantity], steps: Iterable[Step] = ()
) -> Values:
    """Return the nearest values of variables at which gaps vanish.

    Raises ZeroDivisionError if none are found.
    """
    for _ in range(MAX_ITERATIONS if gaps else 0):
        values, size = take_newton_step(values, gaps, variables, steps)
        if size < mpf(10) ** -DIGITS:
            return values
    if gaps:
        raise ZeroDivisionError("the loops do not close")
    return values


def define_lets(lets: Iterable[Let]) -> list[Equation]:
    """Return the equations that say what quantities are."""
    return [defining_equation(what(let.symbol), let.symbol, let.expr) for let in lets]


def list_gaps(mechanism: Mechanism) -> list[Equation]:
    """Return the equations that close the loops."""
    gaps = mechanism.loops.gaps.items()
    return [derived_equation(loop(name.removeprefix("gap_")), gap) for name, gap in gaps]


REFERENCE, SPEEDS = "reference", "speeds"
SLOW, FASTER = 1e-9, 2
"""Further speeds relative to that of the mechanism: at SLOW inertia is negligible, at FASTER it is
FASTER^2 times.
"""
ACTIONS = ("N", "N m")


def build_dynamics(
    mechanism: Mechanism,
    general: Sequence[Let],
    printed: Chain,
    motions: Mapping[str, Sequence[Sequence[Values]]],
) -> Dynamics:
    """Build the laws that the equations of a paper can violate, with motions and the residual of
    each equation in them.

    A repaired equation holds in the motion: its residual there is subtracted from it.
    """
    solved = [unknown for step in printed.order for unknown in step.unknowns]
    cycles = {name: _build_cycle(sides, printed) for name, sides in motions.items()}
    laws = [*_general_laws(general), *_reaction_laws(mechanism)]
    if SPEEDS in motions:
        laws += [_rest_law(general), *_scaling_laws(mechanism, solved)]
    affected = frozenset(solved).union(*(map(twin, solved) for twin in TWINS))
    laws = [law for law in laws if any(gap.free_symbols & affected for gap in law.gaps)]
    values = {name: _list_values(cycle) for name, cycle in cycles.items()}
    balances = [e.residual for e in mechanism.equations() if isinstance(e.claims, Balance)]
    sizes = {name: _find_magnitudes(balances, at) for name, at in values.items()}
    scaled = tuple(_scale_law(law, values[law.cycle], sizes[law.cycle]) for law in laws)
    claims = {
        e.claims: replace(e, residual=e.residual - residual_symbol(e))
        for e in printed.equations.values()
    }
    return Dynamics(scaled, cycles, claims, (), TWINS)


def residual_symbol(equation: Equation) -> sp.Symbol:
    """Return the symbol of an equation's residual in the motion, which is zero if the equation
    holds.
    """
    return sp.Symbol(f"left over of ({equation.number})", real=True)


def _symbols_at_speed(k: int) -> Twin:
    return lambda quantity: sp.Symbol(f"{quantity} at speed {k}", real=True)


TWINS = (_symbols_at_speed(1), _symbols_at_speed(2))
"""Symbols of quantities at the second and third of several speeds."""


def _build_cycle(sides: Sequence[Sequence[Values]], printed: Chain) -> Cycle:
    return Cycle(tuple(_stack_values(side, printed) for side in sides), np.ones(len(sides[0])))


def _stack_values(side: Sequence[Values], printed: Chain) -> Arrays:
    points = [Point(values) for values in side]
    arrays: Arrays = {
        symbol: np.array([float(values[symbol]) for values in side]) for symbol in side[0]
    }
    residuals = {
        residual_symbol(e): np.array([float(p(e.residual)) for p in points])
        for e in printed.equations.values()
    }
    return arrays | residuals


def _general_laws(general: Sequence[Let]) -> Iterator[Law]:
    return (
        Law(let.symbol.meaning.removesuffix(VANISHES), let.symbol.unit, (let.expr,))
        for let in general
    )


def _reaction_laws(mechanism: Mechanism) -> Iterator[Law]:
    """Yield the balances of each body, which contain the reverse of the actions on its
    neighbours.
    """
    balances = [
        (e.claims, e.residual) for e in mechanism.equations() if isinstance(e.claims, Balance)
    ]
    for (body, kind), group in groupby(
        balances, key=lambda balance: (balance[0].body, balance[0].kind)
    ):
        unit = ACTIONS[kind == "moment"]
        yield Law(
            f"action and reaction, {kind}s on {body}",
            unit,
            tuple(residual for _, residual in group),
        )


def _rest_law(general: Sequence[Let]) -> Law:
    gaps = tuple(let.expr for let in general if let.symbol.name.startswith(f"{LAW}force"))
    return Law("next to no speed: outer forces balance the weight", "N", gaps, cycle=SPEEDS)


def _scaling_laws(mechanism: Mechanism, solved: Sequence[Quantity]) -> Iterator[Law]:
    """Yield that inertia's part of an action grows with the square of the speed, if nothing else
    depends on it.
    """
    if _depends_on_speed(mechanism):
        return
    once, twice = TWINS
    for unit in ACTIONS:
        actions = [q for q in solved if q.unit == unit and q in mechanism.assembly.unknowns]
        gaps = tuple((twice(q) - q) - FASTER**2 * (once(q) - q) for q in actions)
        if gaps:
            yield Law("inertia's part goes with the square of the speed", unit, gaps, cycle=SPEEDS)


def _depends_on_speed(mechanism: Mechanism) -> bool:
    """Whether a prescribed action depends on rates, or changes with the sign of another action, as
    friction does.
    """
    driver = [] if mechanism.speed is None else [mechanism.speed]
    speeds = {*driver, *(q for c in mechanism.loops.coordinates for q in (c.rate, c.acceleration))}
    definitions = mechanism.told_in(speeds)
    for action in mechanism.assembly.actions:
        for component in (*action.force.components, *action.moment.components):
            expr = component.xreplace(definitions)
            if expr.atoms(sp.Abs, sp.Piecewise) or expr.free_symbols & speeds:
                return True
    return False


def _list_values(cycle: Cycle) -> Arrays:
    """Return the values of all quantities in a motion, also at its other speeds."""
    values = dict(cycle.sides[0])
    for twin, side in zip(TWINS, cycle.sides[1:], strict=False):
        values |= {twin(symbol): array for symbol, array in side.items()}
    return values


def _find_magnitudes(balances: Iterable[Expr], values: Arrays) -> dict[str, float]:
    """Return by unit the magnitudes of a motion to which rounding errors are relative: of the terms
    of all balances of forces, of lengths and speeds of turning, and of products of these.
    """
    forces = [residual for residual in balances if dimension(residual) == of_unit("N")]
    lengths, turnings = (
        [q for q in values if getattr(q, "unit", "") == unit] for unit in ("m", "rad/s")
    )
    force, length, turning = (_largest_term(some, values) for some in (forces, lengths, turnings))
    moment = force * length
    forces_by_unit = {"N": force, "N m": moment, "J": moment, "W": moment * turning}
    return forces_by_unit | {"m": length, "m/s": length * turning}


def _largest_term(gaps: Iterable[Expr], values: Arrays) -> float:
    """Return the size of the largest summand of expressions in a motion."""
    terms = [
        term for gap in gaps for term in sp.Add.make_args(gap) if term.free_symbols <= values.keys()
    ]
    return max((float(np.max(np.abs(Formula(term)(values)))) for term in terms), default=0.0)


ROUNDING = 1e-5
"""Share of a motion's magnitude that a law's scale is at least.

A law's own terms may all be zero but for rounding, as a moment is whose forces all pass through one
point: its rounding is that of the forces. With the tolerance of 1e-7 the share is 1e-12, ten
thousand times that of a single operation.
"""


def _scale_law(law: Law, values: Arrays, sizes: Mapping[str, float]) -> Law:
    """Return a law with the size of its largest term in the motion, no less than the rounding of
    all forces.
    """
    return replace(
        law,
        scale=max(_largest_term(law.gaps, values), ROUNDING * sizes.get(law.unit, 0.0)) or 1.0,
    )


MAX_SIMULTANEOUS = 2
"""Largest number of equations that are solved together for the rates of a loop."""


class MechanismSubject(Subject):
    """A mechanism as derived; ``printed`` are equations of a paper in the order in which they
    determine something.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        mechanism.name_accelerations()
        self.printed = Chain({}, [])

    @property
    @abstractmethod
    def quantities(self) -> frozenset[Quantity]:
        """All quantities that have a value in the motion."""

    @property
    @abstractmethod
    def moving(self) -> list[tuple[Quantity, Quantity]]:
        """Coordinates that may be displaced alone, each with its rate."""

    @abstractmethod
    def motions(self) -> Mapping[str, Sequence[Sequence[Values]]]:
        """Return values over the mechanism's motion, and over others that laws compare it with."""

    @property
    def named(self) -> list[Let]:
        """Definitions of all named quantities, each after those that it needs."""
        return [
            s
            for s in sorted_steps((*self.mechanism.named, *self.mechanism.reports))
            if isinstance(s, Let)
        ]

    @cached_property
    def _gap_steps(self) -> tuple[Step, ...]:
        """Steps that the gaps of the loops need."""
        gaps = self.mechanism.loops.gaps.values()
        return needed(self.named, frozenset().union(*(gap.free_symbols for gap in gaps)))

    def claims(self) -> Mapping[Claimed, Equation]:
        """Return balances, definitions, gaps of loops, and the rates and accelerations that these
        determine.
        """
        named = {let.symbol for let in self.named}
        rates = [Let(s, expr, "") for s, expr in self._rates.items() if s not in named]
        lets = define_lets([*self.named, *rates])
        return by_claim((*self.mechanism.equations(), *lets, *list_gaps(self.mechanism)))

    @cached_property
    def _rates(self) -> dict[Quantity, Expr]:
        """Rates and accelerations of the coordinates that loops determine, each in terms of those
        before it.
        """
        loops, motion = self.mechanism.loops, self.mechanism.motion
        rates, accelerations = (
            [c.rate for c in loops.coordinates],
            [c.acceleration for c in loops.coordinates],
        )
        definitions = self.mechanism.told_in([*rates, *accelerations])
        once = [sp.sympify(motion.rate(gap)).xreplace(definitions) for gap in loops.gaps.values()]
        twice = [sp.sympify(motion.rate(rate)).xreplace(definitions) for rate in once]
        return _solve_in_turn(once, rates) | _solve_in_turn(twice, accelerations)

    def common(self, printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
        """Return both with the definitions of quantities that occur in only one: coordinates, their
        rates, data.
        """
        both = printed.free_symbols & derived.free_symbols
        definitions: dict[Quantity, Expr] = {}
        for let in self.named:
            if let.symbol not in both:
                definitions[let.symbol] = let.expr.xreplace(definitions)
        return printed.xreplace(definitions), derived.xreplace(definitions)

    def actions(self) -> Mapping[sp.Symbol, str]:
        """Return the forces and moments between bodies, with their meanings."""
        return {unknown: unknown.meaning for unknown in self.mechanism.assembly.unknowns}

    @cached_property
    def system(self) -> System:
        """Model of the mechanism; a motion of bodies that nothing states the guides of has none."""
        return self.mechanism.system()

    def model(self) -> System:
        """Return the model of the mechanism. Raises MechanismError if nothing guides a body."""
        return self.system

    def dynamics(self) -> Dynamics | None:
        """Return the laws for the printed equations as a whole; None if no law depends on what they
        determine.
        """
        if not self.printed.order:
            return None
        return build_dynamics(
            self.mechanism,
            build_law_residuals(self.mechanism, self.moving),
            self.printed,
            self.motions(),
        )


def _solve_in_turn(residuals: Sequence[Expr], unknowns: Sequence[Quantity]) -> dict[Quantity, Expr]:
    """Solve linear equations, the smallest sets first; their unknowns remain symbols in what
    follows.

    Unknowns that need more than MAX_SIMULTANEOUS equations at once are left out, as their formulas
    would be too long for a comparison.
    """
    solutions: dict[Quantity, Expr] = {}
    remaining = list(residuals)
    while solved := next(
        _solve_together(remaining, [q for q in unknowns if q not in solutions]), None
    ):
        together, values = solved
        solutions |= values
        remaining = [residual for residual in remaining if residual not in together]
    return solutions


def _solve_together(
    residuals: Sequence[Expr], unknowns: Sequence[Quantity]
) -> Iterator[tuple[tuple[Expr, ...], dict[Quantity, Expr]]]:
    """Yield sets of equations that determine as many unknowns, the smallest first, with the
    solutions.
    """
    for size in range(1, MAX_SIMULTANEOUS + 1):
        for equations in combinations(residuals, size):
            symbols = set().union(*(residual.free_symbols for residual in equations))
            together = [unknown for unknown in unknowns if unknown in symbols]
            if len(together) == size:
                matrix, right = sp.linear_eq_to_matrix(equations, together)
                if sp.expand(matrix.det()) != 0:
                    yield equations, dict(zip(together, matrix.LUsolve(right), strict=True))
