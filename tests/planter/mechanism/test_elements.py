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
    body = next(body for body in scene.bodies if body.name == name)
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
    (slot,) = (point for point in scene.points if point.name == "slot")
    (length,) = (curve for curve in scene.curves if "length of spring" in curve.name)
    for moment in MOMENTS:
        start, *_, end = place(scene, "spring", moment)
        assert start == pytest.approx([np.asarray(slot.x)[moment], np.asarray(slot.y)[moment]])
        assert end == pytest.approx([400.0, 10.0])  # the anchor of the file
        assert np.hypot(*(end - start)) == pytest.approx(length.values[moment])


def test_slider_moves_in_its_guide() -> None:
    scene = scene_of("slider_crank")
    rail = place(scene, "guide", 0)
    for moment in MOMENTS:
        block = place(scene, "slider", moment)
        assert rail[:, 0].min() < block[:, 0].min()
        assert block[:, 0].max() < rail[:, 0].max()
        assert block.mean(axis=0)[1] == pytest.approx(10.0)  # the offset of the file


def roller_gap(scene: Scene, moment: int) -> float:
    """Return the distance [mm] of a roller from its cam, or how far it is in it."""
    cam, roller = (shapely.Polygon(place(scene, name, moment)) for name in ("cam", "slide"))
    overlap = cam.intersection(roller)
    if overlap.is_empty:
        return float(cam.distance(roller))
    return float(overlap.area / (overlap.length / 2))


def test_roller_rolls_on_its_cam() -> None:
    scene = scene_of("cam_follower")
    size = np.ptp(place(scene, "slide", 0), axis=0).max() / 2
    assert max(roller_gap(scene, moment) for moment in MOMENTS) < 0.01 * size
    # tampered: the path of the roller's centre as a contour, and a cam that is turned
    (cam,) = (body for body in scene.bodies if body.name == "cam")
    points = cam.outlines[0].points
    larger = points * (1 + size / np.hypot(*points.T))[:, None]
    wide = replace(cam, outlines=(replace(cam.outlines[0], points=larger),))
    pitch = replace(scene, bodies=[wide if body is cam else body for body in scene.bodies])
    assert max(roller_gap(pitch, moment) for moment in MOMENTS) > 0.1 * size
    assert (
        max(roller_gap(turn_body(scene, "cam", 30.0), moment) for moment in MOMENTS) > 0.02 * size
    )


STATED = """\
m.follower("N_cam", slide, cam, P, m.O, across=m.vector(m.world, z=-1), radius=q.R)
"""


def test_stated_roller_has_its_radius_and_touches() -> None:
    text = (own.EXAMPLES / "cam_follower.py").read_text(encoding="utf-8")
    before = 'm.follower("N_cam", slide, cam, P, m.O, across=m.vector(m.world, z=-1))\n'
    assert before in text
    text = text.replace(before, STATED)
    text = text.replace("    mu    | 1 ", "    R     | mm    | roller | 9\n    mu    | 1 ")
    view = open_view(str(own.generated(text) / "cam_follower.toml"), {})
    scene = view.scenes({control.path: control.value for control in view.controls}, "exact")[0]
    assert np.ptp(place(scene, "slide", 0), axis=0) == pytest.approx([18.0, 18.0], rel=1e-3)
    assert max(roller_gap(scene, moment) for moment in MOMENTS) < 0.05


def test_contact_is_no_corner_of_a_body() -> None:
    """The roller's centre and the mate's shaft move against a body, which is drawn without them."""
    assert not any(chain.name == "cam" for chain in scene_of("cam_follower").chains)
    train = scene_of("planetary_train")
    corners = {chain.name: [train.points[k].name for k in chain.points] for chain in train.chains}
    assert corners == {"carrier": ["O", "B", "C"], "planet": ["C", "centroid"]}


def test_cylinder_lies_between_its_ends() -> None:
    scene = scene_of("lift_arm")
    (cylinder,) = (
        body for body in scene.bodies if body.name == "F cylinder" and body.outlines[0].closed
    )
    alone = replace(scene, bodies=[cylinder])
    for moment in MOMENTS:
        ends = place(scene, "F cylinder", moment)
        ((_, (corners,)),) = alone.placed(slice(moment, moment + 1))
        middle = shapely.Point(corners.mean(axis=0))
        assert shapely.LineString(ends).distance(middle) < 1e-9
