"""A mechanism that is driven along an angle: values along its turn."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence

import mpmath
import sympy as sp
from mpmath import mpf

from ...evaluate import DIGITS, GUARD, Point
from ...mechanics.mechanism import Mechanism
from ...mechanics.statement import MechanismError
from ...model import Lane
from ...quantity import Quantity
from . import given
from .given import Values
from .laws import FASTER, REFERENCE, SLOW, SPEEDS
from .own import Own
from .steps import after

WALK = 36
"""Steps from the start of a turn to where loops are wanted."""
TRIALS = 50
ANGLES = 24
"""Angles of a turn that laws are tried at."""
NEARBY = 8
"""Angles of a turn with data near the mechanism's own."""
ASIDE = 0.382
"""Share of a step that they stand off the angles at which mechanisms are often singular."""


class Driven(Own):
    """A mechanism at random values and along its own turn."""

    def __init__(self, mechanism: Mechanism, angle: Quantity, speed: Quantity, lane: Lane) -> None:
        super().__init__(mechanism)
        self.angle, self.speed, self.lane = angle, speed, lane

    @property
    def quantities(self) -> frozenset[Quantity]:
        given = {*self.mechanism.given.values(), *(q for vector in self.lane.along for q in vector)}
        return frozenset(given.union(*(step.defines for step in self.lane.steps)))

    @property
    def moving(self) -> list[tuple[Quantity, Quantity]]:
        return [(self.angle, self.speed), *((c.value, c.rate) for c in self.mechanism.loops.coordinates)]

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Random data, and a random angle of a turn that the loops allow. Raises MechanismError where none is found."""
        for _ in range(TRIALS):
            data = given.drawn(self.mechanism.given, given.of(self.mechanism), rng)
            try:
                return next(self._along(data, [rng.uniform(0, 2 * mpmath.pi)]))
            except ZeroDivisionError:
                continue
        raise MechanismError(f"{self.mechanism.name}: its loops close nowhere near the values that are given")

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """The mechanism's own values along its turn."""
        return self._turn([2 * mpmath.pi * i / points for i in range(points)])

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        """Random angles of its turn with data near its own; None where loops do not close all along it."""
        data = given.draw_near(given.of(self.mechanism), rng)
        try:
            return list(self._along(data, sorted(mpf(rng.uniform(0, 2 * mpmath.pi)) for _ in range(NEARBY))))
        except ZeroDivisionError:
            return None

    def motions(self) -> Mapping[str, Sequence[Sequence[Values]]]:
        """Its turn, and the same at next to no speed, at its own, and faster."""
        angles = [2 * mpmath.pi * (i + mpf(ASIDE)) / ANGLES for i in range(ANGLES)]
        turns = [self._turn(angles, factor) for factor in (SLOW, 1, FASTER)]
        return {REFERENCE: turns[1:2], SPEEDS: turns}

    def _turn(self, angles: Sequence[mpf], faster: float = 1) -> list[Values]:
        own = given.of(self.mechanism)
        try:
            return list(self._along(own | {self.speed: own[self.speed] * mpf(faster)}, angles))
        except ZeroDivisionError:
            raise MechanismError(
                f"{self.mechanism.name}: with the values of its table loops do not close all along a turn, or forces "
                "are not determined"
            ) from None

    def _along(self, data: Values, angles: Sequence[mpf]) -> Iterator[Values]:
        """Values of all quantities at angles, one after another."""
        with mpmath.workdps(DIGITS + GUARD):
            places = self._started(data)
            last = mpf(0)
            for angle in angles:
                steps = max(1, int(WALK * abs(angle - last) / (2 * mpmath.pi)))
                for i in range(1, steps + 1):
                    places = self._closed(data, last + (angle - last) * i / steps, places)
                last = angle
                yield self._values(data, angle, places)

    def _started(self, data: Values) -> list[mpf]:
        loops, point = self.mechanism.loops, Point(data)
        return self._closed(data, mpf(0), [point(sp.sympify(loops.start[value])) for value in loops.values])

    def _closed(self, data: Values, angle: mpf, places: list[mpf]) -> list[mpf]:
        """Coordinates that close the loops, by Newton's method; ZeroDivisionError where it leads nowhere."""
        loops = self.mechanism.loops
        if not loops.values:
            return []
        at = mpmath.matrix(places)
        for _ in range(40):
            here = {**data, self.angle: angle, **dict(zip(loops.values, at, strict=True))}
            point = Point(after(self._before, here))
            slopes = mpmath.matrix([[point(entry) for entry in row] for row in loops.jacobian()])
            step = mpmath.lu_solve(slopes, -mpmath.matrix([point(gap) for gap in loops.gaps.values()]))
            at = at + step
            if mpmath.norm(step) < mpf(10) ** -(DIGITS):
                return list(at)
        raise ZeroDivisionError("the loops do not close")

    def _values(self, data: Values, angle: mpf, places: Sequence[mpf]) -> Values:
        loose = dict(zip((q for vector in self.lane.along for q in vector), places, strict=True))
        return after(self.lane.steps, {**data, self.angle: angle, **loose})
