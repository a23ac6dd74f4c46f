"""Profiles that meet in the clutches: distances against an independent geometry library."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

from planter.clutch.engage import profiles
from planter.kernels import Kernel

RNG = np.random.default_rng(5)
SHAFT = (10.0, 4.8)
TOOTH = (10.5, 11.0, np.arcsin(10 / 10.5))


def kernel(build: Callable[..., dict[str, ca.SX]], *sizes: int) -> Kernel:
    inputs = [ca.SX.sym(f"i{k}", size) for k, size in enumerate(sizes)]
    found = build(*inputs)
    names = [f"i{k}" for k in range(len(sizes))]
    return Kernel(ca.Function("profile", inputs, list(found.values()), names, list(found)))


def _tooth(centre: ca.SX, angle: ca.SX) -> dict[str, ca.SX]:
    touch = profiles.tooth_on_hexagon(profiles.Tooth(*TOOTH), centre, angle, profiles.Hexagon(*SHAFT))
    slopes = ca.jacobian(touch.gap, centre).T
    return {"gap": touch.gap, "normal": touch.normal, "point": touch.point, "slopes": slopes}


def _hexagon() -> shapely.Polygon:
    corner = (SHAFT[0] - SHAFT[1]) / np.cos(np.pi / 6)
    angles = np.pi / 3 * np.arange(6)
    return shapely.Polygon(corner * np.column_stack([np.cos(angles), np.sin(angles)])).buffer(SHAFT[1], quad_segs=2000)


def _wedge(centre: np.ndarray, angle: float) -> shapely.Polygon:
    """The tooth with its faces from tip to root, closed far outside."""
    tip, root, face = TOOTH
    half = np.arccos(tip * np.sin(face) / root) - (np.pi / 2 - face)
    ends = root * np.array([[np.cos(half), np.sin(half)], [np.cos(half), -np.sin(half)]])
    shape = shapely.Polygon([(tip, 0), tuple(ends[0]), (40, 1), (40, -1), tuple(ends[1])])
    return translate(rotate(shape, np.degrees(angle), origin=(0, 0)), *centre)


def test_distance_of_tooth_and_shaft() -> None:
    found, shaft = kernel(_tooth, 2, 1), _hexagon()
    seen = 0
    for _ in range(300):
        centre, angle = RNG.uniform(-0.8, 0.8, 2), RNG.uniform(-4, 4)
        gap = float(found(i0=centre, i1=angle)["gap"][0, 0])
        if gap > 0:
            seen += 1
            assert gap == pytest.approx(_wedge(centre, angle).distance(shaft), abs=2e-6)
    assert seen > 50


def test_normal_is_the_way_the_distance_grows_and_the_point_lies_on_the_shaft() -> None:
    found, shaft = kernel(_tooth, 2, 1), _hexagon()
    for _ in range(100):
        at = found(i0=RNG.uniform(-0.6, 0.6, 2), i1=RNG.uniform(-4, 4))
        np.testing.assert_allclose(at["normal"], at["slopes"], atol=1e-9)
        assert np.linalg.norm(at["normal"]) == pytest.approx(1, abs=1e-12)
        assert shaft.exterior.distance(shapely.Point(*at["point"][:, 0])) < 1e-5


def test_support_is_that_of_a_curve_of_constant_width() -> None:
    width = 29.4
    found = kernel(lambda a: dict(zip(("value", "slope"), profiles.support(a, ca.SX(width)), strict=True)), 1)
    for angle in RNG.uniform(-7, 7, 100):
        here, there = found(i0=angle), found(i0=angle + np.pi)
        assert float(here["value"][0, 0] + there["value"][0, 0]) == pytest.approx(width, abs=1e-12)
        ahead = found(i0=angle + 1e-6)["value"] - found(i0=angle - 1e-6)["value"]
        assert float(here["slope"][0, 0]) == pytest.approx(float(ahead[0, 0]) / 2e-6, abs=1e-6)


def test_distance_of_jaws_is_that_of_rounded_rectangles() -> None:
    def jaws(offset: ca.SX, lift: ca.SX) -> dict[str, ca.SX]:
        gap, normal = profiles.jaw_on_jaw(offset, lift, ca.SX(6.0), ca.SX(0.5))
        return {"gap": gap, "normal": normal}

    found = kernel(jaws, 1, 1)
    grown = shapely.box(-5.5, -50, 5.5, -0.5).buffer(0.5, quad_segs=2000)
    for _ in range(200):
        place = (RNG.uniform(-9, 9), RNG.uniform(-4, 4))
        at = found(i0=place[0], i1=place[1])
        point = shapely.Point(*place)
        signed = -grown.exterior.distance(point) if grown.contains(point) else grown.distance(point)
        assert float(at["gap"][0, 0]) == pytest.approx(signed, abs=1e-6)
        assert np.linalg.norm(at["normal"]) == pytest.approx(1, abs=1e-9)
