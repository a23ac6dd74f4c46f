"""Equations as residuals, with what their source claims them to be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sympy import Expr

from .quantity import Quantity

Kind = Literal["force", "moment"]
Legibility = Literal["printed", "partly legible", "lost"]
Relation = Literal["=", "<", "<=", ">", ">="]


@dataclass(frozen=True)
class Balance:
    """Which balance: of which body or bodies, force or moment, along which axis of which frame, about which point."""

    body: str
    kind: Kind
    axis: str
    frame: str
    about: str = ""

    def __str__(self) -> str:
        about = f" about {self.about}" if self.about else ""
        return f"{self.body}: {self.kind} along {self.axis} of {self.frame}{about}"


@dataclass(frozen=True)
class Equation:
    """``residual = 0`` (or another relation to 0), under the number of its source, with what it is claimed to be.

    ``defines`` names the one symbol that a definition may be solved for; a balance may be solved for any.
    """

    number: str
    residual: Expr
    source: str
    claims: Balance | str
    legibility: Legibility = "printed"
    defines: Quantity | None = None
    relation: Relation = "="
