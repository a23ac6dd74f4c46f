"""The gear train: closure, conjugate pitch curves, curvature, and the arm that it drives."""

import numpy as np
import pytest
import scipy

from planter.errors import ComputationError, GeometryError
from planter.numerics.arrays import TURN
from planter.papers.mapping import model
from planter.papers.mapping.curve import AngleCurve, load_curve
from planter.papers.mapping.dyads import solve_dyads
from planter.papers.mapping.train import RADII, Train, polar_curves
from tests.planter.papers.mapping.data import CORRECTED, si

A = 0.07


def harmonic(e: float, points: int = 720) -> Train:
    """1/i = 1 + e cos(theta)."""
    theta = np.linspace(0, TURN, points + 1)
    return Train(AngleCurve(theta, -theta - e * np.sin(theta)), A)


DEFAULT = Train(load_curve("sun2019-curve"), A)


@pytest.mark.parametrize("e", [0.1, 0.6, 0.9, 0.99])
def test_split_parameter_is_an_elliptic_integral(e: float) -> None:
    exact = 2 / np.pi * np.sqrt(1 + e) * scipy.special.ellipe(2 * e / (1 + e))
    assert harmonic(e).x_s == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("train", [DEFAULT, harmonic(0.6), harmonic(0.99)])
def test_both_stages_close(train: Train) -> None:
    assert np.abs(train.closure_errors).max() < 1e-12


def test_another_split_parameter_leaves_the_first_stage_open() -> None:
    wrong = Train(DEFAULT.curve, A)
    wrong.__dict__["x_s"] = DEFAULT.x_s * (1 + 1e-6)
    assert abs(wrong.closure_errors[0]) > 1e-6
    assert abs(wrong.closure_errors[1]) < 1e-12


def test_circles_come_from_a_uniform_turn() -> None:
    train = harmonic(0.0)
    assert np.array(train.radius_range) == pytest.approx(np.full((2, 4), A / 2))
    assert train.least_curvature_radius == pytest.approx([A / 2] * 4)
    assert train.convex == [True] * 4
    assert train.closure_errors == pytest.approx((0, 0), abs=1e-13)


@pytest.mark.parametrize("train", [DEFAULT, harmonic(0.6)])
def test_pitch_curves_are_conjugate(train: Train) -> None:
    """In mesh the radii fill the centre distance, equal arcs roll off, and both tangents are one
    line.
    """
    theta = np.linspace(0.01, 6.2, 200)
    gears = train.gears(theta)
    assert gears["r1"] + gears["r2"] == pytest.approx(A)
    assert gears["r3"] + gears["r4"] == pytest.approx(A)
    for driver, follower, rates in (
        ("r1", "r2", ("dpsi1", "dpsi2")),
        ("r3", "r4", ("dpsi3", "dpsi4")),
    ):
        assert gears[driver] * gears[rates[0]] == pytest.approx(gears[follower] * gears[rates[1]])
    assert gears["i1"] * gears["i2"] == pytest.approx(gears["i"])
    assert gears["i1"] / gears["i2"] == pytest.approx(train.x_s**2)


def test_arcs_of_mating_curves_are_equal() -> None:
    """From the polar curves alone."""
    psi, radii = polar_curves(harmonic(0.6), samples=100_000)
    x, y = radii * np.cos(psi), radii * np.sin(psi)
    lengths = np.hypot(np.diff(x), np.diff(y)).sum(axis=1)
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-3)
    assert lengths[2] == pytest.approx(lengths[3], rel=1e-3)
    assert psi[:, -1] == pytest.approx([TURN] * 4, abs=1e-12)


