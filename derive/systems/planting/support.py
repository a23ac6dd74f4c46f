"""The support force alone: what one side adds to it, without all that cancels, and which inputs it does not feel.

Weight and momentum of a machine's parts make its support force; in a model where action equals reaction the contact
forces inside it cancel, and so do the accelerations that the two sides, half a turn apart, have with opposite signs.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from sympy import S, Symbol

from ...branches import clip
from ...influence import Influence, flattened, share
from ...model import Effects, Lane, Let, System, entries
from ...polynomial import Polynomial
from ...quantity import Quantity, Vector
from . import derivation, flanks
from . import quantities as q

F_share = Quantity("F_share", "N", "what one side adds to the vertical support force", "derived: support force")
COORDINATES = frozenset({
    q.phi52, q.phi52_dot, q.phi52_ddot, q.alpha, q.Omega, q.Omega_dot, q.theta1, q.theta1_dot, q.theta1_ddot,
})  # fmt: skip
"""Motion of a side: what its momentum is written in."""


RISEN, FALLEN = (
    Quantity(name, "1", f"share of the {what} that is passed", "derived: support force")
    for name, what in (("x_r", "rise"), ("x_f", "fall"))
)


def cam_steps() -> tuple[Let, ...]:
    """Swing and its rates by polynomials in the shares of the flanks, which follow the default law.

    A flank begins and ends at rest: so the derivatives of the clipped law are those of the law at the clipped share.
    """
    x, laws = flanks.x, flanks.law(flanks.DEFAULT)
    if any(law.subs(x, end) != 0 for law in laws[1:] for end in (0, 1)):
        raise ValueError("a flank does not begin and end at rest")
    ends = ((RISEN, *q.delta_r, 1), (FALLEN, *q.delta_f, -1))
    swing, slope, bend = (
        q.H * sum(sign * Polynomial.of(law, x, at) / (end - start) ** n for at, start, end, sign in ends)
        for n, law in enumerate(laws)
    )
    source = "derived: cam law"
    shares = (Let(at, clip((q.delta - start) / (end - start), S.Zero, S.One), source) for at, start, end, _ in ends)
    return (
        *shares, Let(q.theta1, swing, source), Let(q.dpsi_ddelta, slope, source),
        Let(q.theta1_dot, -q.phi72_dot * q.dpsi_ddelta, source),
        Let(q.theta1_ddot, q.phi72_dot**2 * bend - q.phi72_ddot * q.dpsi_ddelta, source),
    )  # fmt: skip


def with_polynomials(lane: Lane) -> Lane:
    """A lane with the cam's steps as polynomials."""
    steps = cam_steps()
    written = {symbol for step in steps for symbol in step.defines}
    first = next(i for i, step in enumerate(lane.steps) if written & set(step.defines))
    before, after = (
        tuple(step for step in part if not written & set(step.defines))
        for part in (lane.steps[:first], lane.steps[first:])
    )
    return replace(lane, steps=(*before, *steps, *after))


def of_model(model: System, flat: bool) -> System:
    """A side's share of a model's support force; ``flat``: as a sum of products of the coordinates' functions."""
    if model.lane is None:
        raise ValueError(f"{model.name} has no lane")
    whole = with_polynomials(model.lane)
    influence = Influence(whole, share(whole, q.F_support, F_share))
    steps = influence.reduced()
    if flat:
        steps = flattened(steps, F_share, COORDINATES)
    name = model.name.replace("planting_", "planting_support_")
    lane = Lane(q.phi, q.INPUTS, steps, Vector("share", (F_share,)))
    effects = Effects(_names(model.lane, influence.without), influence.felt)
    return System(name, f"{model.title}: support force", model.source, model.assumptions, lane, effects=effects)


def _names(lane: Lane, symbols: Iterable[Symbol]) -> tuple[str, ...]:
    inputs = [quantity.name for vector in lane.inputs for quantity in entries(vector)]
    gone = {symbol.name for symbol in symbols}
    return tuple(name for name in inputs if name in gone)


def exact() -> System:
    """That of the device from first principles."""
    return of_model(derivation.exact(), flat=True)


SYSTEMS = (exact,)
