"""The functions that are emitted: of a system (prologue, lane, events, frame) and of formulas (a function a stage)."""

from __future__ import annotations

from ..model import Formulas, needed
from ..quantity import Vector
from .schedule import Schedule, share
from .text import Emitted


def of_system(plan: Schedule) -> tuple[Emitted, ...]:
    """Prologue, lane (one side), events and frame (what both sides share)."""
    system = plan.system
    lane_inputs = (system.angle, *system.inputs, plan.hoisted)
    events = Vector("events", tuple(step.symbol for step in plan.events))
    event_steps = needed((*plan.lane, *plan.events), frozenset(events))
    lane_steps = needed(plan.lane, frozenset(system.side))
    sides = (Vector("side1", system.side.quantities), Vector("side2", tuple(map(system.twin, system.side))))
    machine = next(v for v in system.inputs if v.name == "machine")
    return (
        Emitted("prologue", system.inputs, plan.prologue, plan.hoisted),
        Emitted("lane", lane_inputs, lane_steps, system.side),
        Emitted("events", lane_inputs, event_steps, events),
        Emitted("frame", (*sides, machine), plan.frame, system.totals),
    )


def of_formulas(formulas: Formulas) -> tuple[Emitted, ...]:
    """A function for each stage, with the steps that its outputs need."""
    return tuple(
        Emitted(
            stage.name,
            stage.inputs,
            share(needed(stage.steps, frozenset(stage.outputs)), prefix="c"),
            stage.outputs,
        )
        for stage in formulas.stages
    )
