"""Springs, guides, cams and pitch curves in drawings: they are where the motion has them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from planter.mechanism.show import open_view
from planter.report.scene import Body, Scene
from tests.support import own

MOMENTS = (0, 40, 155)
"""Frames that are looked at."""
MOST_GAP_MM = 2e-3
"""Largest gap of pitch curves in contact, which are polygons of one degree."""


def scene_of(name: str) -> Scene:
    view = open_view(str(own.generated(name) / f"{name}.toml"), {})
    return view.scenes({control.path: control.value for control in view.controls}, "exact")[0]


def place(scene: Scene, name: str, moment: int) -> np.ndarray:  # type: ignore[type-arg]
    """Return the first outline (k, 2) [mm] of a body of a scene at a moment."""
    (body,) = (body for body in scene.bodies if body.name == name)
    alone = replace(scene, bodies=[replace(body, outlines=body.outlines[:1])])
    ((_, (points,)),) = alone.placed(slice(moment, moment + 1))
    return points


def turn_body(scene: Scene, name: str, turn: float) -> Scene:
    """Return a scene with a body turned farther [deg]."""

    def turned(body: Body) -> Body:
        return replace(body, turn=np.asarray(body.turn) + turn) if body.name == name else body

    return replace(scene, bodies=[turned(body) for body in scene.bodies])


def gap(scene: Scene, gears: tuple[str, str], moment: int) -> float:
    """Return the distance of two pitch curves [mm], or how far they overlap."""
    first, second = (shapely.Polygon(place(scene, gear, moment)) for gear in gears)
    overlap = first.intersection(second)
    if overlap.is_empty:
        return float(first.distance(second))
    return float(overlap.area / (overlap.length / 2))


def test_pitch_curves_of_unround_gears_touch_all_the_time() -> None:
    scene = scene_of("elliptic_gears")
    names = [body.name for body in scene.bodies if body.outlines[0].look == "gear"]
    assert len(names) == 2
    pair = names[0], names[1]
    assert max(gap(scene, pair, moment) for moment in MOMENTS) < MOST_GAP_MM
    # tampered: turned by a part of a turn, one of them cuts into the other, or loses it
    tampered = turn_body(scene, names[1], 40.0)
    assert max(gap(tampered, pair, moment) for moment in MOMENTS) > 100 * MOST_GAP_MM


def test_spring_ends_where_it_is_attached() -> None:
    scene = scene_of("slider_crank")
    (spring,) = (chain for chain in scene.chains if chain.name == "spring")
    corners = [scene.points[index] for index in spring.points]
    assert all(point.hidden for point in corners)
    (slot,) = (point for point in scene.points if point.name == "slot")
    assert corners[0].x == pytest.approx(slot.x)
    assert corners[0].y == pytest.approx(slot.y)
    assert corners[-1].x == pytest.approx(400.0)  # the anchor of the file
    (length,) = (curve for curve in scene.curves if "length of spring" in curve.name)
    distance = np.hypot(corners[-1].x - corners[0].x, corners[-1].y - corners[0].y)
    assert distance == pytest.approx(length.values)


def test_slider_moves_in_its_guide() -> None:
    scene = scene_of("slider_crank")
    rail = place(scene, "guide", 0)
    for moment in MOMENTS:
        block = place(scene, "slider in guide", moment)
        assert rail[:, 0].min() < block[:, 0].min()
        assert block[:, 0].max() < rail[:, 0].max()
        assert block.mean(axis=0)[1] == pytest.approx(10.0)  # the offset of the file


def test_roller_stays_on_its_cam() -> None:
    scene = scene_of("cam_follower")
    name = "cam of N cam, path of the roller's centre"

    def distance(scene: Scene, moment: int) -> float:
        centre = place(scene, "roller of N cam", moment).mean(axis=0)
        return float(shapely.LinearRing(place(scene, name, moment)).distance(shapely.Point(centre)))

    assert max(distance(scene, moment) for moment in MOMENTS) < 1e-9
    assert max(distance(turn_body(scene, name, 30.0), moment) for moment in MOMENTS) > 0.1


def test_cylinder_lies_between_its_ends() -> None:
    scene = scene_of("lift_arm")
    (rod,) = (chain for chain in scene.chains if chain.name == "F cylinder")
    ends = [scene.points[index] for index in rod.points]
    for moment in MOMENTS:
        line = shapely.LineString(
            [(np.asarray(e.x)[moment], np.asarray(e.y)[moment]) for e in ends]
        )
        middle = place(scene, "F cylinder", moment).mean(axis=0)
        assert line.distance(shapely.Point(middle)) < 1e-9
