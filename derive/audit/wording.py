"""Sentences that keep the expressions in them, so that they can be typeset without reading text back."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from sympy import Basic

Piece: TypeAlias = str | Basic


class Said(str):
    """A sentence: a string that knows which of its pieces are expressions.

    >>> from sympy import symbols
    >>> a, b = symbols("a b")
    >>> Said("sign of ", a - b), Said("sign of ", a - b).pieces
    ('sign of a - b', ('sign of ', a - b))
    """

    pieces: tuple[Piece, ...]

    def __new__(cls, *pieces: Piece) -> Said:
        opened = tuple(part for piece in pieces for part in parts(piece))
        self = super().__new__(cls, "".join(map(str, opened)))
        self.pieces = opened
        return self

    def __reduce__(self) -> tuple[type[Said], tuple[Piece, ...]]:
        return type(self), self.pieces


def parts(piece: Piece) -> tuple[Piece, ...]:
    """The pieces of a sentence; a plain string or an expression is one."""
    return piece.pieces if isinstance(piece, Said) else (piece,)


def joined(separator: str, sentences: Iterable[Piece]) -> Said:
    """Sentences or expressions one after the other."""
    pieces: list[Piece] = []
    for sentence in sentences:
        pieces += [separator] if pieces else []
        pieces.append(sentence)
    return Said(*pieces)
