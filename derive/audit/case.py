"""A paper and its subject: readings, pairs of equations to compare, points, directions,
cross-references.
"""

from __future__ import annotations

import random
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice, product
from typing import Any

import sympy as sp
from mpmath import mpf
from sympy import Basic, Expr

from ..chain import Chain
from ..equations import Claimed, ClaimError, Equation, find_claim
from ..evaluate import Point
from ..quantity import Quantity
from .paper import Paper, Reading, Reference, Source, Subject
from .terms import Equilibrium
from .typesetting import Said, join_parts

_PERIODIC = (sp.sin, sp.cos, sp.tan)


def find_directions(equations: Sequence[Equation]) -> frozenset[Quantity]:
    """Angles that come in by sines, cosines and tangents alone, or in what another direction is
    defined as.

    Whole multiples of them only: half a turn of half an angle is not a turn.
    """
    symbols = set().union(*(e.residual.free_symbols for e in equations))
    angles = {s for s in symbols if isinstance(s, Quantity) and s.unit == "rad"}
    outsides = [(e.defines, _find_outside(e.residual, frozenset(angles))) for e in equations]
    while counted := {s for s in angles if not _turns_freely(s, outsides, angles)}:
        angles -= counted
    return frozenset(s for s in angles if any(_is_periodic_in(e, s) for e in equations))


Outside = dict[Basic, set[Basic]]
"""Terms, by the angle that stands in them elsewhere than in a periodic function."""


def _turns_freely(
    symbol: Quantity, outsides: Iterable[tuple[sp.Symbol | None, Outside]], angles: set[Quantity]
) -> bool:
    """Whether no equation but those of other directions tells it from itself a turn later."""
    for defines, outside in outsides:
        terms = outside.get(symbol, set())
        if any(defines not in angles or not _adds(term, symbol) for term in terms):
            return False
    return True


def _find_outside(expr: Basic, angles: frozenset[Quantity]) -> Outside:
    """The terms of an expression, or of its cases, in which angles stand elsewhere than in a
    periodic function.
    """
    if isinstance(expr, sp.Symbol):
        return {expr: {expr}} if expr in angles else {}
    if isinstance(expr, _PERIODIC):
        return {s: {expr} for s in expr.free_symbols & angles if not _adds(expr.args[0], s)}
    inner: Outside = {}
    for part in expr.args:
        for symbol, terms in _find_outside(part, angles).items():
            inner.setdefault(symbol, set()).update(terms)
    is_multiple = isinstance(expr, sp.Mul) and len(expr.args) == 2 and expr.args[0].is_Integer
    if is_multiple or isinstance(expr, sp.Add | sp.Piecewise | sp.Tuple):
        return inner
    return {symbol: {expr} for symbol in inner}


def _adds(expr: Basic, symbol: Quantity) -> bool:
    """Whether a symbol stands in a sum, a whole number of times."""
    if not isinstance(expr, sp.Expr):
        return False
    terms = [term for term in sp.Add.make_args(sp.expand_mul(expr)) if symbol in term.free_symbols]
    return len(terms) == 1 and bool((terms[0] / symbol).is_Integer)


def _is_periodic_in(equation: Equation, symbol: Quantity) -> bool:
    return any(symbol in node.free_symbols for node in equation.residual.atoms(*_PERIODIC))


SEEDS = (1, 2, 5, 8)
"""Seeds of the random admissible points: between them they take both cases of every branch."""
MOST_POINTS = 55
"""Points that are tried for a condition that an equation holds on."""
CYCLE = 24
"""Points along the machine's own cycle."""
DENSE = 120
"""Points along it at which terms are compared in size: the largest of a smooth one is then right to
about 1 %.
"""
NEAR = mpf("1e-6")
"""Share by which what is near differs: far above the last of 50 digits, far below the distance to
another branch.
"""


