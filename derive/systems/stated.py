"""Mechanisms and formulas of one's own as what papers are tried against: what they claim, values to decide at."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import mpmath
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ..audit.case import Case
from ..audit.paper import Paper
from ..audit.subject import Subject
from ..equations import Claimed, Equation, by_claim, defined, derived, loop, what
from ..evaluate import DIGITS, GUARD, Point
from ..formulas import Formulas
from ..machine_file import scale
from ..mechanics.mechanism import Mechanism
from ..mechanics.statement import MechanismError
from ..model import Lane, Let, LinearSolve, Step
from ..quantity import Quantity
from ..table import Quantities

WALK = 36
"""Steps from the start of a turn to where loops are wanted."""
SPREAD = 0.2
"""Data without bounds are tried within this share of their values."""
TRIALS = 50


class Own(Subject):
    """A mechanism that is driven along an angle, as derived, at random values and along its own turn."""

    def __init__(self, mechanism: Mechanism) -> None:
        lane = mechanism.system().lane
        if lane is None:
            raise MechanismError(f"{mechanism.name}: only a mechanism that an angle drives can be tried against")
        self.mechanism, self.lane = mechanism, lane

    def claims(self) -> Mapping[Claimed, Equation]:
        """Balances, what named quantities are, the gaps of loops."""
        named = {let.symbol: let for let in (*self.mechanism.named, *self.mechanism.reports)}
        gaps = self.mechanism.loops.gaps.items()
        return by_claim((
            *self.mechanism.equations(),
            *(defined(what(symbol), symbol, let.expr) for symbol, let in named.items()),
            *(derived(loop(name.removeprefix("gap_")), gap) for name, gap in gaps),
        ))  # fmt: skip

    def common(self, printed: Expr, derived: Expr) -> tuple[Expr, Expr]:
        """What only one of them names is told by what it is: in coordinates, their rates and accelerations, data."""
        both = printed.free_symbols & derived.free_symbols
        plain: dict[Quantity, Expr] = {}
        for let in self.mechanism.named:
            if let.symbol not in both:
                plain[let.symbol] = let.expr.xreplace(plain)
        return printed.xreplace(plain), derived.xreplace(plain)

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Random data, and a random angle of a turn that the loops allow. Raises MechanismError where none is found."""
        for _ in range(TRIALS):
            data = {q: mpf(rng.uniform(*map(float, ends))) for q, ends in self._ranges.items()}
            try:
                return next(self._along(data, [rng.uniform(0, 2 * mpmath.pi)]))
            except ZeroDivisionError:
                continue
        raise MechanismError(f"{self.mechanism.name}: its loops close nowhere near the values that are given")

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """The mechanism's own values along its turn."""
        angles = [2 * mpmath.pi * i / points for i in range(points)]
        return list(self._along(self._own, angles))

    @cached_property
    def _own(self) -> dict[Quantity, mpf]:
        """The values that the statement gives, in SI. Raises MechanismError for one that it does not give."""
        given = self.mechanism.given
        for quantity in given.values():
            if quantity != self.mechanism.angle and quantity.name not in given.data:
                raise MechanismError(f"{self.mechanism.name}: the table gives no value of {quantity}")
        return {q: value for q, value in own_values(given).items() if q != self.mechanism.angle}

    @cached_property
    def _ranges(self) -> dict[Quantity, tuple[mpf, mpf]]:
        return ranges(self.mechanism.given, self._own)

    def _along(self, data: Mapping[Quantity, mpf], angles: Sequence[mpf]) -> Iterator[dict[Quantity, mpf]]:
        """Values of all quantities at angles, one after another."""
        with mpmath.workdps(DIGITS + GUARD):
            places = self._started(data)
            last = mpf(0)
            for angle in angles:
                steps = max(1, int(WALK * abs(angle - last) / (2 * mpmath.pi)))
                for i in range(1, steps + 1):
                    places = self._closed(data, last + (angle - last) * i / steps, places)
                last = angle
                yield self._values(data, angle, places)

    def _started(self, data: Mapping[Quantity, mpf]) -> list[mpf]:
        loops, point = self.mechanism.loops, Point(data)
        return self._closed(data, mpf(0), [point(sp.sympify(loops.start[value])) for value in loops.values])

    def _closed(self, data: Mapping[Quantity, mpf], angle: mpf, places: list[mpf]) -> list[mpf]:
        """Coordinates that close the loops, by Newton's method; ZeroDivisionError where it leads nowhere."""
        loops = self.mechanism.loops
        if not loops.values:
            return []
        at = mpmath.matrix(places)
        for _ in range(40):
            point = Point({**data, self.mechanism.angle: angle, **dict(zip(loops.values, at, strict=True))})
            slopes = mpmath.matrix([[point(entry) for entry in row] for row in loops.jacobian()])
            step = mpmath.lu_solve(slopes, -mpmath.matrix([point(gap) for gap in loops.gaps.values()]))
            at = at + step
            if mpmath.norm(step) < mpf(10) ** -(DIGITS):
                return list(at)
        raise ZeroDivisionError("the loops do not close")

    def _values(self, data: Mapping[Quantity, mpf], angle: mpf, places: Sequence[mpf]) -> dict[Quantity, mpf]:
        given = dict(zip((q for vector in self.lane.along for q in vector), places, strict=True))
        return after(self.lane, {**data, self.lane.angle: angle, **given})


