"""Sums of measures of a machine, and limits on them, as functions of its design: what a search
minimises and satisfies.

Every measure has one definition, of `planter.engine.solvers.continuous_cycle`: extremes of the curve
wherever they are, and integrals between all angles at which it is not smooth. Samples are taken
where they are asked for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from planter.engine.curves import QuantityCurves
from planter.engine.machine import Machine
from planter.engine.measures import (
    TIME,
    WITHOUT_SIZE,
    Crossing,
    EventTime,
    Extremum,
    Kind,
    Limit,
    Measure,
    MeasureCondition,
    SettlingBand,
)
from planter.engine.nodes import NodeMeasure
from planter.engine.solvers.continuous_cycle import ContinuousCycle
from planter.engine.solvers.curve_sum import (
    CurveJump,
    CurveSide,
    CurveStatistic,
    CurveSum,
    Sampling,
    find_spreads,
)
from planter.engine.solvers.cycle_panels import PanelCache
from planter.engine.solvers.joined import CurvedPart, JoinedObjective
from planter.engine.solvers.objective import evaluate_summary, find_gradient
from planter.engine.solvers.sampled_cycle import SampledCycle
from planter.errors import InputError
from planter.files import units
from planter.files.units import Unit, parse_unit
from planter.kernels import Array
from planter.numerics.statistics import SMOOTH

EXTREMES: Mapping[Kind, tuple[int, ...]] = {"max": (1,), "min": (-1,), "range": (1, -1)}
"""Sides of a curve whose extremes a measure is of: +1 for the greatest value, -1 for the least."""


def resolve_measure(machine: Machine, measure: Measure) -> Measure:
    """Return a measure with names of the machine's quantities, conditions in their display units.

    A measure of a place that the motion decides on has the span of the motion unless it has one of
    its own. Raises InputError for a name that the machine does not have, a unit of another kind, or
    a size without a measure.
    """
    _check_place(machine, measure)
    quantities = [machine.find_quantity(name) for name in measure.names]
    measure = measure.with_names([quantity.name for quantity in quantities])
    displays = [find_display_unit(machine, Measure("all", q.name)) for q in quantities[1:]]
    where, span = measure.where, measure.span
    if isinstance(where, Crossing | SettlingBand):
        where = _convert(machine, where, displays[0])
    elif isinstance(where, EventTime):
        where = EventTime(_find_event(machine, where.event))
    if where is not None and machine.motion is not None:
        span = span or (0.0, machine.motion.span)
    conditions = displays[len(displays) - len(measure.during) :]
    during = tuple(
        _convert(machine, condition, display)
        for condition, display in zip(measure.during, conditions, strict=True)
    )
    if measure.size and measure.kind in WITHOUT_SIZE:
        raise InputError(
            f"{machine.source}: {measure}: over a cycle {measure.kind} takes no abs, which has "
            f"corners"
        )
    if measure.kind == "work" and quantities[0].unit not in ("W", "N m"):
        raise InputError(
            f"{machine.source}: {measure}: only a power [W] or a torque [N m] does work"
        )
    return replace(measure, during=during, where=where, span=span)


def _find_event(machine: Machine, text: str) -> str:
    """Return the name of the only event that has a name, or else that has it in its own."""
    names = [str(kind["name"]) for kind in machine.event_kinds]
    close = [name for name in names if name == text] or [name for name in names if text in name]
    if len(close) == 1:
        return close[0]
    events = "; ".join(close or names)
    reason = f"its events are {events}" if names else "it has no events"
    raise InputError(f"{machine.source}: time of {text}: no single event has this name; {reason}")


def _check_place(machine: Machine, measure: Measure) -> None:
    """Raise InputError for a measure of times of a machine that an angle drives, or of angles of a
    motion.
    """
    where = measure.where
    is_time = isinstance(where, EventTime | SettlingBand)
    is_timed = measure.in_time or measure.span is not None or is_time
    is_free = is_timed or isinstance(where, Crossing)
    is_cyclic = measure.kind in ("work", "jump") or isinstance(where, Extremum)
    if machine.motion is None and is_timed:
        reason = "an angle drives it, so give an angle, or leave out the time"
    elif machine.motion is not None and is_cyclic:
        word = "where" if isinstance(where, Extremum) else measure.kind
        reason = f"it moves freely, and {word} is that of a cycle, not of a time"
    elif machine.motion is not None and not is_free:
        reason = (
            "it moves freely, so give a time (at 1 s), a span of times (max NAME over 0..2 s) or "
            "what decides on the time (NAME where OTHER is 0 first)"
        )
    else:
        return
    raise InputError(f"{machine.source}: {measure}: {reason}")


def extend_span(machine: Machine, measures: Sequence[Measure]) -> Machine:
    """Return a machine that moves freely over the times of measures; another one as it is."""
    if machine.motion is None:
        return machine
    ends = [measure.angle or 0.0 for measure in measures if measure.in_time]
    ends += [measure.span[1] for measure in measures if measure.span is not None]
    if not ends:
        return machine
    return machine.with_span(max(ends))


def list_conditions(machine: Machine, measure: Measure) -> tuple[MeasureCondition, ...]:
    """Return the conditions of a measure, those of its span of times included."""
    if measure.span is None or measure.where is not None or machine.motion is None:
        return measure.during
    first, last = measure.span
    ends = [MeasureCondition(TIME, -1, first)] if first > 0 else []
    ends += [MeasureCondition(TIME, 1, last)] if last < machine.motion.span else []
    return (*ends, *measure.during)


def resolve_limit(machine: Machine, limit: Limit) -> Limit:
    """Return a limit with names of the machine's quantities, in their display units.

    Raises InputError as above.
    """
    measure = resolve_measure(machine, limit.measure)
    display = find_display_unit(machine, measure)
    return _convert(machine, replace(limit, measure=measure), display)


Bound = TypeVar("Bound", bound=Limit | MeasureCondition | Crossing | SettlingBand)


def find_display_unit(machine: Machine, measure: Measure) -> Unit:
    """Return the unit in which a measure of a machine's quantity is given."""
    if measure.kind == "work":
        return parse_unit("J")
    quantity = machine.find_quantity(measure.name)
    unit = Unit(
        units.display_unit(quantity.key), quantity.factor, parse_unit(quantity.unit).dimension
    )
    return unit.squared() if measure.kind == "variance" else unit


