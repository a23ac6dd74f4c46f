"""Seedling pick-up: the derivation against independent geometry, and the paper's formulas against
the derivation.
"""

import random
from collections.abc import Iterator, Mapping
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
import scipy
import sympy as sp

from derive.formulas import evaluate_expression as formula_value
from derive.papers import yu2023
from derive.papers.pickup import quantities as q
from derive.papers.pickup import subject as claims
from derive.papers.pickup import subject as pickup_points
from derive.quantity import Quantity
from tests.support.late import LateDict, LateList

CLAIMS = LateDict(
    lambda: {str(claim): equation for claim, equation in claims.derive_formulas().equations.items()}
)
FORMULAS = LateDict(
    lambda: {
        claim: (e.defines, e.defines - e.residual)
        for claim, e in CLAIMS.items()
        if e.defines is not None
    }
)
PRINTED = {number: e for number, e in yu2023.PAPER.equations.items() if e.legibility != "lost"}


def meant(number: str) -> dict[sp.Symbol, sp.Expr]:
    """What the printed symbols of an equation stand for, in the reading that is kindest to the
    paper.
    """
    kindest = (
        question.readings[0].printed
        for question in yu2023.PAPER.questions
        if number in question.numbers
    )
    return {
        k: v for part in (yu2023.PAPER.readings.get(number, {}), *kindest) for k, v in part.items()
    }


READ = {n: replace(e, residual=e.residual.xreplace(meant(n))) for n, e in PRINTED.items()}
POINTS = LateList(lambda: [claims.SUBJECT.admissible(random.Random(seed)) for seed in range(16)])
TURN = LateList(lambda: claims.SUBJECT.reference(24))
SMALL = mp.mpf(10) ** -50
Point = Mapping[Quantity, mp.mpf]


@pytest.fixture(autouse=True)
def _digits() -> Iterator[None]:
    with mp.workdps(60):
        yield


def value(expr: sp.Expr, point: Point) -> mp.mpf:
    return formula_value(sp.sympify(expr), point)


def derived(claim: str, point: Point) -> float:
    return float(value(FORMULAS[claim][1], point))


def vector(length: mp.mpf, angle: mp.mpf) -> mp.mpc:
    return length * mp.expj(angle)


def same_direction(angle: mp.mpf, vector: mp.mpc) -> bool:
    return abs(mp.expj(angle) - vector / abs(vector)) < SMALL


def test_every_claim_holds_at_every_point() -> None:
    for point in (*POINTS, *TURN):
        third = point[q.x_S] < 0 and point[q.y_S] < 0
        for claim, equation in CLAIMS.items():
            residual = value(equation.residual, point)
            if equation.relation != "=":
                assert (residual > 0) == (equation.relation == ">"), claim
            elif "quadrant" not in claim or third == ("third" in claim):
                assert abs(residual) < SMALL, claim


def test_the_tip_comes_to_every_quadrant() -> None:
    assert {(p[q.x_S] > 0, p[q.y_S] > 0) for p in POINTS} == {
        (x, y) for x in (True, False) for y in (True, False)
    }


def test_printed_direction_fails_only_in_second_quadrant() -> None:
    printed = {
        third: -PRINTED[f"phi4, {name}"].residual + q.phi4
        for third, name in ((True, "third quadrant"), (False, "other quadrants"))
    }
    wrong = set()
    for point in POINTS:
        x, y = point[q.x_S], point[q.y_S]
        direction = value(printed[bool(x < 0 and y < 0)], point)
        if not same_direction(direction, mp.mpc(x, y)):
            wrong.add((x > 0, y > 0))
    assert wrong == {(False, True)}


