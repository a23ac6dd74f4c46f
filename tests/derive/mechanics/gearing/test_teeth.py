"""Contact ratio of rack teeth on pitch curves: textbook circles, a rack, and where teeth no longer
meet.
"""

import math

import numpy as np
import pytest
import sympy as sp

from derive.mechanics.gearing import teeth
from planter.kernels.formulas import load

TEETH = load("gear_teeth")
MODULE, ANGLE = 2e-3, math.radians(20)


def ratio(curvature_1: float, curvature_2: float, addendum: float = 1.0) -> dict[str, float]:
    return TEETH.at(
        "contact_ratio",
        kappa1=curvature_1,
        kappa2=curvature_2,
        teeth=[MODULE, addendum, addendum, ANGLE],
    )


@pytest.mark.parametrize("z", [(20, 20), (18, 54), (40, 120)])
def test_contact_ratio_of_circles_matches_spur_gears(z: tuple[int, int]) -> None:
    """The path between both tip circles over the base pitch, by radii (ISO 21771)."""
    radii = [MODULE * count / 2 for count in z]
    tips = [math.sqrt((r + MODULE) ** 2 - (r * math.cos(ANGLE)) ** 2) for r in radii]
    path = sum(tips) - sum(radii) * math.sin(ANGLE)
    expected = path / (math.pi * MODULE * math.cos(ANGLE))
    result = ratio(*(1 / r for r in radii))
    assert result["epsilon"] == pytest.approx(expected, rel=1e-13)
    assert ratio(*(1.001 / r for r in radii))["epsilon"] != pytest.approx(expected, rel=1e-5)


def test_of_racks_and_of_hollow_places() -> None:
    rack = ratio(0.0, 0.0)
    assert rack["g1"] == pytest.approx(MODULE / math.sin(ANGLE), rel=1e-14)
    assert ratio(-3.0, 10.0)["epsilon"] > ratio(3.0, 10.0)["epsilon"]


def test_tips_inside_base_circle_are_reported() -> None:
    bends = np.linspace(-60, 60, 241)
    result = TEETH(
        "contact_ratio", kappa1=bends, kappa2=np.zeros(241), teeth=[MODULE, 1.0, 1.0, ANGLE]
    )
    by_radii = 1 / bends[bends != 0] + MODULE - math.cos(ANGLE) / bends[bends != 0]
    assert ((result["outside1"][bends != 0] >= 0) == (by_radii * bends[bends != 0] >= 0)).all()
    assert (result["outside1"] < 0).any()
    assert np.isfinite(result["epsilon"]).all()


def test_paths_in_curvatures_and_in_radii_are_the_same() -> None:
    r, h, alpha = sp.Rational(1, 25), sp.Rational(1, 500), sp.Rational(7, 20)
    _, path = teeth.path_by_curvature(1 / r, h, alpha)
    assert sp.N(path - teeth.path_of_action(r, h, alpha), 30) == pytest.approx(0, abs=1e-25)