def _convert(machine: Machine, bound: Bound, display: Unit) -> Bound:
    """Return a limit or a condition in a display unit."""
    if not bound.unit:
        return bound
    unit = parse_unit(bound.unit)
    if not unit.same_kind(display):
        allowed = (
            f"it must be a unit such as {display.text}"
            if display.text
            else "it is a number without a unit"
        )
        raise InputError(
            f"{machine.source}: {bound}: {bound.unit} is not a unit of {bound.names[0]}; {allowed}"
        )
    return replace(bound, number=bound.number * (unit.factor / display.factor), unit=display.text)


class MeasureCurves:
    """The curves that measures over a cycle, or parts of it, are of, by which sums of these are
    objectives.
    """

    def __init__(self, machine: Machine, measures: Sequence[Measure]) -> None:
        self.machine = machine
        spans = [measure for measure in measures if _is_span(measure)]
        worked = [m.name for m in spans if self._is_power(m)]
        names = [m.name for m in spans if m.name not in worked or not self._is_power(m)]
        self.worked, self.names = list(dict.fromkeys(worked)), list(dict.fromkeys(names))
        conditions = [each for m in spans for each in list_conditions(machine, m)]
        self.conditions = list(dict.fromkeys(conditions))

    def _is_power(self, measure: Measure) -> bool:
        return measure.kind == "work" and self.machine.find_quantity(measure.name).unit != "N m"

    @cached_property
    def curves(self) -> QuantityCurves:
        """The curves: quantities, then powers."""
        return QuantityCurves(self.machine, self.names, self.conditions, self.worked)

    @cached_property
    def panels(self) -> PanelCache:
        """The panels of the curves, which all sums share."""
        return PanelCache(self.curves)

    def build(self, terms: Sequence[Measure], sampling: Sampling = "refined") -> JoinedObjective:
        """Return a sum of measures; of `sampling` samples, those that are of the whole cycle are of
        these alone.
        """
        machine, widths = self.machine, self.machine.upper - self.machine.lower
        cyclic = [m for m in terms if _is_span(m) and not self._find_conditions(m)]
        cyclic = [m for m in cyclic if m.kind != "jump"]
        partial = [m for m in terms if self._find_conditions(m)]
        jumps = [m for m in terms if m.kind == "jump"]
        parts: list[CurvedPart] = []
        if sampling == "refined":
            cyclic, partial = [], cyclic + partial
        elif cyclic:
            parts.append(SampledCycle(self.curves, self._build_sum(cyclic), sampling))
        sums = [self._build_sum(true) for true in (partial, jumps) if true]
        parts += [ContinuousCycle(self.panels, total) for total in sums]
        parts += [NodeMeasure(machine, m) for m in terms if not _is_span(m)]
        return JoinedObjective(parts, machine.design_names, widths, machine.design)

    def _build_sum(self, terms: Sequence[Measure]) -> CurveSum:
        statistics: list[CurveStatistic] = []
        sides: list[CurveSide] = []
        jumps: list[CurveJump] = []
        weights: list[float] = []
        for measure in terms:
            row = self._find_row(measure)
            factor = self.machine.find_quantity(measure.name).factor
            conditions = self._find_conditions(measure)
            if measure.kind in EXTREMES:
                for side in EXTREMES[measure.kind]:
                    signs = (1, -1) if measure.size else (side,)
                    sides += [CurveSide(len(weights), row, sign, conditions) for sign in signs]
                    weights.append(measure.weight * (side if measure.kind == "min" else 1) / factor)
            elif measure.kind == "jump":
                jumps.append(CurveJump(len(weights), row))
                weights.append(measure.weight / factor)
            elif measure.kind == "work":
                statistics.append(
                    CurveStatistic("integral", row, measure.weight * self.machine.turn, conditions)
                )
            else:
                kind = next(kind for kind in SMOOTH if kind == measure.kind)
                power = 2 if kind == "variance" else 1
                statistics.append(
                    CurveStatistic(kind, row, measure.weight / factor**power, conditions)
                )
        return CurveSum(tuple(statistics), tuple(sides), np.array(weights), tuple(jumps))

    def is_empty(self, measure: Measure, x: Array) -> bool:
        """Return whether the conditions of a measure never hold at a design."""
        conditions = self._find_conditions(measure)
        return bool(conditions) and self.panels(x).is_empty(conditions)

    def find_spread(self, measure: Measure) -> float:
        """Return by how much the quantity of a measure varies at the machine's own design, else its
        size.
        """
        if not _is_span(measure):
            return abs(NodeMeasure(self.machine, measure).value(self.machine.design)) or 1.0
        factor = self.machine.find_quantity(measure.name).factor
        return float(find_spreads(self.curves)[self._find_row(measure)]) / factor

    def _find_conditions(self, measure: Measure) -> tuple[int, ...]:
        conditions = list_conditions(self.machine, measure)
        return tuple(map(self.conditions.index, conditions))

    def _find_row(self, measure: Measure) -> int:
        if self._is_power(measure):
            return len(self.names) + self.worked.index(measure.name)
        return self.names.index(measure.name)


