"""Audit subjects with values: a mechanism that an angle drives, over its revolution, one that moves
freely, and frames and points in any configuration.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import islice, product

import mpmath
import numpy as np
import sympy as sp
from mpmath import mpf
from sympy import Expr

from ...equations import Balance, Claimed, Equation, by_claim
from ...evaluate import DIGITS, GUARD, NotEvaluated, Point
from ...functions import partial_derivative
from ...mechanics.free_motion import project_on_rates
from ...mechanics.loops import Coordinate
from ...mechanics.mechanism import TIME, Mechanism
from ...mechanics.statement import MechanismError
from ...model import Lane, Let
from ...quantity import Quantity
from ..laws import Formula
from ..paper import Array, Dynamics, Subject
from ..terms import STEPS, Equilibrium
from .subject import (
    FASTER,
    REFERENCE,
    SLOW,
    SPEEDS,
    TRIALS,
    MechanismSubject,
    Values,
    close_gaps,
    define_lets,
    draw_near,
    draw_values,
    evaluate_steps,
    list_gaps,
    mechanism_values,
    take_newton_step,
)

CONTINUATION_STEPS = 36
"""Steps per revolution in which the loops are followed to an angle."""
ANGLES = 24
"""Angles of a revolution at which laws are tested."""
NEARBY_ANGLES = 8
"""Angles of a revolution with data near those of the mechanism."""
ANGLE_OFFSET = 0.382
"""Offset, as a share of a step, from the angles at which mechanisms are often singular."""
INSTANT = 0.2, 1.5
"""Range of the times [s] of random states: at time zero too much would hold."""
MOST_RESTS = 64
"""States of rest that may be equilibria, at most: those of three angles."""
DIRECTIONS = 3
"""Directions in which an equilibrium is left."""
Rows = tuple[list[list[Expr]], list[Expr]]
"""Linear equations: rows of slopes in the unknowns, and right-hand sides."""


class DrivenSubject(MechanismSubject):
    """A mechanism that an angle drives: at random values, and over its revolution."""

    def __init__(self, mechanism: Mechanism, angle: Quantity, speed: Quantity) -> None:
        super().__init__(mechanism)
        self.angle, self.speed = angle, speed

    @cached_property
    def lane(self) -> Lane:
        """The model's results along the angle."""
        lane = self.system.lane
        assert lane is not None
        return lane

    @property
    def quantities(self) -> frozenset[Quantity]:
        inputs = {
            *self.mechanism.given.values(),
            *(q for vector in self.lane.along for q in vector),
        }
        return frozenset(inputs.union(*(step.defines for step in self.lane.steps)))

    @property
    def moving(self) -> list[tuple[Quantity, Quantity]]:
        return [
            (self.angle, self.speed),
            *((c.value, c.rate) for c in self.mechanism.loops.coordinates),
        ]

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Draw data and an angle at which the loops close.

        Raises MechanismError if there is none.
        """
        for _ in range(TRIALS):
            data = draw_values(self.mechanism.given, mechanism_values(self.mechanism), rng)
            try:
                return next(self._evaluate_angles(data, [rng.uniform(0, 2 * mpmath.pi)]))
            except ZeroDivisionError:
                continue
        raise MechanismError(
            f"{self.mechanism.name}: its loops close nowhere near the values that are given"
        )

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """Return the mechanism's values over its revolution."""
        return self._evaluate_revolution([2 * mpmath.pi * i / points for i in range(points)])

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        """Return values at random angles with data near those of the mechanism; None if the loops
        do not close.
        """
        data = draw_near(mechanism_values(self.mechanism), rng)
        try:
            return list(
                self._evaluate_angles(
                    data, sorted(mpf(rng.uniform(0, 2 * mpmath.pi)) for _ in range(NEARBY_ANGLES))
                )
            )
        except ZeroDivisionError:
            return None

    def motions(self) -> Mapping[str, Sequence[Sequence[Values]]]:
        """Return its revolution, and the same at a negligible, the given and a higher speed."""
        angles = [2 * mpmath.pi * (i + mpf(ANGLE_OFFSET)) / ANGLES for i in range(ANGLES)]
        revolutions = [self._evaluate_revolution(angles, factor) for factor in (SLOW, 1, FASTER)]
        return {REFERENCE: revolutions[1:2], SPEEDS: revolutions}

    def _evaluate_revolution(self, angles: Sequence[mpf], speed_factor: float = 1) -> list[Values]:
        values = mechanism_values(self.mechanism)
        try:
            return list(
                self._evaluate_angles(
                    values | {self.speed: values[self.speed] * mpf(speed_factor)}, angles
                )
            )
        except ZeroDivisionError:
            raise MechanismError(
                f"{self.mechanism.name}: with the values of its table loops do not close over a "
                f"revolution, or "
                "forces are not determined"
            ) from None

    def _evaluate_angles(self, data: Values, angles: Sequence[mpf]) -> Iterator[Values]:
        """Values of all quantities at angles, one after another."""
        loops = self.mechanism.loops
        positions = [q for vector in self.lane.along for q in vector]
        start = {q: Point(data)(sp.sympify(loops.start[q])) for q in loops.values}
        with mpmath.workdps(DIGITS + GUARD):
            last = mpf(0)
            values = self._close_loops(data | start | {self.angle: last})
            for angle in angles:
                steps = max(1, int(CONTINUATION_STEPS * abs(angle - last) / (2 * mpmath.pi)))
                for i in range(1, steps + 1):
                    between = last + (angle - last) * i / steps
                    values = self._close_loops(values | {self.angle: between})
                last = angle
                coordinates = zip(positions, (values[q] for q in loops.values), strict=True)
                yield evaluate_steps(
                    self.lane.steps, {**data, self.angle: angle, **dict(coordinates)}
                )

    def _close_loops(self, values: Values) -> Values:
        loops = self.mechanism.loops
        return close_gaps(values, list(loops.gaps.values()), loops.values, self._gap_steps)


