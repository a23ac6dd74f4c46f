"""Quantities over a box of designs: an enclosure of each of their samples over a turn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Protocol

import numpy as np

from planter.kernels import Array
from planter.numerics.arrays import Integers
from planter.optimise.proof.arithmetic import PI, Enclosing
from planter.optimise.proof.balls import Ball, U, Unbounded, chosen
from planter.optimise.proof.branches import Branches
from planter.optimise.proof.jets import Jet, Space

MOST_LANES = 8
"""Pieces of a lane, on average, above which a box is too wide to follow them."""


class Enclosed(Protocol):
    """Quantities F(phi, x): the sums over `offsets` [turns] of shares at phi + each, `period` [turns] that of all.

    `is_continuous` says that they do not jump over designs, whatever their code asks.
    """

    @property
    def offsets(self) -> tuple[Fraction, ...]: ...
    @property
    def period(self) -> Fraction: ...
    @property
    def is_continuous(self) -> bool: ...

    def follow(self, space: Space, phi: Ball) -> Callable[[Enclosing, Integers], Sequence[Jet]]:
        """Return the shares over a box as a function of lanes, of angles phi (lanes,) [rad].

        They are smooth but where they ask the space of the function's first argument.
        """

    def is_empty(self, lower: Array, upper: Array, phi: Ball) -> bool:
        """Return whether at some of the angles phi (lanes,) [rad] no design of a box [lower, upper] (p,) counts."""


def samples(response: Enclosed, space: Space, count: int) -> list[Jet]:
    """Each quantity at phi = 2 pi i / count over a box, a lane for each of the angles that differ by the period."""
    return enclose_at(response, space, list_samples(response, count))


def list_samples(response: Enclosed, count: int) -> list[Fraction]:
    """Return those of the angles i / count [turns] that differ by the period."""
    whole = (count * response.period).denominator == 1
    return [Fraction(i, count) for i in range(int(count * response.period) if whole else count)]


def enclose_at(response: Enclosed, space: Space, turns: Sequence[Fraction]) -> list[Jet]:
    """Return each quantity over a box at angles [turns], a lane for each."""
    count = len(turns)
    phi = list_angles([turn + offset for offset in response.offsets for turn in turns])
    sides, shares = range(1, len(response.offsets)), _pieces(response, space, phi)
    space.jumping = np.asarray(space.jumping.reshape(-1, count).any(axis=0))
    return [
        sum((share.taken(slice(k * count, (k + 1) * count)) for k in sides), share.taken(slice(0, count)))
        for share in shares
    ]


def list_angles(turns: Sequence[Fraction]) -> Ball:
    """Return angles [rad] for angles in turns."""
    share = np.array([float(2 * turn) for turn in turns])
    return PI * Ball(share, U * np.abs(share))


def _pieces(response: Enclosed, space: Space, phi: Ball) -> list[Jet]:
    """The shares at angles (lanes,): around all pieces of each."""
    lanes, script = np.arange(len(phi.mid)), np.empty((0, len(phi.mid)))
    parts: list[tuple[Integers, list[Jet]]] = []
    shares = response.follow(space, phi)
    space.jumping = np.zeros(len(phi.mid), dtype=bool)
    while len(lanes):
        branches = Branches(len(lanes), script)
        jets = shares(Enclosing(space.asking(branches, lanes)), lanes)
        if not response.is_continuous:
            np.logical_or.at(space.jumping, lanes, branches.jumping)
        parts.append((lanes, [replace(jet.repeated(len(lanes)), space=space) for jet in jets]))
        further, script = branches.further()
        lanes = lanes[further]
        if sum(len(known) for known, _ in parts) > MOST_LANES * len(phi.mid):
            raise Unbounded("a box goes through many branches")
    quantities = range(len(parts[0][1]))
    return [_around([(known, jets[index]) for known, jets in parts]) for index in quantities]


def _around(parts: Sequence[tuple[Integers, Jet]]) -> Jet:
    """One jet around all parts: the first has every lane, the others pieces of some."""
    (lanes, first), *others = parts
    felt = tuple(sorted({k for _, jet in parts for k in jet.felt}))
    whole = first.over(felt).taken(lanes)
    touched = np.zeros(len(lanes), dtype=bool)
    balls = [whole.value, whole.gradient, whole.hessian]
    bounds = [(ball.low, ball.high) for ball in balls] if others else []
    for which, jet in others:
        touched[which] = True
        piece = jet.over(felt).taken(np.arange(len(which)))
        for (low, high), ball in zip(bounds, (piece.value, piece.gradient, piece.hessian), strict=True):
            for lane, place in enumerate(which):
                low[..., place] = np.minimum(low[..., place], ball.low[..., lane])
                high[..., place] = np.maximum(high[..., place], ball.high[..., lane])
    if others:
        balls = [chosen(touched, Ball.between(*side), ball) for side, ball in zip(bounds, balls, strict=True)]
    return Jet(whole.space, felt, *balls)
