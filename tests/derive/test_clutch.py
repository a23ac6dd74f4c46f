"""The clutch: its derivation against numeric geometry, closed forms and its paper as printed."""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from derive.dimensions import DimensionError, dimension
from derive.equations import Equation
from derive.papers.shi2021 import PAPER
from derive.quantity import Quantity
from derive.systems import clutch
from derive.systems import clutch_quantities as q

CLAIMS = clutch.claims()
POINTS = [clutch.admissible(random.Random(seed)) for seed in range(6)]
SPECIAL = {"angle between the faces at the least tip distance", "forces on the tooth without slip"}
HOLDS = {
    "=": lambda v: abs(v) < mpmath.mpf(10) ** -40,
    "<": lambda v: v < 0,
    "<=": lambda v: v <= 0,
    ">": lambda v: v > 0,
    ">=": lambda v: v >= 0,
}


def value(expr: sp.Expr, point: clutch.Values) -> mpmath.mpf:
    symbols = sorted(expr.free_symbols, key=str)
    with mpmath.workdps(60):
        return mpmath.mpf(sp.lambdify(symbols, expr, "mpmath")(*(point[s] for s in symbols)))


def size(expr: sp.Expr, point: clutch.Values) -> mpmath.mpf:
    return max((abs(value(term, point)) for term in sp.Add.make_args(expr)), default=mpmath.mpf(1)) or mpmath.mpf(1)


def derived(claim: str) -> sp.Expr:
    """The expression that a derived definition gives."""
    equation = CLAIMS[claim]
    return equation.defines - equation.residual


def number(claim: str, **known: float) -> float:
    """The same in floating point, symbols given by name."""
    expr = derived(claim)
    return float(sp.lambdify(sorted(expr.free_symbols, key=str), expr, "numpy")(**known))


def broken(claims: dict[str, Equation], point: clutch.Values) -> set[str]:
    return {c for c, e in claims.items() if not HOLDS[e.relation](value(e.residual, point) / size(e.residual, point))}


def differing(equations: dict[str, Equation]) -> list[str]:
    """Numbers of the printed equations that are not the derived ones at 50 digits or in their relation."""
    found = []
    for number_, printed in equations.items():
        ours = CLAIMS.get(printed.claims)
        if ours is None or printed.legibility == "lost":
            continue
        gap = printed.residual - ours.residual
        same = all(abs(value(gap, p)) < mpmath.mpf(10) ** -50 * size(printed.residual, p) for p in POINTS)
        if not (same and printed.relation == ours.relation):
            found.append(number_)
    return found


def test_every_symbol_is_described() -> None:
    equations = [*CLAIMS.values(), *PAPER.equations.values()]
    symbols = set().union(*(e.residual.free_symbols for e in equations))
    assert [s for s in symbols if not isinstance(s, Quantity)] == []
    assert not {s.name for s in vars(q).values() if isinstance(s, Quantity)} - {s.name for s in symbols}


def test_every_derived_equation_has_a_dimension() -> None:
    for equation in CLAIMS.values():
        dimension(equation.residual)


def test_printed_equations_that_mix_dimensions() -> None:
    mixed = []
    for number_, equation in PAPER.equations.items():
        try:
            dimension(equation.residual)
        except DimensionError:
            mixed.append(number_)
    assert mixed == ["9"]


def test_every_claim_of_the_paper_is_derived() -> None:
    claims = {e.claims for e in PAPER.equations.values() if not str(e.claims).startswith("definition: ")}
    assert claims <= CLAIMS.keys()
    assert all(claim == equation.number for claim, equation in CLAIMS.items())


def test_the_derivation_knows_no_paper() -> None:
    for module in Path(clutch.__file__).parent.glob("clutch*.py"):
        assert "derive.papers" not in module.read_text(encoding="utf-8")


def test_printed_equations_that_differ() -> None:
    assert differing(PAPER.equations) == [
        "contact", "Y_C", "A1", "semi-major", "semi-minor", "fillet", "curvature", "4b", "5a", "5b", "5c", "6", "7a",
        "8b", "9", "B1", "B2", "12", "13b", "slip", "no slip",
    ]  # fmt: skip


