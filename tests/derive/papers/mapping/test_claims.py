"""Kinematic mapping: the derivation against independent geometry, and the patent's formulas against
the derivation.
"""

import cmath
import random
from collections.abc import Mapping

import mpmath as mp
import numpy as np
import pytest
import scipy
import sympy as sp

from derive.equations import ClaimError
from derive.evaluate import MachineFile
from derive.papers.mapping import geometry
from derive.papers.mapping import quantities as q
from derive.papers.mapping import subject as claims
from derive.quantity import Quantity
from tests.support.late import LateDict, LateList

CLAIMS = LateDict(
    lambda: {str(claim): equation for claim, equation in claims.derive_formulas().equations.items()}
)
POINTS = LateList(lambda: [claims.SUBJECT.admissible(random.Random(seed)) for seed in range(3)])
Point = Mapping[Quantity, mp.mpf]

# The poses of the patent with the first angle as its mapping parameters have it: its text omits the
# minus sign.
POSES = [(235, 120, -10), (252, 112, 0), (237, 121, 12), (80, -270, -85), (58, -258, -75)]
PRINTED_Z = [
    (-70.0125, 111.8235, -0.0872, 0.9962),
    (-56, 126, 0, 1),
    (-47.782, 124.1748, 0.1045, 0.9945),
    (72.5088, 120.6958, -0.6756, 0.7373),
    (84.6885, 101.5375, -0.6088, 0.7934),
]


def value(expr: sp.Expr, point: Point) -> mp.mpf:
    symbols = sorted(expr.free_symbols, key=str)
    with mp.workdps(60):
        return mp.mpf(sp.lambdify(symbols, expr, "mpmath")(*(point[s] for s in symbols)))


def derived(text: str, symbol: Quantity, point: Point) -> float:
    """What a derived definition makes of a symbol."""
    (expr,) = sp.solve(CLAIMS[text].residual, symbol)
    return float(value(expr, point))


def circle_poses(
    seed: int, count: int
) -> tuple[dict[Quantity, float], list[dict[Quantity, float]]]:
    """A random dyad and poses that hold its moving hinge on the circle, by complex numbers."""
    rng = np.random.default_rng(seed)
    hinge, centre = complex(*rng.normal(size=2)), complex(*rng.normal(size=2))
    radius = rng.uniform(0.5, 2)
    dyad = {
        q.x: hinge.real,
        q.y: hinge.imag,
        q.X_c: centre.real,
        q.Y_c: centre.imag,
        q.L1: radius,
        q.a0: 1.0,
    }
    poses = []
    for theta, phi in rng.uniform(-3, 3, (count, 2)):
        on_circle = centre + cmath.rect(radius, theta)
        tip = on_circle - hinge * cmath.exp(1j * phi)
        poses.append(
            {
                q.d1: tip.real,
                q.d2: tip.imag,
                q.phi: phi,
                q.theta: theta,
                q.X: on_circle.real,
                q.Y: on_circle.imag,
            }
        )
    return dyad, poses


def test_hinge_formulas_match_complex_numbers() -> None:
    dyad, poses = circle_poses(seed=1, count=4)
    for pose in poses:
        point = claims.complete_values({**dyad, **{s: pose[s] for s in (q.d1, q.d2, q.phi)}})
        for name, symbol in (("X", q.X), ("Y", q.Y)):
            assert float(point[symbol]) == pytest.approx(pose[symbol], abs=1e-14)
            text = f"moving hinge in the fixed frame by the mapping parameters, {name}"
            assert derived(text, symbol, point) == pytest.approx(pose[symbol], abs=1e-14)


@pytest.mark.parametrize("scale", [1.0, -3.5])
def test_mapping_parameters_are_homogeneous(scale: float) -> None:
    dyad, (pose, *_) = circle_poses(seed=2, count=1)
    point = claims.complete_values({**dyad, **{s: pose[s] for s in (q.d1, q.d2, q.phi)}})
    scaled = {**point, **{z: scale * point[z] for z in q.MAPPED}}
    assert derived(
        "coordinate d1 of a pose by the mapping parameters", q.d1, scaled
    ) == pytest.approx(pose[q.d1])
    assert derived(
        "coordinate d2 of a pose by the mapping parameters", q.d2, scaled
    ) == pytest.approx(pose[q.d2])


