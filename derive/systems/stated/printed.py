"""The equations of a paper about a mechanism of one's own as a chain: what they give, one after another."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp
from sympy import Expr

from ...audit.paper import Paper
from ...chain import Chain, solvable
from ...equations import Definition, Equation
from ...evaluate import NotEvaluated, Point, UnknownNodeError
from ...quantity import Quantity
from .claims import Repaired
from .own import Own

SOME_VALUE = 0.3
"""A value of every quantity, to find out whether an expression has values."""


def chain(paper: Paper, own: Own) -> Chain:
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


def _has_values(expr: Expr, own: Own) -> bool:
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