@pytest.mark.parametrize("number_", ["1b", "2a", "A2", "3b", "7b", "10", "11", "14"])
def test_a_tampered_sign_is_noticed(number_: str) -> None:
    equation = PAPER.equations[number_]
    last = sp.Add.make_args(sp.expand(equation.residual))[-1]
    copy = replace(equation, residual=equation.residual - 2 * last)
    assert number_ in differing({number_: copy})


def test_a_reversed_relation_is_noticed() -> None:
    assert differing({"3a": replace(PAPER.equations["3a"], relation="<=")}) == ["3a"]


@pytest.mark.parametrize("point", POINTS)
def test_admissible_points_obey_the_derivation(point: clutch.Values) -> None:
    assert broken(CLAIMS, point) == SPECIAL
    needed = set().union(*(e.residual.free_symbols for e in (*CLAIMS.values(), *PAPER.equations.values())))
    assert {s.name for s in needed - point.keys()} == {"unread"}


def test_special_states_obey_their_equations() -> None:
    """Faces at the least tip distance; balance of the forces along the surface when F_y is what holds the tooth."""
    point = dict(POINTS[0])
    with mpmath.workdps(60):
        point[q.b1] -= value(CLAIMS["tooth tips go round the shaft"].residual, point)
        point[q.xi] = value(derived("angle between the faces of a tooth"), point)
        point[q.F_y] -= value(CLAIMS["forces on the tooth without slip"].residual, point)
        assert abs(value(derived("acceleration of the slip"), point)) < mpmath.mpf(10) ** -45
    assert SPECIAL.isdisjoint(broken({c: CLAIMS[c] for c in SPECIAL}, point))


def test_the_reference_cycle_obeys_the_derivation() -> None:
    """What it breaks are conditions: the paper's tip distance, rounded down, and no slip at either end of contact."""
    for i, point in enumerate(clutch.reference(5)):
        unmet = broken(CLAIMS, point) - SPECIAL
        assert unmet - {"load at which the tooth slips"} == {"tooth tips go round the shaft"}, i
        assert (point[q.N] > 1e-6) == (i < 4)


def test_a_tampered_derivation_is_noticed() -> None:
    equation = CLAIMS["contact load over time"]
    tampered = {"x": replace(equation, residual=equation.residual.subs(q.m1, 2 * q.m1))}
    assert broken(tampered, POINTS[0]) == {"x"}


# geometry


def pose(theta: float) -> np.ndarray:
    """Vertices of the pentagon of width 1, C first, found from the constraints alone: by bisection for A's place."""
    rho, h = 0.5 / np.sin(np.deg2rad(72)), 0.5
    angle = np.deg2rad(18) - theta
    shape = rho * np.exp(1j * (angle + np.deg2rad(72) * np.arange(5)))
    normal = np.exp(1j * np.deg2rad(150))

    def off(u: float) -> float:
        moved = shape + u + 1j * (h - shape[2].imag)
        return (moved[3] * normal.conjugate()).real - h

    u = brentq(off, -2, 2, xtol=1e-15)
    return shape + u + 1j * (h - shape[2].imag)


CORNER = np.deg2rad(np.linspace(66, 90, 1000))


def test_vertex_path_against_constrained_poses() -> None:
    side = 1 / np.sqrt(3)
    A1, A2 = number("coefficient of the sine in the path of C"), number("coefficient of the cosine in the path of C")
    for theta in CORNER[::20]:
        vertices = pose(theta)
        known = {"R": 1.0, "a": side, "theta": theta}
        assert number("path of C, x", A1=A1, A2=A2, **known) == pytest.approx(vertices[0].real, abs=1e-12)
        assert number("path of C, y", **known) == pytest.approx(vertices[0].imag, abs=1e-12)
        assert number("vertex A while A and B slide", **known) == pytest.approx(vertices[2].real, abs=1e-12)


