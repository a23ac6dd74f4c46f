"""From a system's steps to the texts of its functions: common subexpressions, hoisting, order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import sympy as sp

from ..model import Let, Step, System
from ..quantity import Quantity, Vector
from .expression import operations

COMMON = "common subexpression"


@dataclass(frozen=True)
class Schedule:
    """The steps of the emitted functions of a system."""

    system: System
    prologue: tuple[Step, ...]
    hoisted: Vector
    lane: tuple[Step, ...]
    events: tuple[Let, ...]
    frame: tuple[Step, ...]


def schedule(system: System) -> Schedule:
    """Share common subexpressions, then move to the prologue what the angle does not change."""
    event_lets = tuple(
        Let(Quantity(f"g{i}", "1", f"{e.name}: {e.argument} less {e.target}", "derived: joint"), e.argument - e.target,
            f"joint: {e.name}")
        for i, e in enumerate(system.events))  # fmt: skip
    steps = share((*system.lane, *event_lets), prefix="c")
    still, moving = split(steps, frozenset({system.angle}))
    events = tuple(s for s in moving if isinstance(s, Let) and s.source.startswith("joint: "))
    lane = tuple(step for step in moving if step not in events)
    needed_later = frozenset().union(
        *(s.needs for s in moving), *(s.needs for s in system.frame), system.side.quantities
    )
    hoisted = tuple(s for step in still for s in step.defines if s in needed_later)
    return Schedule(system, still, Vector("hoisted", hoisted), lane, events, share(system.frame, prefix="d"))


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
    names = (sp.Symbol(f"{prefix}{i}", real=True) for i in range(1, 10_000))
    common, reduced = sp.cse([expression(step) for step in steps], symbols=names, order="canonical")
    pending = dict(common)
    ordered: list[Step] = []

    def define(expr: sp.Expr) -> None:
        for symbol in sorted(expr.free_symbols & pending.keys(), key=lambda s: (len(s.name), s.name)):
            if symbol in pending:
                inner = pending.pop(symbol)
                define(inner)
                ordered.append(Let(symbol, inner, COMMON))

    for step, expr in zip(steps, reduced, strict=True):
        define(expr)
        ordered.append(with_expression(step, expr))
    return tuple(ordered)


def expression(step: Step) -> sp.Expr:
    """What a step evaluates itself."""
    return step.expr if isinstance(step, Let) else step.argument


def with_expression(step: Step, expr: sp.Expr) -> Step:
    return replace(step, expr=expr) if isinstance(step, Let) else replace(step, argument=expr)


def operations_of(steps: Sequence[Step]) -> int:
    """Operations in the steps themselves; what a called function does is not counted."""
    return sum(operations(expression(step)) for step in steps)
