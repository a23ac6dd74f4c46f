"""What the audit asks of the design by kinematic mapping."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

from mpmath import mpf

from ...audit.subject import Subject
from ...equations import Claimed, Equation
from ...quantity import Quantity
from . import claims


class KinematicMapping(Subject):
    """The design by kinematic mapping, as derived, on the cycle of the built-in one."""

    def claims(self) -> Mapping[Claimed, Equation]:
        return claims.formulas().equations

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        return claims.admissible(rng)

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        return claims.reference(points)


SUBJECT = KinematicMapping()