STATE_PARTS = ("value", "rate")
INSTANTS = 24
"""Times of a motion at which laws are tested."""
NEARBY_TIMES = 8
"""Times of a motion near which states are drawn."""
COORDINATE_RANGE = {"rad": 0.4, "m": 0.05, "1": 0.1}
"""Largest distance of random coordinates from the start, by their unit."""
TOLERANCE = 1e-9


class FreeSubject(MechanismSubject):
    """A mechanism that moves freely: in random states, and in its motion over some seconds.

    Where no joint holds a body that its coordinates guide, balances lack what guides it:
    accelerations then follow from virtual power, and neither actions nor balances are claimed.
    """

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
        inputs = {TIME, *self.mechanism.given.values(), *self._state, *self._unknowns}
        return frozenset(inputs.union(let.symbol for let in self.named))

    @property
    def named(self) -> list[Let]:
        """Definitions of all named quantities that have a value, each after those that it needs."""
        if self._is_held:
            return super().named
        missing, determined = set(self.mechanism.assembly.unknowns), []
        for let in super().named:
            if let.expr.free_symbols & missing:
                missing.add(let.symbol)
            else:
                determined.append(let)
        return determined

    def claims(self) -> Mapping[Claimed, Equation]:
        """Return what any mechanism claims, without balances where these lack what guides a
        body.
        """
        claims = super().claims()
        return (
            claims
            if self._is_held
            else {c: e for c, e in claims.items() if not isinstance(c, Balance)}
        )

    def actions(self) -> Mapping[sp.Symbol, str]:
        """Return the forces and moments between bodies, with their meanings, where balances
        determine them.
        """
        return super().actions() if self._is_held else {}

    def dynamics(self) -> Dynamics | None:
        """Return the laws for the printed equations as a whole, where balances determine all
        actions.
        """
        return super().dynamics() if self._is_held else None

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Draw data and a state that the constraints allow."""
        with mpmath.workdps(DIGITS + GUARD):
            return self._evaluate(self._draw_state(rng))

    def _draw_state(self, rng: random.Random) -> Values:
        data = draw_values(self.mechanism.given, mechanism_values(self.mechanism), rng)
        start = self._start(data)
        for c in self.coordinates:
            start[c.value] += mpf(rng.uniform(-1, 1)) * COORDINATE_RANGE[c.value.unit]
            start[c.rate] += mpf(rng.uniform(0.5, 2)) * rng.choice((-1, 1))
        return self._project(data | {TIME: mpf(rng.uniform(*INSTANT))}, start)

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """Return the mechanism's motion from its start.

        Raises MechanismError if none can be followed.
        """
        try:
            return self._simulate(np.linspace(0, self.until, points))
        except (ZeroDivisionError, NotEvaluated, MechanismError) as error:
            reason = (
                str(error).removeprefix(f"{self.mechanism.name}: ")
                or "something is divided by zero"
            )
            raise MechanismError(
                f"{self.mechanism.name}: no motion from its start could be followed: {reason}; "
                "Mechanism.begin states another start"
            ) from error

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        """Return states and data near those of the reference motion; None if the constraints allow
        none.
        """
        data, points = mechanism_values(self.mechanism), []
        with mpmath.workdps(DIGITS + GUARD):
            for values in self.reference(NEARBY_TIMES):
                state = draw_near({q: values[q] for q in self._state}, rng)
                nearby = draw_near(data, rng) | {TIME: values[TIME]}
                try:
                    points.append(self._evaluate(self._project(nearby, state)))
                except MechanismError:
                    return None
        return points

    def equilibria(self) -> Sequence[Equilibrium]:
        """Return the states of rest at right angles, without loads or with them, with points near
        each.
        """
        with mpmath.workdps(DIGITS + GUARD):
            rng = random.Random(0)
            data = draw_values(self.mechanism.given, mechanism_values(self.mechanism), rng)
            states = [
                (name, state, still)
                for name, state in self._list_rests(data)
                for still in ({}, self._unloaded)
            ]
            equilibria = (
                self._find_equilibrium(name, data | still, state) for name, state, still in states
            )
            return [some for some in equilibria if some is not None]

    @property
    def _unloaded(self) -> Values:
        """Forces and moments among the data, zero."""
        return {q: mpf(0) for q in self.mechanism.given.values() if q.unit in ("N", "N m")}

    def _list_rests(self, data: Values) -> Iterator[tuple[str, Values]]:
        """Yield states without motion: each angle is a multiple of a right one, lengths are those
        of the start.
        """
        start = self._start(data) | {c.rate: mpf(0) for c in self.coordinates}
        angles = [c.value for c in self.coordinates if c.value.unit == "rad"]
        for turns in islice(product((0, 2, 1, 3), repeat=len(angles)), MOST_RESTS):
            rests = {q: turn * mpmath.pi / 2 for q, turn in zip(angles, turns, strict=True)}
            words = [
                f"{q} = {('0', 'pi/2', 'pi', '3*pi/2')[turn]}"
                for q, turn in zip(angles, turns, strict=True)
            ]
            yield ", ".join(words) or "rest", start | rests

    def _find_equilibrium(self, name: str, data: Values, rest: Values) -> Equilibrium | None:
        """Return a state of rest with points near it, None if it is no equilibrium."""
        rng, data = random.Random(1), data | {TIME: mpf(0)}
        try:
            values = self._evaluate(data | rest)
            if any(abs(values[q]) > mpf(10) ** (-DIGITS // 2) for q in self._accelerations):
                return None
            if any(
                abs(Point(values)(gap)) > mpf(10) ** (-DIGITS // 2)
                for gap in self.mechanism.loops.gaps.values()
            ):
                return None
            loads = [q for q in self._unloaded if data[q] == 0]
            directions = []
            for _ in range(DIRECTIONS):
                way = {
                    q: mpf(rng.uniform(0.5, 1.5)) * rng.choice((-1, 1))
                    for q in (*self._state, *loads)
                }
                directions.append(
                    tuple(Point(self._evaluate_near(data, rest, way, step)) for step in STEPS)
                )
        except (MechanismError, NotEvaluated, ZeroDivisionError):
            return None
        fixed = frozenset(self.mechanism.given.values()) - set(loads) | {TIME}
        return Equilibrium(name, tuple(directions), fixed)

    def _evaluate_near(self, data: Values, rest: Values, way: Values, step: mpf) -> Values:
        moved = {q: rest[q] + step * way[q] for q in self._state}
        pushed = {q: step * way[q] for q in way if q not in moved}
        return self._evaluate(self._project(data | pushed, moved))

    def motions(self) -> Mapping[str, Sequence[Sequence[Values]]]:
        """Return the motion from the start."""
        return {REFERENCE: [self._simulate(np.linspace(0, self.until, INSTANTS))]}

    @property
    def _state(self) -> list[Quantity]:
        return [getattr(c, part) for part in STATE_PARTS for c in self.coordinates]

    @property
    def _accelerations(self) -> list[Quantity]:
        return [c.acceleration for c in self.coordinates]

    @property
    def _unknowns(self) -> list[Quantity]:
        return [*self._accelerations, *(self.mechanism.assembly.unknowns if self._is_held else ())]

    @cached_property
    def _is_held(self) -> bool:
        """Whether balances and constraints, often more than their unknowns, have a solution in a
        random state.
        """
        with mpmath.workdps(DIGITS + GUARD):
            values = evaluate_steps(self._state_steps, self._draw_state(random.Random(0)))
            matrix, right = _evaluate_rows(self._balance_rows, values)
            if matrix.rows <= matrix.cols:
                return True
            solution = self._solve_rows(matrix, right)
            loads = [
                abs(matrix[i, j] * solution[j])
                for i in range(matrix.rows)
                for j in range(matrix.cols)
            ]
            return bool(
                mpmath.norm(matrix * solution - right) <= max(loads) * mpf(10) ** (-DIGITS // 2)
            )

    @cached_property
    def _speeds(self) -> list[Expr]:
        """Expressions in the rates that must vanish: rates of the gaps, and slips."""
        mechanism = self.mechanism
        definitions = mechanism.told_in(self._state[len(self.coordinates) :])
        rates = [mechanism.motion.rate(gap) for gap in mechanism.loops.gaps.values()]
        return [
            sp.sympify(speed).xreplace(definitions) for speed in (*rates, *mechanism.slips.values())
        ]

    @cached_property
    def _bends(self) -> list[Expr]:
        """Rates of the speeds that must vanish."""
        definitions = self.mechanism.told_in(self._accelerations)
        return [
            sp.sympify(self.mechanism.motion.rate(speed)).xreplace(definitions)
            for speed in self._speeds
        ]

    @cached_property
    def _state_steps(self) -> list[Let]:
        """Definitions that follow from a state alone."""
        later, steps = {*self._accelerations, *self.mechanism.assembly.unknowns}, []
        for let in super().named:
            if let.expr.free_symbols & later:
                later.add(let.symbol)
            else:
                steps.append(let)
        return steps

    @cached_property
    def _balance_rows(self) -> Rows:
        """Balances, then constraints: their slopes in accelerations and actions, and right-hand
        sides.
        """
        mechanism = self.mechanism
        unknowns = [*self._accelerations, *mechanism.assembly.unknowns]
        definitions = mechanism.told_in(unknowns)
        balances = [e.residual.xreplace(definitions) for e in mechanism.equations()]
        return _linear_rows([*balances, *self._bends], unknowns)

    @cached_property
    def _system(self) -> Rows:
        """What determines the unknowns: balances and constraints, or virtual power where balances
        do not.
        """
        if self._is_held:
            return self._balance_rows
        inertia, forces = project_on_rates(self.mechanism, TIME)
        slopes, bends = _linear_rows(self._bends, self._accelerations)
        balanced = [[*row, *(slope[i] for slope in slopes)] for i, row in enumerate(inertia)]
        return [*balanced, *([*slope, *[sp.S.Zero] * len(slopes)] for slope in slopes)], [
            *forces,
            *bends,
        ]

    def _solve_rows(self, matrix: mpmath.matrix, right: mpmath.matrix) -> mpmath.matrix:
        """Return the solution by least squares.

        Raises MechanismError if actions are statically indeterminate.
        """
        try:
            return mpmath.lu_solve(matrix, right)
        except ZeroDivisionError:
            raise MechanismError(
                f"{self.mechanism.name}: accelerations and actions do not follow from its "
                f"balances: joints hold "
                "something twice, or nothing resists a motion"
            ) from None

    def _evaluate(self, state: Values) -> Values:
        """Return all quantities in a state.

        Raises MechanismError if actions are statically indeterminate.
        """
        values = evaluate_steps(self._state_steps, state)
        solution = self._solve_rows(*_evaluate_rows(self._system, values))
        return evaluate_steps(
            [let for let in self.named if let not in self._state_steps],
            values | dict(zip(self._unknowns, solution, strict=False)),
        )

    def _start(self, data: Values) -> Values:
        start, point = self.mechanism.loops.start | self.mechanism.start, Point(data)
        return {q: point(sp.sympify(start.get(q, 0))) for q in self._state}

    def _project(self, data: Values, state: Values) -> Values:
        """Return the state near a given one that the constraints allow: positions first, then
        rates.

        Raises MechanismError if there is none.
        """
        positions, rates = ([getattr(c, part) for c in self.coordinates] for part in STATE_PARTS)
        gaps, values = list(self.mechanism.loops.gaps.values()), data | state
        try:
            values = close_gaps(values, gaps, positions, self._state_steps)
            if self._speeds:
                values, _ = take_newton_step(values, self._speeds, rates, self._state_steps)
        except ZeroDivisionError:
            raise MechanismError(
                f"{self.mechanism.name}: constraints follow from one another, or none closes"
            ) from None
        return values

    def _simulate(self, times: Array) -> list[Values]:
        """Return the states of the mechanism's motion at times [s]."""
        data = mechanism_values(self.mechanism)
        with mpmath.workdps(DIGITS + GUARD):
            start = self._project(data | {TIME: mpf(0)}, self._start(data))
            states = self._integrate([float(start[q]) for q in self._state], data, times)
            return [
                self._evaluate(
                    self._project(
                        data | {TIME: mpf(float(time))},
                        dict(zip(self._state, map(mpf, state), strict=True)),
                    )
                )
                for time, state in zip(times, states.tolist(), strict=True)
            ]

    def _integrate(self, start: Sequence[float], data: Values, times: Array) -> Array:
        """Return states (n, 2k) in floating point.

        Raises MechanismError if the motion ends early.
        """
        from scipy.integrate import solve_ivp

        size, (rows, right) = len(self.coordinates), self._system
        definitions: dict[Quantity, Expr] = {}
        for let in self._state_steps:
            definitions[let.symbol] = let.expr.xreplace(definitions)
        forms = [
            Formula(entry.xreplace(definitions))
            for entry in (*(e for row in rows for e in row), *right)
        ]
        constants = {q: np.asarray(float(value)) for q, value in data.items()}

        def rates(time: float, state: Array) -> Array:
            values = (
                constants
                | {TIME: np.asarray(time)}
                | dict(zip(self._state, map(np.asarray, state), strict=True))
            )
            entries = np.array([float(form(values)) for form in forms])
            matrix, pushes = entries[: -len(right)].reshape(len(right), -1), entries[-len(right) :]
            solution = np.linalg.lstsq(matrix, pushes, rcond=None)[0]
            return np.concatenate([state[size:], solution[:size]])

        result = solve_ivp(
            rates, (times[0], times[-1]), start, "LSODA", times, rtol=TOLERANCE, atol=TOLERANCE
        )
        if not result.success:
            raise MechanismError(
                f"{self.mechanism.name}: its motion ends at {result.t[-1]:.6g} s: {result.message}"
            )
        if not np.isfinite(result.y).all():
            raise MechanismError(
                f"{self.mechanism.name}: its accelerations have no value: something is divided by "
                f"zero"
            )
        states: Array = result.y.T
        return states