def parameters(pose: tuple[float, float, float]) -> list[float]:
    d1, d2, phi = pose
    point = claims.complete_values({q.d1: mp.mpf(d1), q.d2: mp.mpf(d2), q.phi: mp.radians(phi)})
    return [float(point[z]) for z in q.MAPPED]


def test_mapping_parameters_are_those_of_the_patent() -> None:
    for pose, printed in zip(POSES, PRINTED_Z, strict=True):
        assert parameters(pose) == pytest.approx(printed, abs=6e-5)


def test_the_first_pose_as_printed_does_not_give_them() -> None:
    assert parameters((235, 120, 10)) != pytest.approx(PRINTED_Z[0], abs=1)


def rows(poses: list[dict[Quantity, float]]) -> np.ndarray:
    evaluated = [
        claims.evaluate_row({q.d1: p[q.d1], q.d2: p[q.d2], q.phi: p[q.phi]}) for p in poses
    ]
    return np.array([[float(p[entry]) for entry in q.ENTRIES] for p in evaluated])


def test_dyad_coefficients_lie_in_null_space_of_poses() -> None:
    dyad, poses = circle_poses(seed=3, count=5)
    point = claims.complete_values(dict(dyad))
    p = np.array([float(point[c]) for c in q.COEFFICIENTS])
    matrix = rows(poses)
    assert np.abs(matrix @ p).max() < 1e-13
    assert np.abs(matrix @ (p * [1, 1, 1, 1, 1, -1, 1, 1])).max() > 1e-3
    assert np.linalg.matrix_rank(matrix) == 8 - geometry.zero_eigenvalues()
    eigenvalues = np.linalg.eigvalsh(matrix.T @ matrix)
    assert np.sum(eigenvalues < 1e-12 * eigenvalues.max()) == geometry.zero_eigenvalues()


def test_centre_and_radius_match_circle_of_three_points() -> None:
    """By the determinant of Coxeter's circle through three points."""
    dyad, poses = circle_poses(seed=4, count=3)
    z = [complex(p[q.X], p[q.Y]) for p in poses]
    w = (z[2] - z[0]) / (z[1] - z[0])
    centre = z[0] + (z[1] - z[0]) * (w - abs(w) ** 2) / (2j * w.imag)
    named = claims.complete_values(dict(dyad))
    again = claims.complete_values({s: named[s] for s in q.TABLE.select("a0 a1 a2 a3")})
    assert complex(float(again[q.X_c]), float(again[q.Y_c])) == pytest.approx(centre)
    assert float(again[q.L1]) == pytest.approx(abs(z[0] - centre))


def test_conics_hold_for_null_space_vectors() -> None:
    point = claims.complete_values({s: POINTS[0][s] for vector in q.BASIS for s in vector})
    basis = np.array([[float(point[s]) for s in vector] for vector in q.BASIS])
    rng = np.random.default_rng(5)
    for multiples in rng.normal(size=(4, 3)):
        p = multiples @ basis
        at = {**point, **dict(zip(q.PARAMETERS, multiples, strict=True))}
        assert float(value(geometry.conic_form(q.K1), at)) == pytest.approx(
            p[0] * p[5] + p[1] * p[4] - p[2] * p[3]
        )
        assert float(value(geometry.conic_form(q.K2), at)) == pytest.approx(
            2 * p[0] * p[6] - p[1] * p[3] - p[2] * p[4]
        )


@pytest.mark.parametrize(("first_angle", "pairs"), [(-10, 1), (10, 0)])
def test_real_solutions_of_the_poses(first_angle: float, pairs: int) -> None:
    """Two belong to the first angle with the minus sign; without it, as the pose is printed, there
    are four.
    """
    poses = [(235, 120, first_angle), *POSES[1:]]
    keys = ("x_mm", "y_mm", "phi_deg")
    machine = MachineFile({"pose": [dict(zip(keys, pose, strict=True)) for pose in poses]})
    with mp.workdps(claims.DIGITS):
        assert claims.complex_pairs(claims.pose_rows(machine)) == pairs
    assert 4 - 2 * pairs == real_dyads(poses)


