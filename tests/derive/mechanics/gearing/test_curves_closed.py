"""Closed forms of the pitch-curve families against textbook geometry and against the integrals they
stand for.
"""

import math

import mpmath
import numpy as np
import pytest
import sympy as sp
from mpmath import mp
from scipy.special import ellipe

from derive.mechanics.gearing import pitch_curve
from derive.mechanics.gearing.families import FAMILIES
from derive.mechanics.gearing.pitch_curve import PitchCurve
from generated.array import curve_ellipse, curve_limacon, curve_sine
from tests.support import pairs
from tests.support.sizing import Size, Sizing

TURN = 2 * np.pi
BY_FORMULA = [family for family in FAMILIES.values() if isinstance(family.turned(), sp.Expr)]
VALUES = {"ellipse": (0.03, 0.4), "limacon": (0.03, 0.013), "sine": (0.06, 0.45)}


def with_values(family: PitchCurve, expr: sp.Expr) -> sp.Expr:
    """An expression in u alone, at exact values of the parameters."""
    substitutions = {
        q: sp.Rational(str(v)) for q, v in zip(family.parameters, VALUES[family.name], strict=True)
    }
    return expr.subs(pitch_curve.a, family.centre_distance()).subs(substitutions)


def test_families_with_formulas() -> None:
    assert sorted(family.name for family in BY_FORMULA) == sorted(VALUES)


# --- centre distance and rotation
# ----------------------------------------------------------------------


def closure_gap(family: PitchCurve, stretched: sp.Expr = sp.S.One) -> float:
    at_distance = family.radius() / (stretched * family.centre_distance() - family.radius())
    f = sp.lambdify(pitch_curve.u, with_values(family, at_distance), "mpmath")
    with mpmath.workdps(30):
        return abs(float(mp.quad(f, [0, mp.pi / 2, mp.pi]) / mp.pi - 1))


@pytest.mark.parametrize("family", BY_FORMULA, ids=lambda f: f.name)
def test_centre_distances_close(family: PitchCurve) -> None:
    assert closure_gap(family) < 1e-20
    assert closure_gap(family, 1 + sp.Rational(1, 10**9)) > 1e-10


@pytest.mark.parametrize("family", BY_FORMULA, ids=lambda f: f.name)
def test_rotations_are_integrals_of_ratios(family: PitchCurve) -> None:
    ratio, turned = (
        sp.lambdify(pitch_curve.u, with_values(family, e), "mpmath")
        for e in (family.ratio(), family.turned())
    )
    with mpmath.workdps(30):
        for u in (mp.mpf("0.7"), mp.mpf(2), mp.pi):
            assert abs(mp.quad(ratio, [0, u / 2, u]) - turned(u)) < 1e-20
        assert abs(turned(mp.pi) - mp.pi) < 1e-25
        assert abs(turned(mp.mpf(2)) * (1 + 1e-9) - mp.quad(ratio, [0, 1, 2])) > 1e-10


def test_limacon_centre_distance_follows_from_mean_ratio() -> None:
    """The mean of 1/(q - b cos u) is 1/sqrt(q^2 - b^2), so that a/(a - r), of mean 2, gives a^2 = 4
    ((a - l)^2 - b^2).

    The root above 2 l is the centre distance: (4 l + 2 sqrt(l^2 + 3 b^2)) / 3.
    """
    limacon = FAMILIES["limacon"]
    l, b = (sp.Symbol(n, positive=True) for n in "lb")  # noqa: E741
    a = sp.Symbol("a", positive=True)
    substitutions = dict(zip(limacon.parameters, (l, b), strict=True))
    assert (
        sp.simplify(
            (a**2 - 4 * ((a - l) ** 2 - b**2)).subs(
                a, limacon.centre_distance().subs(substitutions)
            )
        )
        == 0
    )
    assert limacon.centre_distance().subs(substitutions).subs({l: 1, b: 0}) == 2


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

mu = sp.Symbol("mu", positive=True)


def bend(family: PitchCurve) -> sp.Expr:
    """r^2 + 2 r'^2 - r r'' of the deformed curve where u has the slope mu: the sign of its
    curvature.
    """
    r = family.radius()
    return r**2 + 2 * mu**2 * r.diff(pitch_curve.u) ** 2 - mu**2 * r * r.diff(pitch_curve.u, 2)


@pytest.mark.parametrize("name", ["eccentric_circle", "ellipse", "limacon", "sine"])
def test_convexity_is_the_curvature_at_the_least_radius(name: str) -> None:
    """Over the closed form, r^2 + 2 r'^2 - r r'' at u = pi leaves a factor without a change of
    sign.
    """
    family = FAMILIES[name]
    size, number = family.parameters
    at_pi = bend(family).subs(pitch_curve.u, sp.pi)
    closed = family.convexity().subs(pitch_curve.STEEPER, mu)
    assert not closed.has(pitch_curve.m)
    quotient = sp.lambdify((size, number, mu), at_pi / closed, "math")
    for share in (0.01, 0.1, 0.3, 0.55, 0.8, 0.97):
        for slope in (1.01, 1.37, 2.1, 4.3):
            assert quotient(1.0, share, slope) > 0


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
EXPECTED = {
    "ellipse": lambda s: (
        MEAN / math.sqrt(1 - math.tan(math.asin(s) / 2) ** 2),
        math.tan(math.asin(s) / 2),
    ),
    "limacon": lambda s: (MEAN, MEAN * s / math.sqrt(4 - 3 * s**2)),
    "sine": lambda s: (MEAN / (1 - 1 / math.sqrt(4 - s**2)), s),
}


@pytest.mark.parametrize("swing", [0.03, 0.5, 0.93])
@pytest.mark.parametrize("name", EXPECTED)
def test_sizes_in_closed_form(name: str, swing: float) -> None:
    """The mean radius of an ellipse about its focus is its minor semi-axis; the others are short
    integrals.
    """
    sizes = Sizing(name).parameters(Size(MEAN, swing, 1.3))
    assert sizes == pytest.approx([*EXPECTED[name](swing), 1.3], rel=1e-13)
    assert sizes != pytest.approx([*EXPECTED[name](swing * 1.0001), 1.3], rel=1e-7)


@pytest.mark.parametrize("swing", [0.03, 0.5, 0.93])
def test_size_of_the_eccentric_circle(swing: float) -> None:
    """Its mean radius is 2 R E / pi, from whichever point inside."""
    R, e, _ = Sizing("eccentric_circle").parameters(Size(MEAN, swing))
    assert 2 * R * ellipe((e / R) ** 2) / math.pi == pytest.approx(MEAN, rel=1e-13)
    assert 2 * R * ellipe(e / R) / math.pi != pytest.approx(MEAN, rel=1e-6)


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
