"""Pairs of a measured pitch curve, a periodic C2 cubic through its points, and its conjugate."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from planter.errors import GeometryError
from planter.gearing.teeth.pair import CurvePair, build_contact_pair
from planter.gearing.teeth.rack import RACK
from planter.kernels import Array
from planter.numerics.angles import TURN, turn_deg
from planter.numerics.chebyshev import Panels, RoughFunctionError

_SAMPLES = 9
"""Points between neighbouring samples at which the curve is checked."""
_ROUNDING = 1e-9
"""Share by which the bracket of the centre distance is widened, because that of a circle is at its end."""


class RadiusFunction(Protocol):
    """Function that returns radii (n,) [m] at angles (n,) [rad] from the first point, or their derivatives."""

    def __call__(self, at: Array, derivative: int = 0, /) -> Array: ...


MAX_SLOPE_ANGLE = np.radians(80)
"""Largest angle [rad] between a pitch curve and the circle about its axis: at a pressure angle of 10 deg the normals
of flanks then pass through the axis, and no torque turns the gear."""
MAX_HALVINGS = 8
"""How often the gap between the gear's largest radius and the mate's axis is halved, from `turns` of those radii, until
the mate turns too far: a pitch curve closer to its axis cannot carry teeth."""


def build_sampled_pair(polar: Array, radius: Array, name: str, turns: int = 1, sense: int = 1) -> CurvePair:
    """Return the pair of radii (n,) [m] at polar angles (n,) [rad] that rise by less than a turn.

    The mate turns once in `turns` of the gear; errors begin with `name`. Raises GeometryError
    if the curve through the points reaches its axis, is too steep for any teeth, or has no centre distance that
    closes the mate.
    """
    from scipy.interpolate import CubicSpline

    knots = np.append(polar, polar[0] + TURN) - polar[0]
    curve = CubicSpline(knots, np.append(radius, radius[0]), bc_type="periodic")
    _check_slope(curve, knots, polar[0], sense, name)
    try:
        return _build_pair(curve, knots, _find_centre_distance(curve, knots, turns, name), turns, sense)
    except RoughFunctionError as error:
        raise GeometryError(f"{name}: the curve through the points is too rough to be rolled on: {error}") from error


def _build_pair(curve: RadiusFunction, knots: Array, distance: float, turns: int, sense: int) -> CurvePair:
    """Return the pair of a curve smooth between knots (n + 1,) [rad], at a distance of the axes [m]."""

    def ratios(t: Array) -> Array:
        u = np.mod(t, TURN)
        return np.array(list(RACK("rolling", r=curve(u), dr=curve(u, 1), a=distance).values()))

    turned = Panels.of(lambda t: ratios(t)[:1], knots).integral

    def contact(t: Array) -> Array:
        u, past = np.mod(t, TURN), np.floor(t / TURN)
        rotation = turned(u)[0] + past * TURN / turns
        return np.vstack([curve(u), curve(u, 1), curve(u, 2), ratios(t), rotation])

    return build_contact_pair(contact, distance, knots, sense, turns)


def _sample_angles(knots: Array) -> Array:
    """Return angles [rad] between knots (n + 1,) at which a curve is checked."""
    return np.asarray((knots[:-1, None] + np.diff(knots)[:, None] * np.linspace(0, 1, _SAMPLES)).ravel())


def _check_slope(curve: RadiusFunction, knots: Array, first: float, sense: int, name: str) -> None:
    """Raise GeometryError, with the polar angle, if the curve reaches its axis or is too steep for teeth."""
    places = _sample_angles(knots)
    radius, slope = curve(places), curve(places, 1)

    def at(k: int) -> str:
        return f"at the polar angle {turn_deg(sense * (first + places[k])):.4g} deg"

    smallest, steep = int(np.argmin(radius)), int(np.argmax(np.abs(slope) / radius))
    if radius[smallest] <= 0:
        raise GeometryError(
            f"{name}: the curve through the points has a radius of {radius[smallest] * 1e3:.4g} mm {at(smallest)}: it "
            f"must be above 0"
        )
    angle = np.arctan(np.abs(slope[steep]) / radius[steep])
    if angle > MAX_SLOPE_ANGLE:
        raise GeometryError(
            f"{name}: the curve through the points is {np.degrees(angle):.4g} deg from a circle about its axis "
            f"{at(steep)}, which is not allowed: it must be at most {np.degrees(MAX_SLOPE_ANGLE):g} deg for teeth to "
            "turn it"
        )


def _find_centre_distance(curve: RadiusFunction, knots: Array, turns: int, name: str) -> float:
    """Return the centre distance [m] at which the mate turns once in `turns`. Raises GeometryError without one."""
    from scipy.optimize import brentq

    high = float(curve(_sample_angles(knots)).max())

    def over(distance: float) -> float:
        rates = Panels.of(lambda t: RACK("rolling", r=curve(t), dr=curve(t, 1), a=distance)["ratio"][None], knots)
        return float(rates.integral(knots[-1:])[0, 0] - TURN / turns)

    # Near the largest radius the ratio has a pole, so the bracket is searched from the other end.
    farther = high * (1 + turns) * (1 + _ROUNDING)
    for gap in turns * 0.5 ** np.arange(1, MAX_HALVINGS + 1):
        nearer = high * (1 + gap)
        if over(nearer) >= 0:
            return float(brentq(over, nearer, farther, xtol=1e-18, rtol=1e-15))
        farther = nearer
    raise GeometryError(
        f"{name}: no mate rolls on this curve: where its radius is largest, {high * 1e3:.4g} mm, the mate's would be "
        f"below {gap * high * 1e3:.3g} mm; reduce the largest radius"
    )
