"""The inverse chain of a two-bar arm: from the path of its tip back to bars and angles, and the carrier's triangle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from planter.audit.registry import Inputs, formula
from planter.kernels import Array

_SAMPLES = 3600
_DENSE = 20_000


@dataclass(frozen=True)
class Law:
    """Rotation phi1 of the arm [rad] by carrier angle t from the far point: slope c (1 + p cos t), 0 in the dwell."""

    p: float
    dwell: tuple[float, float]

    def phi1(self, t: Array) -> Array:
        """phi1(0) = pi, and it gains a turn in a turn of the carrier; t (n,) in [0, 2 pi]."""
        a, b = self.dwell
        toothed = self._turned(np.minimum(t, a)) + self._turned(np.maximum(t, b)) - self._turned(np.array(b))
        whole = self._turned(np.array(2 * np.pi)) - self._turned(np.array(b)) + self._turned(np.array(a))
        return np.pi + 2 * np.pi * toothed / whole

    def _turned(self, t: Array) -> Array:
        return t + self.p * np.sin(t)


@dataclass(frozen=True)
class Found:
    """What the inverse chain gets from a path: bars [mm] and angles (n,) [rad]."""

    bars: tuple[float, float]
    phi1: Array
    phi5: Array

    @property
    def path(self) -> Array:
        """The tip's path that these bars and angles make, complex (n,) [mm]."""
        return tip(self.bars, self.phi5, self.phi1)


def tip(bars: tuple[float, float], phi5: Array, phi1: Array) -> Array:
    """Tip as a complex number: L1 at phi5, then L2 at phi5 + pi - phi1."""
    path: Array = bars[0] * np.exp(1j * phi5) + bars[1] * np.exp(1j * (phi5 + np.pi - phi1))
    return path


def inverted(path: Array) -> Found:
    """The chain from a path, complex (n,), the farthest point first: extremes, bars, law of cosines, angles."""
    l3 = abs(path)
    bars = ((l3.max() - l3.min()) / 2, (l3.max() + l3.min()) / 2)
    at_sun, at_tip = (_angle(l3, *sides) for sides in ((bars[0], bars[1]), (bars[1], bars[0])))
    back = np.arange(len(path)) > np.argmin(l3)
    at_planet = np.pi - at_sun - at_tip
    phi6 = np.where(back, 2 * np.pi - at_sun, at_sun)
    phi1 = np.where(back, 2 * np.pi + at_planet, 2 * np.pi - at_planet)
    phi4 = np.unwrap(np.angle(path))
    return Found(bars, phi1, phi6 + phi4)


def _angle(l3: Array, beside: float, across: float) -> Array:
    """Angle of the triangle at the end of L3 where `beside` joins it, by its half: exact to rounding when flat."""
    s = (l3 + beside + across) / 2
    squared = (s - l3) * (s - beside) / np.maximum(s * (s - across), 1e-300)
    return 2 * np.arctan(np.sqrt(np.maximum(squared, 0)))


@formula("bar from its path")
def bar(inputs: Inputs) -> float:
    """A bar's length as half the sum or difference of the extreme distances of the path that the law makes [mm]."""
    return float(_round_trip(inputs)[2].bars[inputs["bar"] - 1])


@formula("bar from a spline through points of its path")
def bar_from_points(inputs: Inputs) -> float:
    """The same from a closed cubic spline through points of that path, equally spaced in t, by chord length [mm]."""
    law, far, bars = _law(inputs)
    t = np.linspace(0, 2 * np.pi, inputs["value_points"] + 1)
    path = tip(bars, far + t, law.phi1(t))
    path[-1] = path[0]
    chord = np.concatenate([[0], np.cumsum(abs(np.diff(path)))])
    distance = abs(CubicSpline(chord, path, bc_type="periodic")(np.linspace(0, chord[-1], _DENSE)))
    extremes = (distance.max() - distance.min()) / 2, (distance.max() + distance.min()) / 2
    return float(extremes[inputs["bar"] - 1])


@formula("round trip of the law")
def law_error(inputs: Inputs) -> float:
    """Largest difference of phi1 between a law and what the chain finds from its path [rad]."""
    _, phi1, found = _round_trip(inputs)
    return float(abs(found.phi1 - phi1).max())


@formula("round trip of the path")
def path_error(inputs: Inputs) -> float:
    """Largest distance of the path that the found bars and angles make from the one they were found from [mm]."""
    path, _, found = _round_trip(inputs)
    return float(abs(found.path - path).max())


@formula("printed rule for the direction of the tip")
def direction_rule(inputs: Inputs) -> float:
    """Largest error on the path of arctan(y/x), less pi in the third quadrant, as the direction of the tip [deg]."""
    path, _, _ = _round_trip(inputs)
    rule = np.arctan(path.imag / path.real) - np.pi * ((path.real < 0) & (path.imag < 0))
    return float(np.degrees(abs(np.angle(np.exp(1j * (rule - np.angle(path)))))).max())


def first_centre_distance(inputs: Inputs) -> float:
    """a1 from the triangle of the carrier by the law of sines [mm]."""
    gamma = np.radians(inputs["gamma_deg"])
    beta1 = _beta1(inputs)
    return float(inputs["L1_mm"] * np.sin(np.pi - beta1 - gamma) / np.sin(gamma))


@formula("first centre distance over the second")
def centre_distance_margin(inputs: Inputs) -> float:
    """a1 less a2 [mm]."""
    return first_centre_distance(inputs) - float(inputs["centre_distance_mm"])


@formula("direction of the planet's axis as printed")
def axis_direction_printed(inputs: Inputs) -> float:
    """Angle from the direction phi5 to O-O1 where M1-O1 points at beta1 + pi - gamma from it [deg]."""
    return _axis_direction(inputs, -1)


@formula("direction of the planet's axis")
def axis_direction(inputs: Inputs) -> float:
    """Angle from the direction phi5 to O-O1 where the triangle of the carrier closes: beta1 + pi + gamma [deg]."""
    return _axis_direction(inputs, 1)


def _axis_direction(inputs: Inputs, sense: int) -> float:
    beta1, gamma = _beta1(inputs), np.radians(inputs["gamma_deg"])
    middle = first_centre_distance(inputs) * np.exp(1j * beta1)
    axis = middle + inputs["centre_distance_mm"] * np.exp(1j * (beta1 + np.pi + sense * gamma))
    return float(np.degrees(np.angle(axis)))


def _beta1(inputs: Inputs) -> float:
    return float(np.arcsin(inputs["centre_distance_mm"] * np.sin(np.radians(inputs["gamma_deg"])) / inputs["L1_mm"]))


def _law(inputs: Inputs) -> tuple[Law, float, tuple[float, float]]:
    start, end = np.radians(inputs["dwell_deg"])
    bars = float(inputs["L1_mm"]), float(inputs["L2_mm"])
    return Law(inputs["law_p"], (float(start), float(end))), float(np.radians(inputs["phi5_far_deg"])), bars


def _round_trip(inputs: Inputs) -> tuple[Array, Array, Found]:
    """Path and phi1 of the law over a turn, its near point among the samples; what the chain finds from the path."""
    law, far, bars = _law(inputs)
    near = brentq(lambda t: float(law.phi1(np.array(t))) - 2 * np.pi, 0, law.dwell[0], xtol=1e-15)
    t = np.unique([*np.linspace(0, 2 * np.pi, _SAMPLES, endpoint=False), near])
    path = tip(bars, far + t, law.phi1(t))
    return path, law.phi1(t), inverted(path)
