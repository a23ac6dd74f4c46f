"""Judgement of an equation under every reading, and along the machine's own cycle: the mildest
one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import mpmath
import sympy as sp
from sympy import Expr

from ..equations import Definition, Equation
from ..evaluate import TOLERANCE, Point
from ..quantity import is_consistent
from .case import AS_READ, Case, Choice
from .comparison import align_derived, are_equivalent, solve_for
from .judge import (
    FAULTS,
    UNJUDGED,
    Judgement,
    complete_print,
    describe_dimensions,
    explain_unjudged,
    judge_condition,
    judge_equation,
)
from .terms import (
    Points,
    differs_by_turns,
    find_largest_size,
    format_value,
    holds,
    list_unknown,
)
from .typesetting import Piece, Said, join_parts

SHOWN = 3
"""Symbols of which a remark gives the values."""


def confirm_in_use(
    case: Case, printed: Equation, derived: Equation | None, judgement: Judgement
) -> Judgement:
    """Return the judgement, or that the equation holds where the machine uses it, with a place
    where it does not.
    """
    if judgement.verdict not in FAULTS or not is_consistent(printed.residual):
        return judgement
    where = sp.true if derived is None else derived.where
    for points in (case.cycle, case.nearby):
        if not _says_the_same(
            case, printed, derived, [point for point in points if point.holds(where)]
        ):
            return judgement
    outside = next(
        (p for p in case.points_where(where) if not _says_the_same(case, printed, derived, [p])),
        None,
    )
    if outside is None:
        return judgement
    domain = _describe_failure(printed, derived, outside)
    finding = Said("it holds where the machine uses it, and not everywhere: ", domain)
    return Judgement(
        "confirmed as rebuilt" if printed.rebuilt else "confirmed", finding, domain=domain
    )


def _says_the_same(
    case: Case, printed: Equation, derived: Equation | None, points: list[Point]
) -> bool:
    sides = [printed, derived] if derived else [printed]
    if not points or any(list_unknown(side.residual, points) for side in sides):
        return False
    at: Points = tuple(points)
    if derived is None:
        return printed.relation == "=" and holds(printed.residual, at)
    return are_equivalent(printed, derived, at, printed.defines in case.directions)


def _describe_failure(printed: Equation, derived: Equation | None, point: Point) -> Said:
    """Return where an equation does not hold: values of its symbols if they are few, and of both
    sides.
    """
    symbols = sorted(printed.residual.free_symbols - {printed.defines}, key=str)
    places: list[Piece] = [Said(s, f" = {mpmath.nstr(point(s), 4)}") for s in symbols[:SHOWN]]
    where = (
        Said("at ", join_parts(", ", places))
        if len(symbols) <= SHOWN
        else Said("at a random point")
    )
    if derived is None:
        return Said(where, f" {_format_side(printed, point)} is left")
    return Said(
        where, f" it gives {_format_side(printed, point)} for {_format_side(derived, point)}"
    )


def _format_side(side: Equation, point: Point) -> str:
    """The value of what an equation defines its symbol as, or of its residual."""
    return format_value(solve_for(side.residual, side.defines), point)


def fold_terms(terms: Iterable[Expr], folds: Mapping[sp.Symbol, Expr]) -> tuple[Expr, ...]:
    """Return the same sum in fewer terms, if ``folds`` replace a difference of symbols by one
    symbol.
    """
    total, back = sp.Add(*terms), dict[sp.Symbol, Expr]()
    for symbol, base in folds.items():
        if symbol in total.free_symbols:
            difference = sp.Dummy(str(symbol), real=True)
            trial = sp.expand(total.xreplace({symbol: base + difference}), trig=False)
            if len(sp.Add.make_args(trial)) < len(sp.Add.make_args(total)):
                total, back = trial, back | {difference: symbol - base}
    return tuple(term.xreplace(back) for term in sp.Add.make_args(total) if term != 0)


@dataclass(frozen=True)
class Hearing:
    """A judgement with the two sides that it was given on, under one reading."""

    judgement: Judgement
    printed: Equation
    derived: Equation | None
    choice: Choice = AS_READ


@dataclass(frozen=True)
class Outcome:
    """Findings on an equation: under the reading that is kindest to it, and under every other."""

    kindest: Hearing
    alternatives: tuple[Hearing, ...] = ()

    @property
    def robust(self) -> bool:
        """Whether every reading gives the same verdict."""
        return (
            len({hearing.judgement.verdict for hearing in (self.kindest, *self.alternatives)}) == 1
        )


def judge_linked_readings(case: Case, number: str) -> dict[str, Outcome]:
    """Outcomes of an equation and of those that share questions with it, under one answer to each
    question.

    Taken is the joint answer with the least sum of severities; of equally kind ones that which
    stands first. A reading under which judging raises an error is `not judged`, and the least kind.
    """
    if not case.choices(number):
        return {number: Outcome(_attempted(case, number, AS_READ))}
    numbers = case.linked(number)
    all_hearings = {
        n: tuple(_attempted(case, n, choice) for choice in case.choices(n)) for n in numbers
    }

    def select_joint(joint: Mapping[str, Choice]) -> dict[str, Hearing]:
        return {
            n: next(h for h in all_hearings[n] if h.choice == choice) for n, choice in joint.items()
        }

    def severity(hearings: Mapping[str, Hearing]) -> tuple[int, ...]:
        return tuple(map(sum, zip(*(h.judgement.severity for h in hearings.values()), strict=True)))

    kindest = min(map(select_joint, case.joint_choices(numbers)), key=severity)
    return {n: Outcome(hearing, all_hearings[n]) for n, hearing in kindest.items()}


def _attempted(case: Case, number: str, choice: Choice) -> Hearing:
    try:
        return _heard(case, number, choice)
    except Exception as error:  # whatever a print contains, it must not end the audit of the others
        return Hearing(explain_unjudged(error), case.paper.equations[number], None, choice)


def _heard(case: Case, number: str, choice: Choice) -> Hearing:
    """The mildest judgement among the footings, reported on the one that leaves fewest terms.

    A footing that leaves printed terms unexplained counts if the mildest one explains them: they
    are then parts of what the print lacks there.
    """
    hearings = [
        Hearing(_judged(case, printed, derived), printed, derived, choice)
        for printed, derived in case.footings(number, choice)
    ]
    mildest = min(hearings, key=lambda hearing: hearing.judgement.severity)
    if loose := _loose(case, mildest):
        return replace(mildest, judgement=_unheld(mildest.judgement, loose))
    if mildest.judgement.verdict not in FAULTS:
        return mildest
    kindest, alike = mildest.judgement, list[Hearing]()
    for hearing in hearings:
        terms = fold_terms(hearing.judgement.missing, case.subject.folds())
        folded = replace(hearing, judgement=replace(hearing.judgement, missing=terms))
        if kindest.missing and not kindest.unexplained:
            folded = _absorb_printed_terms(folded, case.cycle)
        left = folded.judgement
        # only what leaves the same says the same in other terms
        if left.unexplained == kindest.unexplained and bool(left.missing) == bool(kindest.missing):
            alike.append(folded)
    shortest = min(alike, key=lambda hearing: _length(hearing.judgement))
    judgement = replace(shortest.judgement, verdict=kindest.verdict, finding=kindest.finding)
    return replace(shortest, judgement=judgement)


def _absorb_printed_terms(hearing: Hearing, cycle: Sequence[Point]) -> Hearing:
    """Return a hearing whose unexplained printed terms are taken from what is missing.

    Each is taken from the missing action that it is the largest part of: of which it leaves least
    over the cycle.
    """
    judgement, derived = hearing.judgement, hearing.derived
    missing = list(judgement.missing)
    if not judgement.unexplained or not missing or derived is None:
        return hearing
    for printed in judgement.unexplained:
        left = [_size(term - printed, cycle) - _size(term, cycle) for term in missing]
        missing[left.index(min(left))] -= printed
    absorbed = replace(judgement, missing=tuple(missing), unexplained=())
    corrected = complete_print(hearing.printed, derived, absorbed, tuple(cycle))
    return replace(hearing, judgement=replace(absorbed, corrected=corrected))


def _size(expr: Expr, cycle: Sequence[Point]) -> mpmath.mpf:
    return find_largest_size(expr, cycle) or mpmath.mpf(0)


def _judged(case: Case, printed: Equation, derived: Equation | None) -> Judgement:
    points = case.points if derived is None else case.points_where(derived.where)
    judgement = None
    if case.source is not None:
        judgement = _judged_by_source(case, printed, derived, points)
    if judgement is None:
        judgement = judge_equation(printed, derived, points, case.words, case.directions)
        judgement = confirm_in_use(case, printed, derived, judgement)
    return _name_suspects(case, printed, judgement)


def _name_suspects(case: Case, printed: Equation, judgement: Judgement) -> Judgement:
    """Return the judgement on an equation at fault with what may be wrong instead of it."""
    if case.source is None or judgement.verdict not in FAULTS:
        return judgement
    suspects = case.source.describe_footing(printed.number)
    finding = Said(judgement.finding, f"; {suspects}") if suspects else judgement.finding
    return replace(judgement, finding=finding)


def _judged_by_source(
    case: Case, printed: Equation, derived: Equation | None, points: list[Point]
) -> Judgement | None:
    """Return the judgement on an equation of a text: it holds in the motion, or does after a change
    of its LaTeX.

    None if neither is so, or if it has to be compared with its derivation.
    """
    assert case.source is not None
    if reason := case.source.explain_unjudged(printed.number):
        return Judgement(UNJUDGED, reason)
    if clash := case.source.find_clash(printed.number):
        return Judgement("contradicted", f"not dimensionally consistent; {clash}")
    if use := case.source.describe_use(printed.number):
        return Judgement("untested", use)
    symbols = printed.residual.free_symbols
    if isinstance(printed.claims, Definition) or any(
        s not in point for s in symbols for point in points
    ):
        return None
    if printed.relation != "=":
        return judge_condition(printed, case.cycle)
    if holds(printed.residual, tuple(points)):
        return Judgement("confirmed", "it holds at every point that was tried")
    if case.source.compares_angles(printed.number) and differs_by_turns(
        printed.residual, tuple(points)
    ):
        return Judgement("confirmed", "it holds at every point that was tried, up to whole turns")
    in_use = confirm_in_use(case, printed, derived, Judgement("contradicted", ""))
    if in_use.domain:
        return in_use
    if linearised := _judge_linearised(case, printed):
        return linearised
    repair = case.source.repair(printed.number, points, case.draw)
    if repair is None:
        return None
    corrections = tuple((Said(text),) for text in (repair.text, *repair.alternatives))
    finding = f"{describe_dimensions(printed)}removed by a change of its LaTeX"
    return Judgement("misprint", finding, corrections)


def _judge_linearised(case: Case, printed: Equation) -> Judgement | None:
    """Return the judgement on a linearised equation that holds to first order about an equilibrium,
    else None.
    """
    assert case.source is not None
    if not is_consistent(printed.residual):
        return None
    is_announced = case.source.announces_small_motion(printed.number)
    about = [
        some.name for some in case.equilibria if some.describes(printed.residual, is_announced)
    ]
    if not about:
        return None
    outside = _describe_failure(printed, None, case.points[0])
    finding = f"it holds to first order about {', and about '.join(about)}, and not everywhere: "
    return Judgement("confirmed", Said(finding, outside), domain=Said(f"near {about[0]} alone"))


def _loose(case: Case, hearing: Hearing) -> dict[str, Expr]:
    """Return the residuals at supports that do not vanish by the printed formula at its
    correction.
    """
    symbol, judgement = hearing.printed.defines, hearing.judgement
    if symbol is None or hearing.printed.legibility == "lost":
        return {}
    formula = (
        judgement.edits[-1].result
        if judgement.edits
        else solve_for(hearing.printed.residual, symbol)
    )
    constraints = case.subject.constraint_residuals(hearing.printed.claims, formula)
    constraints = {
        name: left.xreplace(hearing.choice.derived) for name, left in constraints.items()
    }
    return {
        name: left
        for name, left in constraints.items()
        if any(abs(point(left)) > TOLERANCE for point in case.points)
    }


def _unheld(judgement: Judgement, loose: Mapping[str, Expr]) -> Judgement:
    pieces = [Said(f"{name} is ", left, ", and must be 0") for name, left in loose.items()]
    if judgement.verdict in FAULTS:
        pieces.insert(0, Said(judgement.finding))
    return replace(judgement, verdict="contradicted", finding=join_parts("; ", pieces), loose=loose)


def _length(judgement: Judgement) -> int:
    """Return the number of edits and of terms left over."""
    return len(judgement.edits) + len(judgement.missing) + len(judgement.unexplained)


def derived_side(case: Case, hearing: Hearing) -> Equation | None:
    """The derived side of a hearing with the sign of the printed one; None where there is nothing
    to compare.
    """
    if hearing.derived is None or hearing.judgement.verdict == UNJUDGED:
        return None
    return align_derived(hearing.printed, hearing.derived, tuple(case.points))
