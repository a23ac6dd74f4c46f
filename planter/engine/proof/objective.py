"""An objective over a cycle, or over samples of it, bounded over boxes of designs.

The objective is a sum of measures of the quantities of a response; limits on such measures may
exclude designs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal, Protocol, cast

import numpy as np

from planter.engine.machine import Machine
from planter.engine.measures import Limit, Measure
from planter.engine.proof.continuation import AssemblyStart
from planter.engine.proof.enclosures import (
    AnglePanels,
    Kinks,
    ResponseProgram,
    RootBranch,
    list_angles,
    list_samples,
)
from planter.engine.proof.intervals import Ball, Unbounded, intersect_balls
from planter.engine.proof.jets import (
    ANYWHERE,
    CENTRE,
    Jet,
    Space,
    join_lanes,
    join_parts,
    unite_supports,
)
from planter.errors import InputError
from planter.kernels import Array, Integers

Box = tuple[Array, Array]
"""Designs between two others (p,)."""
MeasureKind = Literal["max", "min", "range", "mean", "variance", "std", "rms", "at"]
SIDES: dict[str, tuple[int, ...]] = {"max": (1,), "min": (-1,), "range": (1, -1)}
"""Sides on which a quantity is extreme, for each measure of extremes."""
NONNEGATIVE = ("range", "variance", "std", "rms")
"""Measures that are never below zero, of whatever quantity."""

MOST_LANES = 768
"""Lanes of boxes and angles above which it saves no more time to bound several boxes at once."""
MAX_CHOICES = 60
"""Maximum number of combinations of angles, one for each extreme, at which an objective is bounded
from below.
"""

PANELS, PANELS_AT_POINT = 480, 2880
"""Least number of panels of a period over a box, and at a single design."""
PEAKS = 3
"""Angles at which the greatest value of a quantity is bounded from below."""
WIDE_CENTRE = 0.2
"""Share of the looseness of a smooth part that its value at the centre may have."""

REMEMBERED = 64
"""Boxes whose roots are remembered for their parts."""

FindKinks = Callable[[Array], Kinks]
"""Gives the kinks of quantities within their period at a design (p,)."""


@dataclass(frozen=True)
class BoundedMeasure:
    """A measure of a quantity, by its index, times a weight; the weight of a least value, "min", is
    not positive.

    Of kind "at", it is the value at an `angle` [deg]. Quantities that are sizes are nowhere below
    zero. With a `sign`, the measure is limited: at most (+1) or at least (-1) `limit`.
    """

    kind: MeasureKind
    quantity: int
    size: bool = False
    weight: float = 1.0
    angle: float | None = None
    sign: int = 0
    limit: float = 0.0

    @property
    def is_nonnegative(self) -> bool:
        """Whether a term of a sum is nowhere below zero."""
        is_size = self.kind in NONNEGATIVE or (self.size and self.kind in ("max", "at"))
        return is_size and self.weight >= 0

    def is_violated(self, span: tuple[float, float]) -> bool:
        """Return whether no design of a box satisfies the limit, from the span of the measure."""
        return span[0] > self.limit if self.sign > 0 else span[1] < self.limit

    def is_satisfied(self, span: tuple[float, float]) -> bool:
        """Return whether all designs of a box satisfy the limit, from the span of the measure."""
        return span[1] <= self.limit if self.sign > 0 else span[0] >= self.limit

    def to_document(self) -> dict[str, Any]:
        """Return the measure as a JSON object."""
        limit = {"sign": self.sign, "limit": float(self.limit).hex()} if self.sign else {}
        return {
            "measure": self.kind,
            "quantity": self.quantity,
            "size": self.size,
            "weight": float(self.weight).hex(),
            "angle_deg": None if self.angle is None else float(self.angle).hex(),
            **limit,
        }

    @classmethod
    def from_document(cls, entry: Mapping[str, Any]) -> BoundedMeasure:
        """Return the measure of a JSON object whose form was checked."""
        angle = entry["angle_deg"]
        return cls(
            entry["measure"],
            entry["quantity"],
            entry["size"],
            float.fromhex(entry["weight"]),
            None if angle is None else float.fromhex(angle),
            entry.get("sign", 0),
            float.fromhex(entry.get("limit", "0x0p+0")),
        )


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
        panels = self.panels.over(unite_supports([self.panels], *support))
        lanes = np.flatnonzero((self.points.taken(self.order[:1]) - panels).lower_bound <= 0)
        places = [panels.support.index(k) for k in support]
        return panels.taken(lanes).gradient[ANYWHERE].spread()[places]


@dataclass(frozen=True)
class Evidence:
    """Choices with which an objective was bounded over a box; bounds are true whatever they are.

    `panels` of angles, angles `peaks` (n,) [rad] near extremes, which move with the design at
    `rates` (n, p), and `narrow` panels at the centre of the box; samples have none of them. Roots
    are those that were followed to all of a `domain`, which holds the box.
    """

    domain: Box | None = None
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
    `domain` is a box over which roots were followed to all angles, for the parts of the box.
    """

    lower_bound: float
    reached: float
    slopes: Ball
    looseness: Array
    may_jump: bool = False
    evidence: Evidence = Evidence()
    domain: Box | None = None


