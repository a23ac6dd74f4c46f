"""Slips of one character or word in the LaTeX of an equation, and rewrites of it that change
nothing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from .corrections import LatexChange, list_dotted
from .formula import (
    Bracket,
    Name,
    Power,
    Product,
    Quotient,
    RelationChain,
    Sum,
    Symbol,
    Token,
    list_nodes,
    read_formula,
    tokenize_formula,
)
from .names import StatedNames

EXCHANGED = {r"\sin": r"\cos", r"\cos": r"\sin", r"\tan": r"\sin"}


@dataclass(frozen=True)
class PrintedFormula:
    """An equation in its own LaTeX with its tree, and the names of the text that have a meaning."""

    latex: str
    chain: RelationChain
    tokens: tuple[Token, ...]
    names: StatedNames
    vocabulary: tuple[str, ...]

    @classmethod
    def read(
        cls,
        latex: str,
        macros: Mapping[str, tuple[int, str]],
        names: StatedNames,
        vocabulary: Sequence[str],
    ) -> PrintedFormula:
        """Read an equation. Raises FormulaError if it cannot be read."""
        tokens = tuple(token for token in tokenize_formula(latex, macros) if not token.fixed)
        return cls(latex, read_formula(latex, macros), tokens, names, tuple(vocabulary))

    def list_named(self) -> list[Name]:
        """Return the names that stand in the equation itself, not in a macro."""
        starts = {token.start for token in self.tokens}
        return [
            node
            for node in list_nodes(self.chain)
            if isinstance(node, Name) and node.start in starts
        ]


def _change_signs(printed: PrintedFormula) -> Iterator[LatexChange]:
    for token in printed.tokens:
        if token.text in ("+", "-"):
            yield LatexChange(
                ((token.start, token.end, "-" if token.text == "+" else "+"),), "another sign"
            )


def _change_numbers(printed: PrintedFormula) -> Iterator[LatexChange]:
    for token in printed.tokens:
        if token.text.isdigit() and printed.latex[token.start - 1 : token.start] not in ("_", "^"):
            for other in (int(token.text) + 1, 2 * int(token.text)):
                yield LatexChange(
                    ((token.start, token.end, str(other)),), f"{other} for {token.text}"
                )


def _change_names(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield other names of the text for a name: with another index first, for these are what is
    mistaken most.
    """
    for node in printed.list_named():
        spelling = node.symbol.spell()
        alike = [
            other for other in printed.vocabulary if _read_symbol(other).stem == node.symbol.stem
        ]
        for other in dict.fromkeys([*alike, *printed.vocabulary]):
            if other != spelling and _read_symbol(other).dots == node.symbol.dots:
                yield LatexChange(((node.start, node.end, other),), f"{other} for {spelling}")


def _read_symbol(spelling: str) -> Symbol:
    node = read_formula(f"{spelling} = 0").sides[0]
    return node.symbol if isinstance(node, Name) else Symbol(spelling)


def _change_dots(printed: PrintedFormula) -> Iterator[LatexChange]:
    for node in printed.list_named():
        for other in list_dotted(node.symbol, printed.names):
            yield LatexChange(
                ((node.start, node.end, other.spell()),),
                f"{other.spell()} for {node.symbol.spell()}",
            )


def _change_powers(printed: PrintedFormula) -> Iterator[LatexChange]:
    for node in list_nodes(printed.chain):
        tail = printed.latex[node.base.end : node.end] if isinstance(node, Power) else ""
        if isinstance(node, Power) and re.fullmatch(r"\s*\^(?:\d|\{\d\})", tail):
            yield LatexChange(((node.base.end, node.end, ""),), f"without {tail.strip()}")
            yield LatexChange(((node.base.end, node.end, "^3"),), f"^3 for {tail.strip()}")
    powers = {node.base.end for node in list_nodes(printed.chain) if isinstance(node, Power)}
    for node in list_nodes(printed.chain):
        if (
            isinstance(node, Name | Bracket)
            and node.end not in powers
            and not printed.latex[node.end :].startswith("^")
        ):
            yield LatexChange(((node.end, node.end, "^2"),), "a square")


def _change_functions(printed: PrintedFormula) -> Iterator[LatexChange]:
    for token in printed.tokens:
        if token.text in EXCHANGED:
            other = EXCHANGED[token.text]
            yield LatexChange(((token.start, token.end, other),), f"{other} for {token.text}")


def _drop_terms(printed: PrintedFormula) -> Iterator[LatexChange]:
    for node in list_nodes(printed.chain):
        for _, term in node.terms[1:] if isinstance(node, Sum) else ():
            sign = re.search(r"[+\-]\s*$", printed.latex[: term.start])
            if sign:
                yield LatexChange(((sign.start(), term.end, ""),), "a term lost")


def _drop_factors(printed: PrintedFormula) -> Iterator[LatexChange]:
    for node in list_nodes(printed.chain):
        factors = [factor for _, factor in node.factors] if isinstance(node, Product) else []
        for factor in factors:
            if len(factors) > 1 and isinstance(factor, Name | Power | Bracket):
                yield LatexChange(((factor.start, factor.end, " "),), "a factor lost")


def _turn_fractions(printed: PrintedFormula) -> Iterator[LatexChange]:
    for node in list_nodes(printed.chain):
        if isinstance(node, Quotient) and node.above.end <= node.below.start:
            above, below = (
                printed.latex[part.start : part.end] for part in (node.above, node.below)
            )
            pieces = (
                (node.above.start, node.above.end, below),
                (node.below.start, node.below.end, above),
            )
            yield LatexChange(pieces, "a fraction upside down")


SLIPS = {
    "sign": _change_signs,
    "number": _change_numbers,
    "name": _change_names,
    "dots": _change_dots,
    "power": _change_powers,
    "function": _change_functions,
    "term": _drop_terms,
    "factor": _drop_factors,
    "fraction": _turn_fractions,
}
"""Slips by their class."""


def list_rewrites(printed: PrintedFormula) -> Iterator[LatexChange]:
    """Yield changes of an equation that leave it the same: sides exchanged, brackets, room, other
    fractions.
    """
    latex, chain = printed.latex, printed.chain
    starts_bare = any(latex[side.start : side.start + 1] == "^" for side in chain.sides)
    if (
        chain.relations == ("=",)
        and not starts_bare
        and not re.search(r"\\\\|&|\\begin|\\tag|\\label", latex)
    ):
        left, right = chain.sides
        sides = [latex[side.start : side.end] for side in (left, right)]
        pieces = ((left.start, left.end, sides[1]), (right.start, right.end, sides[0]))
        yield LatexChange(pieces, "sides exchanged")
        yield LatexChange(((right.start, right.end, rf"\left( {sides[1]} \right)"),), "brackets")
    for token in printed.tokens:
        if token.text == r"\frac":
            yield LatexChange(((token.start, token.end, r"\dfrac"),), "a larger fraction")
        elif token.text in ("+", "-"):
            yield LatexChange(((token.end, token.end, r"\,"),), "room")
    for node in list_nodes(chain):
        if isinstance(node, Product) and len(node.factors) > 1:
            (_, first), (_, second) = node.factors[:2]
            between = latex[first.end : second.start]
            if not between.strip():
                yield LatexChange(((first.end, second.start, r" \, "),), "room")
