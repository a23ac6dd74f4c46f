"""Comparison of a user's paper with a mechanism or with formulas that the user states."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import replace

import sympy as sp
from mpmath import mpf
from sympy import Expr

from ...chain import Chain, select_solvable
from ...equations import Claimed, Definition, Equation
from ...evaluate import NotEvaluated, Point, UnknownNodeError, table_values
from ...formulas import Formulas
from ...mechanics.mechanism import Mechanism
from ...mechanics.statement import MechanismError
from ...quantity import Quantity
from ..case import Case
from ..paper import Paper, Subject
from .motions import ConfigurationSubject, DrivenSubject, FreeSubject
from .subject import TRIALS, MechanismSubject, draw_near, draw_values, value_ranges

NEARBY = 8
"""Points between the bounds near which data are drawn."""


class FormulasSubject(Subject):
    """Formulas at random values of their data, and while each datum runs from its lower to its
    upper bound.
    """

    def __init__(self, formulas: Formulas) -> None:
        self.formulas, self._values = formulas, table_values(formulas.given)

    def claims(self) -> Mapping[Claimed, Equation]:
        """Return the equations of the formulas by their claims."""
        return self.formulas.equations

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Draw data and return all values.

        Raises MechanismError if the definitions have none for any draw.
        """
        for _ in range(TRIALS):
            try:
                return self.formulas.followed(draw_values(self.formulas.given, self._values, rng))
            except (ZeroDivisionError, TypeError):
                continue
        raise MechanismError(
            f"{self.formulas.name}: its definitions have no real values near the data that are "
            f"given"
        )

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """Return all values on the way from the lower bounds to the upper bounds."""
        return [self.formulas.followed(data) for data in self._interpolate_data(points)]

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        """Return values near those; None if the definitions have no real ones."""
        try:
            return [
                self.formulas.followed(draw_near(data, rng))
                for data in self._interpolate_data(NEARBY)
            ]
        except (ZeroDivisionError, TypeError):
            return None

    def _interpolate_data(self, points: int) -> list[dict[Quantity, mpf]]:
        table = self.formulas.given
        ranges = {
            q: pair
            for q, pair in value_ranges(table, self._values).items()
            if table.data[q.name].bounds
        }
        shares = [mpf(i) / max(points - 1, 1) for i in range(points)]
        return [
            self._values | {q: low + (high - low) * s for q, (low, high) in ranges.items()}
            for s in shares
        ]


PROBE_VALUE = 0.3
"""Value of every quantity in the test whether an expression can be evaluated."""


def build_paper_chain(paper: Paper, subject: MechanismSubject) -> Chain:
    """Build the chain of a paper's equations that determine actions and quantities which the paper
    defines.

    Names that the paper introduces are replaced by their definitions. Equations with a quantity
    that has no value in the motion, or with a function that cannot be evaluated, are left out.
    """
    equations, names = [], dict[sp.Symbol, Expr]()
    for printed in paper.equations.values():
        read = _as_read(paper, printed).xreplace(names)
        if printed.defines is not None and isinstance(printed.claims, Definition):
            names[printed.defines] = printed.defines - read
        elif (
            printed.relation == "=" and printed.legibility != "lost" and _has_values(read, subject)
        ):
            repaired = f"({printed.number}) as the motion has it"
            equations.append(replace(printed, residual=read, claims=repaired))
    defined = (e.defines for e in equations if e.defines in subject.quantities)
    unknowns = dict.fromkeys((*subject.mechanism.assembly.unknowns, *defined))
    symbols = {q for e in equations for q in e.residual.free_symbols}
    return select_solvable(
        equations, [q for q in unknowns if isinstance(q, Quantity) and q in symbols]
    )


def _has_values(expr: Expr, subject: MechanismSubject) -> bool:
    """Whether an expression can be evaluated in the motion at all, be it real or not."""
    if not expr.free_symbols <= subject.quantities:
        return False
    try:
        Point(dict.fromkeys(expr.free_symbols, PROBE_VALUE))(expr)
    except UnknownNodeError:
        return False
    except (NotEvaluated, ArithmeticError, TypeError):
        return True
    return True


def _as_read(paper: Paper, printed: Equation) -> Expr:
    """Return the residual with its symbols replaced by the first of every admissible reading."""
    replacements = {**paper.reading, **paper.readings.get(printed.number, {})}
    residual = printed.residual
    for question in paper.questions:
        if printed.number in question.numbers and question.readings:
            first = question.readings[0]
            residual = residual if first.text is None else first.text
            replacements |= first.printed
    return residual.xreplace(replacements)


SECONDS = 1.0


def trial(stated: Mechanism | Formulas, paper: Paper, until: float = SECONDS) -> Case:
    r"""Compare all equations of a paper with a mechanism or formulas: what a file offers as CASE to
    `planter audit`.

    The size of a term is taken over the revolution of a mechanism that an angle drives, else over
    free motion ``until`` a time [s]. Raises ClaimError for a claim to be something that the
    mechanism or the formulas do not state.

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
    subject = build_subject(stated, until)
    if not isinstance(subject, MechanismSubject):
        case = Case(paper, subject)
    else:
        subject.printed = build_paper_chain(paper, subject)
        case = Case(
            paper, subject, (subject.printed, Chain({}, [])) if subject.printed.order else None
        )
    for number, equation in paper.equations.items():
        if not equation.stands_alone:
            case.derived(number)
    return case


def build_subject(
    stated: Mechanism | Formulas, until: float = SECONDS
) -> MechanismSubject | ConfigurationSubject | FormulasSubject:
    """Build the audit subject of formulas, of frames and points alone, or of a mechanism.

    That is driven by its angle, or moves freely ``until`` a time [s].
    """
    if isinstance(stated, Formulas):
        return FormulasSubject(stated)
    if all(body == stated.ground for body in stated.assembly.bodies):
        return ConfigurationSubject(stated)
    if stated.angle is None or stated.speed is None:
        return FreeSubject(stated, until)
    return DrivenSubject(stated, stated.angle, stated.speed)
