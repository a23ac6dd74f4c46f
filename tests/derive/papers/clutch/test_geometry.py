"""The clutch's polygon, teeth and taper against numeric geometry and closed forms."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

from derive.papers.clutch import quantities as q
from tests.support.clutch import CLAIMS, number


def pose(theta: float) -> np.ndarray:
    """Vertices of the pentagon of width 1, C first, found from the constraints alone: by bisection
    for A's place.
    """
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
    inside = all(
        ((corners[i + 1] - corners[i]).conjugate() * (point - corners[i])).imag > 0
        for i in range(6)
    )
    gaps = []
    for start, end in pairwise(corners):
        share = ((point - start) * (end - start).conjugate()).real / abs(end - start) ** 2
        gaps.append(abs(point - start - min(max(share, 0), 1) * (end - start)))
    return (-min(gaps) if inside else min(gaps)) - fillet


@pytest.mark.parametrize(
    ("factor", "clears"), [(1.0, True), (1.3, True), (0.98, False), (0.5, False)]
)
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
        outline.append(
            v + np.exp(1j * (start + np.linspace(0, (end - start) % (2 * np.pi), 20001)))
        )
    support = (np.concatenate(outline) * normal.conjugate()).real
    e_3 = number("overlap with the third pair of sides", R=1.0, theta=np.deg2rad(degrees))
    assert e_3 == pytest.approx(support.max() - 0.5, abs=1e-8)
    assert -e_3 == pytest.approx(-support.min() - 0.5, abs=1e-8)
    assert abs(e_3) > 1e-4


def test_teeth_against_points() -> None:
    a1, r, b1 = 0.02 / np.sqrt(3), 0.0048, 0.0107
    smallest = float(-CLAIMS["tooth tips go round the shaft"].residual.subs({q.b1: 0, q.a1: a1}))
    tips = smallest * np.exp(1j * np.deg2rad(72) * np.arange(5))
    assert max(abs(s - t) for s in tips for t in tips) == pytest.approx(0.02, rel=1e-12)
    roots = float(
        -CLAIMS["tooth roots clear the shaft's corners"].residual.subs({q.b2: 0, q.a1: a1, q.r: r})
    )
    outermost = brentq(lambda d: reach(complex(d / 0.02, 0), r / 0.02), 0.005, 0.012, xtol=1e-15)
    assert roots == pytest.approx(outermost, rel=1e-12)
    tip, foot = complex(np.sqrt(b1**2 - 0.01**2), 0.01), complex(0, 0.01)
    half = abs(np.angle((foot - tip) / -tip))
    assert number("angle between the faces of a tooth", a1=a1, b1=b1) == pytest.approx(
        2 * half, rel=1e-12
    )


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
    axial_force, across = (float(np.array([force, 0]) @ s) for s in surface)
    values = {q.F1: force, q.F2: 0, q.phi: phi, q.f: 0, q.F_N: 0}
    assert float(CLAIMS["sleeve slides along the taper"].residual.subs(values)) == pytest.approx(
        axial_force
    )
    assert float(
        CLAIMS["sleeve on the taper, force across it"].residual.subs(values)
    ) == pytest.approx(across)
