"""Enclosures of a response and bounds of an objective over a box of designs.

A response is a sequence of programs, some of whose results are roots of others. Evaluated on jets,
it encloses each sample of a cycle, and from these an objective and its slopes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from planter.engine.proof.intervals import PI, Ball, Branches, U, Unbounded, select_balls
from planter.engine.proof.jets import ANYWHERE, CENTRE, Jet, Space, join_lanes, join_parts
from planter.engine.proof.panels import AnglePanels
from planter.engine.proof.programs import Code, ProgramRunner, RecordedProgram, record_program
from planter.engine.proof.roots import enclose_roots, has_rootless_lane
from planter.kernels import Array, Integers

MAX_LANES = 8
"""Average number of pieces of a lane above which a box is too wide to follow them."""


@dataclass(frozen=True)
class ProgramStage:
    """A step of a response: results of a program, or, where `limits` (k,) are given, roots of k
    unknowns.

    `inputs` are indices of values of the response. The program of roots takes the unknowns first,
    whose sizes are at most `limits`, and returns k residuals, then their Jacobian by rows.
    """

    program: RecordedProgram
    inputs: tuple[int, ...]
    limits: tuple[float, ...] = ()

    @property
    def size(self) -> int:
        """The number of values that the stage adds."""
        return len(self.limits or self.program.outputs)


@dataclass(frozen=True)
class ResponseProgram:
    """Quantities F(phi, x) as programs: sums over `offsets` [turns] of shares at phi + offset.

    Values are the p parameters of a design, the angle phi [rad], then the results of each stage;
    those of the last stage are the shares. The quantities have a common `period` [turns], and do
    not jump over designs if `is_continuous`, whatever the conditions in their code.
    """

    parameters: int
    stages: tuple[ProgramStage, ...]
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

    def to_document(self) -> dict[str, Any]:
        """Return the response as a JSON object."""
        return {
            "parameters": self.parameters,
            "stages": [
                {
                    **stage.program.to_document(),
                    "inputs": stage.inputs,
                    "limits": [x.hex() for x in stage.limits],
                }
                for stage in self.stages
            ],
            "offsets": [str(offset) for offset in self.offsets],
            "period": str(self.period),
            "continuous": self.is_continuous,
        }

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> ResponseProgram:
        """Return the response of a JSON object.

        Raises ValueError, KeyError, TypeError or IndexError if it is none.
        """
        stages = tuple(
            ProgramStage(
                RecordedProgram.from_document(stage),
                tuple(stage["inputs"]),
                tuple(float.fromhex(x) for x in stage["limits"]),
            )
            for stage in document["stages"]
        )
        if any(k < 0 for stage in stages for k in stage.inputs):
            raise ValueError("an input of a stage has no index")
        return cls(
            int(document["parameters"]),
            stages,
            tuple(map(Fraction, document["offsets"])),
            Fraction(document["period"]),
            bool(document["continuous"]),
        )


class ResponseRecorder:
    """Builds a response of designs with `parameters` values, from code."""

    def __init__(self, parameters: int) -> None:
        self.parameters, self.stages = parameters, list[ProgramStage]()
        self._count = parameters + 1

    @property
    def phi(self) -> int:
        """The index of the angle."""
        return self.parameters

    def call(self, code: Code, inputs: Sequence[int]) -> list[int]:
        """Return the indices of the results of code."""
        return self._add(ProgramStage(record_program(code, len(inputs)), tuple(inputs)))

    def solve(self, code: Code, inputs: Sequence[int], limits: Sequence[float]) -> list[int]:
        """Return the indices of the roots of code, which takes the unknowns before the inputs."""
        return self._add(
            ProgramStage(
                record_program(code, len(limits) + len(inputs)), tuple(inputs), tuple(limits)
            )
        )

    def _add(self, stage: ProgramStage) -> list[int]:
        self.stages.append(stage)
        self._count += stage.size
        return list(range(self._count - stage.size, self._count))


@dataclass(frozen=True)
class RootStart:
    """Values near roots (k, n) at equal steps from 0 to the end of a `cycle` [rad], NaN where there
    are none.

    A single column (k, 1) is for all angles.
    """

    values: Array
    cycle: float = 0.0

    def find_near(self, phi: Array) -> Array:
        """Return values (k, lanes) near the roots at angles phi (lanes,), by linear
        interpolation.
        """
        if self.values.shape[1] == 1:
            return np.repeat(self.values, len(phi), axis=1)
        angles = np.linspace(0, self.cycle, self.values.shape[1])
        return np.array([np.interp(np.mod(phi, self.cycle), angles, row) for row in self.values])


Starts = Sequence[Sequence[RootStart]]
"""For each box of a space, values near the roots of each stage that has some, in their order."""
FindStarts = Callable[[Array], Sequence[RootStart]]
"""Design (p,) -> values near the roots of each stage that has some.

