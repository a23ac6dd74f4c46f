"""Pairs of gears that are not round, for any statement: families of pitch curves, and tables of a
radius.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy import Expr, S

from ...model import let
from ...quantity import TableError, of_unit
from ...tables import build_table, parse_columns, read_columns
from .families import FAMILIES
from .pitch_curve import a, ahead, contact_steps, dr, du, m, parameter_steps, r, t, turned, u
from .pitch_curve import ratio as speed_ratio

NODES = 360
"""Pieces of the function of the mate's angle that a table becomes."""
SAME_RADIUS = 1e-3
"""Parts of a turn that a mate of several turns needs to be alike are so to this share of the
radius.
"""


@dataclass(frozen=True)
class RollingPair:
    """A pair of gears that roll on each other: expressions at a contact, for `derive.GearContact`
    and `derive.Point`.

    ``distance`` [m] is that of the shafts, ``radius`` [m] the pitch radius of the first gear,
    ``slope`` [m/rad] its derivative by the polar angle of the contact on that gear, ``ratio`` how
    fast the mate turns per turn of the first gear, without unit, and ``turned`` [rad] how far it
    has turned since the polar angle 0.
    """

    distance: Expr
    radius: Expr
    slope: Expr
    ratio: Expr
    turned: Expr


def gear_pair(
    family: str, angle: Expr, deformation: Expr | None = None, **parameters: Expr
) -> RollingPair:
    r"""Return a pair of a family of pitch curves at a polar angle [rad] of the contact on the first
    gear.

    The families with closed forms are ``"ellipse"`` (A [m], k), ``"limacon"`` (l, b [m]) and
    ``"sine"`` (D [m], c), all one turn for one (Wang et al. 2017, 3.3 and 3.4). ``deformation``,
    without unit, is the coefficient of the two-segment deformation (equation 10); the pitch curve
    is not smooth where the segments meet. Raises ValueError for other families and other
    parameters.

    >>> from derive import gear_pair, quantities
    >>> q = quantities("phi | rad | gear\nA | m | semi-axis | 0.02\nk | 1 | eccentricity | 0.2")
    >>> pair = gear_pair("ellipse", q.phi, A=q.A, k=q.k)
    >>> pair.distance, pair.radius
    (2*A, A*(1 - k**2)/(-k*cos(phi) + 1))
    """
    closed = {
        name: (curve, curve.centre_distance(), curve.turned())
        for name, curve in FAMILIES.items()
        if isinstance(curve.centre_distance(), Expr) and isinstance(curve.turned(), Expr)
    }
    if family not in closed:
        raise ValueError(
            f"family {family!r}: those in closed form are {', '.join(closed)}; give others as a "
            f"table"
        )
    curve, shafts, integral = closed[family]
    symbols = {str(symbol): symbol for symbol in curve.parameters}
    if symbols.keys() != parameters.keys():
        raise ValueError(
            f"{family} has the parameters {', '.join(symbols)}, and these are "
            f"{', '.join(parameters)}"
        )
    values: dict[Expr, Expr] = {
        symbols[name]: sp.sympify(value) for name, value in parameters.items()
    }
    distance = sp.sympify(shafts).xreplace(values)
    values |= {t: sp.sympify(angle), a: distance}
    if deformation is None:
        values |= {u: values[t], du: S.One}
        steps = [
            *(step for step in contact_steps(curve) if step.symbol != turned),
            let(turned, integral),
        ]
    else:
        values |= {m: sp.sympify(deformation)}
        steps = [*parameter_steps(), let(ahead, integral - u), *contact_steps(curve)]
    for step in steps:
        values[step.symbol] = step.expr.xreplace(values)
    return RollingPair(distance, values[r], values[dr], values[speed_ratio], values[turned])


@dataclass(frozen=True)
class GearTable:
    """A gear by a table of its pitch radius, with its mate; ``distance`` [m] is that of the shafts
    for this radius.
    """

    distance: float
    mean: Fraction
    swing: Callable[[Expr], Expr]

    def pair(self, angle: Expr, distance: Expr) -> RollingPair:
        """Return the pair at a polar angle [rad]; with another ``distance`` [m] of the shafts it is
        as much larger.
        """
        passed = sp.Rational(self.mean) * t + self.swing(t)
        speed = passed.diff(t)
        radius = distance * speed / (1 + speed)
        parts = (
            part.xreplace({t: sp.sympify(angle)})
            for part in (radius, radius.diff(t), speed, passed)
        )
        return RollingPair(distance, *parts)


def read_gear_pair(path: str | Path, columns: str, ratio: Fraction | int = 1) -> GearTable:
    """Return a gear whose pitch radius is a table of a CSV file, with its mate.

    ``columns`` are those of `derive.read_table`: the polar angle, over a whole turn, and the
    radius; the last radius is the first again. The mate turns ``ratio`` times per turn of this
    gear, such as 1 or Fraction(1, 2); the distance of the shafts follows. So that both roll on each
    other exactly, the radius of a pair follows from the mate's angle, a cubic spline of 360 pieces;
    it meets the periodic spline of the table to about 1e-5 of it. Raises TableError as
    `derive.read_table` does, for angles that are not a whole turn or a radius that is not positive,
    and if the mate does not close.
    """
    from scipy.interpolate import CubicSpline
    from scipy.optimize import brentq

    polar, radius = parse_columns(columns)
    angles, radii = (np.array(column) for column in read_columns(Path(path), polar, radius))
    for wrong, reason in (
        (
            abs(angles[-1] - angles[0] - 2 * math.pi) > 1e-6,
            "the polar angles are not those of a whole turn",
        ),
        (
            radii[-1] != radii[0],
            f"the last radius {radii[-1]:g} m is not the first, {radii[0]:g} m",
        ),
        (radii.min() <= 0, "a pitch radius is not positive"),
    ):
        if wrong:
            raise TableError(f"{path}: {reason}")
    angles[-1] = angles[0] + 2 * math.pi
    curve = CubicSpline(angles, radii, bc_type="periodic")
    mean = Fraction(ratio)
    alike = np.abs(curve(angles + 2 * math.pi / mean.numerator) - radii).max()
    if alike > SAME_RADIUS * radii.max():
        raise TableError(
            f"{path}: a mate that turns {mean} times per turn does not close: the radius must "
            f"repeat {mean.numerator} "
            f"times a turn, and differs by up to {alike:.3g} m"
        )
    nodes, weights = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(angles[0], angles[-1], NODES + 1)
    step = edges[1] / 2 - edges[0] / 2
    samples = curve((edges[:-1, None] + edges[1:, None]) / 2 + step * nodes)

    def turn(distance: float) -> NDArray[np.float64]:
        """Return how far the mate turns over each piece."""
        return step * (samples / (distance - samples)) @ weights

    largest = float(samples.max())
    distance = brentq(
        lambda at: turn(at).sum() - 2 * math.pi * mean,
        largest * (1 + 1e-9),
        largest * (2 + 2 / mean),
        xtol=1e-15,
    )
    passed = np.concatenate([[0.0], np.cumsum(turn(distance))]) - float(mean) * (edges - edges[0])
    passed[-1] = passed[0]
    passed -= CubicSpline(edges, passed, bc_type="periodic")(0.0)
    swing = build_table(
        "swing", (of_unit("rad"), of_unit("rad")), edges.tolist(), passed.tolist(), periodic=True
    )
    return GearTable(distance, mean, swing)
