"""What the audit asks of the clutch."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

from mpmath import mpf
from sympy import Expr

from ...audit.subject import Subject
from ...equations import Claimed, Equation
from ...quantity import Quantity
from . import claims, motion
from .vocabulary import ClutchClaim


class Clutch(Subject):
    """The clutch, as derived, on the cycle of the built-in one."""

    def claims(self) -> Mapping[Claimed, Equation]:
        return claims.formulas().equations

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        return claims.admissible(rng)

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        return claims.reference(points)

    def held(self, claim: Claimed, said: Expr) -> Mapping[str, Expr]:
        deflections = (ClutchClaim.MODAL_DEFLECTION, ClutchClaim.SHAFT_DEFLECTION)
        return motion.held_at_bearing(said) if claim in deflections else {}


SUBJECT = Clutch()
