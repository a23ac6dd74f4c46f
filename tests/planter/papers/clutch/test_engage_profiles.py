"""Profiles that meet in the clutches: distances against an independent geometry library."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

from planter.kernels import formulas
from planter.kernels.kernel import Array
from planter.papers.clutch.contact import DOG, REULEAUX
from planter.papers.clutch.rotor import Rotor, body_outline

RNG = np.random.default_rng(5)
SHAFT = (10.0, 4.8)
TIP, ROOT = 10.5, 11.0
FACE = np.arcsin(10 / 10.5)
STIFF = {
    "stiffness": 1.0,
    "dissipation": 0.0,
    "friction": 0.0,
    "slip_speed": 1.0,
    "least_depth": 1e-30,
}
"""Without friction and dissipation: what acts on the body is the normal force along the normal."""


def at(model: str, contact: str, centre: Array, angle: float, **more: Any) -> dict[str, float]:
    """A contact in mm with the body at a place, turned by an angle, the shaft at the origin."""
    places = [*centre, more.pop("way", 0.0), 0.0, 0.0, 0.0, angle, 0.0]
    return formulas.load(model).at(
        contact, **more, places=places, rates=np.zeros(8), law=list(STIFF.values())
    )


def tooth(centre: Array, angle: float) -> dict[str, float]:
    return at(REULEAUX, "tooth", centre, angle, index=0, tooth_shape=[TIP, ROOT, *SHAFT])


def _hexagon() -> shapely.Polygon:
    corner = (SHAFT[0] - SHAFT[1]) / np.cos(np.pi / 6)
    angles = np.pi / 3 * np.arange(6)
    return shapely.Polygon(corner * np.column_stack([np.cos(angles), np.sin(angles)])).buffer(
        SHAFT[1], quad_segs=2000
    )


def _wedge(centre: np.ndarray, angle: float) -> shapely.Polygon:
    """The tooth with its faces from tip to root, closed far outside."""
    half = np.arccos(TIP * np.sin(FACE) / ROOT) - (np.pi / 2 - FACE)
    ends = ROOT * np.array([[np.cos(half), np.sin(half)], [np.cos(half), -np.sin(half)]])
    shape = shapely.Polygon([(TIP, 0), tuple(ends[0]), (40, 1), (40, -1), tuple(ends[1])])
    return translate(rotate(shape, np.degrees(angle), origin=(0, 0)), *centre)


def test_distance_of_tooth_and_shaft() -> None:
    shaft, seen = _hexagon(), 0
    for _ in range(300):
        centre, angle = RNG.uniform(-0.8, 0.8, 2), RNG.uniform(-4, 4)
        gap = tooth(centre, angle)["gap"]
        if gap > 0:
            seen += 1
            assert gap == pytest.approx(_wedge(centre, angle).distance(shaft), abs=2e-6)
    assert seen > 50


def test_overlap_pushes_the_body_the_way_out() -> None:
    """A step along the force takes its own length off the depth; across it, nothing to first
    order.
    """
    pushed = 0
    for _ in range(300):
        centre, angle = RNG.uniform(-0.6, 0.6, 2), RNG.uniform(-4, 4)
        contact = tooth(centre, angle)
        if contact["normal"] > 0:
            pushed += 1
            out = np.array([contact["on_x"], contact["on_y"]]) / contact["normal"]
            assert np.linalg.norm(out) == pytest.approx(1, abs=1e-12)
            step = 1e-6
            across = np.array([-out[1], out[0]])
            for way, gained in ((out, step), (across, 0)):
                assert tooth(centre + step * way, angle)["gap"] - contact["gap"] == pytest.approx(
                    gained, abs=1e-10
                )
    assert pushed > 50


def test_distance_of_outline_and_sleeve() -> None:
    """Over all sides the least distance of a Reuleaux pentagon from a hexagon about it."""
    width, hole, taper = 29.4, 16.1, 0.35
    body = Rotor(5, 6, width)
    for _ in range(40):
        centre, angle, way = RNG.uniform(-0.3, 0.3, 2), RNG.uniform(-4, 4), RNG.uniform(0, 2)
        shape = [width, hole, 2.0, taper]
        room = hole + (2.0 - way) * np.tan(taper)
        ring = shapely.Polygon(
            room
            / np.cos(np.pi / 6)
            * np.column_stack([np.cos(np.pi / 3 * np.arange(6)), np.sin(np.pi / 3 * np.arange(6))])
        )
        inside = shapely.Polygon(body_outline(body, angle, centre).T)
        gaps = [
            at(REULEAUX, "side", centre, angle, index=i, hole_shape=shape, way=way)["gap"]
            for i in range(6)
        ]
        assert ring.contains(inside)
        assert min(gaps) / np.cos(taper) == pytest.approx(inside.distance(ring.exterior), abs=2e-3)


def test_jaw_distance_agrees_with_rounded_rectangles() -> None:
    """On a radius so large that the circumference is straight."""
    radius, jaws, edge = 1e6, 5, 0.5
    backlash = radius * 2 * np.pi / jaws - 12.0
    grown = shapely.box(-5.5, -50, 5.5, -0.5).buffer(0.5, quad_segs=2000)
    for _ in range(200):
        offset, lift = RNG.uniform(-9, 9), RNG.uniform(-4, 4)
        shape = [jaws, radius, backlash, edge, 3.0]
        distance = at(
            DOG, "jaw", np.zeros(2), offset / radius, index=0, jaw_shape=shape, way=lift + 3.0
        )
        point = shapely.Point(offset, lift)
        signed = -grown.exterior.distance(point) if grown.contains(point) else grown.distance(point)
        assert distance["gap"] == pytest.approx(signed, abs=1e-6)
