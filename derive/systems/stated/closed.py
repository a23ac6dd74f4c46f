"""Formulas of one's own as what papers are tried against."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

from mpmath import mpf

from ...audit.subject import Subject
from ...equations import Claimed, Equation
from ...formulas import Formulas
from ...mechanics.statement import MechanismError
from ...quantity import Quantity
from . import given

TRIALS = 50
NEARBY = 8
"""Points along the way near which data are tried."""


class OwnFormulas(Subject):
    """Formulas, at random values of their data and while each datum with bounds runs from the one to the other."""

    def __init__(self, formulas: Formulas) -> None:
        self.formulas, self._own = formulas, given.values(formulas.given)

    def claims(self) -> Mapping[Claimed, Equation]:
        return self.formulas.equations

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Random data, with all that follows. Raises MechanismError where none are found of which it does."""
        for _ in range(TRIALS):
            try:
                return self.formulas.followed(given.drawn(self.formulas.given, self._own, rng))
            except (ZeroDivisionError, TypeError):
                continue
        raise MechanismError(f"{self.formulas.name}: its definitions have no real values near the data that are given")

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """All values along the way from the lower bounds to the upper ones."""
        return [self.formulas.followed(data) for data in self._way(points)]

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        """Values near those along that way; None where its definitions have no real ones."""
        try:
            return [self.formulas.followed(given.draw_near(data, rng)) for data in self._way(NEARBY)]
        except (ZeroDivisionError, TypeError):
            return None

    def _way(self, points: int) -> list[dict[Quantity, mpf]]:
        table = self.formulas.given
        moving = {q: pair for q, pair in given.ends(table, self._own).items() if table.data[q.name].bounds}
        shares = [mpf(i) / max(points - 1, 1) for i in range(points)]
        along = ({q: low + (high - low) * share for q, (low, high) in moving.items()} for share in shares)
        return [self._own | data for data in along]
