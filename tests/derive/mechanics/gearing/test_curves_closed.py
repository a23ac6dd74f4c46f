"""Closed forms of the pitch-curve families against textbook geometry and against the integrals they
stand for.
"""

import math

import numpy as np
import pytest
import sympy as sp
from scipy.special import ellipe

from derive.mechanics.gearing import pitch_curve
from derive.mechanics.gearing.families import FAMILIES
from generated.array import curve_ellipse, curve_limacon, curve_sine
from tests.support import pairs
from tests.support.sizing import Size, Sizing

TURN = 2 * np.pi


# --- centre distance and rotation
# ----------------------------------------------------------------------


def test_sine_ratio_follows_from_the_radius() -> None:
    sine = FAMILIES["sine"]
    at_distance = sine.radius() / (sine.centre_distance() - sine.radius())
    assert sp.simplify(at_distance - sine.ratio()) == 0


# --- textbook curves
# -----------------------------------------------------------------------------------


def test_equal_ellipses_are_conjugate_at_twice_the_semi_axis() -> None:
    """The conjugate, drawn in its own gear, is the same ellipse, half a turn on (Litvin et al.
    2009).
    """
    A, k = 0.03, 0.4
    parameters = [A, k, 1.0]
    hoisted = curve_ellipse.prologue(np, parameters, 0)
    assert hoisted == [2 * A]
    r, *_, turned = curve_ellipse.contact(np, np.linspace(0, TURN, 50), parameters, hoisted)
    assert 2 * A - r == pytest.approx(A * (1 - k**2) / (1 + k * np.cos(turned)), rel=1e-13)
    assert 2 * A - r != pytest.approx(A * (1 - k**2) / (1 - k * np.cos(turned)), rel=1e-3)


def arc(code: object, parameters: list[float]) -> float:
    """Length of an undeformed pitch curve by the midpoint rule."""
    t = TURN * (np.arange(400) + 0.5) / 400
    r, dr, *_ = code.contact(np, t, parameters, code.prologue(np, parameters, 0))  # type: ignore[attr-defined]
    return float(np.hypot(r, dr).mean() * TURN)


@pytest.mark.parametrize("k", [0.05, 0.4, 0.8])
def test_perimeter_of_the_ellipse(k: float) -> None:
    """4 A E(k^2), E the complete elliptic integral of the second kind; that of the limacon
    likewise.
    """
    assert arc(curve_ellipse, [0.03, k, 1.0]) == pytest.approx(4 * 0.03 * ellipe(k**2), rel=1e-12)
    b = 0.03 * k
    limacon = 4 * (0.03 + b) * ellipe(4 * 0.03 * b / (0.03 + b) ** 2)
    assert arc(curve_limacon, [0.03, b, 1.0]) == pytest.approx(limacon, rel=1e-12)


@pytest.mark.parametrize("c", [0.1, 0.6])
def test_sine_gear_rotates_the_mating_gear_by_a_sine(c: float) -> None:
    parameters = [0.06, c, 1.0]
    t = np.linspace(0, 6, 20)
    *_, ratio, _, turned = curve_sine.contact(
        np, t, parameters, curve_sine.prologue(np, parameters, 0)
    )
    assert turned == pytest.approx(t + c * np.sin(t), abs=1e-14)
    assert ratio == pytest.approx(1 + c * np.cos(t), abs=1e-14)


# --- convexity
# -----------------------------------------------------------------------------------------


TEXTBOOK = [
    (
        "limacon",
        (1.0, 0.5),
        1.0,
        "l = 2 b: the limacon turns concave (Lockwood: A Book of Curves, 1961)",
    ),
    ("sine", (1.0, 2 - math.sqrt(2)), 1.0, "c = 2 - sqrt(2)"),
    ("ellipse", (1.0, 1.0 / 3.0), 2.0, "k (m^2 - 1) = 1"),
    ("ellipse", (1.0, 0.8), 1.5, "k (m^2 - 1) = 1"),
    ("eccentric_circle", (1.0, 0.25), 2.0, "R = m^2 e"),
    ("limacon", (1.0, 0.2), 2.0, "l = (1 + m^2) b"),
]


@pytest.mark.parametrize(("name", "parameters", "m", "limit"), TEXTBOOK)
def test_convexity_limits(name: str, parameters: tuple[float, float], m: float, limit: str) -> None:
    family = FAMILIES[name]
    closed = sp.lambdify((*family.parameters, pitch_curve.m), family.convexity())
    assert closed(*parameters, m) == pytest.approx(0, abs=1e-14), limit
    assert (
        closed(parameters[0], parameters[1] * 0.999, m)
        > 0
        > closed(parameters[0], parameters[1] * 1.001, m)
    )
    other = m / (2 * m - 1)
    assert closed(*parameters, other) == pytest.approx(0, abs=1e-14)


# --- size
# ----------------------------------------------------------------------------------------------

MEAN = 0.03


@pytest.mark.parametrize("swing", [0.1, 0.9])
def test_a_fourier_curve_without_shape_is_the_limacon(swing: float) -> None:
    fourier, limacon = (
        Sizing(name).parameters(Size(MEAN, swing, 1.2)) for name in ("fourier", "limacon")
    )
    assert fourier[[0, 1, 4]] == pytest.approx(limacon, rel=1e-12)
    assert fourier[2:4].tolist() == [0, 0]


def test_fourier_shape_equals_the_coefficients() -> None:
    coefficients = Sizing("fourier").parameters(Size(MEAN, 0.4, 1.0, (0.05, -0.03)))
    assert coefficients[2:4] / coefficients[1] == pytest.approx([0.05, -0.03], rel=1e-14)
    u = np.linspace(0, np.pi, 500)
    r = sum(c * np.cos(k * u) for k, c in enumerate(coefficients[:4]))
    assert (np.diff(r) < 0).all()


def test_shape_bounds_keep_extremes_at_breakpoints() -> None:
    box = [(entry["lower"], entry["upper"]) for entry in pairs.sizing("fourier").sidecar["shapes"]]
    assert sum(k**2 * upper for k, (_, upper) in enumerate(box, 2)) == pytest.approx(0.9)
    assert all(lower == -upper for lower, upper in box)
