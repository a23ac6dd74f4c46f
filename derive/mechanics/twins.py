"""Two equal sides of a machine, half a turn apart: one is derived, the other is the same behind it.

Both act on the bodies that they share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp
from sympy import Expr

from ..equations import Equation, derived
from ..model import Input, Lane, Let, Shared, Step, Twin, needed
from ..quantity import Quantity, Vector
from . import turning
from .statement import MechanismError, Statement


@dataclass(frozen=True)
class Sides:
    """The results, in SI, of one of two equal sides and of both; ``twin`` names a quantity of the other side."""

    twin: Twin
    reported: tuple[Quantity, ...]
    totals: tuple[Quantity, ...]


@dataclass(frozen=True)
class Other:
    """Turns an expression in quantities of one side into the same in those of the other, half a turn behind."""

    angle: Quantity
    twin: Twin
    symbols: frozenset[Quantity]

    def __call__(self, expr: Expr) -> Expr:
        ours = sorted(expr.free_symbols & self.symbols, key=str)
        return expr.xreplace({s: self.twin(s) for s in ours} | {self.angle: self.angle - sp.pi})


def own(stated: Statement) -> frozenset[Quantity]:
    """Quantities that each side has of its own: its motion, and what acts in it."""
    return frozenset(s for step in stated.steps for s in step.defines) | set(stated.unknowns)


def shared(stated: Statement, other: Other) -> list[Equation]:
    """Balances of the bodies that both sides share, with the actions of one side and the same of the other."""
    of_side = [action for action in stated.assembly.actions if action not in stated.common]
    found = []
    for body in stated.shared:
        pin = stated.pin_of(body)
        loads = stated.assembly.loads(body, pin, of_side)
        balances = stated.assembly.balances(body, pin)
        found += [derived(e.claims, e.residual + other(load)) for e, load in zip(balances, loads, strict=True)]
    return found


def along(
    stated: Statement, sides: Sides, inputs: Sequence[Input], forces: Sequence[Step] | None,
    frame: Sequence[Let] | None,
) -> Lane:  # fmt: skip
    """The lane of one side, and what both add up to; see `Mechanism.twin_lane`."""
    if stated.angle is None:
        raise MechanismError(f"{stated.name}: equal sides follow each other along an angle, and none is given")
    side = (*turning.motion(stated), *(turning.forces(stated) if forces is None else forces))
    if frame is None:
        other = Other(stated.angle, sides.twin, own(stated))
        both = [unknown for unknown in stated.assembly.unknowns if unknown not in stated.unknowns]
        frame = turning.solved(stated, shared(stated, other), both).lets()
    sums = needed((*frame, *stated.reports), frozenset(sides.totals))
    summed = frozenset().union(*(step.needs for step in sums))
    passed = [s for step in side for s in step.defines if s in summed or sides.twin(s) in summed]
    told = Vector("side", tuple(dict.fromkeys((*sides.reported, *passed))))
    wanted = frozenset(told).union(*(event.argument.free_symbols for event in stated.events))
    totals = Shared(sides.twin, sums, Vector("totals", sides.totals))
    return Lane(stated.angle, tuple(inputs), needed(side, wanted), told, tuple(stated.events), totals)
