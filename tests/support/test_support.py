"""The tools of the independent checks, against closed forms: each check is worth what its tools
are.
"""

import numpy as np
import pytest
from mpmath import mp

from tests.support import kinematics, machines, xp_complex, xp_mpmath
from tests.support.arithmetic import FLOATS, MPMATH
from tests.support.jets import Jet, turned_y, turned_z

X = 0.7
SLOPES = {
    "sin": np.cos(X),
    "cos": -np.sin(X),
    "tan": 1 / np.cos(X) ** 2,
    "exp": np.exp(X),
    "log": 1 / X,
    "sqrt": 0.5 / np.sqrt(X),
    "arctan": 1 / (1 + X**2),
    "absolute": 1.0,
    "floor": 0.0,
    "sign": 0.0,
}


@pytest.mark.parametrize("name", SLOPES)
def test_complex_step_differentiates(name: str) -> None:
    f = getattr(xp_complex, name)
    assert xp_complex.slopes(lambda x: f(x[0]), [X]) == pytest.approx(SLOPES[name], rel=1e-15)
    assert np.real(f(np.array(X + 0j))) == pytest.approx(getattr(np, name)(X), rel=1e-15)


def test_complex_step_follows_branches() -> None:
    def f(x: np.ndarray) -> np.ndarray:
        return xp_complex.where(xp_complex.logical_or(x[0] < 0, x[0] > 1), 0, x[0] ** 2)

    assert [xp_complex.slopes(f, [x])[0] for x in (-0.5, 0.5, 1.5)] == [0, 1, 0]
    assert xp_complex.slopes(lambda x: xp_complex.absolute(x[0]), [-X])[0] == -1
    assert xp_complex.slopes(lambda x: xp_complex.maximum(x[0], 2 * x[1]), [3.0, 1.0]).tolist() == [
        1,
        0,
    ]
    assert xp_complex.slopes(lambda x: xp_complex.minimum(x[0], 2 * x[1]), [3.0, 1.0]).tolist() == [
        0,
        2,
    ]


@pytest.mark.parametrize(
    ("y", "x"), [(0.3, 0.8), (0.3, -0.8), (-0.3, -0.8), (-0.3, 0.8), (0.5, 0.0)]
)
def test_complex_step_goes_round_with_arctan2(y: float, x: float) -> None:
    expected = np.array([x, -y]) / (x**2 + y**2)
    assert xp_complex.slopes(lambda z: xp_complex.arctan2(z[0], z[1]), [y, x]) == pytest.approx(
        expected, rel=1e-15
    )


@pytest.mark.parametrize(
    "name",
    ["sin", "cos", "tan", "exp", "log", "sqrt", "arctan", "arcsin", "arccos", "floor", "sign"],
)
def test_mpmath_functions_have_numpys_meaning(name: str) -> None:
    assert float(getattr(xp_mpmath, name)(mp.mpf(X))) == pytest.approx(
        getattr(np, name)(X), rel=1e-15
    )


@pytest.mark.parametrize(("y", "x"), [(0.3, 0.8), (0.3, -0.8), (-0.3, -0.8), (-0.3, 0.8)])
def test_mpmath_functions_of_two_numbers_have_numpys_meaning(y: float, x: float) -> None:
    for name in ("arctan2", "divide", "maximum", "minimum"):
        assert float(getattr(xp_mpmath, name)(mp.mpf(y), mp.mpf(x))) == pytest.approx(
            getattr(np, name)(y, x), rel=1e-15
        )


def test_mpmath_functions_keep_all_digits() -> None:
    with mp.workdps(50):
        assert abs(xp_mpmath.sin(xp_mpmath.pi / 6) - mp.mpf(1) / 2) < mp.mpf(10) ** -49


def test_jets_differentiate_twice() -> None:
    """x = sin(3 t) / sqrt(1 + t^2) against complex step of its written-out derivative."""
    t0 = 0.4
    t = Jet(np, t0, 1.0, 0.0)
    jet = (3 * t).sin() / (1 + t * t).sqrt()

    def rate(t: np.ndarray) -> np.ndarray:
        root = np.sqrt(1 + t**2)
        return 3 * np.cos(3 * t) / root - t * np.sin(3 * t) / root**3

    assert jet.rate == pytest.approx(rate(t0), rel=1e-14)
    assert jet.acceleration == pytest.approx(
        xp_complex.slopes(lambda x: rate(x[0]), [t0])[0], rel=1e-14
    )


def test_jets_turn_with_transport_and_coriolis_terms() -> None:
    """A point sliding out on a turning arm."""
    spin, speed, t = 2.0, 0.5, 0.3
    angle, radius, zero = Jet(np, spin * t, spin), Jet(np, speed * t, speed), Jet(np, 0.0)
    radial, across = (
        np.array([np.cos(spin * t), np.sin(spin * t)]),
        np.array([-np.sin(spin * t), np.cos(spin * t)]),
    )
    expected = -(spin**2) * speed * t * radial + 2 * spin * speed * across
    x, y, _ = turned_z(angle, (radius, zero, zero))
    assert [x.acceleration, y.acceleration] == pytest.approx(expected, rel=1e-14)
    z, _, x = turned_y(angle, (zero, zero, radius))
    assert [x.acceleration, z.acceleration] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("name", [*machines.BUILT_IN, *machines.RANDOM])
def test_both_number_systems_give_the_same_motion(name: str) -> None:
    floats = kinematics.Device(machines.machine(name), FLOATS).side(np.array([2.0]))
    with mp.workdps(20):
        digits = kinematics.Device(machines.machine(name), MPMATH).side(mp.mpf(2))
        for angle in ("phi52", "phi72", "theta1"):
            for first, second in zip(
                getattr(floats, angle).parts, getattr(digits, angle).parts, strict=True
            ):
                assert np.asarray(first).item() == pytest.approx(
                    float(second), rel=1e-12, abs=1e-13
                )


def test_ellipse_closes_at_centre_distance() -> None:
    """A second way to a known result: at twice the semi-axis the mate of a focal ellipse is the
    same ellipse.
    """
    device = kinematics.Device(machines.machine("wang2017"))
    assert device.gear6.distance == pytest.approx(2 * device["design.A6_mm"], rel=1e-15)
    assert device.sun.distance != pytest.approx(2 * device["design.R3_mm"], rel=1e-3)
