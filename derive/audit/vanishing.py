"""Terms that do not show because an assumption makes them zero, or because a reading makes printed terms cancel."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import sympy as sp
from sympy import Expr

from ..evaluate import Point
from .case import Case
from .terms import Match, expanded, remainder_vanishes
from .wording import Said, joined


@dataclass(frozen=True)
class Vanished:
    """A term, why it is zero, and whether the print has it."""

    term: Expr
    because: Said
    printed: bool


def vanished(case: Case, number: str, sign: Expr = sp.S.One) -> list[Vanished]:
    """What vanishes in an equation: terms of its derivation (times ``sign``), then those of the print."""
    return [*_derived(case, number, sign), *_read(case, number)]


def _derived(case: Case, number: str, sign: Expr) -> list[Vanished]:
    """Terms that the derivation has while the assumptions are lifted, and those that the print has."""
    reasons = case.assumed(number)
    kept = case.lifted(number)
    own = [sign * t for t in _lost(expanded(kept.residual), reasons, case.points)] if kept else []
    given = [t for t in expanded(case.paper.equations[number].residual) if t.free_symbols & reasons.keys()]
    only_printed = [t for t in given if t not in own and -t not in own]
    found = [(t, t in given or -t in given) for t in _sorted(own)] + [(t, True) for t in _sorted(only_printed)]
    return [Vanished(term, _why(term, reasons), printed) for term, printed in found]


def _lost(terms: Iterable[Expr], reasons: Mapping[sp.Symbol, str], points: list[Point]) -> list[Expr]:
    """Terms with a quantity that is assumed to be zero, without those with another in common that cancel anyway."""
    unit = dict.fromkeys(reasons, sp.S.One)
    lost = [term for term in terms if term.free_symbols & reasons.keys()]
    for symbol in sorted(set().union(*(t.free_symbols for t in lost)) - reasons.keys(), key=str):
        shared = [term for term in lost if symbol in term.free_symbols]
        whole = Match(tuple(term.xreplace(unit) for term in shared), ())
        if len(shared) > 1 and remainder_vanishes(whole, points):
            lost = [term for term in lost if term not in shared]
    return lost


def _why(term: Expr, reasons: Mapping[sp.Symbol, str]) -> Said:
    here = sorted(term.free_symbols & reasons.keys(), key=str)
    return joined("; ", (Said(s, f" = 0: {reasons[s]}") for s in here))


def _read(case: Case, number: str) -> list[Vanished]:
    """Printed terms that cancel, or are zero, when the printed symbols are read as what they stand for."""
    reading = {s: e for s, e in case.reading_of(number).items() if s not in case.assumed(number)}
    terms = expanded(case.paper.equations[number].residual)
    left = {m for _, m in _split(expanded(sp.Add(*terms).xreplace(reading)))}
    found = []
    for term in _sorted(terms):
        read = expanded(term.xreplace(reading))
        if not any(monomial in left for _, monomial in _split(read)):
            found.append(Vanished(term, case.read_as(number), True))
    return found


def _split(terms: tuple[Expr, ...]) -> list[tuple[Expr, Expr]]:
    return [term.as_coeff_Mul(rational=True) for term in terms]


def _sorted(terms: list[Expr] | tuple[Expr, ...]) -> list[Expr]:
    return sorted(terms, key=sp.default_sort_key)
