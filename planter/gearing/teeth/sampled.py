"""The pair of a pitch curve that was measured: points of it, joined by a periodic C2 cubic, and its conjugate."""

from __future__ import annotations

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.pair import Pair, of_contact
from planter.gearing.teeth.rack import RACK
from planter.kernels import Array
from planter.numerics.angles import TURN
from planter.numerics.chebyshev import Panels


def of_samples(polar: Array, radius: Array, name: str, turns: int = 1, sense: int = 1) -> Pair:
    """The pair of radii (n,) [m] at polar angles (n,) [rad] that rise by less than a turn; `name` says whose they are.

    The mate turns once in so many `turns` of the gear. Raises GeometryError where no centre distance closes the mate.
    """
    from scipy.interpolate import CubicSpline

    knots = np.append(polar, polar[0] + TURN) - polar[0]
    curve = CubicSpline(knots, np.append(radius, radius[0]), bc_type="periodic")
    distance = _closing(curve, knots, turns, name)

    def ratios(t: Array) -> Array:
        u = np.mod(t, TURN)
        return np.array(list(RACK("rolling", r=curve(u), dr=curve(u, 1), a=distance).values()))

    turned = Panels.of(lambda t: ratios(t)[:1], knots).integral

    def contact(t: Array) -> Array:
        u, past = np.mod(t, TURN), np.floor(t / TURN)
        rotation = turned(u)[0] + past * TURN / turns
        return np.vstack([curve(u), curve(u, 1), curve(u, 2), ratios(t), rotation])

    return of_contact(contact, distance, knots, sense, turns)


def _closing(curve: object, knots: Array, turns: int, name: str) -> float:
    """The centre distance [m] at which the mate turns once in so many turns."""
    from scipy.optimize import brentq

    assert callable(curve)
    radii = Panels.of(lambda t: curve(t)[None], knots)
    ends = radii.ends
    shares = np.linspace(0, 1, 9)
    dense = radii((ends[:-1, None] + np.diff(ends)[:, None] * shares).ravel())[0]
    low, high = float(dense.min()), float(dense.max())
    if low <= 0:
        raise GeometryError(
            f"{name}: the curve through the points has a radius of {low * 1e3:.4g} mm: it must be above 0"
        )

    def over(distance: float) -> float:
        of = Panels.of(lambda t: RACK("rolling", r=curve(t), dr=curve(t, 1), a=distance)["ratio"][None], knots)
        return float(of.integral(knots[-1:])[0, 0] - TURN / turns)

    nearest = high * (1 + 1e-9)
    farthest = high * (1 + turns)
    return float(brentq(over, nearest + 1e-3 * (farthest - nearest), farthest, xtol=1e-18, rtol=1e-15))
