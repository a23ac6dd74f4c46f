"""Where two formulas in MathML differ, marked in both."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import SequenceMatcher
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

CLASS = "changed"
"""Class of the elements that differ."""
LINES = ("semantics", "mtable", "mtr", "mtd")
"""Elements that hold a formula, or its lines and columns."""


def mark_changes(before: str, after: str) -> tuple[str, str]:
    """Return two formulas in MathML with the smallest elements marked in which they differ.

    >>> mark_changes("<math><mi>a</mi><mo>+</mo></math>", "<math><mi>a</mi><mo>-</mo></math>")[1]
    '<math><mi>a</mi><mo class="changed">-</mo></math>'
    """
    first, second = (ElementTree.fromstring(text) for text in (before, after))
    _mark_children(first, second)
    return ElementTree.tostring(first, encoding="unicode"), ElementTree.tostring(
        second, encoding="unicode"
    )


def _mark_children(first: Element, second: Element) -> None:
    old, new = (list(_list_terms(tree)) for tree in (first, second))
    before, after = (
        [ElementTree.tostring(part, encoding="unicode") for part in parts] for parts in (old, new)
    )
    for operation, i, j, k, m in SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
        if operation == "replace" and j - i == m - k:
            for part, other in zip(old[i:j], new[k:m], strict=True):
                _mark_pair(part, other)
        elif operation != "equal":
            for element in (*old[i:j], *new[k:m]):
                element.set("class", CLASS)


def _list_terms(tree: Element) -> Iterator[Element]:
    """Yield the parts of an element, through the lines that a long sum is broken into and all that
    holds one part.
    """
    for child in tree:
        if child.tag in LINES or (
            child.tag == "mrow" and (len(child) == 1 or tree.tag in ("math", *LINES))
        ):
            yield from _list_terms(child)
        elif child.tag != "annotation":
            yield child


def _mark_pair(old: Element, new: Element) -> None:
    """Mark what differs in two elements: inside of them if they are of a kind and have a like part,
    else themselves.
    """
    if old.tag == new.tag and _list_leaves(old) & _list_leaves(new) and len(old) and len(new):
        _mark_children(old, new)
    else:
        for element in (old, new):
            element.set("class", CLASS)


def _list_leaves(tree: Element) -> set[tuple[str, str]]:
    return set(_iterate_leaves(tree))


def _iterate_leaves(tree: Element) -> Iterator[tuple[str, str]]:
    for node in tree.iter():
        if not len(node) and node.text and node.tag in ("mi", "mn", "mtext"):
            yield node.tag, node.text
