"""Printed numbers of the pick-up's paper, and the formulas that recompute them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from planter.audit.registry import MM, Inputs, formula
from planter.kernels import Array
from planter.kernels.formulas import load
from planter.numerics.arrays import TURN
from planter.papers.pickup.inverse import PathSpline
from planter.papers.pickup.law import MODEL, CosineLaw, Dwell


@formula("centre distance as printed, nearest")
def centre_distance_printed(inputs: Inputs) -> float:
    """m_n (z1 + z2)/cos beta, without the half, at that helix angle of the printed range that comes
    nearest [mm].
    """
    return _nearest(inputs, 1.0)


@formula("centre distance, nearest")
def centre_distance(inputs: Inputs) -> float:
    """m_n (z1 + z2)/(2 cos beta) at that helix angle of the printed range that comes nearest
    [mm].
    """
    return _nearest(inputs, 0.5)


def _nearest(inputs: Inputs, factor: float) -> float:
    distance = float(inputs["centre_distance_mm"])
    largest_and_least = np.cos(np.radians(inputs["helix_range_deg"]))
    shortest, longest = factor * _teeth(inputs) * inputs["normal_module_mm"] / largest_and_least
    return float(np.clip(distance, shortest, longest))


@formula("plants in a square metre, nearest")
def density(inputs: Inputs) -> float:
    """Plants in a square metre [1/m2] at those spacings of the printed range that come nearest."""
    smallest, largest = (float(spacing) / 100 for spacing in inputs["spacing_cm"])
    return float(np.clip(inputs["density_per_m2"], 1 / largest**2, 1 / smallest**2))


@formula("contact ratio of a helical pair")
def helical_contact_ratio(inputs: Inputs) -> float:
    """Transverse part plus overlap of a standard external pair of equal gears; helix angle from the
    centre distance.
    """
    lengths = [
        inputs.si(name) for name in ("L1_mm", "gamma_deg", "centre_distance_mm", "normal_module_mm")
    ]
    teeth = [inputs["teeth_1"], inputs["teeth_2"], inputs.si("face_width_mm")]
    tool = [inputs.si("normal_pressure_angle_deg"), inputs["addendum_coefficient"]]
    return load(MODEL).at("carrier", carrier=[*lengths, *teeth, *tool])["epsilon_h"]


@formula("speed of the simulation over that of the tests")
def simulated_speed(inputs: Inputs) -> float:
    """Speed of the carrier in the simulation over the highest one at which the mechanism was
    tested.
    """
    return float(inputs.si("simulated_deg_per_s") / np.max(inputs.si("tested_rpm")))


def _teeth(inputs: Inputs) -> float:
    return float(inputs["teeth_1"] + inputs["teeth_2"])


_SAMPLES = 3600
_ANY_PAIR = (1.0, 1.0, 0.0, 0.0, 0.0)
"""Teeth, face width, pressure angle and addendum of some pair whose module is its centre
distance.
"""


@dataclass(frozen=True)
class TipMotion:
    """Bars (2,) [m], angles phi5 and phi1 (n,) [rad], and places of the tip (n, 2) [m]."""

    bars: Array
    phi5: Array
    phi1: Array
    tip: Array


def trace_motion(inputs: Inputs, bars: Array, phi5: Array, phi1: Array) -> TipMotion:
    """Return the path of bars at some angles, on the carrier of the paper."""
    still = {"g": np.zeros(len(phi5)), "omega": 0.0}
    motion = load(MODEL)("motion", phi5=phi5, phi1=phi1, triangle=_triangle(inputs, bars), **still)
    return TipMotion(bars, phi5, phi1, np.column_stack([motion["x_S"], motion["y_S"]]))


def of_law(inputs: Inputs, t: Array) -> TipMotion:
    """The motion by the law at carrier angles from the far point (n,)."""
    phi1, bars = _law(inputs).arm(t), np.array([inputs.si("L1_mm"), inputs.si("L2_mm")])
    return trace_motion(inputs, bars, inputs.si("phi5_far_deg") + t, phi1)


def invert_tip_path(inputs: Inputs, path: Array) -> TipMotion:
    """The chain from places (n, 2) [m], the farthest first: bars by their extremes, angles by the
    triangle.
    """
    distance = np.hypot(*path.T)
    far, nearest = distance.max(), distance.min()
    bars = _bars(float(far), float(nearest))
    way = np.where(np.arange(len(path)) > np.argmin(distance), -1.0, 1.0)
    squares = {
        "short": (far - distance) * (far + distance),
        "over": (distance - nearest) * (distance + nearest),
    }
    angles = load(MODEL)("inverse", x_S=path[:, 0], y_S=path[:, 1], way=way, bars=bars, **squares)
    return trace_motion(inputs, bars, angles["phi5"], angles["phi1"])


@formula("bar from its path")
def bar(inputs: Inputs) -> float:
    """A bar's length as half the sum or difference of the extreme distances of the path that the
    law makes [mm].
    """
    turn = _sample_turn(inputs)
    return float(invert_tip_path(inputs, turn.tip).bars[inputs["bar"] - 1] / MM)


@formula("bar from a spline through points of its path")
def bar_from_points(inputs: Inputs) -> float:
    """Return the bars from a closed cubic spline by chord length [mm] through points of that path,
    even in t.
    """
    count = inputs["value_points"]
    extremes = PathSpline(of_law(inputs, TURN * np.arange(count) / count).tip).extremes(0.0)
    distances = [extreme.distance for extreme in extremes]
    return float(_bars(max(distances), min(distances))[inputs["bar"] - 1] / MM)


@formula("round trip of the law")
def law_error(inputs: Inputs) -> float:
    """Largest difference of phi1 between a law and what the chain finds from its path [rad]."""
    turn = _sample_turn(inputs)
    return float(abs(invert_tip_path(inputs, turn.tip).phi1 - turn.phi1).max())


@formula("round trip of the path")
def path_error(inputs: Inputs) -> float:
    """Largest distance of the path that the found bars and angles make from the one they were found
    from [mm].
    """
    turn = _sample_turn(inputs)
    return float(np.hypot(*(invert_tip_path(inputs, turn.tip).tip - turn.tip).T).max() / MM)


@formula("printed rule for the direction of the tip")
def direction_rule(inputs: Inputs) -> float:
    """Largest error on the path of arctan(y/x), less pi in the third quadrant, as the direction of
    the tip [deg].
    """
    x, y = _sample_turn(inputs).tip.T
    rule = np.arctan(y / x) - np.pi * ((x < 0) & (y < 0))
    return float(np.degrees(abs(np.angle(np.exp(1j * (rule - np.arctan2(y, x)))))).max())


@formula("first centre distance over the second")
def centre_distance_margin(inputs: Inputs) -> float:
    """a1 less a2 [mm]."""
    a1 = _carrier(inputs, float(inputs.si("L1_mm")))["a1"]
    return a1 / MM - float(inputs["centre_distance_mm"])


@formula("direction of the planet's axis as printed")
def axis_direction_printed(inputs: Inputs) -> float:
    """Angle from the direction phi5 to O-O1 where M1-O1 points at beta1 + pi - gamma from it
    [deg].
    """
    return _axis_direction(inputs, -1)


@formula("direction of the planet's axis")
def axis_direction(inputs: Inputs) -> float:
    """Angle from the direction phi5 to O-O1 where the triangle of the carrier closes: beta1 + pi +
    gamma [deg].
    """
    return _axis_direction(inputs, 1)


def _axis_direction(inputs: Inputs, sense: int) -> float:
    carrier = _carrier(inputs, float(inputs.si("L1_mm")))
    middle = carrier["a1"] * np.exp(1j * carrier["beta1"])
    turned = carrier["beta1"] + np.pi + sense * inputs.si("gamma_deg")
    return float(
        np.degrees(np.angle(middle + inputs.si("centre_distance_mm") * np.exp(1j * turned)))
    )


def _carrier(inputs: Inputs, L1: float) -> dict[str, float]:
    """The triangle of the carrier with a bar L1 [m]; its gears, of which some are assumed, have no
    part in it.
    """
    gamma, a2 = inputs.si("gamma_deg"), inputs.si("centre_distance_mm")
    return load(MODEL).at("carrier", carrier=[L1, gamma, a2, a2, *_ANY_PAIR])


def _triangle(inputs: Inputs, bars: Array) -> Array:
    carrier = _carrier(inputs, float(bars[0]))
    return np.array(
        [
            *bars,
            inputs.si("gamma_deg"),
            carrier["a1"],
            inputs.si("centre_distance_mm"),
            carrier["beta1"],
        ]
    )


def _bars(far: float, nearest: float) -> Array:
    """Bars (2,) from the extreme distances of the tip [m]."""
    bars = load(MODEL).at("bars", L3_max=far, L3_min=nearest)
    return np.array([bars["L1"], bars["L2"]])


def _law(inputs: Inputs) -> CosineLaw:
    dwell = Dwell(*inputs.si("dwell_deg"))
    return CosineLaw(inputs["law_p"], dwell)


def _sample_turn(inputs: Inputs) -> TipMotion:
    """A turn by the law, its near point among the samples."""
    law = _law(inputs)
    near_point = scipy.optimize.brentq(
        lambda t: float(law.arm(np.array([t]))[0]) - TURN, 0, law.dwell.start, xtol=1e-15
    )
    return of_law(inputs, np.unique([*np.linspace(0, TURN, _SAMPLES, endpoint=False), near_point]))
