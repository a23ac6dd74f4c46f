"""Equations as residuals, with what their source claims them to be."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from typing import Literal, TypeVar

from sympy import Basic, Expr, true

from .quantity import Quantity

Kind = Literal["force", "moment"]
Legibility = Literal["printed", "partly legible", "lost"]
Relation = Literal["=", "<", "<=", ">", ">="]
T = TypeVar("T")


class ClaimError(ValueError):
    """Something is claimed that nothing derives, or claimed twice, or not at all."""


@dataclass(frozen=True)
class Balance:
    """The balance of forces [N] or moments [N m] of a body along an axis of a frame, moments about
    a point.

    >>> str(Balance("rod", "moment", "z", "world", "A"))
    'rod: moment along z of world about A'
    """

    body: str
    kind: Kind
    axis: str
    frame: str
    about: str = ""

    def __str__(self) -> str:
        about = f" about {self.about}" if self.about else ""
        return f"{self.body}: {self.kind} along {self.axis} of {self.frame}{about}"


UNCLAIMED = "no claim but that it holds"
"""Claim of an equation that makes none in particular."""


@dataclass(frozen=True)
class Definition:
    """A name that a source gives to something: there is nothing to derive."""

    meaning: str

    def __str__(self) -> str:
        return f"definition: {self.meaning}"


Claimed = Balance | Definition | str
"""What an equation claims to be: a balance, a definition, or else a sentence, the same in a paper
and in a derivation.
"""


@dataclass(frozen=True)
class Witness:
    """Values that a source prints of an equation's symbols: digits, in units that the equation
    allows.

    ``between`` bounds symbols that it prints nothing of by what follows from the values of others,
    lower bound first.
    """

    where: str
    values: tuple[tuple[Quantity, str], ...]
    between: tuple[tuple[Quantity, Expr, Expr], ...] = ()


@dataclass(frozen=True)
class Equation:
    """An equation ``residual = 0``, or another relation to 0, in any one unit, with its number and
    its claim.

    ``defines`` names the only symbol that a definition may be solved for; a balance may be solved
    for any. ``stated`` says that a derived equation holds by the meaning of its symbols. Of a
    transcription, ``rebuilt`` lists illegible pieces that were completed, ``witnesses`` are printed
    values that it must give, ``typed`` is it in the order and with the signs of the print. ``where``
    is the condition under which a derived equation holds.
    """

    number: str
    residual: Expr
    source: str
    claims: Claimed
    legibility: Legibility = "printed"
    defines: Quantity | None = None
    relation: Relation = "="
    stated: bool = False
    rebuilt: tuple[str, ...] = ()
    witnesses: tuple[Witness, ...] = ()
    where: Basic = true
    typed: str = field(default="", compare=False)

    @property
    def stands_alone(self) -> bool:
        """Whether no derivation can be compared with the equation."""
        return isinstance(self.claims, Definition) or self.claims == UNCLAIMED


def stated_equation(claim: Claimed, residual: Expr, defines: Quantity | None = None) -> Equation:
    """Build an equation that holds by the meaning of its symbols, so that nothing is derived."""
    return replace(derived_equation(claim, residual, defines), stated=True)


def derived_equation(
    claim: Claimed, residual: Expr, defines: Quantity | None = None, relation: Relation = "="
) -> Equation:
    """Build a derived equation; its number is the claim's sentence."""
    return Equation(
        str(claim), residual, f"derived: {claim}", claim, defines=defines, relation=relation
    )


def defining_equation(claim: Claimed, symbol: Quantity, expr: Expr) -> Equation:
    """Build the derived equation that a symbol equals an expression."""
    return derived_equation(claim, symbol - expr, symbol)


def by_claim(equations: Iterable[Equation]) -> dict[Claimed, Equation]:
    """Equations by what they claim to be; raises ClaimError where two claim the same."""
    equations_by_claim: dict[Claimed, Equation] = {}
    for equation in equations:
        other = equations_by_claim.setdefault(equation.claims, equation)
        if other is not equation:
            raise ClaimError(
                f"{other.source} and {equation.source} claim the same: {equation.claims}"
            )
    return equations_by_claim


def find_claim(stated: Mapping[Claimed, T], claim: Claimed) -> T:
    """Return the value of a claim.

    Raises ClaimError that names the nearest claims if there is none.
    """
    if claim in stated:
        return stated[claim]
    close = get_close_matches(str(claim), sorted(map(str, stated)), n=3)
    hint = f"; near it: {', '.join(map(repr, close))}" if close else ""
    raise ClaimError(f"nothing here states {str(claim)!r}{hint}")


def what(quantity: Quantity | str) -> str:
    """Return the claim that an equation says what a quantity is; the name of the quantity will do.

    Claims have no unit.

    >>> what("F_spring")
    'what F_spring is'
    """
    return f"what {quantity} is"


def loop(name: str) -> str:
    """Return the claim that an equation closes a loop, by the name of its gap: point and axis, as
    in "Bx" (no unit).

    >>> loop("Bx")
    'the loop Bx closes'
    """
    return f"the loop {name} closes"