@pytest.mark.parametrize("points", [POINTS, TURN], ids=["random", "cycle"])
def test_triangles_close(points: list[Point]) -> None:
    """By complex numbers, from distances and directions that the derivation does not use
    together.
    """
    for p in points:
        o1, m1, s = (
            mp.mpc(p[x], p[y]) for x, y in ((q.x_O1, q.y_O1), (q.x_M1, q.y_M1), (q.x_S, q.y_S))
        )
        assert abs(o1 - vector(p[q.L1], p[q.phi5])) < SMALL
        assert abs(s - o1 - vector(p[q.L2], p[q.phi5] + mp.pi - p[q.phi1])) < SMALL
        assert abs(abs(m1) - p[q.a1]) < SMALL
        assert abs(abs(o1 - m1) - p[q.a2]) < SMALL
        assert mp.arg(m1 / o1) > 0
        assert abs(mp.arg(m1 / o1) - p[q.beta1]) < SMALL
        assert abs(abs(mp.arg((o1 - m1) / -m1)) - p[q.gamma]) < SMALL
        assert abs(abs(mp.arg(o1 / (o1 - m1))) - p[q.U1]) < SMALL
        assert same_direction(p[q.W1], o1 - m1)
        assert same_direction(p[q.Z1], s - o1)
        assert abs(abs(s) - p[q.L3]) < SMALL
        assert same_direction(p[q.phi6], o1 / s)
        assert same_direction(p[q.phi1], -o1 / (s - o1))
        assert same_direction(p[q.phi4], s)


def test_printed_carrier_rotates_planet_too_far() -> None:
    """Its O1 keeps the distance L1 but lies twice beta1 ahead."""
    for p in POINTS:
        printed = value(q.W1 - READ["W1"].residual, p)
        o1 = vector(p[q.a1], p[q.Y1]) + vector(p[q.a2], printed)
        assert abs(abs(o1) - p[q.L1]) < SMALL
        assert same_direction(p[q.phi5] + 2 * p[q.beta1], o1)


def test_velocities_are_those_of_differences() -> None:
    for p in POINTS:
        arm = p[q.omega] / p[q.iZ]

        def at(t: mp.mpf, p: Point = p, arm: mp.mpf = arm) -> mp.mpc:
            phi5, phi1 = p[q.phi5] + p[q.omega] * t, p[q.phi1] + arm * t
            return vector(p[q.L1], phi5) + vector(p[q.L2], phi5 + mp.pi - phi1)

        step = mp.mpf(10) ** -18
        assert (
            abs((at(step) - at(-step)) / (2 * step) - mp.mpc(p[q.vx_S], p[q.vy_S]))
            < mp.mpf(10) ** -30
        )
        assert (
            abs(mp.mpc(p[q.vx_O1], p[q.vy_O1]) - 1j * p[q.omega] * mp.mpc(p[q.x_O1], p[q.y_O1]))
            < SMALL
        )
        assert (
            abs(mp.mpc(p[q.vx_M1], p[q.vy_M1]) - 1j * p[q.omega] * mp.mpc(p[q.x_M1], p[q.y_M1]))
            < SMALL
        )


def test_extremes_of_the_distance() -> None:
    for p in POINTS:
        angles = np.linspace(np.pi, 3 * np.pi, 4001)[:-1]
        arm = float(p[q.L1]) - float(p[q.L2]) * np.exp(-1j * angles)
        far, closest = np.argmax(abs(arm)), np.argmin(abs(arm))
        assert angles[far] == pytest.approx(float(p[q.phi1_far]))
        assert angles[closest] == pytest.approx(float(p[q.phi1_near]))
        assert [abs(arm[far]), abs(arm[closest])] == pytest.approx(
            [float(p[q.L3_max]), float(p[q.L3_min])]
        )
        assert [abs(np.angle(arm[i])) for i in (far, closest)] == pytest.approx(
            [float(p[q.phi6_far]), float(p[q.phi6_near])]
        )


def test_pitch_curves_roll_and_fill_the_centre_distance() -> None:
    for p in (*POINTS, *TURN):
        assert abs(p[q.R1] * p[q.dphi5] - p[q.R2] * p[q.dphi2]) < SMALL
        assert abs(p[q.R1] + p[q.R2] - p[q.a1]) < SMALL
        assert p[q.x1] ** 2 + p[q.y1] ** 2 == pytest.approx(p[q.R1] ** 2)
        assert p[q.x2] ** 2 + p[q.y2] ** 2 == pytest.approx(p[q.R2] ** 2)