@dataclass(frozen=True)
class Choice:
    """An answer to each thing that a paper leaves open of an equation."""

    answers: tuple[Reading, ...] = ()

    @property
    def meaning(self) -> str:
        return "; ".join(answer.meaning for answer in self.answers)

    @property
    def because(self) -> str:
        """The places in the paper that admit the answers."""
        return "; ".join(dict.fromkeys(answer.because for answer in self.answers if answer.because))

    @property
    def printed(self) -> dict[sp.Symbol, Expr]:
        return {
            symbol: meant for answer in self.answers for symbol, meant in answer.printed.items()
        }

    @property
    def derived(self) -> dict[sp.Symbol, Expr]:
        """Return the derived equation of a printed one.

        Raises ClaimError if the subject derives none.
        """
        return {
            symbol: meant for answer in self.answers for symbol, meant in answer.derived.items()
        }

    @property
    def text(self) -> Expr | None:
        return next((answer.text for answer in self.answers if answer.text is not None), None)


AS_READ = Choice()


def change_slightly(value: mpf, rng: random.Random) -> mpf:
    """Return a random small change of a value: a share of it, or of one where it is zero."""
    return NEAR * mpf(rng.uniform(-1, 1)) * (abs(value) or 1)


@dataclass(frozen=True)
class Case:
    """A paper with the subject that it is tried against.

    ``chains`` are its executable chains, if it has any: that of one side, then that of what both
    sides share. ``source`` is the text that its equations were read from, if one was.
    """

    paper: Paper
    subject: Subject
    chains: tuple[Chain, Chain] | None = None
    source: Source | None = field(default=None, compare=False)
    _random_points: list[Point] = field(init=False, default_factory=list, compare=False)
    _chosen: dict[sp.Basic, list[Point]] = field(init=False, default_factory=dict, compare=False)
    _lifted: dict[str, Equation | None] = field(init=False, default_factory=dict, compare=False)

    @cached_property
    def claims(self) -> Mapping[Claimed, Equation]:
        return self.subject.claims()

    @cached_property
    def points(self) -> list[Point]:
        return self.draw(len(SEEDS))

    def draw(self, count: int) -> list[Point]:
        """Return random admissible points, the same ones and more of them at each call."""
        for place in range(len(self._random_points), count):
            seed = SEEDS[place] if place < len(SEEDS) else SEEDS[-1] + 1 + place - len(SEEDS)
            self._random_points.append(Point(self.subject.admissible(random.Random(seed))))
        return self._random_points[:count]

    def points_where(self, condition: sp.Basic) -> list[Point]:
        """Random admissible points at which a condition holds; all of them where none is tried at
        which it does.
        """
        if condition not in self._chosen:
            points = (self.draw(place + 1)[place] for place in range(MOST_POINTS))
            fitting = (point for point in points if point.holds(condition))
            self._chosen[condition] = (
                self.points if condition == sp.true else list(islice(fitting, len(SEEDS)))
            )
        return self._chosen[condition] or self.points

    @cached_property
    def cycle(self) -> list[Point]:
        return [Point(values) for values in self.subject.reference(CYCLE)]

    @cached_property
    def dense_cycle(self) -> list[Point]:
        """Points along the machine's own cycle that are close enough to find the largest values of
        terms.
        """
        return [Point(values) for values in self.subject.reference(DENSE)]

    @cached_property
    def equilibria(self) -> Sequence[Equilibrium]:
        """Equilibria about which equations may be linearised, with points near them."""
        return self.subject.equilibria()

    @cached_property
    def nearby(self) -> list[Point]:
        """Points near the machine's own cycle, with nothing special in their data."""
        rng = random.Random(SEEDS[0])
        values = self.subject.nearby(rng)
        if values is not None:
            return [Point(cycle_values) for cycle_values in values]
        return [
            Point({s: v + change_slightly(v, rng) for s, v in point.values().items()})
            for point in self.cycle
        ]

    @cached_property
    def words(self) -> list[Quantity]:
        """Every quantity that the paper's equations speak of."""
        symbols = set().union(*(e.residual.free_symbols for e in self.paper.equations.values()))
        return sorted((s for s in symbols if isinstance(s, Quantity)), key=str)

    def pair(self, number: str, choice: Choice = AS_READ) -> tuple[Equation, Equation | None]:
        """A printed equation as it is read, and its derivation in the same quantities, None for one
        that stands alone.

        Raises ClaimError where the subject derives nothing of what the equation claims to be.
        """
        return self.footings(number, choice)[-1]

    def footings(
        self, number: str, choice: Choice = AS_READ
    ) -> list[tuple[Equation, Equation | None]]:
        """The pairs that an equation may be judged by: a balance's own quantities first, the fewest
        last.

        All say the same; they differ in how many of the quantities that the print does not name are
        eliminated.
        """
        printed = self.paper.equations[number]
        read = replace(
            printed, residual=self._read(number, choice), defines=self._defined(number, choice)
        )
        if printed.stands_alone:
            return [(read, None)]
        derived = self.derived(number)
        derived = replace(derived, residual=derived.residual.xreplace(dict(choice.derived)))
        if not _states_a_sum(printed, derived):
            return [(read, derived)]
        sums = self.subject.footings(read.residual, derived.residual)
        return [
            (replace(read, residual=printed_sum), replace(derived, residual=derived_sum))
            for printed_sum, derived_sum in sums
        ]

    def choices(self, number: str) -> list[Choice]:
        """Every way to read an equation of which the paper leaves something open, as it is read
        first; else none.
        """
        open_to = [q.readings for q in self.paper.questions if number in q.numbers]
        return [Choice(answers) for answers in product(*open_to)] if open_to else []

    def linked(self, number: str) -> tuple[str, ...]:
        """The equations that share a question with this one, directly or through others, in the
        order of the paper.
        """
        numbers = {number}
        while (
            more := {n for q in self.paper.questions if numbers & {*q.numbers} for n in q.numbers}
            - numbers
        ):
            numbers |= more
        return tuple(n for n in self.paper.equations if n in numbers)

    def joint_choices(self, numbers: Collection[str]) -> list[dict[str, Choice]]:
        """Every way to read linked equations together: each question has one answer in all of
        them.
        """
        questions = [q for q in self.paper.questions if not {*numbers}.isdisjoint(q.numbers)]
        return [
            {
                n: Choice(
                    tuple(a for q, a in zip(questions, answers, strict=True) if n in q.numbers)
                )
                for n in numbers
            }
            for answers in product(*(q.readings for q in questions))
        ]

    def select_choices(self, answers: Mapping[str, str]) -> dict[str, Choice]:
        """Return the reading of each equation by its meaning in ``answers``, or its first one if
        none has it.
        """
        ways = {n: self.choices(n) for n in answers}
        return {
            n: next((c for c in ways[n] if c.meaning == meaning), ways[n][0])
            for n, meaning in answers.items()
        }

    def read_chains(self, chosen: Mapping[str, Choice]) -> tuple[Chain, Chain]:
        """The executable chains with their equations as they are read; raises ValueError where the
        paper has none.
        """
        if self.chains is None:
            raise ValueError(f"{self.paper.name} has no executable chains")
        side, frame = (
            replace(
                chain,
                equations={
                    n: _chosen(e, chosen.get(n, AS_READ)) for n, e in chain.equations.items()
                },
            )
            for chain in self.chains
        )
        return side, frame

    @property
    def executed(self) -> tuple[str, ...]:
        """The equations that the chains solve, of which the paper leaves something open."""
        spent = frozenset[str]().union(*(chain.spent for chain in self.chains or ()))
        return tuple(n for n in self.paper.equations if n in spent and self.choices(n))

    @cached_property
    def directions(self) -> frozenset[Quantity]:
        """Angles that are directions: they come in nowhere but by their sines and cosines."""
        return find_directions([*self.paper.equations.values(), *self.claims.values()])

    def derived(self, number: str) -> Equation:
        """Return the derived equation of a printed one.

        Raises ClaimError if the subject derives none.
        """
        printed = self.paper.equations[number]
        try:
            return find_claim(self.claims, printed.claims)
        except ClaimError as error:
            raise ClaimError(f"{printed.source}: {error}") from None

    def _read(self, number: str, choice: Choice) -> Expr:
        printed = self.paper.equations[number].residual if choice.text is None else choice.text
        return printed.xreplace(self.find_meanings(number, choice))

    def find_meanings(self, number: str, choice: Choice) -> dict[sp.Symbol, Expr]:
        """Return what the printed symbols of an equation stand for under a reading: zero, where an
        assumption makes a quantity vanish.
        """
        meanings = {**self.symbol_meanings(number), **choice.printed}
        zeros = dict.fromkeys(self.subject.zero(), sp.S.Zero)
        if self.lifted(number) is None:
            return meanings
        return zeros | {symbol: meant.xreplace(zeros) for symbol, meant in meanings.items()}

    @cached_property
    def definitions(self) -> Mapping[sp.Symbol, Expr]:
        """Quantities by what the derivation says that they are, in other quantities."""
        return self.subject.definitions()

    def _defined(self, number: str, choice: Choice) -> Quantity | None:
        """The quantity that a definition defines as its symbols are read; None if that is no
        multiple of a quantity.
        """
        symbol = self.paper.equations[number].defines
        if symbol is None:
            return None
        meant = {**self.symbol_meanings(number), **choice.printed}.get(symbol, symbol)
        quantity = sp.sympify(meant).as_coeff_Mul()[1]
        return quantity if isinstance(quantity, Quantity) else None

    def lifted(self, number: str) -> Equation | None:
        """The derivation of an equation while assumptions are lifted; None where none bears on
        it.
        """
        if number not in self._lifted:
            printed = self.paper.equations[number]
            residual = self.subject.lift(
                printed.claims, printed.residual.xreplace(self.symbol_meanings(number))
            )
            self._lifted[number] = (
                None if residual is None else replace(self.derived(number), residual=residual)
            )
        return self._lifted[number]

    def assumed(self, number: str) -> dict[sp.Symbol, str]:
        """Quantities of an equation, printed or derived, that an assumption makes zero, each with
        the reason.
        """
        lifted = self.lifted(number)
        if lifted is None:
            return {}
        symbols = lifted.residual.free_symbols | self.paper.equations[number].residual.free_symbols
        return {s: why for s, why in self.subject.zero().items() if s in symbols}

    def symbol_meanings(self, number: str) -> dict[sp.Symbol, Expr]:
        """Return the expressions that replace the printed symbols of an equation."""
        return {**self.paper.reading, **self.paper.readings.get(number, {})}

    def read_as(self, number: str) -> Said:
        """Describe how symbols of an equation are read that mean something else."""
        symbols = self.paper.equations[number].residual.free_symbols
        meant = sorted(self.symbol_meanings(number).items(), key=str)
        return join_parts("; ", (Said(s, " read as ", e) for s, e in meant if s in symbols))


