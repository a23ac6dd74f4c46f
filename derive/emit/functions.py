"""The functions that are emitted of a system: of its lane (prologue, lane, events, frame), and its closed forms."""

from __future__ import annotations

from collections.abc import Iterator

from ..model import Call, ClosedForm, Input, Lane, Shared, Step, System, entries, needed
from ..quantity import OpenVector, Vector
from .schedule import Schedule, schedule, share
from .text import Emitted


def of_system(system: System) -> tuple[Emitted, ...]:
    """Every function, each with the steps that its outputs need."""
    lane = of_lane(schedule(system.lane)) if system.lane else ()
    return (*lane, *map(of_closed_form, system.closed_forms))


def of_lane(plan: Schedule) -> Iterator[Emitted]:
    """Prologue (what the angle does not change), lane, events and frame (what equal sides share), those there are."""
    lane = plan.lane
    hoisted = (plan.hoisted,) if len(plan.hoisted) else ()
    inputs = (lane.angle, *lane.inputs, *lane.along, *hoisted)
    if hoisted:
        yield _composed(lane, Emitted("prologue", lane.inputs, plan.prologue, plan.hoisted))
    yield _composed(lane, Emitted("lane", inputs, needed(plan.moving, frozenset(lane.outputs)), lane.outputs))
    if plan.events:
        events = Vector("events", tuple(step.symbol for step in plan.events))
        steps = needed((*plan.moving, *plan.events), frozenset(events))
        yield _composed(lane, Emitted("events", inputs, steps, events))
    if lane.shared:
        yield _frame(lane, lane.shared, plan.frame)


def of_closed_form(form: ClosedForm) -> Emitted:
    steps = share(needed(form.steps, frozenset(form.outputs)), prefix="c")
    return Emitted(form.name, form.inputs, steps, form.outputs)


def _frame(lane: Lane, shared: Shared, steps: tuple[Step, ...]) -> Emitted:
    """What equal sides share, from the outputs of both and those inputs that its steps need."""
    side = lane.outputs
    twins = tuple(map(shared.twin, side))
    needs = frozenset().union(*(step.needs for step in steps)) - frozenset((*side, *twins))
    given: tuple[Input, ...] = (lane.angle, *lane.inputs)
    sides = (Vector(f"{side.name}1", side.quantities), Vector(f"{side.name}2", twins))
    return Emitted("frame", (*sides, *(v for v in given if needs & set(entries(v)))), steps, shared.totals)


def _composed(lane: Lane, function: Emitted) -> Emitted:
    """The same, taking the functions that it calls and those that say how long its inputs are."""
    called = {step.function.name for step in function.steps if isinstance(step, Call)}
    sizing = {v.sized_by[0] for v in function.inputs if isinstance(v, OpenVector) and v.sized_by}
    return function.taking(tuple(f for f in lane.functions if f.name in called | sizing))
