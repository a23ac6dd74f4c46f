"""Errors planted in printed equations by program, and rewrites that change nothing: what an audit is tested with.

Independent of the audit's own edits: nothing here imports them.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache

import sympy as sp
from mpmath import mpf
from sympy import Basic, Expr

from derive.audit.judge import Comparison, Judgement, judge
from derive.audit.subject import Subject
from derive.dimensions import DimensionError, dimension, of_unit
from derive.equations import Equation
from derive.evaluate import NotEvaluated, Point
from derive.paper import Paper
from derive.pipeline import TRIALS
from derive.quantity import Quantity

SUBJECTS = {paper.PAPER.name: (paper, system) for paper, system in TRIALS}
FACTORS = (sp.Integer(2), sp.Rational(1, 2), sp.pi / 180)
FUNCTIONS = (sp.atan, sp.asin, sp.acos, sp.tan, sp.sin, sp.cos)
REVERSED = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}
DOTS = re.compile(r"_(d*)dot$")
INDEX = re.compile(r"[xyz0-9]+(_2)?$")
SLOW = 20
"""Equations that are not confirmed and have more terms than this, both sides together, are slow to judge."""
EQUAL = mpf(10) ** -42

Path = tuple[int, ...]
Planted = tuple[str, Expr]


@dataclass(frozen=True)
class Mutant:
    """A printed equation with one error in it, and what the error is."""

    kind: str
    what: str
    equation: Equation


@cache
def subject(name: str) -> Subject:
    """The subject of a paper."""
    return Subject.of(*SUBJECTS[name])


def tried(name: str, equation: Equation) -> Judgement:
    """The judgement on an equation in the place of the printed one of its number."""
    own = subject(name)
    return judge(*_pair(name, equation), own.points, own.words)


@cache
def untouched(name: str, number: str) -> Judgement:
    """The judgement on an equation as printed."""
    return tried(name, subject(name).paper.equations[number])


def outcome(found: Judgement) -> tuple[str, frozenset[tuple[str, ...]], frozenset[Expr], frozenset[Expr]]:
    """What has to change: verdict, corrections, terms that the print lacks or that have no explanation."""
    return found.verdict, frozenset(found.corrections), frozenset(found.missing), frozenset(found.unexplained)


def _pair(name: str, equation: Equation) -> tuple[Equation, Equation | None]:
    own = subject(name)
    alone = Paper(name, "", {equation.number: equation})
    return replace(own, paper=alone, derive_claims=lambda: own.claims).pair(equation.number)


@cache
def derivable(name: str) -> tuple[str, ...]:
    """Numbers of the equations that can be read, are derived and quick to judge with an error in them.

    Slow are those that are not confirmed and have many terms, or mix dimensions: there any symbol may be meant.
    """
    return tuple(n for n, e in subject(name).paper.equations.items() if e.legibility != "lost" and _is_quick(name, e))


def _is_quick(name: str, equation: Equation) -> bool:
    printed, derived = _pair(name, equation)
    if derived is None:
        return False
    few = sum(map(_size, (printed.residual, derived.residual))) <= SLOW
    return is_sound(name, equation) or (few and is_consistent(printed))


def _size(expr: Expr) -> int:
    return len(sp.Add.make_args(sp.expand(expr, trig=False)))


@cache
def is_sound(name: str, equation: Equation) -> bool:
    """Whether an equation is confirmed, found without judging it: its derivation gives the same at every point."""
    printed, derived = _pair(name, equation)
    if derived is None or printed.relation != derived.relation:
        return False
    both = Comparison(printed.residual, derived.residual, subject(name).points)
    return both.equal or both.edited(-printed.residual).equal


def is_consistent(equation: Equation) -> bool:
    """Whether all terms of an equation have one dimension."""
    try:
        dimension(equation.residual)
    except DimensionError:
        return False
    return True


@cache
def mutants(name: str, count: int, seed: int = 0) -> tuple[Mutant, ...]:
    """Different errors in the equations of a paper, kind after kind, each proven to change what is said."""
    rng = random.Random(f"{name} {seed}")
    pools = {kind: _pool(name, kind) for kind in KINDS}
    for pool in pools.values():
        rng.shuffle(pool)
    found: list[Mutant] = []
    while len(found) < count and any(pools.values()):
        for pool in pools.values():
            chosen = next((m for m in _drained(pool) if changes(name, m.equation)), None)
            found += [chosen] if chosen and len(found) < count else []
    return tuple(found)


def _drained(pool: list[Mutant]) -> Iterator[Mutant]:
    while pool:
        yield pool.pop()


def _pool(name: str, kind: str) -> list[Mutant]:
    """Every error of a kind in the equations of a paper."""
    own = subject(name)
    return [
        Mutant(kind, what, mutated)
        for number in derivable(name)
        for what, mutated in KINDS[kind](own.paper.equations[number], own.words)
        if is_sound(name, own.paper.equations[number]) or is_consistent(mutated)
    ]


def changes(name: str, equation: Equation) -> bool:
    """Whether an equation says something else than the printed one, at 50 digits at some admissible point."""
    printed = subject(name).paper.equations[equation.number]
    if equation.relation != printed.relation:
        return True
    before, after = (_pair(name, e)[0].residual for e in (printed, equation))
    signs = (1,) if printed.defines or printed.relation != "=" else (1, -1)
    return all(any(_differs(p, before, sign * after) for p in subject(name).points) for sign in signs)


def _differs(point: Point, one: Expr, other: Expr) -> bool:
    first = point(one)
    size = max(abs(point(t)) for t in sp.Add.make_args(one))
    try:
        second = point(other)
    except NotEvaluated:
        return all(s in point for s in other.free_symbols)
    return abs(first - second) > EQUAL * max(size, abs(second))


# places


def places(expr: Basic, path: Path = ()) -> Iterator[tuple[Path, Expr]]:
    """Every subexpression with the way to it; conditions are left out."""
    if isinstance(expr, Expr):
        yield path, expr
    for index, part in enumerate(expr.args):
        if not isinstance(part, sp.logic.boolalg.Boolean) or part.is_Symbol:
            yield from places(part, (*path, index))


def put(expr: Basic, path: Path, new: Basic) -> Basic:
    """``expr`` with another subexpression at a place."""
    if not path:
        return new
    index, *rest = path
    return expr.func(*expr.args[:index], put(expr.args[index], tuple(rest), new), *expr.args[index + 1 :])


def rewritten(equation: Equation, change: Callable[[Expr], Expr]) -> Equation:
    """An equation with its right side changed if it defines a symbol, else with its residual changed."""
    symbol = equation.defines
    if symbol is None:
        return replace(equation, residual=change(equation.residual))
    return replace(equation, residual=symbol - change(symbol - equation.residual))


def _everywhere(
    here: Callable[[Expr, list[Quantity]], Iterable[Planted]],
) -> Callable[[Equation, list[Quantity]], Iterator[tuple[str, Equation]]]:
    """An error at one place, at each place of an equation."""

    def planted(equation: Equation, words: list[Quantity]) -> Iterator[tuple[str, Equation]]:
        symbol = equation.defines
        said = equation.residual if symbol is None else symbol - equation.residual
        for path, node in places(said):
            for what, new in here(node, words):
                mutated = put(said, path, new)
                yield what, replace(equation, residual=mutated if symbol is None else symbol - mutated)

    return planted


# kinds of error


def _sign(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    if isinstance(node, sp.Add):
        for term in node.args:
            yield f"sign of {term}", node - 2 * term


def _factor(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    for factor in FACTORS:
        if isinstance(node, sp.Add):
            yield from ((f"factor {factor} on {t}", node + (factor - 1) * t) for t in node.args)
        if isinstance(node, FUNCTIONS):
            yield f"factor {factor} on the argument of {node}", node.func(factor * node.args[0])


def _symbol(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    if isinstance(node, Quantity):
        for other in words:
            if other != node and of_unit(other.unit) == of_unit(node.unit):
                yield f"{other} for {node}", other


def _index(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    return (p for p in _symbol(node, words) if INDEX.sub("", str(p[1])) == INDEX.sub("", str(node)))


def _dots(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    if isinstance(node, Quantity):
        for other in words:
            if other != node and DOTS.sub("", other.name) == DOTS.sub("", node.name):
                yield f"{other} for {node}", other


def _cosine(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    if isinstance(node, sp.sin | sp.cos):
        other = sp.cos if isinstance(node, sp.sin) else sp.sin
        yield f"{other.__name__} of {node.args[0]}", other(node.args[0])


def _function(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    if isinstance(node, FUNCTIONS):
        yield f"without {node.func.__name__} of {node.args[0]}", node.args[0]


def _branches(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    if isinstance(node, sp.Piecewise) and len(node.args) == 2:
        (first, condition), (second, other) = node.args
        yield "conditions exchanged", sp.Piecewise((second, condition), (first, other))


def _throughout(equation: Equation, words: list[Quantity]) -> Iterator[tuple[str, Equation]]:
    for symbol in sorted(equation.residual.free_symbols - {equation.defines}, key=str):
        if equation.residual.count(symbol) > 1:
            for _, other in _symbol(symbol, words):
                swap = equation.residual.xreplace({symbol: other})
                if equation.defines not in (None, other):
                    yield f"{other} for {symbol} throughout", replace(equation, residual=swap)


def _whole(equation: Equation, words: list[Quantity]) -> Iterator[tuple[str, Equation]]:
    for factor in (sp.S.NegativeOne, *FACTORS):
        if equation.defines is not None:
            yield f"factor {factor} on the whole", rewritten(equation, lambda e, f=factor: f * e)


def _relation(equation: Equation, words: list[Quantity]) -> Iterator[tuple[str, Equation]]:
    if equation.relation in REVERSED:
        yield "reversed", replace(equation, relation=REVERSED[equation.relation])


KINDS: dict[str, Callable[[Equation, list[Quantity]], Iterable[tuple[str, Equation]]]] = {
    "sign": _everywhere(_sign),
    "symbol": _everywhere(_symbol),
    "factor": _everywhere(_factor),
    "sine": _everywhere(_cosine),
    "dots": _everywhere(_dots),
    "function": _everywhere(_function),
    "relation": _relation,
    "branches": _everywhere(_branches),
    "index": _everywhere(_index),
    "throughout": _throughout,
    "whole": _whole,
}
"""What slips of the pen, the typesetter and the scanner do, by name."""

# rewrites that change nothing


def _held(function: type[sp.Function]) -> Callable[[Expr], Expr]:
    return lambda argument: function(argument, evaluate=False)


_sin, _cos, _tan = (_held(f) for f in (sp.sin, sp.cos, sp.tan))


def _replaced(old: type[Basic], new: Callable[..., Expr]) -> Callable[[Expr], Expr]:
    return lambda expr: expr.replace(old, new)


def _reversed(expr: Expr) -> Expr:
    return expr.func(*reversed(expr.args), evaluate=False) if isinstance(expr, sp.Add | sp.Mul) else expr


def _product(base: Expr, exponent: Expr) -> Expr:
    return sp.Mul(base, base, evaluate=False) if exponent == 2 else sp.Pow(base, exponent)


def _conditions_turned(expr: Expr) -> Expr:
    return expr.replace(
        sp.Piecewise, lambda *cases: sp.Piecewise(*((v, c.reversed if c.is_Relational else c) for v, c in cases[::-1]))
    )


def _sides_exchanged(equation: Equation) -> Equation:
    if equation.defines is not None:
        return equation
    relation = REVERSED.get(equation.relation, equation.relation)
    return replace(equation, residual=-equation.residual, relation=relation)


def _said(change: Callable[[Expr], Expr]) -> Callable[[Equation], Equation]:
    return lambda equation: rewritten(equation, change)


REWRITES: dict[str, Callable[[Equation], Equation]] = {
    "sides exchanged": _sides_exchanged,
    "multiplied out": _said(sp.expand),
    "products multiplied out": _said(sp.expand_mul),
    "factored": _said(sp.factor),
    "common factors taken out": _said(sp.factor_terms),
    "one fraction": _said(sp.together),
    "terms reversed": _said(_reversed),
    "double negation": _said(lambda e: sp.Mul(-1, sp.Mul(-1, e, evaluate=False), evaluate=False)),
    "halves of the double": _said(
        lambda e: e and sp.Mul(sp.Rational(1, 2), sp.Mul(2, e, evaluate=False), evaluate=False)
    ),
    "divided by one": _said(lambda e: sp.Mul(e, sp.Pow(sp.Integer(1), -1, evaluate=False), evaluate=False)),
    "sin(pi - x)": _said(_replaced(sp.sin, lambda x: _sin(sp.pi - x))),
    "-sin(-x)": _said(_replaced(sp.sin, lambda x: -_sin(-x))),
    "cos(-x)": _said(_replaced(sp.cos, lambda x: _cos(-x))),
    "-cos(pi - x)": _said(_replaced(sp.cos, lambda x: -_cos(sp.pi - x))),
    "cos(2 pi + x)": _said(_replaced(sp.cos, lambda x: _cos(2 * sp.pi + x))),
    "tan(pi + x)": _said(_replaced(sp.tan, lambda x: _tan(sp.pi + x))),
    "sin/cos for tan": _said(_replaced(sp.tan, lambda x: sp.sin(x) / sp.cos(x))),
    "-atan(-x)": _said(_replaced(sp.atan, lambda x: -sp.atan(-x, evaluate=False))),
    "squares as products": _said(_replaced(sp.Pow, _product)),
    "sin^2 + cos^2 for one": _said(lambda e: e * (sp.sin(1) ** 2 + sp.cos(1) ** 2)),
    "sums of angles multiplied out": _said(sp.expand_trig),
    "conditions the other way round": _said(_conditions_turned),
}
"""Other ways to write the same, by name."""
PLACES_KEPT = ("sides exchanged", "terms reversed", "double negation", "halves of the double", "one fraction",
               "cos(-x)", "-sin(-x)", "sin/cos for tan", "-atan(-x)", "squares as products")  # fmt: skip
"""Rewrites that keep the places at which an equation may be corrected: the rest may join or split them."""
