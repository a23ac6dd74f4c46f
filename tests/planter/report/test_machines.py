"""Every machine as it is drawn obeys its geometry: gears touch, bars keep their ends, bodies stay
inside.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapely import Point, Polygon

from derive.__main__ import main as derive
from planter.engine.machine import load_machine
from planter.gears import figures as gears
from planter.gears.geometry.cutting import ToothOrder, cut_teeth
from planter.gears.geometry.pitch_curves import build_circle_pair
from planter.mechanism.cycle import compute_cycle
from planter.mechanism.drawing import build_cycle_scene
from planter.mechanism.model import Model
from planter.papers.clutch import scene as clutch
from planter.papers.clutch.rotor import Rotor
from planter.papers.mapping import curve, synthesis, train
from planter.papers.mapping import file as poses
from planter.papers.mapping import scene as mapping
from planter.papers.pickup import file as pickup_file
from planter.papers.pickup import model as pickup_model
from planter.papers.pickup import scene as pickup
from planter.report.scene import Scene
from tests.support.scenes import placed
from tests.support.structure import ROOT

EXAMPLES = ROOT / "docs" / "examples"


@pytest.fixture(scope="module")
def picking() -> Scene:
    machine = pickup_file.load_pickup("yu2023")
    return pickup.build_pickup_scene(machine, pickup_model.build_train(machine))


@pytest.mark.parametrize("moment", [0, 60, 140, 300])
def test_the_gears_of_a_pick_up_touch_where_teeth_drive_it(picking: Scene, moment: int) -> None:
    at = placed(picking, moment)
    assert at["sun"][0].distance(at["intermediate gear"][0]) < 0.01


def test_locking_arcs_lie_on_each_other_in_the_dwell(picking: Scene) -> None:
    begins, ends = (event.place for event in picking.events if "dwell" in event.name)
    at = placed(picking, round((begins + ends) / 2))
    radii = [np.hypot(*np.array(at[gear][1].coords).T) for gear in ("sun", "intermediate gear")]
    assert np.ptp(np.concatenate(radii)) < 1e-6


def test_pickup_needle_ends_at_tip(picking: Scene) -> None:
    tip = picking.points[0]
    for moment in (0, 100, 250):
        bar = placed(picking, moment)["arm and needle"][0]
        assert Point(bar.coords[-1]).distance(Point(tip.x[moment], tip.y[moment])) < 1e-9


def test_rotor_stays_inside_polygon() -> None:
    scene = clutch.build_rotor_scene(Rotor(5, 6, 0.05), "own")
    for moment in range(0, scene.moments, 23):
        at = placed(scene, moment)
        assert Polygon(at["sleeve"][0]).buffer(1e-6).contains(Polygon(at["body"][0]))
    tight = replace(scene, bodies=(scene.bodies[0], replace(scene.bodies[1], at=(0.0, 0.0))))
    at = placed(tight, 23)
    assert not Polygon(at["sleeve"][0]).buffer(1e-6).contains(Polygon(at["body"][0]))


def test_linkage_bars_meet_in_hinges() -> None:
    synthesised = synthesis.synthesise(poses.load_poses("sun2019-corrected"))
    scene = mapping.build_linkage_scene(synthesised.linkages[0], synthesised.poses, 1)
    for moment in range(0, scene.moments, 17):
        at = placed(scene, moment)
        arm = [Point(corner) for corner in at["arm"][0].coords]
        assert Point(at["crank"][0].coords[-1]).distance(arm[0]) < 1e-6
        assert Point(at["follower"][0].coords[-1]).distance(arm[1]) < 1e-6


def test_train_gears_touch_and_arm_ends_at_tip() -> None:
    pose_file = poses.load_poses("sun2019-corrected")
    scene = mapping.build_train_scene(
        train.build_training(curve.load_curve("sun2019-curve"), 0.07, file=pose_file)
    )
    assert scene is not None
    for moment in range(0, scene.moments, 13):
        at = placed(scene, moment)
        second, third = at["middle gears"]
        assert at["sun"][0].distance(second) < 0.25
        assert third.distance(at["planet and arm"][0]) < 0.25
        tip = Point(scene.points[0].x[moment], scene.points[0].y[moment])
        assert Point(at["planet and arm"][1].coords[-1]).distance(tip) < 1e-3


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    folder = tmp_path_factory.mktemp("own")
    assert derive([str(EXAMPLES / "transplanting_arm.py"), "--out", str(folder)]) == 0
    cycle = compute_cycle(Model(load_machine(str(folder / "transplanting_arm.toml"))))
    return build_cycle_scene("arm", cycle)


def test_user_mechanism_bodies_are_rigid(arm: Scene) -> None:
    """Distances between the points of a body are the same at every moment; the path of its loop
    closes.
    """
    for chain in arm.chains:
        at = np.array([[arm.points[k].x, arm.points[k].y] for k in chain.points])
        lengths = np.hypot(*np.swapaxes(at[1:] - at[:-1], 0, 1))
        assert np.ptp(lengths, axis=1) == pytest.approx(0, abs=1e-9), chain.name
    assert {chain.name for chain in arm.chains} >= {"crank", "coupler"}


def test_teeth_mesh_without_overlap_as_they_turn() -> None:
    """Gears of other numbers of teeth than drawn by default: their outlines touch and do not share
    an area.
    """
    order = ToothOrder(teeth=23)
    pair = cut_teeth(build_circle_pair(0.023, 0.023), order, "own", ("gear", "mate"))
    scene = gears.build_scene(pair)
    for moment in (0, 17, 101):
        first, second = (Polygon(lines[0]) for lines in placed(scene, moment).values())
        assert first.distance(second) < 0.02
        assert first.intersection(second).area < 1e-3
    turned = replace(scene.bodies[1], turn=scene.bodies[1].turn + 360 / 46)
    first, second = (
        Polygon(lines[0])
        for lines in placed(replace(scene, bodies=(scene.bodies[0], turned)), 17).values()
    )
    assert first.intersection(second).area > 1
