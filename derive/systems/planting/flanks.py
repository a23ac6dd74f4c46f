"""Laws of a cam's flank: how a follower goes from one dwell to the next, over its position x from 0 to 1.

Each law is stated by the shape of its acceleration alone. Integrated twice from rest and scaled to a rise of 1, it must
come to rest again. Shapes: Norton, Cam Design and Manufacturing Handbook (2009), chapters 3 and 4.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from itertools import pairwise

import sympy as sp
from sympy import Expr, Rational, S, cos, pi, sin

from ...mechanics.kinematics import FollowerLaw
from ...model import ClosedForm, Let, System
from ...quantity import Quantity, Vector

_SOURCE = "cam law"
x = Quantity("x", "1", "position in the flank, from 0 to 1", _SOURCE)
p = Quantity("p", "1", "share of the rise", _SOURCE)
dp = Quantity("dp", "1", "slope of the share of the rise", _SOURCE)
ddp = Quantity("ddp", "1", "second derivative of the share of the rise", _SOURCE)
LAW = Vector("law", (p, dp, ddp))

DEFAULT = "4-5-6-7 polynomial"

_EIGHTH = Rational(1, 8)
Pieces = tuple[tuple[Expr, Expr], ...]
"""Shape of an acceleration: where each piece ends, and what it is up to there."""
SHAPES: dict[str, Pieces] = {
    DEFAULT: ((S.One, x**2 * (1 - x) ** 2 * (1 - 2 * x)),),
    "3-4-5 polynomial": ((S.One, x * (1 - x) * (1 - 2 * x)),),
    "cycloidal": ((S.One, sin(2 * pi * x)),),
    "modified sine": (
        (_EIGHTH, sin(4 * pi * x)),
        (7 * _EIGHTH, sin(4 * pi / 3 * x + pi / 3)),
        (S.One, sin(4 * pi * x)),
    ),
    "modified trapezoid": (
        (_EIGHTH, sin(4 * pi * x)),
        (3 * _EIGHTH, S.One),
        (5 * _EIGHTH, cos(4 * pi * x - 3 * pi / 2)),
        (7 * _EIGHTH, S.NegativeOne),
        (S.One, sin(4 * pi * x)),
    ),
    "harmonic": ((S.One, cos(pi * x)),),
}
"""Laws by their name in machine files."""
JOINTS = tuple(_EIGHTH * k for k in (0, 1, 3, 5, 7, 8))
"""Positions in a flank where a derivative of some law jumps."""
FLANK = FollowerLaw("flank", JOINTS)
"""The law as a lane calls it: which one is chosen at run time."""


def law(title: str) -> tuple[Expr, Expr, Expr]:
    """Share of the rise at x in [0, 1], and its first and second derivative.

    Raises ValueError where the shape does not come to rest, or has a joint that is not among ``JOINTS``.
    """
    ends, shapes = zip(*SHAPES[title], strict=True)
    if not set(ends) <= set(JOINTS):
        raise ValueError(f"{title}: its joints must be among {', '.join(map(str, JOINTS))}")
    speeds = _integrated(shapes, ends)
    rises = _integrated(speeds, ends)
    if sp.simplify(speeds[-1].subs(x, 1)) != 0:
        raise ValueError(f"{title}: the follower does not come to rest")
    whole = sp.simplify(rises[-1].subs(x, 1))
    rise, speed, acceleration = (_selected(some, ends, whole) for some in (rises, speeds, shapes))
    return rise, speed, acceleration


def joints(title: str) -> tuple[Expr, ...]:
    """Positions in the flank where a derivative of a law jumps, its ends among them."""
    return (S.Zero, *(end for end, _ in SHAPES[title]))


def _integrated(pieces: Iterable[Expr], ends: tuple[Expr, ...]) -> tuple[Expr, ...]:
    """Integrals of pieces, each going on from where the one before has ended, the first from zero."""
    found: list[Expr] = []
    reached: Expr = S.Zero
    for piece, (start, end) in zip(pieces, pairwise((S.Zero, *ends)), strict=True):
        primitive = sp.integrate(sp.expand(piece), x)
        found.append(primitive - primitive.subs(x, start) + reached)
        reached = found[-1].subs(x, end)
    return tuple(found)


def _selected(pieces: Iterable[Expr], ends: tuple[Expr, ...], whole: Expr) -> Expr:
    """The piece at x, as a share of the whole rise."""
    told = [_told(piece / whole) for piece in pieces]
    cases = [(piece, sp.Lt(x, end)) for piece, end in zip(told[:-1], ends[:-1], strict=True)]
    return sp.Piecewise(*cases, (told[-1], True)) if cases else told[-1]


def _told(expr: Expr) -> Expr:
    found = sp.simplify(expr)
    return sp.horner(found) if found.is_polynomial(x) else found


def named(title: str) -> str:
    """The name of a law's functions.

    >>> named("4-5-6-7 polynomial")
    'flank_4_5_6_7_polynomial'
    """
    return "flank_" + title.replace("-", "_").replace(" ", "_")


def system(title: str) -> System:
    """A law as a function of the position in the flank."""
    steps = tuple(Let(symbol, expr, "acceleration, integrated") for symbol, expr in zip(LAW, law(title), strict=True))
    source = "derived from the shape of its acceleration (Norton, Cam Design and Manufacturing Handbook, 2009)"
    return System(named(title), title, source, ("from rest to rest",), closed_forms=(
        ClosedForm("law", (x,), steps, Vector("flank", LAW.quantities)),
    ))  # fmt: skip


SYSTEMS = tuple(partial(system, title) for title in SHAPES)