def test_curvatures_obey_euler_and_savary() -> None:
    """1/rho1 + 1/rho2 = (1/R1 + 1/R2) sin(mu), mu between radius and tangent."""
    for p in (*POINTS, *TURN):
        mu = mp.atan2(p[q.R1], p[q.dR1])
        radii = 1 / p[q.R1] + 1 / p[q.R2]
        assert abs(1 / p[q.rho1] + 1 / p[q.rho2] - radii * mp.sin(mu)) < SMALL * 1000
        assert abs(1 / p[q.rho1] - 1 / p[q.rho2] - radii * mp.sin(mu)) > mp.mpf(10) ** -6


def test_cycle_curvature_matches_circle_of_three_points() -> None:
    fine = [
        pickup_points.complete_values(claims.derive_formulas(), base)
        for base in pickup_points.compute_cycle(claims.derive_formulas(), 900)[40:43]
    ]
    a, b, c = (complex(p[q.x1], p[q.y1]) for p in fine)
    area = ((b - a).conjugate() * (c - a)).imag / 2
    assert abs(b - a) * abs(c - b) * abs(a - c) / (4 * area) == pytest.approx(
        float(fine[1][q.rho1]), rel=1e-4
    )


def test_circular_contact_ratio_matches_textbook() -> None:
    """External spur pair, ISO 21771: both tip circles on the base circles, less the centre
    distance.
    """
    for p in POINTS:
        r = [float(p[s]) for s in (q.rho1, q.rho2)]
        tips = [
            radius + float(p[ha] * p[q.m]) for radius, ha in zip(r, (q.ha1, q.ha2), strict=True)
        ]
        angle, pitch = float(p[q.alpha0]), np.pi * float(p[q.m])
        reach = sum(
            np.sqrt(t**2 - (radius * np.cos(angle)) ** 2) for t, radius in zip(tips, r, strict=True)
        )
        ratio = (reach - sum(r) * np.sin(angle)) / (pitch * np.cos(angle))
        assert float(p[q.epsilon]) == pytest.approx(ratio)


def test_contact_ratio_of_the_helical_pair() -> None:
    """Tangents of the tip's pressure angles plus overlap; at the built-in numbers near the printed
    1.9358.
    """
    for p in (*POINTS, TURN[0]):
        z, mn, beta = [float(p[q.z_1]), float(p[q.z_2])], float(p[q.m_n]), float(p[q.beta])
        at = np.arctan(np.tan(float(p[q.alpha_n])) / np.cos(beta))
        radii = [mn * teeth / np.cos(beta) / 2 for teeth in z]
        tips = [np.arccos(r * np.cos(at) / (r + float(p[q.ha_n]) * mn)) for r in radii]
        transverse = sum(t * (np.tan(tip) - np.tan(at)) for t, tip in zip(z, tips, strict=True)) / (
            2 * np.pi
        )
        overlap = float(p[q.B]) * np.sin(beta) / (np.pi * mn)
        assert float(p[q.epsilon_h]) == pytest.approx(transverse + overlap)
    assert float(TURN[0][q.epsilon_h]) == pytest.approx(1.9358, abs=2e-4)


def test_centre_distance_as_printed_is_twice_too_long() -> None:
    at = TURN[0]
    assert 8 < np.degrees(float(at[q.beta])) < 20
    assert derived("centre distance of the helical pair", at) == pytest.approx(44.6e-3)
    assert float(value(q.a2 - PRINTED["14"].residual, at)) == pytest.approx(89.2e-3)


@pytest.mark.parametrize(
    ("slope", "moved"), [(q.epsilon_ha, (q.ha1, q.ha2)), (q.epsilon_m, (q.m,))]
)
def test_slopes_of_the_contact_ratio(slope: Quantity, moved: tuple[Quantity, ...]) -> None:
    for p in POINTS[:4]:
        step, ends = mp.mpf(10) ** -18, []
        for sign in (1, -1):
            keep = {s: v for s, v in p.items() if s not in (q.g1, q.g2, q.epsilon)}
            shifted = keep | {s: p[s] + sign * step for s in moved}
            ends.append(claims.derive_formulas().followed(shifted)[q.epsilon])
        assert abs((ends[0] - ends[1]) / (2 * step) - p[slope]) < mp.mpf(10) ** -25