Raises Unbounded if there are none.
"""

REMEMBERED = 64
"""Results of a stage that are kept for inputs that come again."""


class EnclosedResponse:
    """The quantities of a response over boxes of designs; `find_starts` gives where to look for
    roots.
    """

    def __init__(self, program: ResponseProgram, find_starts: FindStarts | None = None) -> None:
        self.program = program
        self.find_starts: FindStarts = find_starts or (lambda _: ())
        self.runners = [ProgramRunner(stage.program) for stage in program.stages]
        self._fixed_results: dict[Any, list[Jet]] = {}

    def prepare(self, space: Space, phi: Jet, starts: Starts) -> list[Jet]:
        """Return the inputs of the last stage over a box at angles phi (lanes,) [rad].

        After the p parameters of a design, a space may have the place in a panel of angles as one
        more. `starts` are those of each of the boxes of the space, which have equal numbers of
        lanes. Raises Unbounded where roots do not exist.
        """
        values, roots = [*space.parameters()[: self.program.parameters], phi], 0
        for index, stage in enumerate(self.program.stages[:-1]):
            inputs, guesses = [values[k] for k in stage.inputs], None
            if stage.limits:
                lanes = np.split(phi.value.mid[CENTRE], len(starts))
                guesses = np.concatenate(
                    [box[roots].find_near(part) for box, part in zip(starts, lanes, strict=True)],
                    axis=1,
                )
                guesses = (
                    guesses[:, :1] if self.program.fixed[index] and len(starts) == 1 else guesses
                )
                roots += 1
            values += self._evaluate(index, space, inputs, guesses)
        return [values[k] for k in self.program.stages[-1].inputs]

    def _evaluate(
        self, index: int, space: Space, inputs: Sequence[Jet], guesses: Array | None
    ) -> list[Jet]:
        """Return the results of a stage; those that no angle changes are remembered."""
        if not self.program.fixed[index]:
            return self._compute(index, space, inputs, guesses)
        support = sorted({k for jet in inputs for k in jet.support})
        parts = [ball for jet in inputs for ball in (jet.value, jet.gradient, jet.hessian)]
        key = (
            index,
            *support,
            space.half[support].tobytes(),
            *(side.tobytes() for b in parts for side in (b.mid, b.rad)),
        )
        if key not in self._fixed_results:
            if len(self._fixed_results) == REMEMBERED:
                del self._fixed_results[next(iter(self._fixed_results))]
            self._fixed_results[key] = self._compute(index, space, inputs, guesses)
        return [replace(jet, space=space) for jet in self._fixed_results[key]]

    def _compute(
        self, index: int, space: Space, inputs: Sequence[Jet], guesses: Array | None
    ) -> list[Jet]:
        runner = self.runners[index]
        if guesses is None:
            return runner.enclose_smooth(space, inputs)
        if np.isnan(guesses).all():
            raise Unbounded("loops do not close at the centre of a box")
        smooth = space.asking(
            Branches.none(1)
        )  # `at_points` must not change the space of the caller
        fixed = [replace(jet, space=smooth) for jet in inputs]
        roots = enclose_roots(
            smooth,
            guesses,
            lambda q: _split_gaps(runner.enclose_smooth(smooth, [*q, *fixed]), len(q)),
        )
        return [replace(root, space=space) for root in roots]

    def is_empty(self, lower: Array, upper: Array, phi: Ball) -> bool:
        """Return whether at one of the angles phi (lanes,) [rad] no design of a box [lower, upper]
        (p,) has roots.

        Roots are searched up to the limits of their stage, which must take parameters and angles
        alone.
        """
        space = Space(lower, lower)
        box = [
            space.constant(Ball.between(lower[k : k + 1], upper[k : k + 1]))
            for k in range(self.program.parameters)
        ]
        values = [*box, space.constant(phi)]
        stages = zip(self.program.stages, self.runners, strict=True)
        return any(
            _has_no_roots(stage, runner, space, [values[k] for k in stage.inputs])
            for stage, runner in stages
            if np.isfinite(stage.limits).any() and max(stage.inputs) < len(values)
        )


def _has_no_roots(
    stage: ProgramStage, runner: ProgramRunner, space: Space, inputs: Sequence[Jet]
) -> bool:
    """Return whether there are certainly no roots within the limits of a stage in one of the lanes
    of its inputs.
    """

    def enclose_gaps(
        q: Sequence[Ball], lanes: Integers
    ) -> tuple[Sequence[Ball], Sequence[Sequence[Ball]]]:
        taken = [jet if jet.lanes == 1 else jet.taken(lanes) for jet in inputs]
        rows = runner.enclose_smooth(space, [*map(space.constant, q), *taken])
        return _split_gaps([row.value[ANYWHERE] for row in rows], len(q))

    limits = np.array(stage.limits)
    return has_rootless_lane(enclose_gaps, -limits, limits, max(jet.lanes for jet in inputs))


T = TypeVar("T")


def _split_gaps(rows: Sequence[T], size: int) -> tuple[Sequence[T], Sequence[Sequence[T]]]:
    """Return the residuals (k,) and the rows of their Jacobian (k, k) from the results of code of
    roots.
    """
    return rows[:size], [rows[k : k + size] for k in range(size, size + size * size, size)]


def enclose_samples(response: EnclosedResponse, space: Space, count: int) -> list[Jet]:
    """Return each quantity over a box at phi = 2 pi i / count, with a lane for each angle modulo
    the period.
    """
    starts = [response.find_starts(space.centre)]
    return enclose_turns(response, space, list_samples(response.program, count), starts)


def list_samples(response: ResponseProgram, count: int) -> list[Fraction]:
    """Return the angles [turns] of `count` equal steps of a cycle, of a turn or more, that differ
    modulo the period.
    """
    cycle = max(Fraction(1), response.period)
    share = response.period / cycle * count
    return [cycle * i / count for i in range(int(share) if share.denominator == 1 else count)]


def enclose_turns(
    response: EnclosedResponse, space: Space, turns: Sequence[Fraction], starts: Starts
) -> list[Jet]:
    """Return each quantity over boxes at fixed angles [turns], a lane for each."""
    fixed = [list_angles([turn + offset for turn in turns]) for offset in response.program.offsets]
    return enclose_at(response, space, [space.constant(phi) for phi in fixed], starts)


def enclose_moving(response: EnclosedResponse, space: Space, phi: Jet, starts: Starts) -> list[Jet]:
    """Return each quantity over a box at angles that may move with the design [rad], a lane for
    each.
    """
    offsets = response.program.offsets
    return enclose_at(
        response, space, [phi + space.constant(list_angles([offset])) for offset in offsets], starts
    )


def enclose_at(
    response: EnclosedResponse, space: Space, angles: Sequence[Jet], starts: Starts
) -> list[Jet]:
    """Return each quantity over boxes from the angles [rad] of its shares, of the same lanes
    each.
    """
    count = angles[0].lanes
    sides, shares = (
        range(1, len(angles)),
        _enclose_pieces(response, space, join_lanes(angles), starts),
    )
    space.jumping = np.asarray(space.jumping.reshape(-1, count).any(axis=0))
    return [
        sum(
            (share.taken(slice(k * count, (k + 1) * count)) for k in sides),
            share.taken(slice(0, count)),
        )
        for share in shares
    ]


def list_angles(turns: Sequence[Fraction]) -> Ball:
    """Return angles [rad] for angles in turns."""
    share = np.array([float(2 * turn) for turn in turns])
    return PI * Ball(share, U * np.abs(share))


def _enclose_pieces(
    response: EnclosedResponse, space: Space, phi: Jet, starts: Starts
) -> list[Jet]:
    """Return enclosures of the shares at angles (lanes,) [rad], each around all smooth pieces."""
    count = phi.lanes
    lanes, script = np.arange(count), np.empty((0, count))
    parts: list[tuple[Integers, list[Jet]]] = []
    inputs = response.prepare(space, phi, starts)
    space.jumping = np.zeros(count, dtype=bool)
    while len(lanes):
        branches, jets = response.runners[-1].enclose(space, inputs, lanes, script)
        if not response.program.is_continuous:
            np.logical_or.at(space.jumping, lanes, branches.jumping)
        parts.append((lanes, [replace(jet.repeated(len(lanes)), space=space) for jet in jets]))
        further, script = branches.further()
        lanes = lanes[further]
        if sum(len(piece_lanes) for piece_lanes, _ in parts) > MAX_LANES * count:
            raise Unbounded("a box goes through many branches")
    quantities = range(len(parts[0][1]))
    return [
        _enclose_parts([(piece_lanes, jets[index]) for piece_lanes, jets in parts])
        for index in quantities
    ]


def _enclose_parts(parts: Sequence[tuple[Integers, Jet]]) -> Jet:
    """Return a jet around all parts: the first part has every lane, the others are pieces of some
    lanes.
    """
    (lanes, first), *pieces = parts
    support = tuple(sorted({k for _, jet in parts for k in jet.support}))
    hull = first.over(support).taken(lanes)
    touched = np.zeros(len(lanes), dtype=bool)
    balls = [hull.value, hull.gradient, hull.hessian]
    bounds = [(ball.low, ball.high) for ball in balls] if pieces else []
    for piece_lanes, jet in pieces:
        touched[piece_lanes] = True
        piece = jet.over(support).taken(np.arange(len(piece_lanes)))
        for (low, high), ball in zip(
            bounds, (piece.value, piece.gradient, piece.hessian), strict=True
        ):
            np.minimum.at(low.T, piece_lanes, ball.low.T)
            np.maximum.at(high.T, piece_lanes, ball.high.T)
    if pieces:
        balls = [
            select_balls(touched, Ball.between(*side), ball)
            for side, ball in zip(bounds, balls, strict=True)
        ]
    return Jet(hull.space, support, *balls)


MAX_CHOICES = 60
"""Maximum number of combinations of angles, one for each extreme, at which an objective is bounded
from below.
"""


@dataclass(frozen=True)
class Maximum:
    """The greatest value of a quantity over a cycle: it is nowhere below `points` (lanes), and one
    of `panels` (lanes).

    These are the same samples, or a few angles and what the quantity is anywhere in panels of all
    angles.
    """

    points: Jet
    panels: Jet

    @cached_property
    def order(self) -> Integers:
        """The points by their values at the centre, the greatest first."""
        return np.argsort(-self.points.value[CENTRE].mid, kind="stable")

    def find_span(self, part: int) -> tuple[float, float]:
        """Return between which values the greatest value is, at the centre of the box or anywhere
        in it.
        """
        return float(self.points.value[part].low.max()), float(self.panels.value[part].high.max())

    def find_slopes(self, support: tuple[int, ...]) -> Ball:
        """Return what encloses the slopes of the greatest value: those of all panels that may have
        it.
        """
        panels = self.panels.over(tuple(sorted({*support, *self.panels.support})))
        lanes = np.flatnonzero((self.points.taken(self.order[:1]) - panels).lower_bound <= 0)
        places = [panels.support.index(k) for k in support]
        return panels.taken(lanes).gradient[ANYWHERE].spread()[places]


@dataclass(frozen=True)
class Evidence:
    """Choices with which an objective was bounded over a box; bounds are true whatever they are.

    `panels` of angles, angles `peaks` (n,) [rad] near extremes, which move with the design at
    `rates` (n, p), `starts` of roots, and `narrow` panels at the centre of the box. Samples have
    none of them but starts.
    """

    starts: Sequence[RootStart] = ()
    panels: AnglePanels | None = None
    peaks: Array | None = None
    rates: Array | None = None
    narrow: AnglePanels | None = None


@dataclass(frozen=True)
class ObjectiveBounds:
    """Bounds of an objective over a box: `lower_bound` is below all values, `reached` above the
    value at the centre.

    `slopes` (p,) enclose the derivatives, at kinks the one-sided ones; `looseness` (p,) is the
    contribution of the width of each parameter to the looseness of the bounds. The slopes do not
    apply to an objective that `may_jump`, nor to an objective of which only a part is bounded.
    """

    lower_bound: float
    reached: float
    slopes: Ball
    looseness: Array
    may_jump: bool = False
    evidence: Evidence = Evidence()


def bound_objective(smooth: Jet, extremes: Sequence[Maximum]) -> ObjectiveBounds:
    """Return bounds of a smooth part (one lane) plus greatest values."""
    count = int(MAX_CHOICES ** (1 / max(1, len(extremes))))
    chosen = [extreme.order[:count] for extreme in extremes]
    total = smooth
    for extreme, lanes in zip(extremes, np.meshgrid(*chosen, indexing="ij"), strict=True):
        total = total + extreme.points.taken(lanes.ravel())
    moved = (
        k for extreme in extremes for k in extreme.panels.support if smooth.space.half[k].any()
    )
    total = total.over(tuple(sorted({*total.support, *moved})))
    slopes = smooth.over(total.support).gradient[ANYWHERE][:, 0]
    for extreme in extremes:
        slopes = slopes + extreme.find_slopes(total.support)
    reached = smooth.value[CENTRE][0]
    for extreme in extremes:
        reached = reached + Ball.exact(extreme.find_span(CENTRE)[1])
    space = smooth.space
    half = space.half[list(total.support)]
    curvature = (half * space.reach(total.support, total.hessian.magnitude)).max(axis=-1)
    bounds = ObjectiveBounds(
        float(total.lower_bound.max()),
        float(reached.high),
        slopes,
        curvature + half[:, 0] * slopes.rad,
    )
    return _expand_bounds(total, bounds)


def _expand_bounds(total: Jet, bounds: ObjectiveBounds) -> ObjectiveBounds:
    """Return the bounds with slopes and looseness of all parameters (p,), zero for parameters of
    zero width.
    """
    size, support = len(total.space.lower), list(total.support)
    mid, rad, loose = np.zeros(size), np.zeros(size), np.zeros(size)
    mid[support], rad[support], loose[support] = (
        bounds.slopes.mid,
        bounds.slopes.rad,
        bounds.looseness,
    )
    return ObjectiveBounds(
        bounds.lower_bound, bounds.reached, Ball(mid, rad), loose, total.space.may_jump
    )


def enclose_square(jet: Jet) -> Jet:
    """Return the squares, which are nowhere negative."""
    square = jet**2
    anywhere, power = square.value[ANYWHERE], jet.value[ANYWHERE].square()
    value = Ball.between(np.maximum(anywhere.low, power.low), np.minimum(anywhere.high, power.high))
    return square.holding(join_parts(square.value[CENTRE], value))
