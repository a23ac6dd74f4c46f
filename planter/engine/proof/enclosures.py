"""Enclosures of a response over boxes of designs, at angles or anywhere in panels of a cycle.

A response is a sequence of programs, some of whose results are roots of others.

Ends of panels are linear in the design, so that each is the same function for both panels that meet
there; the last end is the first one a period later. Nothing else is needed for panels to cover a
cycle. Where ends follow the angles at which a quantity has a kink, at some distance, kinks stay
within narrow panels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from planter.engine.proof.intervals import PI, Ball, U, Unbounded, select_balls
from planter.engine.proof.jets import (
    ANYWHERE,
    CENTRE,
    Jet,
    Space,
    join_lanes,
    unite_supports,
)
from planter.engine.proof.programs import Code, RecordedProgram, record_program
from planter.engine.proof.roots import EnclosedRoots, enclose_roots, has_rootless_lane
from planter.kernels import Array, Flags, Integers

MAX_LANES = 8
"""Average number of pieces of a lane above which a box is too wide to follow them."""
REMEMBERED = 64
"""Results of a stage that are kept for inputs that come again."""


@dataclass(frozen=True)
class RootBranch:
    """The roots that are meant over a box of designs, as they were followed to it.

    For each stage with roots, `points` and `radii` (k, m) of balls, each of which holds one root at
    every design of the box: in m equal parts of the period from 0 on [rad], or, of a stage that no
    angle changes, in one. They are NaN in parts to which the roots were not followed.
    """

    turn: float
    points: tuple[Array, ...]
    radii: tuple[Array, ...]

    @property
    def is_whole(self) -> bool:
        """Whether the roots were followed to all angles."""
        return not any(np.isnan(radii).any() for radii in self.radii)

    def find_near(self, number: int, phi: Array) -> Array:
        """Return values (k, lanes) near the roots of a stage at angles phi (lanes,)."""
        return self.points[number][:, self._find_parts(number, phi)]

    def _find_parts(self, number: int, phi: Array) -> Integers:
        count = self.points[number].shape[1]
        parts: Integers = np.floor(np.mod(phi, self.turn) / self.turn * count).astype(np.int64)
        return np.minimum(parts, count - 1)

    def holds(self, number: int, phi: Array, ends: Array, roots: Sequence[Ball]) -> Flags:
        """Return in which lanes roots (k,) of (lanes,) each are those that are meant.

        They are regular and unique near them over a box and between two `ends` (2, lanes) of
        angles, and at its centre and the angle phi (lanes,) they are here. Two continuous and
        regular families of roots that have one in common are the same, wherever both are known.
        """
        points, radii = self.points[number], self.radii[number]
        count = points.shape[1]
        parts = self._find_parts(number, phi)
        low, high = (np.array([getattr(ball, side) for ball in roots]) for side in ("low", "high"))
        inside = (low >= points[:, parts] - radii[:, parts]).all(axis=0)
        inside &= (high <= points[:, parts] + radii[:, parts]).all(axis=0)
        if count == 1:
            return np.asarray(inside)
        steps = np.floor((ends - phi + np.mod(phi, self.turn)) / self.turn * count) + count
        unknown = np.tile(np.isnan(radii).any(axis=0), 3)
        before = np.append(0, np.cumsum(unknown))
        first, last = (np.nan_to_num(side, nan=-1.0).astype(np.int64) for side in steps)
        is_within = (first >= 0) & (last < len(unknown))
        first, last = (np.clip(side, 0, len(unknown) - 1) for side in (first, last))
        return np.asarray(inside & is_within & (before[last + 1] == before[first]))


Branches = Sequence[RootBranch]
"""The roots that are meant over each box of a space."""


@dataclass(frozen=True)
class ResponseProgram:
    """Quantities F(phi, x) as programs: sums over `offsets` [turns] of shares at phi + offset.

    Values are the p parameters of a design, the angle phi [rad], then the results of each stage;
    those of the last stage are the shares. The quantities have a common `period` [turns], and do
    not jump over designs if `is_continuous`, whatever the conditions in their code.
    """

    parameters: int
    stages: tuple[RecordedProgram, ...]
    offsets: tuple[Fraction, ...]
    period: Fraction
    is_continuous: bool

    @cached_property
    def fixed(self) -> tuple[bool, ...]:
        """Whether each stage is the same at all angles."""
        moving, fixed, count = {self.parameters}, list[bool](), self.parameters + 1
        for stage in self.stages:
            fixed.append(moving.isdisjoint(stage.inputs))
            moving |= set() if fixed[-1] else set(range(count, count + stage.size))
            count += stage.size
        return tuple(fixed)

    @cached_property
    def _fixed_results(self) -> dict[Any, EnclosedRoots]:
        return {}

    def to_document(self) -> dict[str, Any]:
        """Return the response as a JSON object."""
        return {
            "parameters": self.parameters,
            "stages": [stage.to_document() for stage in self.stages],
            "offsets": [str(offset) for offset in self.offsets],
            "period": str(self.period),
            "continuous": self.is_continuous,
        }

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> ResponseProgram:
        """Return the response of a JSON object whose form was checked."""
        return cls(
            document["parameters"],
            tuple(map(RecordedProgram.from_document, document["stages"])),
            tuple(map(Fraction, document["offsets"])),
            Fraction(document["period"]),
            document["continuous"],
        )

    @cached_property
    def rooted(self) -> tuple[int, ...]:
        """The indices of the stages with roots."""
        return tuple(index for index, stage in enumerate(self.stages) if stage.limits)

    @cached_property
    def feeding(self) -> tuple[int, ...]:
        """The indices of the stages from which roots follow, in order."""
        needed, ends = set[int](), list[int]()
        for stage in self.stages:
            ends.append((ends[-1] if ends else self.parameters + 1) + stage.size)
        for index in reversed(range(len(self.stages))):
            values = range(ends[index] - self.stages[index].size, ends[index])
            if self.stages[index].limits or needed.intersection(values):
                needed.update(self.stages[index].inputs)
                needed.update(values)
        return tuple(
            index for index, end in enumerate(ends) if self.stages[index].size and end - 1 in needed
        )

    def enclose(self, space: Space, phi: Jet, branches: Branches) -> list[Jet]:
        """Return each quantity over boxes at angles [rad] that may move with the design, a lane for
        each.
        """
        count = phi.lanes
        offsets = [space.constant(list_angles([offset])) for offset in self.offsets]
        shares = self._enclose_pieces(space, join_lanes([phi + x for x in offsets]), branches)
        space.jumping = np.asarray(space.jumping.reshape(-1, count).any(axis=0))
        first, *rest = (slice(k * count, (k + 1) * count) for k in range(len(offsets)))
        return [sum((share.taken(lanes) for lanes in rest), share.taken(first)) for share in shares]

    def prepare(self, space: Space, phi: Jet, branches: Branches) -> list[Jet]:
        """Return the inputs of the last stage over a box at angles phi (lanes,) [rad].

        After the p parameters of a design, a space may have the place in a panel of angles as one
        more. `branches` are those of each of the boxes of the space, which have equal numbers of
        lanes. Raises Unbounded where roots do not exist, or none that are meant.
        """
        values = [*space.parameters()[: self.parameters], phi]
        for index, stage in enumerate(self.stages[:-1]):
            inputs = [values[k] for k in stage.inputs]
            if stage.limits:
                values += self._follow(index, space, phi, inputs, branches)
            else:
                values += self._evaluate(index, space, inputs).jets
        return [values[k] for k in self.stages[-1].inputs]

    def _follow(
        self, index: int, space: Space, phi: Jet, inputs: Sequence[Jet], branches: Branches
    ) -> list[Jet]:
        """Return the roots of a stage that are meant, NaN in lanes in which others were found."""
        number, angles = self.rooted.index(index), phi.value
        is_single = self.fixed[index] and len(branches) == 1
        ends = np.array([angles[ANYWHERE].low, angles[ANYWHERE].high])[
            :, : 1 if is_single else None
        ]
        middle = angles.mid[CENTRE][: ends.shape[1]]
        lanes = np.split(np.arange(len(middle)), len(branches))
        pairs = list(zip(branches, lanes, strict=True))
        guesses = np.concatenate(
            [branch.find_near(number, middle[part]) for branch, part in pairs], axis=1
        )
        if np.isnan(guesses).all():
            raise Unbounded("loops are not closed in the assembly that is meant")
        roots = self._evaluate(index, space, inputs, guesses)
        jets = [jet.repeated(len(middle)) for jet in roots.jets]
        centres = [jet.value[CENTRE] for jet in jets]
        is_meant = np.concatenate(
            [
                branch.holds(number, middle[part], ends[:, part], [ball[part] for ball in centres])
                for branch, part in pairs
            ]
        )
        if not is_meant.any():
            raise Unbounded("the roots of a box are not those that are meant")
        return [jet.masked(is_meant) for jet in jets]

    def find_roots(self, space: Space, phi: Jet, guesses: Sequence[Array]) -> list[EnclosedRoots]:
        """Return the roots near guesses (k, lanes) of each stage that has some, whichever they
        are.
        """
        values: dict[int, Jet] = dict(enumerate([*space.parameters()[: self.parameters], phi]))
        roots, count = list[EnclosedRoots](), self.parameters + 1
        for index, stage in enumerate(self.stages):
            if index in self.feeding:
                inputs = [values[k] for k in stage.inputs]
                results = _run_stage(
                    stage, space, inputs, guesses[len(roots)] if stage.limits else None
                )
                roots += [results] if stage.limits else []
                values |= dict(enumerate(results.jets, count))
            count += stage.size
        return roots

    def _evaluate(
        self, index: int, space: Space, inputs: Sequence[Jet], guesses: Array | None = None
    ) -> EnclosedRoots:
        """Return the results of a stage; those that no angle changes are remembered."""
        stage = self.stages[index]
        if not self.fixed[index]:
            return _run_stage(stage, space, inputs, guesses)
        supports = [jet.support for jet in inputs]
        moving = list(unite_supports(inputs))
        sides = [side.tobytes() for jet in inputs for side in (jet.rows.mid, jet.rows.rad)]
        place = b"" if guesses is None else guesses.tobytes()
        key = index, *supports, space.half[moving].tobytes(), place, *sides
        if key not in self._fixed_results:
            if len(self._fixed_results) == REMEMBERED:
                del self._fixed_results[next(iter(self._fixed_results))]
            self._fixed_results[key] = _run_stage(stage, space, inputs, guesses)
        results = self._fixed_results[key]
        return replace(results, jets=[jet.moved(space) for jet in results.jets])

    def _enclose_pieces(self, space: Space, phi: Jet, branches: Branches) -> list[Jet]:
        """Return enclosures of the shares at angles (lanes,) [rad], each around all smooth
        pieces.
        """
        count, total = phi.lanes, 0
        lanes, script = np.arange(count), np.empty((0, count))
        parts: list[tuple[Integers, list[Jet]]] = []
        inputs = self.prepare(space, phi, branches)
        space.jumping = np.zeros(count, dtype=bool)
        while len(lanes):
            answers, jets = self.stages[-1].enclose(space, inputs, lanes, script)
            if not self.is_continuous:
                np.logical_or.at(space.jumping, lanes, answers.jumping)
            parts.append((lanes, [jet.repeated(len(lanes)) for jet in jets]))
            total += len(lanes)
            if total > MAX_LANES * count:
                raise Unbounded("a box goes through many branches")
            further, script = answers.further()
            lanes = lanes[further]
        quantities = range(len(parts[0][1]))
        return [_unite_pieces([(taken, jets[k]) for taken, jets in parts]) for k in quantities]

    def is_empty(self, lower: Array, upper: Array, phi: Ball) -> bool:
        """Return whether at one of the angles phi (lanes,) [rad] no design of a box [lower, upper]
        (p,) has roots.

        Roots are searched up to the limits of their stage, which must take parameters and angles
        alone.
        """
        space = Space(lower, lower)
        ends = zip(lower[: self.parameters], upper[: self.parameters], strict=True)
        box = [Ball.between(*map(np.atleast_1d, pair)) for pair in ends]
        values = [space.constant(ball) for ball in (*box, phi)]
        return any(
            _has_no_roots(stage, space, [values[k] for k in stage.inputs])
            for stage in self.stages
            if np.isfinite(stage.limits).any() and max(stage.inputs) < len(values)
        )


def _run_stage(
    stage: RecordedProgram, space: Space, inputs: Sequence[Jet], guesses: Array | None
) -> EnclosedRoots:
    """Return the results of a program, or its roots near guesses."""
    if guesses is None:
        return EnclosedRoots(stage.enclose_smooth(space, inputs), np.empty(0), np.empty(0))
    return enclose_roots(
        space,
        guesses,
        lambda q: _split_gaps(stage.solver.enclose_smooth(space, [*q, *inputs]), len(q)),
    )


def _has_no_roots(stage: RecordedProgram, space: Space, inputs: Sequence[Jet]) -> bool:
    """Return whether there are certainly no roots within the limits of a stage in one of the lanes
    of its inputs.
    """

    def enclose_gaps(
        q: Sequence[Ball], lanes: Integers
    ) -> tuple[Sequence[Ball], Sequence[Sequence[Ball]]]:
        taken = [jet if jet.lanes == 1 else jet.taken(lanes) for jet in inputs]
        rows = stage.solver.enclose_smooth(space, [*map(space.constant, q), *taken])
        return _split_gaps([row.value[ANYWHERE] for row in rows], len(q))

    limits = np.array(stage.limits)
    return has_rootless_lane(enclose_gaps, -limits, limits, max(jet.lanes for jet in inputs))


T = TypeVar("T")


def _split_gaps(rows: Sequence[T], size: int) -> tuple[Sequence[T], Sequence[Sequence[T]]]:
    """Return the residuals (k,) and the rows of their Jacobian (k, k) from the results of code of
    roots.
    """
    return rows[:size], [rows[k : k + size] for k in range(size, size + size * size, size)]


def _unite_pieces(parts: Sequence[tuple[Integers, Jet]]) -> Jet:
    """Return a jet around all parts: the first part has every lane, the others are pieces of some
    lanes.
    """
    (lanes, first), *pieces = parts
    support = unite_supports(jet for _, jet in parts)
    hull = first.over(support)
    if not pieces:
        return hull
    touched = np.zeros(len(lanes), dtype=bool)
    low, high = hull.rows.low, hull.rows.high
    for piece_lanes, jet in pieces:
        rows = jet.over(support).rows
        np.minimum.at(low.T, piece_lanes, rows.low.T)
        np.maximum.at(high.T, piece_lanes, rows.high.T)
        touched[piece_lanes] = True
    return Jet(hull.space, support, select_balls(touched, Ball.between(low, high), hull.rows))


def list_samples(response: ResponseProgram, count: int) -> list[Fraction]:
    """Return the angles [turns] of `count` equal steps of a cycle, of a turn or more, that differ
    modulo the period.
    """
    cycle = max(Fraction(1), response.period)
    share = response.period / cycle * count
    return [cycle * i / count for i in range(int(share) if share.denominator == 1 else count)]


def list_angles(turns: Sequence[Fraction]) -> Ball:
    """Return angles [rad] for angles in turns."""
    share = np.array([float(2 * turn) for turn in turns])
    return PI * Ball(share, U * np.abs(share))


class ResponseRecorder:
    """Builds a response of designs with `parameters` values, from code."""

    def __init__(self, parameters: int) -> None:
        self.parameters, self.stages = parameters, list[RecordedProgram]()
        self._count = parameters + 1

    @property
    def phi(self) -> int:
        """The index of the angle."""
        return self.parameters

    def call(self, code: Code, inputs: Sequence[int], limits: Sequence[float] = ()) -> list[int]:
        """Return the indices of the results of code or, with limits (k,), of the roots of its first
        k results, which it takes as unknowns before the inputs.
        """
        stage = record_program(code, len(limits) + len(inputs), inputs, limits)
        self.stages.append(stage)
        self._count += stage.size
        return list(range(self._count - stage.size, self._count))


Kinks = tuple[Array, Array, Array]
"""Angles [rad] of kinks (k,) at a design, their slopes (k, p) in it, and how they bend (k, p, p)."""
LEAST_GUARD = 1e-6
"""Least distance of the end of a panel from a kink [rad]."""


@dataclass(frozen=True)
class AnglePanels:
    """Panels over a period: `parts` (k,) equal ones from each of the `knots` (k,) [rad] to the
    next, or to its end.

    Knots are those at the centre of a box, with `rates` (k, p) in the design. The space of panels
    has the place in a panel, from -1 to 1, as the parameter after those of the design.
    """

    knots: Array
    rates: Array
    parts: tuple[int, ...]
    period: Ball

    @classmethod
    def build(cls, kinks: Kinks, half: Array, period: Ball, count: int) -> AnglePanels:
        """Return at least `count` panels over designs of a box with half widths (p,), narrow ones
        about the kinks.
        """
        turn = float(period.mid[0])
        angles, rates, bends = kinks
        guard = np.einsum("kij,i,j->k", np.abs(bends), half, half) + LEAST_GUARD
        ends = np.concatenate([angles - guard, angles + guard])
        slopes = np.concatenate([rates, rates])
        knots: list[tuple[float, Array]] = []
        for k in np.argsort(ends, kind="stable"):
            if not knots or ends[k] - knots[-1][0] > np.abs(slopes[k] - knots[-1][1]) @ half:
                knots.append((ends[k], slopes[k]))
        while (
            len(knots) > 1
            and knots[0][0] + turn - knots[-1][0] <= np.abs(knots[0][1] - knots[-1][1]) @ half
        ):
            knots.pop()
        knots = knots or [(0.0, np.zeros_like(half))]
        places = np.array([place for place, _ in knots])
        widths = np.diff(places, append=places[0] + turn)
        parts = tuple(max(1, int(np.ceil(width / turn * count))) for width in widths)
        return cls(places, np.array([rate for _, rate in knots]), parts, period)

    @cached_property
    def places(self) -> Array:
        """Return the angles [rad] at which panels begin at the centre of a box (m,)."""
        return self._divide(self.knots, self.knots[:1] + self.period.mid[0])

    @cached_property
    def slopes(self) -> Array:
        """Slopes (m, p) of the places in the design."""
        return self._divide(self.rates, self.rates[:1])

    def _divide(self, values: Array, end: Array) -> Array:
        """Return values at all places from those (k, ...) at the knots and at the end of the
        period.
        """
        steps = np.diff(values, axis=0, append=end)
        shares = [np.arange(count) / count for count in self.parts]
        return np.concatenate(
            [
                value + np.multiply.outer(share, step)
                for value, share, step in zip(values, shares, steps, strict=True)
            ]
        )

    def angles(self, space: Space) -> tuple[Jet, Jet]:
        """Return the angles in the panels [rad], and the shares of the panels in the period, over a
        box.

        Raises Unbounded if a panel may have no width.
        """
        low = space.linear(self.places, self.slopes)
        next_, count = np.roll(np.arange(len(self.places)), -1), len(self.places)
        is_last = np.arange(count) == count - 1
        turn = Ball(
            np.where(is_last, self.period.mid, 0.0), np.where(is_last, self.period.rad, 0.0)
        )
        high = low.taken(next_) + space.constant(turn)
        width = high - low
        if not (width.value[ANYWHERE].low > 0).all():
            raise Unbounded("panels of angles overlap")
        place = space.parameters()[-1]
        return (low + high) / 2 + width * place / 2, width / space.constant(self.period)

    def find_peaks(self, jet: Jet, k: int, count: int) -> tuple[Array, Array]:
        """Return `count` angles [rad] where a quantity, with its place k, is nearly greatest, and
        their slopes (n, p).

        They are those of the greatest values of parabolas at the centre of the box, and move as
        panels do.
        """
        full = jet.over(unite_supports([jet], k))
        at = full.support.index(k)
        value, slope = full.value.mid[CENTRE], full.gradient.mid[CENTRE][at]
        bend = np.minimum(full.hessian.mid[at * (at + 3) // 2], 0.0)
        place = np.where(
            bend < 0, np.clip(-slope / np.where(bend < 0, bend, -1.0), -1, 1), np.sign(slope)
        )
        best = np.argsort(-(value + slope * place + bend * place**2 / 2), kind="stable")[:count]
        share = (1 + place[best]) / 2
        widths = np.diff(self.places, append=self.places[0] + self.period.mid[0])[best]
        further = np.roll(self.slopes, -1, axis=0)[best] - self.slopes[best]
        return self.places[best] + share * widths, self.slopes[best] + share[:, None] * further
