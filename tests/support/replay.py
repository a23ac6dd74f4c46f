"""Corrections in words, carried out again on the expression that they speak of.

This reads the sentences that `edits` and `comparison` write, and shares nothing with them, so that
a finding can be checked by what it says.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import permutations

import sympy as sp
from sympy import Basic, Expr

Parse = Callable[[str], Expr]
MOST_ORDERS = 120
"""Orders of several edits that are tried: those of five."""


class UnreadableEditError(ValueError):
    """A correction that is none of the known sentences."""


def list_corrected(expr: Expr, words: Sequence[str], parse: Parse) -> Iterator[Expr]:
    """Yield what an expression may be after edits in words, in every order, each at every place
    that it fits.

    Raises UnreadableEditError for a sentence that is not known.
    """
    for number, order in enumerate(permutations(words)):
        if number == MOST_ORDERS:
            return
        yield from _list_in_order(expr, order, parse)


def _list_in_order(expr: Expr, words: Sequence[str], parse: Parse) -> Iterator[Expr]:
    if not words:
        yield expr
        return
    for changed in _list_edited(expr, words[0], parse):
        yield from _list_in_order(changed, words[1:], parse)


def _list_edited(expr: Expr, sentence: str, parse: Parse) -> Iterator[Expr]:
    """Yield what an expression may be after one edit in words."""
    for pattern, apply in _SENTENCES.items():
        if match := re.fullmatch(pattern, sentence):
            yield from apply(expr, *(part and part.strip() for part in match.groups()), parse)
            return
    raise UnreadableEditError(f"{sentence}: no known correction")


def _list_replaced(expr: Basic, old: Basic, new: Basic) -> Iterator[Basic]:
    """Yield an expression with each one of the occurrences of a part replaced."""
    if expr == old:
        yield new
    for index, part in enumerate(expr.args):
        for changed in _list_replaced(part, old, new):
            yield expr.func(*expr.args[:index], changed, *expr.args[index + 1 :])


def _replace_throughout(expr: Expr, new: str, old: str, parse: Parse) -> Iterator[Expr]:
    yield expr.xreplace({parse(old): parse(new)})


def _exchange(expr: Expr, first: str, second: str, parse: Parse) -> Iterator[Expr]:
    yield expr.xreplace({parse(first): parse(second), parse(second): parse(first)})


def _exchange_cases(expr: Expr, first: str, second: str, parse: Parse) -> Iterator[Expr]:
    for cases in expr.atoms(sp.Piecewise):
        (value, condition), (other, rest) = cases.args
        if [str(condition), str(rest)] == [first, second]:
            yield expr.xreplace({cases: sp.Piecewise((other, condition), (value, rest))})


def _replace(expr: Expr, new: str, old: str, parse: Parse) -> Iterator[Expr]:
    yield from _list_replaced(expr, parse(old), parse(new))


def _scale(expr: Expr, factor: str, part: str, parse: Parse) -> Iterator[Expr]:
    """Multiply a part, wherever it stands; else a term of the sum multiplied out, or several terms
    of a sum.
    """
    number, scaled = parse(factor), parse(part)
    yield from _list_replaced(expr, scaled, number * scaled)
    group = set(sp.Add.make_args(scaled))
    for node in sorted(expr.atoms(sp.Add), key=sp.default_sort_key):
        if group < set(node.args):
            yield from _list_replaced(expr, node, node + (number - 1) * scaled)
    yield expr + (number - 1) * scaled


def _change_sign(expr: Expr, part: str, parse: Parse) -> Iterator[Expr]:
    yield from _scale(expr, "-1", part, parse)


def _scale_whole(expr: Expr, factor: str, parse: Parse) -> Iterator[Expr]:
    yield parse(factor) * expr


def _scale_argument(expr: Expr, factor: str, part: str, parse: Parse) -> Iterator[Expr]:
    function = parse(part)
    yield from _list_replaced(expr, function, function.func(parse(factor) * function.args[0]))


def _exchange_function(
    expr: Expr, new: str, old: str, argument: str, parse: Parse
) -> Iterator[Expr]:
    yield from _list_replaced(expr, parse(f"{old}({argument})"), parse(f"{new}({argument})"))


def _apply_function(expr: Expr, function: str, argument: str, parse: Parse) -> Iterator[Expr]:
    yield from _list_replaced(expr, parse(argument), parse(f"{function}({argument})"))


def _remove_function(expr: Expr, function: str, argument: str, parse: Parse) -> Iterator[Expr]:
    yield from _list_replaced(expr, parse(f"{function}({argument})"), parse(argument))


def _remove(expr: Expr, part: str, parse: Parse) -> Iterator[Expr]:
    yield from _list_replaced(expr, parse(part), sp.S.Zero)


_SENTENCES: Mapping[str, Callable[..., Iterator[Expr]]] = {
    r"cases (.+) and (.+) exchanged": _exchange_cases,
    r"(.+) and (.+) exchanged": _exchange,
    r"(.+) for (.+) throughout": _replace_throughout,
    r"(\w+) for (\w+) of (.+)": _exchange_function,
    r"(.+) for (.+)": _replace,
    r"factor (.+) on the whole": _scale_whole,
    r"factor (.+) on the argument of (.+)": _scale_argument,
    r"factor (.+) on (?:the group )?(.+)": _scale,
    r"sign of (?:the group )?(.+)": _change_sign,
    r"without (\w+) of (.+)": _remove_function,
    r"without (.+)": _remove,
    r"(\w+) of (.+)": _apply_function,
}
"""Sentences of corrections, the more special first, with what each does to an expression."""