def test_ellipse_against_constrained_poses() -> None:
    centre = complex(number("centre of the ellipse, x", R=1.0), number("centre of the ellipse, y", R=1.0))
    s1, s2 = number("semi-major axis of the ellipse", R=1.0), number("semi-minor axis of the ellipse", R=1.0)
    x_F = number("focus of the ellipse, x", R=1.0)
    focus = complex(x_F, number("line of the foci", x_F=x_F))
    other = 2 * centre - focus
    sums = np.array([abs(p - focus) + abs(p - other) for p in (pose(t)[0] for t in CORNER)])
    assert np.abs(sums - 2 * s1).max() < 1e-12
    assert abs(focus - centre) ** 2 == pytest.approx(s1**2 - s2**2, abs=1e-14)


def test_semi_axes_against_cardan_motion() -> None:
    """A, B and the corner lie on a circle that rolls in one twice as large: semi-axes are distance +- its radius."""
    vertices, corner = pose(np.deg2rad(80)), complex(-1 / np.sqrt(12), 0.5)
    (ax, ay), (bx, by), (cx, cy) = ((p.real, p.imag) for p in (vertices[2], vertices[3], corner))
    matrix = 2 * np.array([[ax - bx, ay - by], [ax - cx, ay - cy]])
    centre = np.linalg.solve(matrix, [ax**2 + ay**2 - bx**2 - by**2, ax**2 + ay**2 - cx**2 - cy**2])
    radius = np.hypot(ax - centre[0], ay - centre[1])
    reach = abs(vertices[0] - complex(*centre))
    assert number("semi-major axis of the ellipse", R=1.0) == pytest.approx(reach + radius, abs=1e-13)
    assert number("semi-minor axis of the ellipse", R=1.0) == pytest.approx(abs(reach - radius), abs=1e-13)


def test_curvature_where_the_path_leaves_the_side() -> None:
    step = 1e-4
    before, at, after = (pose(np.pi / 2 + k * step)[0] for k in (-1, 0, 1))
    a, b, c = abs(before - at), abs(after - at), abs(after - before)
    area = abs(((at - before).conjugate() * (after - before)).imag) / 2
    assert number("curvature of the path where it leaves the side", R=1.0) == pytest.approx(
        a * b * c / (4 * area), rel=1e-6
    )


def reach(point: complex, fillet: float) -> float:
    """Signed distance of a point from a hexagon of width 1 with rounded corners."""
    inner = (1 - 2 * fillet) / np.sqrt(3)
    corners = inner * np.exp(1j * np.pi / 3 * np.arange(7))
    inside = all(((corners[i + 1] - corners[i]).conjugate() * (point - corners[i])).imag > 0 for i in range(6))
    gaps = []
    for start, end in pairwise(corners):
        share = ((point - start) * (end - start).conjugate()).real / abs(end - start) ** 2
        gaps.append(abs(point - start - min(max(share, 0), 1) * (end - start)))
    return (-min(gaps) if inside else min(gaps)) - fillet


@pytest.mark.parametrize(("factor", "clears"), [(1.0, True), (1.3, True), (0.98, False), (0.5, False)])
def test_least_fillet(factor: float, clears: bool) -> None:
    residual = CLAIMS["fillet that the tooth tips clear"].residual
    limit = float(-residual.subs({q.r: 0, q.a1: 1 / sp.sqrt(3)}))
    gap = min(reach(pose(t)[0], factor * limit) for t in CORNER)
    assert bool(gap > -1e-9) == clears


@pytest.mark.parametrize("degrees", [67, 72, 77, 79, 85, 89])
def test_overlap_against_support_function(degrees: float) -> None:
    vertices, normal = pose(np.deg2rad(degrees)), np.exp(1j * np.deg2rad(30))
    outline = [vertices]
    for i, v in enumerate(vertices):
        start, end = np.angle(vertices[(i + 2) % 5] - v), np.angle(vertices[(i + 3) % 5] - v)
        outline.append(v + np.exp(1j * (start + np.linspace(0, (end - start) % (2 * np.pi), 20001))))
    support = (np.concatenate(outline) * normal.conjugate()).real
    e_3 = number("overlap with the third pair of sides", R=1.0, theta=np.deg2rad(degrees))
    assert e_3 == pytest.approx(support.max() - 0.5, abs=1e-8)
    assert -e_3 == pytest.approx(-support.min() - 0.5, abs=1e-8)
    assert abs(e_3) > 1e-4