def _linear_rows(residuals: Sequence[Expr], unknowns: Sequence[Quantity]) -> Rows:
    """Return the slopes of residuals in unknowns, and the right-hand sides at which the residuals
    vanish.
    """
    nothing = dict.fromkeys(unknowns, sp.S.Zero)
    rows = [
        [partial_derivative(residual, unknown) for unknown in unknowns] for residual in residuals
    ]
    return rows, [-residual.xreplace(nothing) for residual in residuals]


def _evaluate_rows(rows: Rows, values: Values) -> tuple[mpmath.matrix, mpmath.matrix]:
    point, (slopes, right) = Point(values), rows
    matrix = mpmath.matrix([[point(entry) for entry in row] for row in slopes])
    return matrix, mpmath.matrix([point(entry) for entry in right])


REACH = {"rad": 1.2}
"""Largest value of a coordinate, by its unit; 1 of any other."""
NEARBY = 8


class ConfigurationSubject(Subject):
    """Frames and points without bodies, at random values of their coordinates, rates and
    accelerations.

    The values satisfy the loops, and the rates and accelerations also what rolls without slip.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        loops = mechanism.loops
        self._solved = [c for c in loops.coordinates if c.value in loops.start][: len(loops.gaps)]
        if len(self._solved) < len(loops.gaps):
            raise MechanismError(
                f"{mechanism.name}: {len(loops.gaps)} gaps need a start of as many coordinates, "
                f"not {len(self._solved)}"
            )

    @property
    def quantities(self) -> frozenset[Quantity]:
        """All quantities that have a value."""
        named = (let.symbol for let in self.mechanism.named)
        return frozenset((*self.mechanism.given.values(), *self.mechanism.loops.all, *named))

    def claims(self) -> Mapping[Claimed, Equation]:
        """Return definitions of named quantities, and the gaps of loops."""
        return by_claim((*define_lets(self.mechanism.named), *list_gaps(self.mechanism)))

    @cached_property
    def _stages(self) -> tuple[list[Expr], list[Expr], list[Expr]]:
        """The gaps, their rates with the slips, and the rates of those."""
        rate = self.mechanism.motion.rate
        gaps = [sp.sympify(gap) for gap in self.mechanism.loops.gaps.values()]
        slips = [sp.sympify(slip) for slip in self.mechanism.slips.values()]
        rates = [*(sp.sympify(rate(gap)) for gap in gaps), *slips]
        return gaps, rates, [sp.sympify(rate(speed)) for speed in rates]

    def admissible(self, rng: random.Random) -> Mapping[Quantity, mpf]:
        """Draw data and a configuration with its rates.

        Raises MechanismError if the loops close for no draw.
        """
        with mpmath.workdps(DIGITS + GUARD):
            for _ in range(TRIALS):
                values = draw_values(self.mechanism.given, mechanism_values(self.mechanism), rng)
                if self.mechanism.angle is not None:
                    values[self.mechanism.angle] = mpf(rng.uniform(0, 2 * float(mpmath.pi)))
                try:
                    return self._complete(values, rng)
                except (ValueError, ZeroDivisionError):
                    continue
        raise MechanismError(
            f"{self.mechanism.name}: its loops close nowhere near the values that are given"
        )

    def _complete(self, values: Values, rng: random.Random) -> Values:
        """Return values with those of coordinates, rates, accelerations and named quantities."""
        loops, named = self.mechanism.loops, self.mechanism.named
        for let in named:
            if let.expr.free_symbols <= values.keys():
                values[let.symbol] = Point(values)(let.expr)
        for coordinate in loops.coordinates:
            for part in (coordinate.value, coordinate.rate, coordinate.acceleration):
                reach = REACH.get(part.unit, 1.0)
                values[part] = mpf(rng.uniform(-reach, reach))
        start = {c.value: Point(values)(loops.start[c.value]) for c in self._solved}
        gaps, rates, accelerations = self._stages
        values = close_gaps(values | start, gaps, list(start))
        moved = loops.coordinates if self.mechanism.slips else self._solved
        if rates:
            values, _ = take_newton_step(values, rates, [c.rate for c in moved], ())
            values, _ = take_newton_step(values, accelerations, [c.acceleration for c in moved], ())
        for let in named:
            values[let.symbol] = Point(values)(let.expr)
        return values

    def reference(self, points: int) -> Sequence[Mapping[Quantity, mpf]]:
        """Return the values of random configurations, since nothing moves the mechanism along a
        cycle.
        """
        return [self.admissible(random.Random(1000 + index)) for index in range(points)]

    def nearby(self, rng: random.Random) -> Sequence[Mapping[Quantity, mpf]] | None:
        """Return further configurations."""
        return [self.admissible(rng) for _ in range(NEARBY)]
