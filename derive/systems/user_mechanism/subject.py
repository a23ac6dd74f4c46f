"""A user's mechanism as an audit subject: what it claims, and the laws that a paper's equations must satisfy.

Laws are power, momentum, angular momentum, virtual work on each coordinate, action and reaction on each body; of a
mechanism that an angle drives also rest, and forces that grow with the square of the speed. What the paper does not
state is as derived.
"""

from __future__ import annotations

import random
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations, groupby

import mpmath
import numpy as np
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ...audit.case import change_slightly
from ...audit.paper import Cycle, Dynamics, Law, Subject
from ...audit.paper import Values as Arrays
from ...audit.trial import Formula
from ...chain import Chain
from ...equations import Balance, Claimed, Equation, by_claim, defined, derived, loop, what
from ...evaluate import Point, scale
from ...mechanics.driven_motion import LAW, VANISHES, build_law_residuals
from ...mechanics.mechanism import Mechanism
from ...mechanics.statement import MechanismError
from ...model import Let, LinearSolve, Step, System, Twin, needed, sorted_steps
from ...quantity import Quantities, Quantity

SPREAD = 0.2
"""Data without bounds are tried within this share of their table_values."""
Values = dict[Quantity, mpf]


def table_values(given: Quantities) -> Values:
    """The values that a table gives, in SI."""
    return {given[name]: mpf(str(datum.value)) * scale(given[name].shown) for name, datum in given.data.items()}


def value_ranges(given: Quantities, own: Values) -> dict[Quantity, tuple[mpf, mpf]]:
    """Between what data are tried: their bounds, else near their table_values."""
    found = {}
    for quantity, value in own.items():
        bounds = given.data[quantity.name].bounds
        low, high = (value * (1 - SPREAD), value * (1 + SPREAD))
        if bounds is not None:
            low, high = (mpf(str(end)) * scale(quantity.shown) for end in bounds)
        found[quantity] = low, high
    return found


def draw_values(given: Quantities, own: Values, rng: random.Random) -> Values:
    """Random ones between their ends."""
    return {q: mpf(rng.uniform(*map(float, pair))) for q, pair in value_ranges(given, own).items()}


def draw_near(own: Values, rng: random.Random) -> Values:
    """Values that differ a little from those of a machine, so that none of them is special."""
    return {q: value + change_slightly(value, rng) for q, value in own.items()}


def mechanism_values(mechanism: Mechanism) -> Values:
    """The values of a mechanism but for its angle. Raises MechanismError for one that its table does not give."""
    for quantity in mechanism.given.values():
        if quantity != mechanism.angle and quantity.name not in mechanism.given.data:
            raise MechanismError(f"{mechanism.name}: the table gives no value of {quantity}")
    return {q: value for q, value in table_values(mechanism.given).items() if q != mechanism.angle}


def evaluate_steps(steps: Iterable[Step], values: Mapping[Quantity, mpf]) -> Values:
    """Values with those that steps give. Raises ZeroDivisionError where equations determine nothing."""
    found = dict(values)
    for step in steps:
        found |= _stepped(step, Point(found))
    return found


def _stepped(step: Step, point: Point) -> Values:
    if isinstance(step, Let):
        return {step.symbol: point(step.expr)}
    assert isinstance(step, LinearSolve)
    matrix = mpmath.matrix([[point(entry) for entry in row] for row in step.matrix])
    right = mpmath.matrix([point(entry) for entry in step.right])
    return {**dict(zip(step.symbols, mpmath.lu_solve(matrix, right), strict=True)), step.pivot: mpf(1)}


REFERENCE, SPEEDS = "reference", "speeds"
SLOW, FASTER = 1e-9, 2
"""Speeds beside the mechanism's own: one at which inertia is next to nothing, and one at which it is FASTER^2 times."""
ACTIONS = ("N", "N m")


def build_dynamics(
    mechanism: Mechanism, general: Sequence[Let], printed: Chain, motions: Mapping[str, Sequence[Sequence[Values]]]
) -> Dynamics:
    """The laws that a print's equations can break, with motions and what each equation leaves over in them.

    Repaired, an equation holds of the motion: what it leaves over is taken from it.
    """
    solved = [unknown for step in printed.order for unknown in step.unknowns]
    cycles = {name: _cycle(sides, printed) for name, sides in motions.items()}
    laws = [*_general(general), *_reactions(mechanism)]
    if SPEEDS in motions:
        laws += [_rest(general), *_scaling(mechanism, solved)]
    felt = frozenset(solved).union(*(map(twin, solved) for twin in TWINS))
    found = tuple(_scaled(law, cycles[law.cycle]) for law in laws if any(g.free_symbols & felt for g in law.gaps))
    claims = {e.claims: replace(e, residual=e.residual - left_over(e)) for e in printed.equations.values()}
    return Dynamics(found, cycles, claims, (), TWINS)


