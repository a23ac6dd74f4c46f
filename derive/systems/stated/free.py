"""A mechanism that moves by itself: values in random states and along its own motion."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from functools import cached_property

import mpmath
import numpy as np
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ...audit.formula import Formula
from ...audit.laws import Array
from ...evaluate import DIGITS, GUARD, Point
from ...mechanics.loops import Coordinate
from ...mechanics.mechanism import TIME, Mechanism
from ...mechanics.statement import MechanismError
from ...model import Let
from ...quantity import Quantity
from ...slopes import slope
from . import given
from .given import Values
from .laws import REFERENCE
from .own import Own
from .steps import after

INSTANTS = 24
"""Instants of a motion that laws are tried at."""
NEARBY = 8
"""Instants of its motion near which states are tried."""
ASIDE = {"rad": 0.4, "m": 0.05, "1": 0.1}
"""How far random places may be from the start, by the unit of the coordinate."""
TOLERANCE = 1e-9
ROUNDS = 40


class Free(Own):
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
        data = given.drawn(self.mechanism.given, given.of(self.mechanism), rng)
        with mpmath.workdps(DIGITS + GUARD):
            start = self._start(data)
            for c in self.coordinates:
                start[c.value] += mpf(rng.uniform(-1, 1)) * ASIDE[c.value.unit]
                start[c.rate] += mpf(rng.uniform(0.5, 2)) * rng.choice((-1, 1))
            return self._values(self._held(data | {TIME: mpf(0)}, start))

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """The mechanism's own motion from its start on."""
        return self._course(np.linspace(0, self.until, points))

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        """Return states and data near those of the reference motion; None if the constraints allow none."""
        own, found = given.of(self.mechanism), []
        with mpmath.workdps(DIGITS + GUARD):
            for known in self.reference(NEARBY):
                state = given.draw_near({q: known[q] for q in self._state}, rng)
                try:
                    found.append(self._values(self._held(given.draw_near(own, rng) | {TIME: known[TIME]}, state)))
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
        known = after(self._known, state)
        point, (rows, right) = Point(known), self._system
        try:
            found = _solved([[point(entry) for entry in row] for row in rows], [point(entry) for entry in right])
        except ZeroDivisionError:
            raise MechanismError(
                f"{self.mechanism.name}: accelerations and actions do not follow from its balances: joints hold "
                "something twice, or nothing resists a motion"
            ) from None
        return after(
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
        point = Point(after(self._known, at))
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
        data = given.of(self.mechanism)
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