def test_spline_is_the_periodic_cubic_through_the_value_points() -> None:
    """SciPy's, through points of the path that the law gives."""
    far = np.radians(40)
    points = [complex(*map(float, (p[q.q_i], p[q.u_i]))) for p in claims.SUBJECT.reference(25)]
    assert points[0].real == pytest.approx((93.3377 + 163) * np.cos(far) / 1000)
    path = [tip_of_the_law(2 * np.pi * j / 25) for j in range(26)]
    chords = np.cumsum([0, *np.abs(np.diff(path))]) / np.sum(np.abs(np.diff(path)))
    curve = scipy.interpolate.CubicSpline(
        chords, [*np.real(path[:-1]), path[0].real], bc_type="periodic"
    )
    for j, p in ((int(25 * float((p[q.phi5] - p[q.phi50]) / (2 * mp.pi))), p) for p in TURN):
        assert float(p[q.p_u]) == pytest.approx(
            float(curve(chords[j] + float(p[q.u] - p[q.u_i]))), abs=1e-12
        )
        assert float(p[q.q_i]) == pytest.approx(path[j].real, abs=1e-12)


def tip_of_the_law(t: float) -> complex:
    """The tip over the carrier's angle from the farthest point, by quadrature of the arm's
    slope.
    """
    start, end, p = np.radians(210), np.radians(270), 0.3549389251

    def plain(a: float, b: float) -> float:
        return float(scipy.integrate.quad(lambda x: 1 + p * np.cos(x), a, b)[0])

    c = 2 * np.pi / (plain(0, start) + plain(end, 2 * np.pi))
    assert c == pytest.approx(1.1606603790, abs=1e-9)
    phi1 = np.pi + c * (plain(0, min(t, start)) + plain(end, max(t, end)))
    phi5 = np.radians(40) + t
    return complex(0.0933377 * np.exp(1j * phi5) - 0.163 * np.exp(1j * (phi5 - phi1)))


def test_the_cycle_follows_the_law() -> None:
    assert len(TURN) == 20
    for p in TURN:
        t = float(p[q.phi5] - p[q.phi50])
        assert not 210 <= np.degrees(t) <= 270
        assert complex(p[q.x_S], p[q.y_S]) == pytest.approx(tip_of_the_law(t), abs=1e-12)


@pytest.mark.parametrize("n", [4, 27])
def test_knots_and_range_are_those_of_a_spline(n: int) -> None:
    """SciPy's basis functions need that many knots and sum to one only between those two."""
    counts = {q.n: mp.mpf(n), q.k: mp.mpf(3)}
    last, first, end = (
        int(derived(f"index of the {name}", counts))
        for name in ("last knot", "knot where the curve begins", "knot where the curve ends")
    )
    knots = np.cumsum(np.random.default_rng(1).uniform(0.5, 1.5, last + 1))
    curve = scipy.interpolate.BSpline(knots, np.ones(n + 1), 3, extrapolate=False)
    middles = (knots[:-1] + knots[1:]) / 2
    basis = [
        scipy.interpolate.BSpline.basis_element(knots[j : j + 5], extrapolate=False)
        for j in range(n + 1)
    ]
    sums = np.sum([np.nan_to_num(b(middles)) for b in basis], axis=0)
    assert [j for j, total in enumerate(sums) if total == pytest.approx(1)] == list(
        range(first, end)
    )
    assert curve(middles[first]) == pytest.approx(1)


def test_an_unreachable_symbol_is_named() -> None:
    base = pickup_points.random_base(random.Random(0))
    with pytest.raises(ValueError, match=r"nothing leads to .*L3"):
        pickup_points.complete_values(
            claims.derive_formulas(), {s: v for s, v in base.items() if s != q.L1}
        )