def left_over(equation: Equation) -> sp.Symbol:
    """What an equation leaves over in the motion: zero if it holds."""
    return sp.Symbol(f"left over of ({equation.number})", real=True)


def _at_speed(k: int) -> Twin:
    return lambda quantity: sp.Symbol(f"{quantity} at speed {k}", real=True)


TWINS = (_at_speed(1), _at_speed(2))
"""What quantities are called at the second and third of several speeds."""


def _cycle(sides: Sequence[Sequence[Values]], printed: Chain) -> Cycle:
    return Cycle(tuple(_arrays(side, printed) for side in sides), np.ones(len(sides[0])))


def _arrays(side: Sequence[Values], printed: Chain) -> Arrays:
    points = [Point(values) for values in side]
    found: Arrays = {symbol: np.array([float(values[symbol]) for values in side]) for symbol in side[0]}
    return found | {left_over(e): np.array([float(p(e.residual)) for p in points]) for e in printed.equations.values()}


def _general(general: Sequence[Let]) -> Iterator[Law]:
    return (Law(let.symbol.meaning.removesuffix(VANISHES), let.symbol.unit, (let.expr,)) for let in general)


def _reactions(mechanism: Mechanism) -> Iterator[Law]:
    """What acts on a body, the reverse of what it does to its neighbours among it, is its rate of momentum."""
    balances = [(e.claims, e.residual) for e in mechanism.equations() if isinstance(e.claims, Balance)]
    for (body, kind), found in groupby(balances, key=lambda one: (one[0].body, one[0].kind)):
        unit = ACTIONS[kind == "moment"]
        yield Law(f"action and reaction, {kind}s on {body}", unit, tuple(residual for _, residual in found))


def _rest(general: Sequence[Let]) -> Law:
    gaps = tuple(let.expr for let in general if let.symbol.name.startswith(f"{LAW}force"))
    return Law("next to no speed: outer forces balance the weight", "N", gaps, cycle=SPEEDS)


def _scaling(mechanism: Mechanism, solved: Sequence[Quantity]) -> Iterator[Law]:
    """Inertia's part of an action grows with the square of the speed, where nothing else goes with the speed."""
    if _goes_with_speed(mechanism):
        return
    once, twice = TWINS
    for unit in ACTIONS:
        actions = [q for q in solved if q.unit == unit and q in mechanism.assembly.unknowns]
        gaps = tuple((twice(q) - q) - FASTER**2 * (once(q) - q) for q in actions)
        if gaps:
            yield Law("inertia's part goes with the square of the speed", unit, gaps, cycle=SPEEDS)


def _goes_with_speed(mechanism: Mechanism) -> bool:
    """Whether a given action feels rates, or one that turns with another's sign, as friction does."""
    own = [] if mechanism.speed is None else [mechanism.speed]
    speeds = {*own, *(q for c in mechanism.loops.coordinates for q in (c.rate, c.acceleration))}
    told = mechanism.told_in(speeds)
    for action in mechanism.assembly.actions:
        for component in (*action.force.components, *action.moment.components):
            plain = component.xreplace(told)
            if plain.atoms(sp.Abs, sp.Piecewise) or plain.free_symbols & speeds:
                return True
    return False


def _scaled(law: Law, cycle: Cycle) -> Law:
    """A law with the size of its largest term in the motion."""
    values = dict(cycle.sides[0])
    for twin, side in zip(TWINS, cycle.sides[1:], strict=False):
        values |= {twin(symbol): found for symbol, found in side.items()}
    terms = [term for gap in law.gaps for term in sp.Add.make_args(gap)]
    size = max((float(np.max(np.abs(Formula(term)(values)))) for term in terms), default=0.0)
    return replace(law, scale=size or 1.0)


MOST_TOGETHER = 2
"""Equations that are solved together for the rates of a loop."""


