"""Laws of a cam's flank: derived from their accelerations, they are those of the textbooks, and end
at rest.
"""

from functools import cache

import pytest
import sympy as sp

from derive.papers.planting import flanks
from derive.papers.planting.flanks import SHAPES, x

# Largest velocity and acceleration for a rise of 1 over a flank of 1 (Norton, Cam Design and
# Manufacturing Handbook).
FACTORS = {
    "4-5-6-7 polynomial": (2.188, 7.513),
    "3-4-5 polynomial": (1.875, 5.774),
    "cycloidal": (2.000, 6.283),
    "modified sine": (1.760, 5.528),
    "modified trapezoid": (2.000, 4.888),
    "harmonic": (1.571, 4.935),
}
law = cache(flanks.derive_flank_law)


@pytest.mark.parametrize("title", SHAPES)
def test_flank_laws_rest_at_ends_with_consistent_slopes(title: str) -> None:
    rise, speed, acceleration = law(title)
    assert [
        sp.simplify(e.subs(x, v)) for e, v in ((rise, 0), (rise, 1), (speed, 0), (speed, 1))
    ] == [0, 1, 0, 0]
    for place in (
        sp.Rational(1, 17),
        sp.Rational(3, 11),
        sp.Rational(1, 2),
        sp.Rational(7, 10),
        sp.Rational(19, 20),
    ):
        speed_error, acceleration_error = (
            (e.diff(x) - f).subs(x, place) for e, f in ((rise, speed), (speed, acceleration))
        )
        assert abs(sp.N(speed_error)) < 1e-14
        assert abs(sp.N(acceleration_error)) < 1e-12


@pytest.mark.parametrize("title", SHAPES)
def test_a_law_is_continuous_and_symmetric(title: str) -> None:
    rise, speed, _ = (sp.lambdify(x, e) for e in law(title))
    for joint in map(float, flanks.flank_breakpoints(title)[1:-1]):
        for f in (rise, speed):
            assert f(joint - 1e-12) == pytest.approx(f(joint + 1e-12), abs=1e-10)
    for place in (0.05, 0.2, 0.33, 0.45):
        assert rise(place) + rise(1 - place) == pytest.approx(1, abs=1e-14)


@pytest.mark.parametrize("title", SHAPES)
def test_the_factors_are_those_of_the_textbook(title: str) -> None:
    grid = [i / 2000 for i in range(2001)]
    _, speed, acceleration = (sp.lambdify(x, e) for e in law(title))
    factors = max(map(speed, grid)), max(abs(acceleration(v)) for v in grid)
    assert factors == pytest.approx(FACTORS[title], abs=2e-3)


def test_invalid_flank_shapes_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SHAPES, "crooked", ((sp.S.One, x * (1 - 2 * x)),))
    monkeypatch.setitem(SHAPES, "elsewhere", ((sp.Rational(1, 3), x), (sp.S.One, -x)))
    with pytest.raises(ValueError, match=r"crooked: .* rest"):
        flanks.derive_flank_law("crooked")
    with pytest.raises(ValueError, match=r"elsewhere: .*0, 1/8"):
        flanks.derive_flank_law("elsewhere")
