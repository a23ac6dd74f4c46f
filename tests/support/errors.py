"""What slips of the pen, the typesetter and the scanner do to an equation, by program.

Independent of the audit's own edits: nothing here imports them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import sympy as sp
from sympy import Basic, Expr

from derive.equations import Equation
from derive.quantity import Quantity, of_unit

FACTORS = (sp.Integer(2), sp.Rational(1, 2), sp.pi / 180)
FUNCTIONS = (sp.atan, sp.asin, sp.acos, sp.tan, sp.sin, sp.cos)
REVERSED = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}
DOTS = re.compile(r"_(d*)dot$")
INDEX = re.compile(r"[xyz0-9]+(_2)?$")

Path = tuple[int, ...]
Planted = tuple[str, Expr]


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
    return expr.func(
        *expr.args[:index], put(expr.args[index], tuple(rest), new), *expr.args[index + 1 :]
    )


def rewritten(equation: Equation, change: Callable[[Expr], Expr]) -> Equation:
    """An equation with its right side changed if it defines a symbol, else with its residual
    changed.
    """
    symbol = equation.defines
    if symbol is None:
        return replace(equation, residual=change(equation.residual))
    return replace(equation, residual=symbol - change(symbol - equation.residual))


def _everywhere(
    generate_errors: Callable[[Expr, list[Quantity]], Iterable[Planted]],
) -> Callable[[Equation, list[Quantity]], Iterator[tuple[str, Equation]]]:
    """An error at one place, at each place of an equation."""

    def planted(equation: Equation, words: list[Quantity]) -> Iterator[tuple[str, Equation]]:
        symbol = equation.defines
        solved = equation.residual if symbol is None else symbol - equation.residual
        for path, node in places(solved):
            for description, new in generate_errors(node, words):
                mutated = put(solved, path, new)
                yield (
                    description,
                    replace(equation, residual=mutated if symbol is None else symbol - mutated),
                )

    return planted


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
        yield f"{other.__name__} of {node.args[0]}", other(node.args[0], evaluate=False)


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


def _plant_everywhere(equation: Equation, words: list[Quantity]) -> Iterator[tuple[str, Equation]]:
    for factor in (sp.S.NegativeOne, *FACTORS):
        if equation.defines is not None:
            yield f"factor {factor} on the whole", rewritten(equation, lambda e, f=factor: f * e)


def _relation(equation: Equation, words: list[Quantity]) -> Iterator[tuple[str, Equation]]:
    if equation.relation in REVERSED:
        yield "reversed", replace(equation, relation=REVERSED[equation.relation])


def _deletion(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    if isinstance(node, sp.Add):
        yield from ((f"{term} deleted", node - term) for term in node.args)


def _surplus(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    """A quantity of the equation's own once more, in a sum."""
    if isinstance(node, sp.Add) and len(node.args) < 6:
        symbols = sorted((s for s in node.free_symbols if isinstance(s, Quantity)), key=str)
        for symbol in symbols:
            if any(term == symbol or -term == symbol for term in node.args):
                for other in symbols:
                    if other != symbol and of_unit(other.unit) == of_unit(symbol.unit):
                        yield f"{other} too many", node + other


def _group(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    if isinstance(node, sp.Add) and len(node.args) > 3:
        for first, second in zip(node.args, node.args[1:], strict=False):
            yield f"sign of {first + second}", node - 2 * (first + second)


def _group_factor(node: Expr, words: list[Quantity]) -> Iterator[Planted]:
    if isinstance(node, sp.Add) and len(node.args) > 3:
        for first, second in zip(node.args, node.args[1:], strict=False):
            yield f"factor 2 on {first + second}", node + first + second


def _twice(equation: Equation, words: list[Quantity]) -> Iterator[tuple[str, Equation]]:
    """Signs of two, and of three, different terms of a sum."""
    solved = equation.residual if equation.defines is None else equation.defines - equation.residual
    terms = sp.Add.make_args(solved)
    for count in (2, 3):
        for start in range(len(terms) - count + 1 if len(terms) > 2 * count else 0):
            chosen = terms[start::2][:count]
            mutated = solved - 2 * sp.Add(*chosen)
            residual = mutated if equation.defines is None else equation.defines - mutated
            yield f"signs of {', '.join(map(str, chosen))}", replace(equation, residual=residual)


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
    "whole": _plant_everywhere,
    "deletion": _everywhere(_deletion),
    "surplus": _everywhere(_surplus),
    "group": _everywhere(_group),
    "group factor": _everywhere(_group_factor),
    "several": _twice,
}
"""What slips of the pen, the typesetter and the scanner do, by name."""