class MechanismSubject(Subject):
    """A mechanism as derived; ``printed`` are equations of a paper in the order in which they give something."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.system = mechanism, mechanism.system()
        self.printed = Chain({}, [])

    @property
    @abstractmethod
    def quantities(self) -> frozenset[Quantity]:
        """Everything that has a value in its motion."""

    @property
    @abstractmethod
    def moving(self) -> list[tuple[Quantity, Quantity]]:
        """What may be moved alone, each with its rate."""

    @abstractmethod
    def motions(self) -> Mapping[str, Sequence[Sequence[Values]]]:
        """Values along its own motion, and along others that laws compare it with."""

    @property
    def named(self) -> list[Let]:
        """What has a name of its own, each after what it is told in."""
        return [s for s in sorted_steps((*self.mechanism.named, *self.mechanism.reports)) if isinstance(s, Let)]

    @cached_property
    def _before(self) -> tuple[Step, ...]:
        """What the gaps of loops are told in."""
        gaps = self.mechanism.loops.gaps.values()
        return needed(self.named, frozenset().union(*(gap.free_symbols for gap in gaps)))

    def claims(self) -> Mapping[Claimed, Equation]:
        """Balances, what named quantities are, the gaps of loops, rates and accelerations that these determine."""
        named = {let.symbol: let for let in self.named}
        gaps = self.mechanism.loops.gaps.items()
        return by_claim((
            *self.mechanism.equations(),
            *(defined(what(symbol), symbol, let.expr) for symbol, let in named.items()),
            *(derived(loop(name.removeprefix("gap_")), gap) for name, gap in gaps),
            *(defined(what(symbol), symbol, expr) for symbol, expr in self._rates.items() if symbol not in named),
        ))  # fmt: skip

    @cached_property
    def _rates(self) -> dict[Quantity, Expr]:
        """Rates and accelerations of the coordinates that loops determine, each in terms of those before it."""
        loops, motion = self.mechanism.loops, self.mechanism.motion
        rates, accelerations = [c.rate for c in loops.coordinates], [c.acceleration for c in loops.coordinates]
        told = self.mechanism.told_in([*rates, *accelerations])
        once = [sp.sympify(motion.rate(gap)).xreplace(told) for gap in loops.gaps.values()]
        twice = [sp.sympify(motion.rate(rate)).xreplace(told) for rate in once]
        return _solve_in_turn(once, rates) | _solve_in_turn(twice, accelerations)

    def common(self, printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
        """What only one of them names is told by what it is: in coordinates, their rates and accelerations, data."""
        both = printed.free_symbols & derived.free_symbols
        plain: dict[Quantity, Expr] = {}
        for let in self.named:
            if let.symbol not in both:
                plain[let.symbol] = let.expr.xreplace(plain)
        return printed.xreplace(plain), derived.xreplace(plain)

    def actions(self) -> Mapping[sp.Symbol, str]:
        return {unknown: unknown.meaning for unknown in self.mechanism.assembly.unknowns}

    def model(self) -> System:
        return self.system

    def dynamics(self) -> Dynamics | None:
        """Laws that the printed equations must keep as a whole; None where they give nothing that a law feels."""
        if not self.printed.order:
            return None
        return build_dynamics(
            self.mechanism, build_law_residuals(self.mechanism, self.moving), self.printed, self.motions()
        )


def _solve_in_turn(residuals: Sequence[Expr], unknowns: Sequence[Quantity]) -> dict[Quantity, Expr]:
    """Unknowns of linear equations: those of the fewest equations first, which stay symbols in what follows.

    What needs more than MOST_TOGETHER equations at once is left out: its formula would be too long to compare with.
    """
    found: dict[Quantity, Expr] = {}
    left = list(residuals)
    while solved := next(_solve_together(left, [q for q in unknowns if q not in found]), None):
        together, values = solved
        found |= values
        left = [residual for residual in left if residual not in together]
    return found


def _solve_together(
    residuals: Sequence[Expr], unknowns: Sequence[Quantity]
) -> Iterator[tuple[tuple[Expr, ...], dict[Quantity, Expr]]]:
    """Equations that determine as many unknowns as they are many, the fewest first, with these."""
    for size in range(1, MOST_TOGETHER + 1):
        for some in combinations(residuals, size):
            known = set().union(*(residual.free_symbols for residual in some))
            together = [unknown for unknown in unknowns if unknown in known]
            if len(together) == size:
                matrix, right = sp.linear_eq_to_matrix(some, together)
                if sp.expand(matrix.det()) != 0:
                    yield some, dict(zip(together, matrix.LUsolve(right), strict=True))
