"""Laws that any mechanism's printed equations must keep as a whole, and its motions to try them in.

Power, momentum, angular momentum, virtual work on each coordinate, action and reaction on each body; of a mechanism
that an angle drives also rest, and forces that go with the square of the speed. What the print does not give is as
derived.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np
import sympy as sp

from ...audit.formula import Formula
from ...audit.laws import Cycle, Dynamics, Law
from ...audit.laws import Values as Arrays
from ...chain import Chain
from ...equations import Balance, Equation
from ...evaluate import Point
from ...mechanics.lawful import LAW, VANISHES
from ...mechanics.mechanism import Mechanism
from ...model import Let, Twin
from ...quantity import Quantity
from .given import Values

REFERENCE, SPEEDS = "reference", "speeds"
SLOW, FASTER = 1e-9, 2
"""Speeds beside the mechanism's own: one at which inertia is next to nothing, and one at which it is FASTER^2 times."""
ACTIONS = ("N", "N m")


def dynamics(
    mechanism: Mechanism, general: Sequence[Let], printed: Chain, motions: Mapping[str, Sequence[Sequence[Values]]]
) -> Dynamics:
    """The laws that a print's equations can break, with motions and what each equation leaves over in them.

    Repaired, an equation holds of the motion: what it leaves over is taken from it.
    """
    solved = [unknown for step in printed.order for unknown in step.unknowns]
    cycles = {name: _cycle(sides, printed) for name, sides in motions.items()}
    laws = [*_general(general), *_reactions(mechanism)]
    if SPEEDS in motions:
        laws += [_rest(general), *_scaling(mechanism, solved)]
    felt = frozenset(solved).union(*(map(twin, solved) for twin in TWINS))
    found = tuple(_scaled(law, cycles[law.cycle]) for law in laws if any(g.free_symbols & felt for g in law.gaps))
    claims = {e.claims: replace(e, residual=e.residual - left_over(e)) for e in printed.equations.values()}
    return Dynamics(found, cycles, claims, (), TWINS)


def left_over(equation: Equation) -> sp.Symbol:
    """What an equation leaves over in the motion: zero if it holds."""
    return sp.Symbol(f"left over of ({equation.number})", real=True)


def _at_speed(k: int) -> Twin:
    return lambda quantity: sp.Symbol(f"{quantity} at speed {k}", real=True)


TWINS = (_at_speed(1), _at_speed(2))
"""What quantities are called at the second and third of several speeds."""


def _cycle(sides: Sequence[Sequence[Values]], printed: Chain) -> Cycle:
    return Cycle(tuple(_arrays(side, printed) for side in sides), np.ones(len(sides[0])))


def _arrays(side: Sequence[Values], printed: Chain) -> Arrays:
    points = [Point(values) for values in side]
    found: Arrays = {symbol: np.array([float(values[symbol]) for values in side]) for symbol in side[0]}
    return found | {left_over(e): np.array([float(p(e.residual)) for p in points]) for e in printed.equations.values()}


def _general(general: Sequence[Let]) -> Iterator[Law]:
    return (Law(let.symbol.meaning.removesuffix(VANISHES), let.symbol.unit, (let.expr,)) for let in general)


def _reactions(mechanism: Mechanism) -> Iterator[Law]:
    """What acts on a body, the reverse of what it does to its neighbours among it, is its rate of momentum."""
    balances = [(e.claims, e.residual) for e in mechanism.equations() if isinstance(e.claims, Balance)]
    for (body, kind), found in groupby(balances, key=lambda one: (one[0].body, one[0].kind)):
        unit = ACTIONS[kind == "moment"]
        yield Law(f"action and reaction, {kind}s on {body}", unit, tuple(residual for _, residual in found))


def _rest(general: Sequence[Let]) -> Law:
    gaps = tuple(let.expr for let in general if let.symbol.name.startswith(f"{LAW}force"))
    return Law("next to no speed: outer forces balance the weight", "N", gaps, cycle=SPEEDS)


def _scaling(mechanism: Mechanism, solved: Sequence[Quantity]) -> Iterator[Law]:
    """Inertia's part of an action grows with the square of the speed, where nothing else goes with the speed."""
    if _goes_with_speed(mechanism):
        return
    once, twice = TWINS
    for unit in ACTIONS:
        actions = [q for q in solved if q.unit == unit and q in mechanism.assembly.unknowns]
        gaps = tuple((twice(q) - q) - FASTER**2 * (once(q) - q) for q in actions)
        if gaps:
            yield Law("inertia's part goes with the square of the speed", unit, gaps, cycle=SPEEDS)


def _goes_with_speed(mechanism: Mechanism) -> bool:
    """Whether a given action feels rates, or one that turns with another's sign, as friction does."""
    own = [] if mechanism.speed is None else [mechanism.speed]
    speeds = {*own, *(q for c in mechanism.loops.coordinates for q in (c.rate, c.acceleration))}
    told = mechanism.told_in(speeds)
    for action in mechanism.assembly.actions:
        for component in (*action.force.components, *action.moment.components):
            plain = component.xreplace(told)
            if plain.atoms(sp.Abs, sp.Piecewise) or plain.free_symbols & speeds:
                return True
    return False


def _scaled(law: Law, cycle: Cycle) -> Law:
    """A law with the size of its largest term in the motion."""
    values = dict(cycle.sides[0])
    for twin, side in zip(TWINS, cycle.sides[1:], strict=False):
        values |= {twin(symbol): found for symbol, found in side.items()}
    terms = [term for gap in law.gaps for term in sp.Add.make_args(gap)]
    size = max((float(np.max(np.abs(Formula(term)(values)))) for term in terms), default=0.0)
    return replace(law, scale=size or 1.0)
