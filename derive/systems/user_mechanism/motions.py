"""Audit subjects with values: a mechanism that an angle drives, over its revolution, and one that moves freely."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import mpmath
import numpy as np
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ...audit.paper import Array
from ...audit.trial import Formula
from ...evaluate import DIGITS, GUARD, Point
from ...functions import slope
from ...mechanics.loops import Coordinate
from ...mechanics.mechanism import TIME, Mechanism
from ...mechanics.statement import MechanismError
from ...model import Lane, Let
from ...quantity import Quantity
from .subject import (
    FASTER,
    REFERENCE,
    SLOW,
    SPEEDS,
    MechanismSubject,
    Values,
    draw_near,
    draw_values,
    evaluate_steps,
    mechanism_values,
)

WALK = 36
"""Steps from the start of a turn to where loops are wanted."""
TRIALS = 50
ANGLES = 24
"""Angles of a turn that laws are tried at."""
NEARBY_ANGLES = 8
"""Angles of a turn with data near the mechanism's own."""
ANGLE_OFFSET = 0.382
"""Share of a step that they stand off the angles at which mechanisms are often singular."""


class DrivenSubject(MechanismSubject):
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
            data = draw_values(self.mechanism.given, mechanism_values(self.mechanism), rng)
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
        data = draw_near(mechanism_values(self.mechanism), rng)
        try:
            return list(self._along(data, sorted(mpf(rng.uniform(0, 2 * mpmath.pi)) for _ in range(NEARBY_ANGLES))))
        except ZeroDivisionError:
            return None

    def motions(self) -> Mapping[str, Sequence[Sequence[Values]]]:
        """Its turn, and the same at next to no speed, at its own, and faster."""
        angles = [2 * mpmath.pi * (i + mpf(ANGLE_OFFSET)) / ANGLES for i in range(ANGLES)]
        turns = [self._turn(angles, factor) for factor in (SLOW, 1, FASTER)]
        return {REFERENCE: turns[1:2], SPEEDS: turns}

    def _turn(self, angles: Sequence[mpf], faster: float = 1) -> list[Values]:
        own = mechanism_values(self.mechanism)
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
            point = Point(evaluate_steps(self._before, here))
            slopes = mpmath.matrix([[point(entry) for entry in row] for row in loops.jacobian()])
            step = mpmath.lu_solve(slopes, -mpmath.matrix([point(gap) for gap in loops.gaps.values()]))
            at = at + step
            if mpmath.norm(step) < mpf(10) ** -(DIGITS):
                return list(at)
        raise ZeroDivisionError("the loops do not close")

    def _values(self, data: Values, angle: mpf, places: Sequence[mpf]) -> Values:
        loose = dict(zip((q for vector in self.lane.along for q in vector), places, strict=True))
        return evaluate_steps(self.lane.steps, {**data, self.angle: angle, **loose})


INSTANTS = 24
"""Instants of a motion that laws are tried at."""
NEARBY_TIMES = 8
"""Instants of its motion near which states are tried."""
COORDINATE_RANGE = {"rad": 0.4, "m": 0.05, "1": 0.1}
"""How far random places may be from the start, by the unit of the coordinate."""
TOLERANCE = 1e-9
ROUNDS = 40