def bound_objective(smooth: Jet, extremes: Sequence[Maximum]) -> ObjectiveBounds:
    """Return bounds of a smooth part (one lane) plus greatest values."""
    count = int(MAX_CHOICES ** (1 / max(1, len(extremes))))
    chosen = [extreme.order[:count] for extreme in extremes]
    total, space = smooth, smooth.space
    for extreme, lanes in zip(extremes, np.meshgrid(*chosen, indexing="ij"), strict=True):
        total = total + extreme.points.taken(lanes.ravel())
    moving = np.flatnonzero(space.half.any(axis=1)).tolist()
    extended = (k for extreme in extremes for k in extreme.panels.support if k in moving)
    total = total.over(unite_supports([total], *extended))
    support, reached = total.support, smooth.value[CENTRE][0]
    slopes = smooth.over(support).gradient[ANYWHERE][:, 0]
    for extreme in extremes:
        slopes = slopes + extreme.find_slopes(support)
        reached = reached + Ball.exact(extreme.find_span(CENTRE)[1])
    half = space.half[list(support)]
    curvature = (half * space.reach(support, total.hessian.magnitude)).max(axis=-1)
    mid, rad, loose = np.zeros((3, len(space.lower)))
    columns = slopes.mid, slopes.rad, curvature + half[:, 0] * slopes.rad
    for side, column in zip((mid, rad, loose), columns, strict=True):
        side[list(support)] = column
    lower_bound, may_jump = float(total.lower_bound.max()), bool(space.jumping.any())
    return ObjectiveBounds(lower_bound, float(reached.high), Ball(mid, rad), loose, may_jump)


def enclose_square(jet: Jet) -> Jet:
    """Return the squares, which are nowhere negative."""
    square = jet**2
    anywhere, power = square.value[ANYWHERE], jet.value[ANYWHERE].square()
    value = Ball.between(np.maximum(anywhere.low, power.low), np.minimum(anywhere.high, power.high))
    return square.holding(join_parts(square.value[CENTRE], value))


