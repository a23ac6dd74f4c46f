"""Cubic B-spline through value points, from the recursion of its basis functions (Cox-de Boor; Piegl and Tiller, 1997).

Index 0 stands for knot i; a control point carries the index of the knot where its basis function peaks.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, S

from ...formulas import Formulas
from ...quantity import Quantity
from . import quantities as q
from .vocabulary import PickupClaim

DEGREE = 3
KNOTS = {-2: q.u_im2, -1: q.u_im1, 0: q.u_i, 1: q.u_ip1, 2: q.u_ip2, 3: q.u_ip3}
CONTROLS = {-1: q.d_im1, 0: q.d_i, 1: q.d_ip1, 2: q.d_ip2}
INTERVALS = {-2: q.Delta_im2, -1: q.Delta_im1, 0: q.Delta_i, 1: q.Delta_ip1}
PEAK = (DEGREE + 1) // 2
"""Intervals from where a basis function begins to where it peaks."""


def basis(first: int, degree: int) -> Expr:
    """The basis function that begins at knot ``first``, in the interval from knot 0 to knot 1."""
    if degree == 0:
        return S.One if first == 0 else S.Zero
    last = first + degree + 1
    rising, falling = basis(first, degree - 1), basis(first + 1, degree - 1)
    total = S.Zero
    if rising != 0:
        total += rising * (q.u - KNOTS[first]) / (KNOTS[last - 1] - KNOTS[first])
    if falling != 0:
        total += falling * (KNOTS[last] - q.u) / (KNOTS[last] - KNOTS[first + 1])
    return total


def by_intervals(expr: Expr) -> Expr:
    """An expression in knots, written in the lengths of the intervals between them."""
    places: dict[Quantity, Expr] = {KNOTS[0]: S.Zero}
    for index in (0, 1):
        places[KNOTS[index + 1]] = places[KNOTS[index]] + INTERVALS[index]
    for index in (-1, -2):
        places[KNOTS[index]] = places[KNOTS[index + 1]] - INTERVALS[index]
    return expr.xreplace(places)


def weight(index: int) -> Expr:
    """What the control point ``index`` contributes at knot 0."""
    return sp.factor(by_intervals(basis(index - PEAK, DEGREE).subs(q.u, q.u_i)))


def support() -> Expr:
    """Intervals that a basis function of degree k spans: one more than those of the degree below, which it joins."""
    spans = sp.Function("spans")
    degree = sp.Symbol("degree", integer=True)
    return sp.rsolve(spans(degree) - spans(degree - 1) - 1, spans(degree), {spans(0): 1}).subs(degree, q.k)


def state(f: Formulas) -> None:
    """Claims about the spline."""
    scale = INTERVALS[-1] + INTERVALS[0]
    rows = {index: sp.factor(weight(index) * scale) for index in (-1, 0, 1)}
    overlap = support().subs(q.k, DEGREE) - 1
    f.defines(q.Delta_i, KNOTS[1] - KNOTS[0], PickupClaim.KNOT_INTERVAL, named=True)
    f.defines(q.Delta_im1, KNOTS[0] - KNOTS[-1], PickupClaim.KNOT_INTERVAL_BEFORE)
    f.defines(q.Delta_im2, KNOTS[-1] - KNOTS[-2], PickupClaim.SECOND_KNOT_INTERVAL_BEFORE)
    f.defines(q.Delta_ip1, KNOTS[2] - KNOTS[1], PickupClaim.KNOT_INTERVAL_AFTER)
    f.defines(q.i_last, sp.expand(q.n + support()), PickupClaim.LAST_KNOT)
    f.defines(q.i_first, overlap, PickupClaim.FIRST_CURVE_KNOT)
    f.defines(q.i_end, q.n + support().subs(q.k, DEGREE) - overlap, PickupClaim.LAST_CURVE_KNOT)
    f.defines(q.p_u, sp.Add(*(basis(j - PEAK, DEGREE) * d for j, d in CONTROLS.items())), PickupClaim.CURVE_POINT)
    f.defines(q.q_i, sp.Add(*(weight(j) * CONTROLS[j] for j in rows)), PickupClaim.VALUE_POINT)
    f.defines(q.a_i, rows[-1], PickupClaim.CONTROL_BEFORE)
    f.defines(q.b_i, sp.apart(rows[0], q.Delta_im2), PickupClaim.CONTROL_AT_KNOT)
    f.defines(q.c_i, rows[1], PickupClaim.CONTROL_AFTER)
    f.defines(q.e_i, scale * q.q_i, PickupClaim.KNOT_ROW_RIGHT_SIDE)
    coefficients = zip((q.a_i, q.b_i, q.c_i), (-1, 0, 1), strict=True)
    f.holds(PickupClaim.KNOT_ROW, sp.Add(*(c * CONTROLS[j] for c, j in coefficients)) - q.e_i)
