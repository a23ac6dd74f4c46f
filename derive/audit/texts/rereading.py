"""Formulas that differ little from one that was read: only the smallest term around a change is
read again.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from .formula import (
    Bracket,
    FormulaError,
    FunctionCall,
    Heading,
    Magnitude,
    Node,
    RelationChain,
    Sum,
    build_sum,
    list_nodes,
    read_formula,
    read_terms,
    tokenize_formula,
)


class Rereader:
    """Reads what small changes make of a formula, by the tree that it was read as.

    A formula is read as a whole after a change between its terms, and with macros, plus-minus signs
    or bars in it: what these mean does not stand in a term alone. ``brackets`` are those of
    `read_formula`.
    """

    def __init__(
        self,
        latex: str,
        chain: RelationChain,
        macros: Mapping[str, tuple[int, str]],
        brackets: dict[tuple[str, ...], Bracket],
    ) -> None:
        self.latex, self.chain, self.macros, self.brackets = latex, chain, macros, brackets
        is_plain = not any(token.fixed for token in tokenize_formula(latex, macros))
        for node in list_nodes(chain):
            is_signed = isinstance(node, Sum) and any(abs(sign) == 2 for sign, _ in node.terms)
            is_plain = is_plain and not is_signed and not isinstance(node, Magnitude)
        parts = _list_parts(chain) if is_plain else ()
        self._parts = sorted(parts, key=lambda part: part.end - part.start)

    def read(self, pieces: Sequence[tuple[int, int, str]], changed: str) -> RelationChain:
        """Return the tree of a changed source; ``pieces`` are the ranges that changed.

        Raises FormulaError.
        """
        first, last = min(start for start, _, _ in pieces), max(end for _, end, _ in pieces)
        part = next(
            (part for part in self._parts if part.start <= first and last <= part.end), None
        )
        source = changed[part.start : part.end + len(changed) - len(self.latex)] if part else ""
        if (
            part is None or source.strip() == "t" or source.strip().isdigit()
        ):  # x(t), x(0) are no products
            return read_formula(changed, self.macros, self.brackets)
        try:
            terms = read_terms(source, self.macros, self.brackets)
        except FormulaError:
            return read_formula(changed, self.macros, self.brackets)
        tree: RelationChain = _replace_part(self.chain, part, terms)
        return tree


def _list_parts(chain: RelationChain) -> Iterator[Node]:
    """Yield what is read up to a sign, a relation or the end of a bracket, whatever stands before
    it.
    """
    yield from (side for side in chain.sides if not isinstance(side, Heading))
    for node in list_nodes(chain):
        if isinstance(node, Bracket):
            yield from node.parts
        elif isinstance(node, FunctionCall):
            yield from node.arguments
        elif isinstance(node, Sum) and len(node.terms) > 1:
            yield from (term for _, term in node.terms)


def _replace_part(tree: Any, part: Node, new: tuple[tuple[int, Node], ...]) -> Any:
    """Return a tree with signs and terms in the place of a part; those in a sum become signs and
    terms of that.
    """
    if tree is part:
        return build_sum(part.start, new, part.end)
    if isinstance(tree, tuple):
        return tuple(_replace_part(entry, part, new) for entry in tree)
    if not isinstance(tree, Node) or not (tree.start <= part.start and part.end <= tree.end):
        return tree
    if isinstance(tree, Sum) and any(term is part for _, term in tree.terms):
        terms: list[tuple[int, Node]] = []
        for sign, term in tree.terms:
            (first_sign, first), *rest = new if term is part else ((1, term),)
            terms += [(sign * first_sign, first), *rest]
        return replace(tree, terms=tuple(terms))
    values = {field.name: getattr(tree, field.name) for field in fields(tree)}
    return type(tree)(**{name: _replace_part(value, part, new) for name, value in values.items()})