class ProvableObjective:
    """A sum of measures of the quantities of a response, bounded over boxes of designs.

    Roots of the response are those that `start` means. Extremes and means are those of `count`
    samples, or, if it is None, true extremes and integrals,
    for which `find_kinks` gives the angles in a period at which quantities have kinks; bounds hold
    whatever it gives. `batch` is the number of boxes that are best bounded at once.

    Designs count that satisfy the limits, which are all there are if it `heeds_all`; a box in which
    one is certainly violated has no bound but infinity. Angles at which quantities cannot be
    enclosed are left out: no greatest value, no least one made large, and no mean of squares is
    less than what the others make of it. `labels` are names of the `quantities`, for people, and
    `factors` are SI units per unit of each.
    """

    def __init__(
        self,
        response: ResponseProgram,
        terms: Sequence[BoundedMeasure],
        limits: Sequence[BoundedMeasure] = (),
        count: int | None = None,
        start: AssemblyStart | None = None,
        find_kinks: FindKinks | None = None,
        heeds_all: bool = True,
        labels: Sequence[str] = (),
        quantities: Sequence[ProvedQuantity] = (),
        factors: Sequence[float] = (),
    ) -> None:
        self.response, self.terms, self.limits = response, tuple(terms), tuple(limits)
        self.count, self.heeds_all = count, heeds_all
        self.start, self._find_kinks = start, find_kinks
        self._branches: dict[bytes, RootBranch] = {}
        results = range(len(response.stages[-1].outputs))
        self.labels = tuple(labels) or tuple(f"result {k}" for k in results)
        self.quantities, self.factors = tuple(quantities), tuple(factors)
        measures = (*self.terms, *self.limits)
        self._extremes = list(
            dict.fromkeys(
                (measure.quantity, side)
                for measure in measures
                for side in SIDES.get(measure.kind, ())
            )
        )
        self._angles = list(
            dict.fromkeys(measure.angle for measure in measures if measure.angle is not None)
        )
        self._fixed = [Fraction(angle) / 360 for angle in self._angles]
        self._turns = [] if count is None else [*list_samples(response, count), *self._fixed]
        many = self._turns and len(response.offsets) == 1
        self.batch = max(1, MOST_LANES // len(self._turns)) if many else 1

    def __call__(
        self, lower: Array, upper: Array, evidence: Evidence | None = None
    ) -> ObjectiveBounds:
        """Return the bounds over a box, from choices that are given or made.

        Raises Unbounded without bounds.
        """
        with np.errstate(all="ignore"):
            (result,) = self._bound_batch(
                [(lower, upper)], [evidence or self._begin((lower, upper))]
            )
        if isinstance(result, Unbounded):
            raise result
        return result

    def bound_boxes(
        self, boxes: Sequence[Box], domains: Sequence[Box | None] | None = None
    ) -> list[ObjectiveBounds | Unbounded]:
        """Return the bounds over each of some boxes, or the reason why it is unbounded.

        `domains` hold the boxes, and roots were followed to all of each that is not None.
        """
        pairs = list(zip(boxes, domains or [None] * len(boxes), strict=True))
        batches = [pairs[k : k + self.batch] for k in range(0, len(pairs), self.batch)]
        with np.errstate(all="ignore"):
            return [
                result
                for batch in batches
                for result in self._bound_batch(
                    [box for box, _ in batch], [self._begin(*pair) for pair in batch]
                )
            ]

    def _begin(self, box: Box, domain: Box | None = None) -> Evidence:
        """Return evidence that says to where roots are followed, if there are any."""
        return Evidence((domain or box) if self.response.rooted else None)

    def _bound_batch(
        self, boxes: Sequence[Box], evidence: Sequence[Evidence]
    ) -> list[ObjectiveBounds | Unbounded]:
        try:
            if self.count is None:
                cycles = [self._enclose_panels(*boxes[0], evidence[0])]
            else:
                cycles = self._enclose_samples(boxes, evidence)
        except Unbounded as error:
            if len(boxes) == 1:
                return [error]
            pairs = zip(boxes, evidence, strict=True)
            return [
                result for box, choice in pairs for result in self._bound_batch([box], [choice])
            ]
        return [self._bound_cycle(*pair) for pair in zip(boxes, cycles, strict=True)]

    def find_branch(self, domain: Box | None) -> RootBranch:
        """Return the roots that are meant over a box, remembered for its parts."""
        if domain is None or self.start is None or not self.response.rooted:
            return RootBranch(1.0, (), ())
        key = b"".join(side.tobytes() for side in domain)
        if key not in self._branches:
            if len(self._branches) == REMEMBERED:
                del self._branches[next(iter(self._branches))]
            self._branches[key] = self.start.follow(self.response, *domain)
        return self._branches[key]

    def _enclose_samples(
        self, boxes: Sequence[Box], evidence: Sequence[Evidence]
    ) -> list[EnclosedCycle]:
        """Return the samples of cycles over boxes, each of which takes as many lanes as there are
        angles.
        """
        count = len(self._turns)
        ends = [np.repeat(np.array(side).T, count, axis=1) for side in zip(*boxes, strict=True)]
        space = Space(*(ends if len(boxes) > 1 else boxes[0]))
        spaces = [Space(*box) for box in boxes]
        branches = [self.find_branch(choice.domain) for choice in evidence]
        phi = list_angles(self._turns * len(boxes))
        jets = self.response.enclose(space, space.constant(phi), branches)
        cycles = []
        for k, designs in enumerate(spaces):
            lanes = slice(k * count, (k + 1) * count)
            designs.jumping = space.jumping[lanes]
            taken = [jet.taken(lanes).moved(designs) for jet in jets]
            samples = count - len(self._angles)
            shares = (designs.lift(1) / samples).repeated(samples)
            angles = self._angles, list_angles(self._turns)
            cycles.append(EnclosedCycle(designs, taken, shares, *angles, evidence[k], branches[k]))
        return cycles

    def _enclose_panels(self, lower: Array, upper: Array, evidence: Evidence) -> EnclosedCycle:
        """Return a cycle over a box in panels of angles, and a few angles at which each extreme
        nearly is.
        """
        designs, fixed = Space(lower, upper), list_angles(self._fixed)
        panels, branch = evidence.panels, self.find_branch(evidence.domain)
        if panels is None:
            panels = self._choose_panels(designs)
            evidence = replace(evidence, panels=panels)
        space = Space(np.append(lower, -1.0), np.append(upper, 1.0))
        phi, shares = panels.angles(space)
        lanes = join_lanes([phi, space.constant(fixed)]) if self._fixed else phi
        jets = self.response.enclose(space, lanes, [branch])
        evidence = self._choose_peaks(
            evidence, [jet.taken(slice(0, phi.lanes)) for jet in jets], designs
        )
        points = self._enclose_peaks(designs, evidence)
        designs.jumping = space.jumping
        angles = Ball.exact(np.append(panels.places, fixed.mid))
        return EnclosedCycle(designs, jets, shares, self._angles, angles, evidence, branch, points)

    def _choose_panels(self, designs: Space) -> AnglePanels:
        """Return the panels of a box."""
        if self._find_kinks is None:
            raise Unbounded("the evidence has no panels of angles")
        period, kinks = list_angles([self.response.period]), self._find_kinks(designs.centre)
        count = PANELS if designs.half.any() else PANELS_AT_POINT
        return AnglePanels.build(kinks, designs.half[:, 0], period, count)

    def _choose_peaks(self, evidence: Evidence, jets: Sequence[Jet], designs: Space) -> Evidence:
        """Return evidence with angles near extremes, chosen from quantities in panels if there are
        none yet.
        """
        if evidence.peaks is not None or not self._extremes:
            return evidence
        assert evidence.panels is not None
        size = len(designs.lower)
        peaks = [
            evidence.panels.find_peaks(side * jets[index], size, PEAKS)
            for index, side in self._extremes
        ]
        places, rates = (np.concatenate(part) for part in zip(*peaks, strict=True))
        return replace(evidence, peaks=places, rates=rates)

    def _enclose_peaks(self, space: Space, evidence: Evidence) -> dict[tuple[int, int], Jet]:
        """Return quantities, minus those whose least value is asked for, at angles where they
        nearly are extreme.
        """
        if evidence.peaks is None or evidence.rates is None:
            return {}
        angles = space.linear(evidence.peaks, evidence.rates)
        branch, count = self.find_branch(evidence.domain), angles.lanes
        values = self.response.enclose(space, angles, [branch])
        share = count // len(self._extremes)
        return {
            (index, side): side
            * values[index].repeated(count).taken(slice(k * share, (k + 1) * share))
            for k, (index, side) in enumerate(self._extremes)
        }

    def _bound_cycle(self, box: Box, cycle: EnclosedCycle) -> ObjectiveBounds | Unbounded:
        """Return the bounds over a box from a cycle there, angles without bounds left out."""
        try:
            may_be_empty = not cycle.is_whole and cycle.may_be_empty
            if may_be_empty and self.response.is_empty(*box, cycle.phi):
                return _exclude(cycle)
            if not len(cycle.places):
                raise Unbounded("a quantity may have no bound at any angle")
            return self._bound(cycle)
        except Unbounded as error:
            return error

    def _bound(self, cycle: EnclosedCycle) -> ObjectiveBounds:
        anywhere = [(limit, cycle.find_span(limit, ANYWHERE)) for limit in self.limits]
        if any(limit.is_violated(span) for limit, span in anywhere):
            return _exclude(cycle)
        smooth, extremes, is_whole = cycle.bound_terms(self.terms)
        smooth, evidence = self._narrow(cycle, smooth)
        result = bound_objective(smooth, extremes)
        if not (np.isfinite(result.lower_bound) and np.isfinite(result.looseness).all()):
            raise Unbounded("a bound is not finite")
        is_free = all(limit.is_satisfied(span) for limit, span in anywhere)
        is_met = all(limit.is_satisfied(cycle.find_span(limit, CENTRE)) for limit in self.limits)
        return replace(
            result,
            reached=result.reached if is_whole and is_met and self.heeds_all else np.inf,
            # no side of the box may stand for one in which something is left out
            may_jump=result.may_jump or not is_whole or not is_free,
            evidence=evidence,
            domain=cycle.domain,
        )

    def _narrow(self, cycle: EnclosedCycle, smooth: Jet) -> tuple[Jet, Evidence]:
        """Return a smooth part whose value at the centre, if panels leave it too open, is that of
        more panels.
        """
        space, centre, evidence = cycle.space, smooth.value[CENTRE], cycle.evidence
        room = WIDE_CENTRE * (centre.mid - smooth.lower_bound)
        is_open = self.count is None and space.half.any() and (centre.rad > room).all()
        is_possible = evidence.narrow is not None or self._find_kinks is not None
        if not (is_open and is_possible):  # a proof that is checked may have done without it
            return smooth, evidence
        finer = Evidence(evidence.domain, evidence.narrow)
        point = self._enclose_panels(space.centre, space.centre, finer)
        narrow, _, _ = point.bound_terms(self.terms)
        value = intersect_balls(centre, narrow.value[CENTRE])
        smooth = smooth.holding(join_parts(value, smooth.value[ANYWHERE])).cut()
        return smooth, replace(evidence, narrow=point.evidence.panels)

    @property
    def floor(self) -> float:
        """The largest known number below all objectives."""
        return 0.0 if all(term.is_nonnegative for term in self.terms) else -np.inf


@dataclass(frozen=True)
class EnclosedCycle:
    """Quantities over a box, at samples or anywhere in panels of a cycle.

    Lanes of `jets` are those of the cycle, whose `shares` in it add up to one, then those of
    `angles` [deg]. In panels, jets have a place after the parameters of the box, and `points` are
    values that extremes, by quantity and side, are not below. `phi` are angles of the lanes [rad].
    """

    space: Space
    jets: Sequence[Jet]
    shares: Jet
    angles: Sequence[float]
    phi: Ball
    evidence: Evidence
    branch: RootBranch
    points: Mapping[tuple[int, int], Jet] = field(default_factory=dict)

    @cached_property
    def places(self) -> Integers:
        """The lanes in which all quantities have bounds."""
        lanes: Integers = np.flatnonzero(np.all([jet.is_bounded for jet in self.jets], axis=0))
        self.space.jumping = self.space.jumping[lanes]
        return lanes

    @property
    def is_whole(self) -> bool:
        """Whether all lanes have bounds."""
        return len(self.places) == self.shares.lanes + len(self.angles)

    @property
    def domain(self) -> Box | None:
        """A box whose parts have the same roots, if they were followed to all of it."""
        return self.evidence.domain if self.branch.is_whole else None

    @property
    def may_be_empty(self) -> bool:
        """Whether roots were not followed to some angle."""
        return not self.branch.is_whole

    def bound_terms(self, terms: Sequence[BoundedMeasure]) -> tuple[Jet, list[Maximum], bool]:
        """Return what a sum of measures is not below: a smooth part (one lane) and greatest values,
        and whether that is all of it.

        Raises Unbounded for a measure that needs all angles.
        """
        smooth, extremes, is_whole = self.space.lift(0), list[Maximum](), True
        for term in terms:
            lanes, has_all = self._find_lanes(term)
            sides, weight = SIDES.get(term.kind, ()), abs(term.weight)
            if not (has_all or term.is_nonnegative or sides):
                raise Unbounded(f"a term, {term.kind}, cannot be enclosed at every angle")
            is_whole &= has_all
            if sides and len(lanes):
                extremes += [self._find_maximum(term, side, weight) for side in sides]
            elif len(lanes):
                try:
                    smooth = smooth + self._average(term) * term.weight
                except Unbounded:
                    if not term.is_nonnegative:
                        raise
                    is_whole = False
        return smooth, extremes, is_whole

    def find_span(self, measure: BoundedMeasure, part: int) -> tuple[float, float]:
        """Return between which values a measure is, anywhere in the box or at its centre."""
        lanes, is_whole = self._find_lanes(measure)
        if not len(lanes):
            return -np.inf, np.inf
        if sides := SIDES.get(measure.kind):
            spans = [self._find_maximum(measure, side).find_span(part) for side in sides]
            lows, highs = (Ball.exact(ends).sum() for ends in zip(*spans, strict=True))
            low, high = float(lows.low), float(highs.high) if is_whole else np.inf
            return (-high, -low) if measure.kind == "min" else (low, high)
        try:
            value = self._average(measure).value[part]
        except Unbounded:
            return -np.inf, np.inf
        is_below = is_whole or measure.kind in NONNEGATIVE
        low, high = float(value.low[0]), float(value.high[0])
        return low if is_below else -np.inf, high if is_whole else np.inf

    def _find_lanes(self, measure: BoundedMeasure) -> tuple[Integers, bool]:
        """Return the lanes of the angles that a measure takes, and whether they are all."""
        count = self.shares.lanes
        if measure.angle is None:
            lanes = self.places[self.places < count]
            return lanes, len(lanes) == count
        lanes = self.places[self.places == count + self.angles.index(measure.angle)]
        return lanes, len(lanes) == 1

    def _find_maximum(self, measure: BoundedMeasure, side: int, weight: float = 1.0) -> Maximum:
        """Return the greatest value of a quantity, or of minus it, times a positive weight."""
        lanes, _ = self._find_lanes(measure)
        curve = self.jets[measure.quantity].taken(lanes).hull(len(self.space.lower))
        panels = curve.moved(self.space) * (side * weight)
        points = self.points.get((measure.quantity, side))
        if points is None or not points.is_bounded.any():
            return Maximum(panels, panels)
        return Maximum(points.taken(points.is_bounded) * weight, panels)

    def _average(self, measure: BoundedMeasure) -> Jet:
        """Return a measure without corners; of squares, those that are missing count as zero."""
        lanes, is_whole = self._find_lanes(measure)
        jet = self.jets[measure.quantity].taken(lanes)
        if measure.kind == "at":  # an angle that is fixed, and does not depend on the place
            return jet.hull(len(self.space.lower)).moved(self.space)
        shares = self.shares.taken(lanes)
        if measure.kind in ("variance", "std"):
            mean = self._mean(jet, shares)
            jet = jet - (mean if is_whole else mean / shares.sum())
        if measure.kind != "mean":
            jet = enclose_square(jet)
        mean = self._mean(jet, shares).moved(self.space)
        return mean.call("sqrt") if measure.kind in ("rms", "std") else mean

    def _mean(self, jet: Jet, shares: Jet) -> Jet:
        return (jet.average(len(self.space.lower)) * shares).sum()


def _exclude(cycle: EnclosedCycle) -> ObjectiveBounds:
    """Return the bounds over a box in which no design counts."""
    nothing = np.zeros(len(cycle.space.lower))
    return ObjectiveBounds(
        np.inf, np.inf, Ball(nothing, nothing), nothing, may_jump=True, evidence=cycle.evidence
    )


@dataclass(frozen=True)
class ProvedQuantity:
    """A result by name, or its size; times the length of a cycle, whose mean is a work, if it
    `is_work`.
    """

    name: str
    size: bool = False
    is_work: bool = False

    @classmethod
    def from_measure(cls, measure: Measure) -> ProvedQuantity:
        """Return the quantity that a measure is of."""
        return cls(measure.name, measure.size, measure.kind == "work")

    @classmethod
    def from_document(cls, entry: Mapping[str, Any]) -> ProvedQuantity:
        """Return the quantity of a JSON object."""
        return cls(entry["name"], entry["size"], entry["is_work"])

    def describe(self, machine: Machine) -> str:
        """Return its name and unit, for people."""
        quantity = machine.find_quantity(self.name)
        name = f"|{self.name}|" if self.size else self.name
        return f"work of {name}" if self.is_work else f"{name} [{quantity.unit}]"

    def convert(self, machine: Machine, xp: Any, value: Any, x: Sequence[Any]) -> Any:
        """Return the quantity in display units from the value of the result, in code of designs x
        (p,).
        """
        quantity = machine.find_quantity(self.name)
        value = xp.absolute(value) if self.size else xp.lift(value)
        value = value if quantity.factor == 1 else value / quantity.factor
        if not self.is_work:
            return value
        turn = 2 * xp.pi
        if quantity.unit == "N m":
            return value * turn
        if machine.speed in machine.moved:
            return value * turn / xp.absolute(x[machine.moved.index(machine.speed)])
        return value * turn / abs(float(machine.data[machine.speed]))


class EnclosedMachine(Protocol):
    """Results of a machine as programs, the assembly that is meant, and where kinks are."""

    def record(self, quantities: Sequence[ProvedQuantity]) -> ResponseProgram:
        """Return the code of some quantities over designs."""

    def find_assembly(self, x: Array) -> AssemblyStart:
        """Return the assembly that is meant, by a design (p,)."""

    def find_kinks(self, x: Array) -> Kinks:
        """Return the kinks within the period at a design (p,)."""


def build_provable_objective(
    machine: Machine,
    terms: Sequence[Measure],
    count: int | None,
    enclosed: EnclosedMachine,
    limits: Sequence[Limit] = (),
    origin: Array | None = None,
) -> ProvableObjective:
    """Return a sum of measures over `count` samples, or the true one, as a proof bounds it.

    The assembly is that of the design `origin` (p,), else of the machine's own. Of the limits,
    those at angles that the design moves are left out.
    """
    fixed = [limit for limit in limits if is_fixed(machine, limit.measure)]
    measures = [*terms, *(limit.measure for limit in fixed)]
    quantities = list(dict.fromkeys(map(ProvedQuantity.from_measure, measures)))

    def bound(measure: Measure, sign: int = 0, limit: float = 0.0) -> BoundedMeasure:
        kinds = {"work": "mean", "all": "min" if sign < 0 else "max"}
        kind = cast(MeasureKind, kinds.get(measure.kind, measure.kind))
        index = quantities.index(ProvedQuantity.from_measure(measure))
        size, weight, angle = measure.size, measure.weight, measure.angle
        return BoundedMeasure(kind, index, size, weight, angle, sign, limit)

    return ProvableObjective(
        enclosed.record(quantities),
        [bound(term) for term in terms],
        [bound(limit.measure, limit.sign, limit.number) for limit in fixed],
        count,
        enclosed.find_assembly(machine.design if origin is None else origin),
        enclosed.find_kinks,
        heeds_all=len(fixed) == len(limits),
        labels=[quantity.describe(machine) for quantity in quantities],
        quantities=quantities,
        factors=[machine.find_quantity(quantity.name).factor for quantity in quantities],
    )


def build_bare_objective(
    machine: Machine,
    enclosed: EnclosedMachine,
    quantities: Sequence[ProvedQuantity],
    document: Mapping[str, Any],
) -> ProvableObjective:
    """Return the objective of the quantities of a proof, without terms, with the assembly of the
    design that its document names.
    """
    assembly = document["assembly"]
    design = [] if assembly is None else [float.fromhex(x) for x in assembly["design"]]
    return ProvableObjective(
        enclosed.record(quantities),
        (),
        start=enclosed.find_assembly(np.array(design)) if design else None,
        labels=[quantity.describe(machine) for quantity in quantities],
        quantities=quantities,
        factors=[machine.find_quantity(quantity.name).factor for quantity in quantities],
    )


def is_fixed(machine: Machine, measure: Measure) -> bool:
    """Return whether a measure is of a result at angles that do not move with the design."""
    return not measure.is_moving and machine.find_quantity(measure.name).role == "result"


def check_provable(machine: Machine, terms: Sequence[Measure], label: str) -> None:
    """Raise InputError, which begins with `label`, for a sum of which no proof is known."""
    for measure in terms:
        if measure.is_moving:
            word = "jump" if measure.kind == "jump" else "while" if measure.during else "where"
            raise InputError(
                f"{label}: {measure}: a proof takes angles that are fixed, so leave out `{word}`"
            )
        quantity = machine.find_quantity(measure.name)
        if quantity.role != "result":
            raise InputError(
                f"{label}: {measure}: a proof bounds results, and {quantity.name} is a "
                f"{quantity.role}"
            )
    if not machine.moved:
        raise InputError(
            f"{label}: {machine.source}: it has no [bounds], so there is no box to prove anything "
            f"of"
        )