def after(lane: Lane, values: Mapping[Quantity, mpf]) -> dict[Quantity, mpf]:
    """Values with those that the steps of a lane give; what is not finite is left out with what hangs on it."""
    found = dict(values)
    for step in lane.steps:
        found |= _stepped(step, Point(found))
    return found


def _stepped(step: Step, point: Point) -> dict[Quantity, mpf]:
    if isinstance(step, Let):
        return {step.symbol: point(step.expr)}
    assert isinstance(step, LinearSolve)
    matrix = mpmath.matrix([[point(entry) for entry in row] for row in step.matrix])
    right = mpmath.matrix([point(entry) for entry in step.right])
    return {**dict(zip(step.symbols, mpmath.lu_solve(matrix, right), strict=True)), step.pivot: mpf(1)}


class OwnFormulas(Subject):
    """Formulas, at random values of their data and while each datum with bounds runs from the one to the other."""

    def __init__(self, formulas: Formulas) -> None:
        self.formulas, self._own = formulas, own_values(formulas.given)
        self._ranges = ranges(formulas.given, self._own)

    def claims(self) -> Mapping[Claimed, Equation]:
        return self.formulas.equations

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Random data, with all that follows. Raises MechanismError where none are found of which it does."""
        for _ in range(TRIALS):
            data = {q: mpf(rng.uniform(*map(float, ends))) for q, ends in self._ranges.items()}
            try:
                return self.formulas.followed(data)
            except (ZeroDivisionError, TypeError):
                continue
        raise MechanismError(f"{self.formulas.name}: its definitions have no real values near the data that are given")

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """All values along the way from the lower bounds to the upper ones."""
        moving = {q: ends for q, ends in self._ranges.items() if self.formulas.given.data[q.name].bounds}
        shares = [mpf(i) / max(points - 1, 1) for i in range(points)]
        along = ({q: low + (high - low) * share for q, (low, high) in moving.items()} for share in shares)
        return [self.formulas.followed(self._own | data) for data in along]


def own_values(given: Quantities) -> dict[Quantity, mpf]:
    """The values that a table gives, in SI."""
    return {given[name]: mpf(str(datum.value)) * scale(given[name].shown) for name, datum in given.data.items()}


def ranges(given: Quantities, own: Mapping[Quantity, mpf]) -> dict[Quantity, tuple[mpf, mpf]]:
    """Between what data are tried: their bounds, else near their values."""
    found = {}
    for quantity, value in own.items():
        bounds = given.data[quantity.name].bounds
        ends = (value * (1 - SPREAD), value * (1 + SPREAD))
        if bounds is not None:
            ends = tuple(mpf(str(end)) * scale(quantity.shown) for end in bounds)
        found[quantity] = ends
    return found


def trial(stated: Mechanism | Formulas, paper: Paper) -> Case:
    """A paper on trial against a mechanism or formulas: what a file offers as CASE."""
    return Case(paper, OwnFormulas(stated) if isinstance(stated, Formulas) else Own(stated))
