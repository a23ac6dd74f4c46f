"""What is said of an equation: a verdict and its evidence."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from sympy import Expr

from ..evaluate import NotEvaluated, UnknownNodeError
from .edits import Edit

Word = Literal[
    "confirmed", "confirmed as rebuilt", "untested", "misprint", "incomplete", "contradicted", "reconstructed",
    "definition", "not judged",
]  # fmt: skip
FAULTS: tuple[Word, ...] = ("misprint", "incomplete", "contradicted")
"""Verdicts that find fault with a print, the slightest first."""
UNJUDGED: Word = "not judged"
"""The verdict on an equation that stops the judge; its finding says why."""


@dataclass(frozen=True)
class Judgement:
    """A verdict with its evidence. ``missing`` are terms of the derivation that the print lacks.

    ``domain`` says where an equation does not hold that holds wherever the machine uses it, and is empty elsewhere.
    ``loose`` names what must vanish where a thing is held and does not; ``edits`` are those of the first correction,
    with what they replace.
    """

    verdict: Word
    finding: str
    corrections: tuple[tuple[str, ...], ...] = ()
    missing: tuple[Expr, ...] = ()
    unexplained: tuple[Expr, ...] = field(default=())
    loose: tuple[str, ...] = ()
    domain: str = ""
    edits: tuple[Edit, ...] = field(default=(), compare=False)

    @property
    def severity(self) -> tuple[int, int, int]:
        """What a judgement is the milder for being less: of the verdict, the terms left over, the edits needed."""
        left = len(self.missing) + len(self.unexplained)
        needed = min((len(c) for c in self.corrections), default=0)
        grade = (*FAULTS, UNJUDGED).index(self.verdict) + 1 if self.verdict in (*FAULTS, UNJUDGED) else 0
        return grade, left, needed


def explain_unjudged(error: Exception) -> Judgement:
    """Return the judgement on an equation of which judging raised an error, with the reason in words."""
    text = " ".join(str(error).split())
    plain = isinstance(error, NotEvaluated | UnknownNodeError)
    return Judgement(UNJUDGED, text if plain else f"{type(error).__name__}: {text}")
