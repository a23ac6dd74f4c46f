"""From a lane's steps to the texts of its functions: common subexpressions, hoisting, order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count, islice

import sympy as sp

from ..model import Event, Lane, Let, LinearSolve, Step
from ..quantity import Quantity, Vector
from .expression import operations

COMMON = "common subexpression"


@dataclass(frozen=True)
class Schedule:
    """The steps of the emitted functions of a lane."""

    lane: Lane
    prologue: tuple[Step, ...]
    hoisted: Vector
    moving: tuple[Step, ...]
    events: tuple[Let, ...]
    frame: tuple[Step, ...]


def schedule(lane: Lane) -> Schedule:
    """Share common subexpressions, then move to the prologue what the angle does not change."""
    joints = tuple(_joint(i, event) for i, event in enumerate(lane.events))
    steps = share((*lane.steps, *joints), prefix="c")
    still, moving = split(steps, frozenset({lane.angle}.union(*lane.along)))
    at_joints = frozenset(joint.symbol for joint in joints)
    events = tuple(s for s in moving if isinstance(s, Let) and s.symbol in at_joints)
    if len(events) < len(joints):
        raise ValueError(f"lane: an event does not depend on {lane.angle}, so it never happens")
    needed_later = frozenset(lane.outputs).union(*(step.needs for step in moving))
    hoisted = tuple(s for step in still for s in step.defines if s in needed_later)
    own = tuple(step for step in moving if step not in events)
    frame = share(lane.shared.steps, prefix="d") if lane.shared else ()
    return Schedule(lane, still, Vector("hoisted", hoisted), own, events, frame)


def _joint(index: int, event: Event) -> Let:
    """What is zero at an event, or a whole number of its periods."""
    meaning = f"{event.name}: {event.argument} less {event.target}"
    symbol = Quantity(f"g{index}", "1", meaning, "derived: joint")
    return Let(symbol, event.argument - event.target, f"joint: {event.name}")


def split(steps: Sequence[Step], moving: frozenset[sp.Symbol]) -> tuple[tuple[Step, ...], tuple[Step, ...]]:
    """Steps that do not depend on ``moving``, and those that do."""
    still: list[Step] = []
    lane: list[Step] = []
    for step in steps:
        if step.needs & moving:
            moving = moving | set(step.defines)
            lane.append(step)
        else:
            still.append(step)
    return tuple(still), tuple(lane)


def share(steps: Sequence[Step], prefix: str) -> tuple[Step, ...]:
    """The same steps with common subexpressions computed once, each in a step of its own before its first use."""
    taken = {symbol.name for step in steps for symbol in (*step.needs, *step.defines)}
    names = (sp.Symbol(name, real=True) for i in count(1) if (name := f"{prefix}{i}") not in taken)
    parts = [expressions(step) for step in steps]
    common, reduced = sp.cse([part for some in parts for part in some], symbols=names, order="canonical")
    pending, left = dict(common), iter(reduced)
    ordered: list[Step] = []

    def define(expr: sp.Expr) -> None:
        for symbol in sorted(expr.free_symbols & pending.keys(), key=lambda s: (len(s.name), s.name)):
            if symbol in pending:
                inner = pending.pop(symbol)
                define(inner)
                ordered.append(Let(symbol, inner, COMMON))

    for step, some in zip(steps, parts, strict=True):
        own = tuple(islice(left, len(some)))
        for expr in own:
            define(expr)
        ordered.append(with_expressions(step, own))
    return tuple(ordered)


def expressions(step: Step) -> tuple[sp.Expr, ...]:
    """What a step evaluates itself."""
    if isinstance(step, LinearSolve):
        return step.entries
    return (step.expr if isinstance(step, Let) else step.argument,)


def with_expressions(step: Step, own: tuple[sp.Expr, ...]) -> Step:
    if isinstance(step, LinearSolve):
        return step.filled(own)
    return replace(step, expr=own[0]) if isinstance(step, Let) else replace(step, argument=own[0])


def operations_of(steps: Sequence[Step]) -> int:
    """Operations in the steps themselves; what a called function or an elimination does is not counted."""
    return sum(operations(expr) for step in steps for expr in expressions(step))
