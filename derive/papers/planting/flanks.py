"""Laws of a cam's flank: motion of a follower from one dwell to the next, over the position x from
0 to 1.

Each law is stated by the shape of its acceleration alone. Integrated twice from rest and scaled to
a rise of 1, it must end at rest. Shapes: Norton, Cam Design and Manufacturing Handbook (2009),
chapters 3 and 4.
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
"""Shape of an acceleration: end and expression of each piece."""
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
BREAKPOINTS = tuple(_EIGHTH * k for k in (0, 1, 3, 5, 7, 8))
"""Positions in a flank at which a derivative of some law jumps."""
FLANK = FollowerLaw("flank", BREAKPOINTS)
"""The law as a lane calls it; it is selected at run time."""


def derive_flank_law(title: str) -> tuple[Expr, Expr, Expr]:
    """Return the share of the rise at x in [0, 1], and its first and second derivative [1].

    Raises ValueError if the law does not end at rest, or has a breakpoint that is not among
    ``BREAKPOINTS``.
    """
    ends, shapes = zip(*SHAPES[title], strict=True)
    if not set(ends) <= set(BREAKPOINTS):
        raise ValueError(
            f"{title}: its breakpoints must be among {', '.join(map(str, BREAKPOINTS))}"
        )
    speeds = _integrate_pieces(shapes, ends)
    rises = _integrate_pieces(speeds, ends)
    if sp.simplify(speeds[-1].subs(x, 1)) != 0:
        raise ValueError(f"{title}: the follower does not end at rest")
    total = sp.simplify(rises[-1].subs(x, 1))
    rise, speed, acceleration = (
        _join_pieces(pieces, ends, total) for pieces in (rises, speeds, shapes)
    )
    return rise, speed, acceleration


def flank_breakpoints(title: str) -> tuple[Expr, ...]:
    """Return the positions in the flank at which a derivative of a law jumps, with both ends."""
    return (S.Zero, *(end for end, _ in SHAPES[title]))


def _integrate_pieces(pieces: Iterable[Expr], ends: tuple[Expr, ...]) -> tuple[Expr, ...]:
    """Return the integrals of pieces, continuous from zero."""
    integrals: list[Expr] = []
    value: Expr = S.Zero
    for piece, (start, end) in zip(pieces, pairwise((S.Zero, *ends)), strict=True):
        primitive = sp.integrate(sp.expand(piece), x)
        integrals.append(primitive - primitive.subs(x, start) + value)
        value = integrals[-1].subs(x, end)
    return tuple(integrals)


def _join_pieces(pieces: Iterable[Expr], ends: tuple[Expr, ...], total: Expr) -> Expr:
    """Return the piece at x relative to the total rise."""
    *first, last = (_simplify_piece(piece / total) for piece in pieces)
    cases = [(piece, sp.Lt(x, end)) for piece, end in zip(first, ends[:-1], strict=True)]
    return sp.Piecewise(*cases, (last, True)) if cases else last


def _simplify_piece(expr: Expr) -> Expr:
    simple = sp.simplify(expr)
    return sp.horner(simple) if simple.is_polynomial(x) else simple


def flank_model_name(title: str) -> str:
    """Return the name of a law's model.

    >>> flank_model_name("4-5-6-7 polynomial")
    'flank_4_5_6_7_polynomial'
    """
    return "flank_" + title.replace("-", "_").replace(" ", "_")


def build_flank_system(title: str) -> System:
    """Build the model of a law: a function of the position in the flank."""
    steps = tuple(
        Let(symbol, expr, "acceleration, integrated")
        for symbol, expr in zip(LAW, derive_flank_law(title), strict=True)
    )
    source = (
        "derived from the shape of its acceleration (Norton, Cam Design and Manufacturing "
        "Handbook, 2009)"
    )
    return System(
        flank_model_name(title),
        title,
        source,
        ("from rest to rest",),
        closed_forms=(ClosedForm("law", (x,), steps, Vector("flank", LAW.quantities)),),
    )


SYSTEMS = tuple(partial(build_flank_system, title) for title in SHAPES)