class FreeSubject(MechanismSubject):
    """A mechanism in random states, and in its own motion over some seconds."""

    def __init__(self, mechanism: Mechanism, until: float) -> None:
        super().__init__(mechanism)
        self.until = until

    @property
    def coordinates(self) -> list[Coordinate]:
        return self.mechanism.loops.coordinates

    @property
    def moving(self) -> list[tuple[Quantity, Quantity]]:
        return [(c.value, c.rate) for c in self.coordinates]

    @property
    def quantities(self) -> frozenset[Quantity]:
        found = {TIME, *self.mechanism.given.values(), *self._state, *self._unknowns}
        return frozenset(found.union(let.symbol for let in self.named))

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Random data, and a random state that the constraints allow."""
        data = draw_values(self.mechanism.given, mechanism_values(self.mechanism), rng)
        with mpmath.workdps(DIGITS + GUARD):
            start = self._start(data)
            for c in self.coordinates:
                start[c.value] += mpf(rng.uniform(-1, 1)) * COORDINATE_RANGE[c.value.unit]
                start[c.rate] += mpf(rng.uniform(0.5, 2)) * rng.choice((-1, 1))
            return self._values(self._held(data | {TIME: mpf(0)}, start))

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """The mechanism's own motion from its start on."""
        return self._course(np.linspace(0, self.until, points))

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        """Return states and data near those of the reference motion; None if the constraints allow none."""
        own, found = mechanism_values(self.mechanism), []
        with mpmath.workdps(DIGITS + GUARD):
            for known in self.reference(NEARBY_TIMES):
                state = draw_near({q: known[q] for q in self._state}, rng)
                try:
                    found.append(self._values(self._held(draw_near(own, rng) | {TIME: known[TIME]}, state)))
                except MechanismError:
                    return None
        return found

    def motions(self) -> Mapping[str, Sequence[Sequence[Values]]]:
        return {REFERENCE: [self._course(np.linspace(0, self.until, INSTANTS))]}

    @property
    def _state(self) -> list[Quantity]:
        return [*(c.value for c in self.coordinates), *(c.rate for c in self.coordinates)]

    @property
    def _accelerations(self) -> list[Quantity]:
        return [c.acceleration for c in self.coordinates]

    @property
    def _unknowns(self) -> list[Quantity]:
        return [*self._accelerations, *self.mechanism.assembly.unknowns]

    @cached_property
    def _speeds(self) -> list[Expr]:
        """What vanishes in the rates: those of the gaps, and slips."""
        mechanism = self.mechanism
        told = mechanism.told_in(self._state[len(self.coordinates) :])
        rates = [mechanism.motion.rate(gap) for gap in mechanism.loops.gaps.values()]
        return [sp.sympify(speed).xreplace(told) for speed in (*rates, *mechanism.slips.values())]

    @cached_property
    def _known(self) -> list[Let]:
        """What a state alone tells."""
        later, found = set(self._unknowns), []
        for let in self.named:
            if let.expr.free_symbols & later:
                later.add(let.symbol)
            else:
                found.append(let)
        return found

    @cached_property
    def _system(self) -> tuple[list[list[Expr]], list[Expr]]:
        """Rows in accelerations and actions, and right-hand sides: of every balance, then of every constraint."""
        mechanism = self.mechanism
        told = mechanism.told_in(self._unknowns)
        residuals = [e.residual.xreplace(told) for e in mechanism.equations()]
        residuals += [mechanism.motion.rate(speed).xreplace(told) for speed in self._speeds]
        nothing = dict.fromkeys(self._unknowns, sp.S.Zero)
        return [[slope(r, u) for u in self._unknowns] for r in residuals], [-r.xreplace(nothing) for r in residuals]

    def _values(self, state: Values) -> Values:
        """Everything in a state. Raises MechanismError where joints hold something twice."""
        known = evaluate_steps(self._known, state)
        point, (rows, right) = Point(known), self._system
        try:
            found = _solved([[point(entry) for entry in row] for row in rows], [point(entry) for entry in right])
        except ZeroDivisionError:
            raise MechanismError(
                f"{self.mechanism.name}: accelerations and actions do not follow from its balances: joints hold "
                "something twice, or nothing resists a motion"
            ) from None
        return evaluate_steps(
            [let for let in self.named if let not in self._known],
            known | dict(zip(self._unknowns, found, strict=True)),
        )

    def _start(self, data: Values) -> Values:
        told, point = self.mechanism.loops.start | self.mechanism.start, Point(data)
        return {q: point(sp.sympify(told.get(q, 0))) for q in self._state}

    def _held(self, data: Values, state: Values) -> Values:
        """A state near one that the constraints allow: places first, then rates."""
        gaps, places = list(self.mechanism.loops.gaps.values()), [c.value for c in self.coordinates]
        at = data | state
        for _ in range(ROUNDS if gaps else 0):
            step = self._step(at, gaps, places)
            at |= {q: at[q] + s for q, s in zip(places, step, strict=True)}
            if mpmath.norm(step) < mpf(10) ** -DIGITS:
                break
        if self._speeds:
            rates = [c.rate for c in self.coordinates]
            at |= {q: at[q] + s for q, s in zip(rates, self._step(at, self._speeds, rates), strict=True)}
        return at

    def _step(self, at: Values, vanishing: Sequence[Expr], along: Sequence[Quantity]) -> mpmath.matrix:
        """The shortest step that makes expressions vanish. Raises MechanismError where none does."""
        point = Point(evaluate_steps(self._known, at))
        rows = mpmath.matrix([[point(slope(expr, q)) for q in along] for expr in vanishing])
        try:
            pulls = mpmath.lu_solve(rows * rows.T, -mpmath.matrix([point(expr) for expr in vanishing]))
        except ZeroDivisionError:
            raise MechanismError(
                f"{self.mechanism.name}: constraints follow from one another, or none closes"
            ) from None
        return rows.T * pulls

    def _course(self, times: Array) -> list[Values]:
        """States of the mechanism's own motion at times [s]."""
        data = mechanism_values(self.mechanism)
        with mpmath.workdps(DIGITS + GUARD):
            start = self._held(data | {TIME: mpf(0)}, self._start(data))
            states = self._integrated([float(start[q]) for q in self._state], data, times)
            held = [
                self._held(data | {TIME: mpf(float(t))}, dict(zip(self._state, map(mpf, map(float, at)), strict=True)))
                for t, at in zip(times, states, strict=True)
            ]
            return [self._values(state) for state in held]

    def _integrated(self, start: Sequence[float], data: Values, times: Array) -> Array:
        """States (n, 2k) in floating point. Raises MechanismError where the motion ends before."""
        from scipy.integrate import solve_ivp

        size, count = len(self.coordinates), len(self._unknowns)
        rows, right = self._system
        told: dict[Quantity, Expr] = {}
        for let in self._known:
            told[let.symbol] = let.expr.xreplace(told)
        forms = [Formula(entry.xreplace(told)) for entry in (*(e for row in rows for e in row), *right)]
        fixed = {q: np.asarray(float(value)) for q, value in data.items()}

        def rates(time: float, state: Array) -> Array:
            values = fixed | {TIME: np.asarray(time)} | dict(zip(self._state, map(np.asarray, state), strict=True))
            found = np.array([float(form(values)) for form in forms])
            matrix, pushed = found[: -len(right)].reshape(-1, count), found[-len(right) :]
            moved = np.linalg.lstsq(matrix, pushed, rcond=None)[0]
            return np.concatenate([state[size:], moved[:size]])

        done = solve_ivp(rates, (times[0], times[-1]), start, "LSODA", times, rtol=TOLERANCE, atol=TOLERANCE)
        if not done.success:
            raise MechanismError(f"{self.mechanism.name}: its motion ends at {done.t[-1]:.6g} s: {done.message}")
        states: Array = done.y.T
        return states


def _solved(rows: Sequence[Sequence[mpf]], right: Sequence[mpf]) -> list[mpf]:
    """Unknowns of equations of which there are as many, or more that agree."""
    return list(mpmath.lu_solve(mpmath.matrix(rows), mpmath.matrix(right)))