def _is_span(measure: Measure) -> bool:
    """Return whether a measure is of the cycle or parts of it, not of single angles."""
    return measure.kind != "at"


class Goal:
    """A sum of measures and limits over designs x (p,), by true extremes and integrals.

    With `samples` the sum is that over so many samples of the cycle. Measures and limits are as
    `resolve_measure` gives them; values are in display units.
    """

    def __init__(
        self,
        machine: Machine,
        terms: Sequence[Measure],
        limits: Sequence[Limit] = (),
        samples: int | None = None,
    ) -> None:
        self.machine, self.terms, self.limits, self.samples = (
            machine,
            tuple(terms),
            tuple(limits),
            samples,
        )
        self.size = len(machine.design)

    @cached_property
    def objective(self) -> JoinedObjective:
        """The sum."""
        return MeasureCurves(self.machine, self.terms).build(self.terms, self.samples or "refined")

    @cached_property
    def limited(self) -> tuple[JoinedObjective, ...]:
        """Return the objectives whose values are those that the limits are on."""
        return tuple(self._of_limits.build([bound_measure(limit)]) for limit in self.limits)

    @cached_property
    def _of_limits(self) -> MeasureCurves:
        return MeasureCurves(self.machine, [bound_measure(limit) for limit in self.limits])

    def restart(self) -> None:
        """Forget all designs so far: what is evaluated next does not depend on them, to the last
        digit.
        """
        for objective in (*([self.objective] if self.terms else []), *self.limited):
            objective.restart()

    def evaluate(self, x: Array) -> float:
        """Return the sum of the measures at a design x (p,).

        Raises ComputationError where loops do not close.
        """
        return _evaluate(self.objective, x)

    def slope(self, x: Array) -> Array:
        """Return the gradient (p,) of the sum at a design; an extreme that angles share has that of
        one.
        """
        return find_gradient(self.objective, x)

    def evaluate_limit(self, x: Array, limit: Limit) -> float | None:
        """Return what a limit is on at a design; None if its condition never holds, or nothing
        jumps.
        """
        limited = self.limited[self.limits.index(limit)]
        return None if self._of_limits.is_empty(bound_measure(limit), x) else _evaluate(limited, x)

    def step(self, limit: Limit) -> float:
        """Return what counts as one in the violation of a limit: the limit, or the spread of what
        it is on.
        """
        return abs(limit.number) or self._of_limits.find_spread(bound_measure(limit))


def bound_measure(limit: Limit) -> Measure:
    """Return the measure that a limit is on: one that holds everywhere is on an extreme."""
    measure = replace(limit.measure, weight=1.0)
    return (
        replace(measure, kind="max" if limit.sign > 0 else "min")
        if measure.kind == "all"
        else measure
    )


def evaluate_measure(machine: Machine, measure: Measure, samples: int | None = None) -> float:
    """Return a measure at a machine's own design in its display unit, true or over samples of the
    cycle.
    """
    return Goal(machine, (replace(measure, weight=1.0),), (), samples).evaluate(machine.design)


def evaluate_measures(machine: Machine, measures: Sequence[Measure]) -> list[float]:
    """Return true measures at a machine's own design in their display units, by panels that they
    share.
    """
    curves, x = MeasureCurves(machine, measures), machine.design
    return [_evaluate(curves.build([replace(m, weight=1.0)]), x) for m in measures]


def _evaluate(objective: JoinedObjective, x: Array) -> float:
    return evaluate_summary(objective, objective.summarise(x)).objective