@pytest.mark.parametrize("gear", range(4))
def test_curvature_equals_points(gear: int) -> None:
    """By the circle through three neighbours on the polar curve."""
    train, step = harmonic(0.6), 2e-3
    theta = np.linspace(0.3, 6, 25)
    kappa = model.curvature(*train.curve.slopes(theta), train.x_s, A)[gear]
    rate = ("dpsi1", "dpsi2", "dpsi3", "dpsi4")[gear]
    points, weights = np.polynomial.legendre.leggauss(12)
    three = []
    for shift in (-step, 0, step):
        angles = theta[:, None] + shift * (1 + points) / 2
        turned = (train.gears(angles.ravel())[rate].reshape(angles.shape) @ weights) * shift / 2
        three.append(train.gears(theta + shift)[RADII[gear]] * np.exp(1j * turned))
    p, q, r = three
    cross = np.imag(np.conj(q - p) * (r - q))
    circle = 2 * cross / (np.abs(q - p) * np.abs(r - q) * np.abs(r - p))
    assert kappa == pytest.approx(circle, rel=2e-3, abs=0.05)


def test_driver_turns_concave_beyond_a_limit() -> None:
    assert harmonic(0.1).convex == [True] * 4
    assert not all(harmonic(0.9).convex)
    for k in range(4):
        assert bool(harmonic(0.9).concave(k)) != harmonic(0.9).convex[k]


def test_radii_reach_their_extremes_with_the_slope() -> None:
    smallest, largest = DEFAULT.radius_range
    gears = DEFAULT.gears(np.linspace(0, TURN, 20001))
    for k, name in enumerate(RADII):
        assert (smallest[k], largest[k]) == pytest.approx(
            (gears[name].min(), gears[name].max()), abs=1e-8
        )
        assert 0 < smallest[k] < largest[k] < A


def test_swapping_driver_and_driven_gives_the_inverse_train() -> None:
    """The curve of the carrier against the arm: its train has the radii of the stages the other way
    round.
    """
    train = harmonic(0.5)
    theta = np.linspace(0, TURN, 721)
    turned = -train.curve.at(theta)
    back = Train(AngleCurve(turned, -theta), A)
    driven, again = train.gears(theta), back.gears(turned)
    assert again["i"] == pytest.approx(1 / driven["i"], rel=1e-5)


def test_the_train_drives_the_arm_along_the_curve() -> None:
    dyad = solve_dyads(si(CORRECTED)).dyads[0]
    motion = DEFAULT.motion(dyad)
    relative = motion["phi"] - motion["theta"]
    assert relative == pytest.approx(DEFAULT.curve.at(motion["theta"]), abs=1e-12)
    z = motion["places"][0] + 1j * motion["places"][1]
    hinge = complex(*dyad.centre) + dyad.radius * np.exp(1j * motion["theta"])
    assert z + np.exp(1j * motion["phi"]) * complex(*dyad.point) == pytest.approx(hinge, abs=1e-14)
    assert z[0] == pytest.approx(z[-1], abs=1e-13)


def test_carrier_bends_by_the_cosine_rule() -> None:
    assert np.degrees(DEFAULT.bend(0.099724)) == pytest.approx(
        2 * np.degrees(np.arcsin(99.724 / 140)), rel=1e-12
    )
    assert DEFAULT.bend(2 * A) == pytest.approx(np.pi)
    with pytest.raises(GeometryError, match="at most twice the centre distance, 140 mm"):
        DEFAULT.bend(0.1401)


def test_printed_split_parameter_is_near_assumed_points() -> None:
    """The patent prints 0.968 for points that it does not disclose."""
    assert DEFAULT.x_s == pytest.approx(0.968, abs=2e-3)
    assert DEFAULT.x_s != pytest.approx(0.968, abs=5e-4)


def test_stopping_curve_is_refused_with_angle() -> None:
    theta = np.linspace(0, TURN, 361)
    with pytest.raises(ComputationError, match=r"reaches zero at carrier angle 1[67]\d"):
        Train(AngleCurve(theta, -theta - 1.01 * np.sin(theta)), A)


def test_rising_curve_has_gears_of_falling_curve() -> None:
    curve = DEFAULT.curve
    mirrored = Train(AngleCurve(curve.carrier, -curve.relative, 1), A)
    assert mirrored.x_s == pytest.approx(DEFAULT.x_s, rel=1e-13)
    assert np.array(mirrored.radius_range) == pytest.approx(np.array(DEFAULT.radius_range))