def test_teeth_against_points() -> None:
    a1, r, b1 = 0.02 / np.sqrt(3), 0.0048, 0.0107
    least = float(-CLAIMS["tooth tips go round the shaft"].residual.subs({q.b1: 0, q.a1: a1}))
    tips = least * np.exp(1j * np.deg2rad(72) * np.arange(5))
    assert max(abs(s - t) for s in tips for t in tips) == pytest.approx(0.02, rel=1e-12)
    roots = float(-CLAIMS["tooth roots clear the shaft's corners"].residual.subs({q.b2: 0, q.a1: a1, q.r: r}))
    outermost = brentq(lambda d: reach(complex(d / 0.02, 0), r / 0.02), 0.005, 0.012, xtol=1e-15)
    assert roots == pytest.approx(outermost, rel=1e-12)
    tip, foot = complex(np.sqrt(b1**2 - 0.01**2), 0.01), complex(0, 0.01)
    half = abs(np.angle((foot - tip) / -tip))
    assert number("angle between the faces of a tooth", a1=a1, b1=b1) == pytest.approx(2 * half, rel=1e-12)


def test_least_travel_against_the_taper() -> None:
    """The side of the hole, moved by the travel, lies one outline radius from the axis."""
    a, phi = 0.017, np.deg2rad(20)
    b = number("largest outline radius of the body", a=a)
    travel = number("least travel of the sleeve", a=a, b=b, phi=phi)
    assert b == pytest.approx(np.sqrt(3) * a * abs(pose(1.3) - pose(1.3).mean()).max(), rel=1e-12)
    assert np.sqrt(3) / 2 * a + travel * np.tan(phi) == pytest.approx(b, rel=1e-12)


def test_sleeve_forces_against_projection() -> None:
    phi, force = 0.3, 20.0
    surface = np.array([np.cos(phi), np.sin(phi)]), np.array([np.sin(phi), -np.cos(phi)])
    along, across = (float(np.array([force, 0]) @ s) for s in surface)
    known = {q.F1: force, q.F2: 0, q.phi: phi, q.f: 0, q.F_N: 0}
    assert float(CLAIMS["sleeve slides along the taper"].residual.subs(known)) == pytest.approx(along)
    assert float(CLAIMS["sleeve on the taper, force across it"].residual.subs(known)) == pytest.approx(across)


# linkage


def test_crank_gear_rolls_on_the_rack() -> None:
    """Equal arcs on both pitch circles; the link adds its own turn."""
    k, gamma, alpha = 0.3, np.deg2rad(85), np.deg2rad(25)
    arc = alpha - np.deg2rad(5)
    relative = number("rotation of the crank gear relative to the link", k=k, gamma=gamma, alpha=alpha)
    assert relative * k == pytest.approx(arc, rel=1e-13)
    assert number("rotation of the crank gear with the link", k=k, gamma=gamma, alpha=alpha) == pytest.approx(
        relative + arc, rel=1e-13
    )
    assert number("rotation of the crank gear with the link", k=k, gamma=gamma, alpha=np.deg2rad(4)) == 0


def test_a_full_turn_of_the_crank_gear_counts_its_teeth() -> None:
    claim = "rotation of the crank gear for a number of teeth"
    assert number(claim, n=14.0, m=0.002, r_A=0.014) == pytest.approx(2 * np.pi, rel=1e-14)


def test_crank_against_closed_triangles() -> None:
    crank, rod, start, travel = 15.0, 44.8, 40.0, 5.7

    def angle(distance: float) -> float:
        return brentq(lambda s: abs(distance - crank * np.exp(1j * s)) - rod, 0, np.pi, xtol=1e-15)

    turned = number("rotation of the crank for the travel of the sleeve", l_AB=crank, l_BC=rod, l_AC=start, c=travel)
    assert turned == pytest.approx(angle(start) - angle(start + travel), rel=1e-12)


# engagement

SHAFT = {"E": 206e9, "I": 9.6e-9, "rho": 7850.0, "S": 3.46e-4, "l": 0.06}


