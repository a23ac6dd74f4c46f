"""Locking arcs by circles and forces: where they meet the tips, and the least radius that holds."""

import cmath
import math

import pytest

from planter.kernels.formulas import load

ARCS = load("locking_arcs")
A = 0.071


@pytest.mark.parametrize("addendum", [1e-9, 1e-4, 2.4e-3])
def test_the_arc_ends_on_the_tip_circle(addendum: float) -> None:
    radius = 0.031
    reach = ARCS.at("horn", distance=A, radius=radius, tips=A - radius + addendum)["reach"]
    end = radius * cmath.exp(1j * reach)
    assert abs(end - A) - (A - radius) == pytest.approx(addendum, rel=1e-6)
    assert 0 < reach < math.pi / 4


@pytest.mark.parametrize("friction", [0.1, 0.2, 0.6])
@pytest.mark.parametrize("tips", [0.02, 0.035, 0.06])
def test_smallest_radius_balances_friction_moment(friction: float, tips: float) -> None:
    """About the driven axis, on the edge of the horn; with a larger radius the normal force
    wins.
    """
    radius = ARCS.at("least", distance=A, tips=tips, friction=friction)["radius"]
    assert moment(radius, tips, friction) == pytest.approx(0, abs=1e-9 * A)
    assert (
        moment(radius + 1e-4, tips, friction)
        > 0
        > moment(radius - (radius + tips - A) / 2, tips, friction)
    )


@pytest.mark.parametrize("tips", [0.02, 0.06])
def test_without_friction_any_overlap_holds(tips: float) -> None:
    assert ARCS.at("least", distance=A, tips=tips, friction=0.0)["radius"] == pytest.approx(
        A - tips, abs=1e-15
    )


def moment(radius: float, tips: float, friction: float) -> float:
    """Of a unit force along the arc's normal at the horn's edge, less that of the friction that it
    lets be.
    """
    reach = ARCS.at("horn", distance=A, radius=radius, tips=tips)["reach"]
    out = cmath.exp(1j * reach)
    arm = radius * out - A
    normal, rubbing = ((arm.conjugate() * force).imag for force in (out, 1j * out))
    return abs(normal) - friction * abs(rubbing)
