"""Comparison of a user's paper with a mechanism or with formulas that the user states."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import replace

import sympy as sp
from mpmath import mpf
from sympy import Expr

from ...audit.case import Case
from ...audit.paper import Paper, Subject
from ...chain import Chain, solvable
from ...equations import Claim, Claimed, Definition, Equation
from ...evaluate import NotEvaluated, Point, UnknownNodeError
from ...formulas import Formulas
from ...mechanics.mechanism import Mechanism
from ...mechanics.statement import MechanismError
from ...quantity import Quantity
from .motions import DrivenSubject, FreeSubject
from .subject import MechanismSubject, draw_near, draw_values, table_values, value_ranges


class Repaired(Claim):
    """An equation as the motion has it, whatever its print says."""

    HOLDS = "({}) as the motion has it"


TRIALS = 50
NEARBY = 8
"""Points along the way near which data are tried."""


class FormulasSubject(Subject):
    """Formulas, at random values of their data and while each datum with bounds runs from the one to the other."""

    def __init__(self, formulas: Formulas) -> None:
        self.formulas, self._own = formulas, table_values(formulas.given)

    def claims(self) -> Mapping[Claimed, Equation]:
        return self.formulas.equations

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Random data, with all that follows. Raises MechanismError where none are found of which it does."""
        for _ in range(TRIALS):
            try:
                return self.formulas.followed(draw_values(self.formulas.given, self._own, rng))
            except (ZeroDivisionError, TypeError):
                continue
        raise MechanismError(f"{self.formulas.name}: its definitions have no real values near the data that are given")

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """All values along the way from the lower bounds to the upper ones."""
        return [self.formulas.followed(data) for data in self._way(points)]

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        """Values near those along that way; None where its definitions have no real ones."""
        try:
            return [self.formulas.followed(draw_near(data, rng)) for data in self._way(NEARBY)]
        except (ZeroDivisionError, TypeError):
            return None

    def _way(self, points: int) -> list[dict[Quantity, mpf]]:
        table = self.formulas.given
        moving = {q: pair for q, pair in value_ranges(table, self._own).items() if table.data[q.name].bounds}
        shares = [mpf(i) / max(points - 1, 1) for i in range(points)]
        along = ({q: low + (high - low) * share for q, (low, high) in moving.items()} for share in shares)
        return [self._own | data for data in along]


SOME_VALUE = 0.3
"""A value of every quantity, to find out whether an expression has values."""


def chain(paper: Paper, own: MechanismSubject) -> Chain:
    """Actions, and what the paper defines, from its equations, as far as these go.

    Its own names are read as what they are defined as; an equation that names what has no value in the motion, or
    contains a function that cannot be evaluated, is left out.
    """
    equations, names = [], dict[sp.Symbol, Expr]()
    for printed in paper.equations.values():
        read = _as_read(paper, printed).xreplace(names)
        if printed.defines is not None and isinstance(printed.claims, Definition):
            names[printed.defines] = printed.defines - read
        elif printed.relation == "=" and printed.legibility != "lost" and _has_values(read, own):
            claim = Repaired.HOLDS.of(printed.number)
            equations.append(replace(printed, residual=read, claims=claim))
    asked = [*own.mechanism.assembly.unknowns, *(e.defines for e in equations if e.defines in own.quantities)]
    held = {q for e in equations for q in e.residual.free_symbols}
    return solvable(equations, [q for q in dict.fromkeys(asked) if isinstance(q, Quantity) and q in held])


def _has_values(expr: Expr, own: MechanismSubject) -> bool:
    """Whether an expression can be evaluated in the motion at all; whether it is real there, is another question."""
    if not expr.free_symbols <= own.quantities:
        return False
    try:
        Point(dict.fromkeys(expr.free_symbols, SOME_VALUE))(expr)
    except UnknownNodeError:
        return False
    except (NotEvaluated, ArithmeticError, TypeError):
        return True
    return True


def _as_read(paper: Paper, printed: Equation) -> Expr:
    """An equation as its symbols are read, by the first of every admissible reading."""
    meant = {**paper.reading, **paper.readings.get(printed.number, {})}
    residual = printed.residual
    for question in paper.questions:
        if printed.number in question.numbers and question.readings:
            first = question.readings[0]
            residual = residual if first.text is None else first.text
            meant |= first.printed
    return residual.xreplace(meant)


SECONDS = 1.0


def trial(stated: Mechanism | Formulas, paper: Paper, until: float = SECONDS) -> Case:
    r"""Compare all equations of a paper with a mechanism or formulas: what a file offers as CASE to `planter audit`.

    The size of a term is taken along the turn of a mechanism that an angle drives, else over free motion ``until`` a
    time [s]. Raises ClaimError for a claim to be something that the mechanism or the formulas do not state.

    >>> from derive import Formulas, Paper, quantities, trial, what
    >>> q = quantities("r | m | radius | 0.02\nd | m | diameter")
    >>> f = Formulas("disc", given=q)
    >>> f.defines(q.d, 2 * q.r)
    d
    >>> paper = Paper("invented2026", "An invented paper")
    >>> paper.defines("1", q.d, 2 * q.r, what(q.d))
    >>> trial(f, paper).paper.name
    'invented2026'
    """
    case = (
        Case(paper, FormulasSubject(stated))
        if isinstance(stated, Formulas)
        else _of_mechanism(build_subject(stated, until), paper)
    )
    for number, equation in paper.equations.items():
        if not equation.stands_alone:
            case.derived(number)
    return case


def _of_mechanism(subject: MechanismSubject, paper: Paper) -> Case:
    subject.printed = chain(paper, subject)
    return Case(paper, subject, (subject.printed, Chain({}, [])) if subject.printed.order else None)


def build_subject(mechanism: Mechanism, until: float = SECONDS) -> MechanismSubject:
    """A mechanism as what papers are tried against."""
    lane = mechanism.system().lane
    if lane is None or mechanism.angle is None or mechanism.speed is None:
        return FreeSubject(mechanism, until)
    return DrivenSubject(mechanism, mechanism.angle, mechanism.speed, lane)