def _chosen(printed: Equation, choice: Choice) -> Equation:
    residual = printed.residual if choice.text is None else choice.text
    return replace(printed, residual=residual.xreplace(choice.printed))


def _states_a_sum(printed: Equation, derived: Equation) -> bool:
    return printed.defines is None and derived.defines is None and printed.relation == "="


def judge_references(case: Case) -> list[dict[str, Any]]:
    """Every reference of a paper: whether its equations give the quantities, and which of the
    paper's do.
    """
    return [_judged(case, reference) for reference in case.paper.references]


def _judged(case: Case, reference: Reference) -> dict[str, Any]:
    lacking = [
        s
        for s in reference.symbols
        if not any(_gives(_meant(case, n), s) for n in reference.numbers)
    ]
    instead = [n for n in case.paper.equations if any(_gives(_meant(case, n), s) for s in lacking)]
    return {
        "paper": case.paper.name,
        "quantities": [str(symbol) for symbol in reference.symbols],
        "refers_to": list(reference.numbers),
        "verdict": "cannot be meant" if lacking else "can be meant",
        "lacking": [str(symbol) for symbol in lacking],
        "instead": instead,
    }


def _meant(case: Case, number: str) -> Equation:
    """An equation as it is derived, for of many the print is lost; one that stands alone as it is
    printed.
    """
    printed = case.paper.equations[number]
    return printed if printed.stands_alone else case.derived(number)


def _gives(equation: Equation, symbol: Quantity) -> bool:
    """Whether an equation says what a quantity is: it defines it, or defines nothing and speaks of
    it.
    """
    if equation.defines is not None:
        return equation.defines == symbol
    return symbol in equation.residual.free_symbols