def test_mode_is_that_of_a_simply_supported_beam_twice_as_long() -> None:
    """Its frequency is (pi/L)^2 sqrt(EI/(rho S)), exactly."""
    E, I, rho, S, l = SHAFT.values()  # noqa: E741
    mass = number("modal mass of the shaft", rho=rho, S=S, l=l)
    stiffness = number("modal stiffness of the shaft", E=E, I=I, l=l)
    assert np.sqrt(stiffness / mass) == pytest.approx((np.pi / (2 * l)) ** 2 * np.sqrt(E * I / (rho * S)), rel=1e-13)
    assert mass == pytest.approx(quad(lambda x: rho * S * np.sin(np.pi * x / (2 * l)) ** 2, 0, l)[0], rel=1e-12)


def test_contact_against_integration() -> None:
    """Newton's law for body and mode, integrated: deflection, load and largest load."""
    m1, F_M, speed, r1 = 0.35, 114.0, 4.71, 0.0105
    E, I, rho, S, l = SHAFT.values()  # noqa: E741
    mass, stiffness = rho * S * l / 2, np.pi**4 * E * I / (32 * l**3)
    times = np.linspace(0, 5e-4, 2001)
    solution = solve_ivp(
        lambda _, s: [s[1], (F_M - stiffness * s[0]) / (mass + m1)], (0, 5e-4), [0, speed * r1], t_eval=times,
        rtol=1e-11, atol=1e-16, method="DOP853",
    )  # fmt: skip
    load = F_M - m1 * (F_M - stiffness * solution.y[0]) / (mass + m1)
    known = {"m1": m1, "m2": rho * S * l}
    B1 = number("circular frequency in contact", E=E, I=I, l=l, **known)
    B2 = number("acceleration by the driving force", F_M=F_M, **known)
    start = {"B1": B1, "B2": B2, "Delta_omega": speed, "r1": r1}
    for i in range(0, 2001, 100):
        t = float(times[i])
        assert number("deflection at the contact over time", t=t, **start) == pytest.approx(
            solution.y[0, i], abs=1e-14, rel=1e-7
        )
        assert number("contact load over time", t=t, F_M=F_M, m1=m1, **start) == pytest.approx(load[i], rel=1e-6)
    largest = number("largest contact load", E=E, I=I, l=l, F_M=F_M, Delta_omega=speed, r1=r1, **known)
    assert largest == pytest.approx(load.max(), rel=1e-5)
    assert largest > load.max() * (1 - 1e-9)


def test_section_of_a_hexagon() -> None:
    """Area and second moment by Simpson's integral of the width across it."""
    heights = np.linspace(-np.sqrt(3) / 2, np.sqrt(3) / 2, 200001)
    width = 2 - np.abs(heights) * 2 / np.sqrt(3)
    assert number("section of the shaft", a1=1.0) == pytest.approx(np.trapezoid(width, heights), rel=1e-9)
    assert number("second moment of the shaft", a1=1.0) == pytest.approx(
        np.trapezoid(width * heights**2, heights), rel=1e-9
    )


def test_slip_against_vectors() -> None:
    """Reactions, load and friction as vectors; the tooth moves along the surface only."""
    theta0, F_y, N, f0, m1 = 0.6, 4.0, 60.0, 5.0, 0.35
    along = np.array([np.cos(theta0), -np.sin(theta0)])
    across = np.array([np.sin(theta0), np.cos(theta0)])
    a0 = number("acceleration of the slip", theta0=theta0, F_y=F_y, N=N, f0=f0, m1=m1)
    F_x = (N - F_y * across[1]) / across[0]
    force = np.array([F_x, F_y]) - N * across - f0 * along
    assert force == pytest.approx(m1 * a0 * along, abs=1e-12)
    known = {q.theta0: theta0, q.F_x: F_x, q.F_y: F_y, q.N: N, q.f0: f0, q.m1: m1, q.a0: a0}
    for claim in ("forces on the tooth across the surface", "forces on the tooth along the surface"):
        assert float(CLAIMS[claim].residual.subs(known)) == pytest.approx(0, abs=1e-12)
    assert (float(CLAIMS["load at which the tooth slips"].residual.subs(known)) > 0) == (a0 > 0)
