"""Pitch-curve families: one small class each, checked by closed forms and by the laws of
rolling.
"""

import math

import mpmath
import numpy as np
import pytest
import sympy as sp

from derive.emit import text as emit_curve
from derive.mechanics.gearing import pitch_curve
from derive.mechanics.gearing.families import FAMILIES
from derive.mechanics.gearing.pitch_curve import PitchCurve
from derive.quantity import Quantity
from generated.array import curve_eccentric_circle, curve_ellipse

MODULES = {"eccentric_circle": curve_eccentric_circle, "ellipse": curve_ellipse}
PARAMETERS = {"eccentric_circle": [0.030916, 0.005583, 1.542], "ellipse": [0.030694, 0.031, 1.26]}
WIDE = {"eccentric_circle": [0.03, 0.015, 1.3], "ellipse": [0.03, 0.6, 0.8]}
TERMS = 48


@pytest.mark.parametrize("family", FAMILIES.values(), ids=FAMILIES)
def test_joints_sit_at_extrema(family: PitchCurve) -> None:
    slope = family.radius().diff(pitch_curve.u)
    assert sp.simplify(slope.subs(pitch_curve.u, 0)) == 0
    assert sp.simplify(slope.subs(pitch_curve.u, sp.pi)) == 0


def test_families_of_the_paper_are_registered() -> None:
    assert {"eccentric_circle", "ellipse", "fourier", "limacon", "sine"} == FAMILIES.keys()


@pytest.mark.parametrize("family", FAMILIES.values(), ids=FAMILIES)
def test_parameter_names_do_not_collide_with_code(family: PitchCurve) -> None:
    for function in emit_curve.build_curve_functions(family):
        defined = [s.name for step in function.steps for s in step.defines]
        parameter_names = [q.name for q in (*family.parameters, pitch_curve.m, pitch_curve.a)]
        assert len({*defined, *parameter_names}) == len(defined) + len(parameter_names)


def test_a_parameter_with_a_name_of_the_prologue_is_refused() -> None:
    class Named(type(FAMILIES["ellipse"])):  # type: ignore[misc]
        parameters = (Quantity("terms", "m", "test", "test"), FAMILIES["ellipse"].parameters[1])

    with pytest.raises(ValueError, match="family ellipse: its prologue needs the name terms"):
        emit_curve.build_curve_functions(Named())


@pytest.mark.parametrize("family", FAMILIES.values(), ids=FAMILIES)
def test_radius_is_even(family: PitchCurve) -> None:
    radius = family.radius()
    assert sp.simplify(radius - radius.subs(pitch_curve.u, -pitch_curve.u)) == 0


def test_ellipse_rotation_equals_integral_of_ratio() -> None:
    """d/du of the closed form gives the ratio of two equal ellipses (Litvin et al. 2009, chapter
    4).
    """
    ellipse = FAMILIES["ellipse"]
    ratio = ellipse.ratio().subs(pitch_curve.a, ellipse.centre_distance())
    assert sp.simplify(ellipse.turned().diff(pitch_curve.u) - ratio) == 0


def test_ellipse_ratio_extremes_are_those_of_equal_ellipses() -> None:
    """Ratio between (1 - k)/(1 + k) and (1 + k)/(1 - k)."""
    _, _, _, ratio, _, _ = contact("ellipse", np.array([0.0, math.pi / 1.26]))
    k = 0.031
    assert ratio == pytest.approx([(1 + k) / (1 - k), (1 - k) / (1 + k)], rel=1e-14)


@pytest.mark.parametrize("eccentricity", [0.1, 0.5, 0.9])
def test_eccentric_circle_is_a_circle(eccentricity: float) -> None:
    """Its points are at the distance R from a centre that is e away."""
    radius = sp.lambdify(
        (pitch_curve.u, *FAMILIES["eccentric_circle"].parameters),
        FAMILIES["eccentric_circle"].radius(),
    )
    t = np.linspace(0, 2 * np.pi, 50)
    r = radius(t, 1.0, eccentricity)
    assert np.hypot(r * np.cos(t) - eccentricity, r * np.sin(t)) == pytest.approx(1.0, rel=1e-14)


def hoisted(name: str, parameters: list[float]) -> list[float]:
    return MODULES[name].prologue(np, parameters, TERMS if name == "eccentric_circle" else 0)


def contact(
    name: str, t: np.ndarray, parameters: list[float] | None = None
) -> tuple[np.ndarray, ...]:
    values = parameters or PARAMETERS[name]
    return MODULES[name].contact(np, t, values, hoisted(name, values))


@pytest.mark.parametrize("values", [PARAMETERS, WIDE], ids=["paper", "wide"])
@pytest.mark.parametrize("name", MODULES)
def test_closure_and_conjugacy(name: str, values: dict[str, list[float]]) -> None:
    """One turn for one turn, and the rotation is the integral of the ratio, by quadrature that
    knows the joint.
    """
    parameters = values[name]
    joint = math.pi / parameters[2]

    def ratio(t: mpmath.mpf) -> float:
        return float(contact(name, np.array([float(t)]), parameters)[3][0])

    turn = mpmath.quad(ratio, [0, joint, 2 * math.pi])
    assert float(turn) == pytest.approx(2 * math.pi, abs=1e-12)
    assert contact(name, np.array([2 * math.pi]), parameters)[5][0] == pytest.approx(
        2 * math.pi, abs=1e-12
    )
    for end in (0.3, joint, 4.0):
        expected = float(mpmath.quad(ratio, [0, min(end, joint), end]))
        assert contact(name, np.array([end]), parameters)[5][0] == pytest.approx(
            expected, abs=1e-11
        )


@pytest.mark.parametrize("name", MODULES)
def test_derivatives_on_both_sides_of_the_joint(name: str) -> None:
    h = 1e-6
    joint = math.pi / PARAMETERS[name][2]
    for t in (joint - 2 * h, joint + 2 * h, 1.0, 5.0, 2 * h, -2 * h):
        r, dr, ddr, ratio, dratio, turned = contact(name, np.array([t - h, t, t + h]))
        for value, slope in ((r, dr), (dr, ddr), (ratio, dratio), (turned, ratio)):
            assert (value[2] - value[0]) / (2 * h) == pytest.approx(
                slope[1], abs=2e-9 * max(1, np.abs(slope).max())
            )


def test_a_wrong_centre_distance_does_not_close() -> None:
    parameters, wrong = (
        PARAMETERS["eccentric_circle"],
        hoisted("eccentric_circle", PARAMETERS["eccentric_circle"]),
    )
    t = (np.arange(4000) + 0.5) * 2 * np.pi / 4000
    right_mean = contact("eccentric_circle", t)[3].mean()
    wrong[0] *= 1 + 1e-6
    wrong_mean = curve_eccentric_circle.contact(np, t, parameters, wrong)[3].mean()
    assert abs(right_mean - 1) < 1e-7 < abs(wrong_mean - 1)


def test_terms_needed_by_the_series() -> None:
    """At e/R = 0.5 the cosine coefficients pass 1e-12 after about 26 terms."""
    series = np.abs(curve_eccentric_circle.prologue(np, [1.0, 0.5, 1.0], 60)[1:])
    assert 24 <= int(np.argmax(series < 1e-12)) <= 28
