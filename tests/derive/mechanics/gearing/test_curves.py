"""Pitch-curve families: one small class each, checked by closed forms and by the laws of
rolling.
"""

import numpy as np
import pytest
import sympy as sp

from derive.emit import text as emit_curve
from derive.mechanics.gearing import pitch_curve
from derive.mechanics.gearing.families import FAMILIES
from derive.mechanics.gearing.pitch_curve import PitchCurve
from derive.quantity import Quantity
from generated.array import curve_eccentric_circle


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


def test_terms_needed_by_the_series() -> None:
    """At e/R = 0.5 the cosine coefficients pass 1e-12 after about 26 terms."""
    series = np.abs(curve_eccentric_circle.prologue(np, [1.0, 0.5, 1.0], 60)[1:])
    assert 24 <= int(np.argmax(series < 1e-12)) <= 28