def real_dyads(poses: list[tuple[float, float, float]], starts: int = 300) -> int:
    """Dyads whose hinge keeps one distance in all poses: distinct roots of Newton's method from
    random starts.
    """
    tips = np.array([complex(a, b) for a, b, _ in poses]) / 100
    turns = np.exp(1j * np.radians([c for *_, c in poses]))

    def differences(unknowns: np.ndarray) -> np.ndarray:
        hinge, centre = complex(*unknowns[:2]), complex(*unknowns[2:])
        return np.diff(np.abs(tips + turns * hinge - centre) ** 2)

    dyads: list[np.ndarray] = []
    for start in np.random.default_rng(6).normal(scale=4, size=(starts, 4)):
        root = scipy.optimize.root(differences, start, tol=1e-13)
        neighbours = [r for r in dyads if np.allclose(r, root.x, atol=1e-6)]
        if (
            np.abs(differences(root.x)).max() < 1e-9
            and np.abs(root.x).max() < 1e3
            and not neighbours
        ):
            dyads.append(root.x)
    return len(dyads)


def of_train(**values: float) -> Point:
    names = {"w1": q.w1, "w2": q.w2, "a": q.a, "mean_root": q.mean_root}
    return claims.complete_values({names[name]: mp.mpf(number) for name, number in values.items()})


def test_pitch_curves_roll_and_fill_the_centre_distance() -> None:
    for speed in (-3.0, -0.2, 0.4):
        gears = of_train(w1=1.5, w2=speed, a=0.07, mean_root=0.9)
        for driver, follower in (
            ((q.r1, q.dpsi1), (q.r2, q.dpsi2)),
            ((q.r3, q.dpsi3), (q.r4, q.dpsi4)),
        ):
            arcs = [gears[radius] * gears[rate] for radius, rate in (driver, follower)]
            assert float(arcs[0]) == pytest.approx(float(arcs[1]))
            assert float(gears[driver[0]] + gears[follower[0]]) == pytest.approx(0.07)


def test_ratio_matches_willis_equation() -> None:
    """Willis: rates relative to the carrier stand as in the train with the carrier at rest."""
    gears = of_train(w1=2.0, w2=-1.0, a=0.07, mean_root=0.9)
    assert float(gears[q.i]) == pytest.approx((0 - 2) / (-1 - 2))
    assert float(gears[q.i1] * gears[q.i2]) == pytest.approx(float(gears[q.i]))
    assert float(gears[q.slope] * gears[q.i]) == pytest.approx(-1)


def test_split_closes_the_first_stage_and_with_it_the_second() -> None:
    """For 1/i = 1 + e cos(theta), whose mean root is a complete elliptic integral."""
    e, turn = 0.6, np.linspace(0, 2 * np.pi, 721)
    arm = -e * np.sin(turn)
    curve = scipy.interpolate.CubicSpline(turn, [*arm[:-1], arm[0]], bc_type="periodic")
    mean = 2 / np.pi * np.sqrt(1 + e) * float(mp.ellipe(2 * e / (1 + e)))
    assert float(claims.mean_root(curve)) == pytest.approx(mean, rel=1e-9)
    rates = [of_train(w1=1, w2=-e * np.cos(theta), a=0.07, mean_root=mean) for theta in turn[:-1:6]]
    for share in (q.dpsi2, q.dpsi4):
        assert np.mean([float(r[share]) for r in rates]) == pytest.approx(1, rel=1e-12)
    assert float(rates[0][q.turn2]) == pytest.approx(2 * np.pi)


def test_tip_of_the_train_by_complex_numbers() -> None:
    dyad, poses = circle_poses(seed=7, count=5)
    for pose in poses:
        point = claims.complete_values({**dyad, q.theta: pose[q.theta], q.phi: pose[q.phi]})
        assert float(point[q.d1]) == pytest.approx(pose[q.d1])
        assert float(point[q.d2]) == pytest.approx(pose[q.d2])


def test_reference_is_a_turn_of_the_built_in_train() -> None:
    turn = claims.SUBJECT.reference(6)
    for point in turn:
        assert max(abs(value(e.residual, point)) for e in CLAIMS.values()) < mp.mpf(10) ** -45
    assert [round(float(p[q.theta]), 6) for p in turn] == [
        round(k * np.pi / 3, 6) for k in range(6)
    ]
    assert float(turn[0][q.L2]) == pytest.approx(0.2115459, abs=1e-7)
    assert len({float(p[q.L1]) for p in turn}) == 1
    assert len({float(p[q.i]) for p in turn}) == 6


def test_value_without_derivation_is_refused() -> None:
    with pytest.raises(
        ClaimError,
        match=r"nothing here states 'entry A_j9 of the matrix'; near it: .*'entry A_j",
    ):
        claims.derive_formulas().expr("entry A_j9 of the matrix")
