"""The identity that every finding must satisfy: print, corrections and missing terms are the
derivation.

A record holds all of it as text. `edited` is the print after its correction, to which `terms` are
added and from which `unexplained` is taken; the result is the derivation, or a constant multiple
where an equation defines no symbol.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import sympy as sp
from sympy import Expr

from derive.audit.case import Case
from derive.audit.comparison import Comparison, solve_for
from derive.audit.judge import FAULTS
from derive.audit.terms import Points
from derive.evaluate import Point
from derive.quantity import Quantity
from tests.support.replay import Parse, list_corrected

SOUND = ("confirmed", "confirmed as rebuilt")
RELATION_EDIT = re.compile("[<>]=? for [<>]=?")


def find_identity_failure(record: Mapping[str, Any], case: Case, points: Sequence[Point]) -> str:
    """Return why a finding does not account for the difference of its two sides; empty if it does.

    Points must be admissible; of an equation that holds in use alone, the cycle is taken. Records
    without two sides to compare have nothing to account for. Raises sympy.SympifyError for a text
    that is no formula.
    """
    if record["verdict"] not in (*SOUND, *FAULTS) or not (record["printed"] and record["derived"]):
        return ""
    at = tuple(case.cycle if record["domain"] else points)
    names = {str(symbol): symbol for symbol in at[0].values()}
    parse = partial(sp.sympify, locals=names)
    texts = record["printed"], record["edited"] or record["printed"], record["derived"]
    printed, edited, derived = (parse(text.rsplit(" ", 2)[0]) for text in texts)
    missing, unexplained = (
        sp.Add(*(parse(term["term"]) for term in record[key])) for key in ("terms", "unexplained")
    )
    symbol = names.get(record["defines"])
    if not _follows_by_words(printed, edited, record["correction"], symbol, at, parse):
        return "edited: it is not the print after the correction"
    left = missing - unexplained
    if record["derived"].split()[-2] != "=":
        same = any(_are_same(side, derived, at, bounds=True) for side in (edited, -edited))
        return (
            ""
            if same is (record["verdict"] != "contradicted")
            else "the conditions are not as the verdict says"
        )
    is_direction = symbol in case.directions
    scales = symbol is None
    completed = (
        edited + left if symbol is None else edited - left
    )  # terms are of what the equation gives
    if any(
        _are_same(side, derived, at, scales=scales, turns=is_direction)
        for side in (completed, -completed)
    ):
        return ""
    return "terms: print, corrections, missing and unexplained terms are not the derivation"


def _are_same(first: Expr, second: Expr, points: Points, **alike: bool) -> bool:
    return Comparison(first, second, points, **alike).same


def _follows_by_words(
    printed: Expr,
    edited: Expr,
    corrections: Sequence[str],
    symbol: Quantity | None,
    points: Points,
    parse: Parse,
) -> bool:
    """Whether a residual is the printed one after the edits that the first correction names."""
    words = [
        word
        for text in corrections[:1]
        for word in text.split("; ")
        if not RELATION_EDIT.fullmatch(word)
    ]
    start, end = printed, edited
    if symbol is not None:
        start, end = (solve_for(side, symbol) for side in (printed, edited))
    return any(_are_same(some, end, points) for some in list_corrected(start, words, parse))
