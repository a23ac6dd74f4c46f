"""The drawing: what it shows is where the mechanism is, packed and unpacked, and the page lets its
script alone run.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shapely import Polygon

from planter.engine.solvers.sampled_cycle import sample_angles
from planter.gears.geometry.cutting import ToothOrder
from planter.kernels import Array
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.papers.planting.report import scene
from planter.papers.planting.report.scene import build_scene, list_nozzle_changes
from planter.report.animation import MotionBlock, pack_scene
from planter.report.html import Section, render_page
from planter.report.picture import draw_picture
from planter.report.scene import TOLERANCE, Curve, Scene, refine_places
from planter.report.sheet import Angle, Length, arrange_column, find_crossing, place_labels
from planter.report.subject import open_machine
from tests.support.browser import page_after_scripts
from tests.support.scenes import placed

TOUCHING = 0.02
"""Pitch curves that touch come closer than this [mm]: they are polygons of 180 sides."""


@pytest.fixture(scope="module")
def device() -> Device:
    return Device(load("wang2017-wide"))


@pytest.fixture(scope="module")
def device_scene(device: Device) -> Scene:
    return build_scene(device, device.design)


def unpacked(record: Any, channel: Any) -> Array:
    """Series that a record tells, as the drawing's script reads it."""
    count = record["moments"]
    if isinstance(channel, float):
        return np.full(count, channel)
    if "step" in channel:
        return channel["from"] + channel["step"] * np.arange(count)
    values = np.frombuffer(base64.b64decode(record["data"]), dtype="<f4").reshape(-1, count)
    return np.roll(values[channel["series"]], -channel["ahead"]).astype(float)


def gaps(device_scene: Scene, moment: int) -> list[float]:
    at = placed(device_scene, moment)
    gaps = []
    for side in (1, 2):
        five, six = at[f"middle body, side {side}"]
        gaps += [
            at["sun"][0].distance(five),
            six.distance(at[f"planet and nozzle, side {side}"][0]),
        ]
    return gaps


@pytest.mark.parametrize("moment", [0, 47, 133, 200, 291])
def test_gears_touch_wherever_the_carrier_is(device_scene: Scene, moment: int) -> None:
    assert max(gaps(device_scene, moment)) < TOUCHING


def test_a_gear_drawn_at_a_wrong_place_does_not_touch(device_scene: Scene) -> None:
    sun, carrier, *other_bodies = device_scene.bodies
    moved = [replace(part, at=(part.at[0] + 0.2, part.at[1] + 0.2)) for part in carrier.parts]
    wrong = replace(device_scene, bodies=(sun, replace(carrier, parts=moved), *other_bodies))
    assert max(gaps(wrong, 47)) > TOUCHING


def shared(device_scene: Scene, moment: int) -> tuple[float, float]:
    """Largest area [mm2] and distance [mm] between teeth that mesh, of both sides."""
    cut = [
        Polygon(points[0])
        for line, points in device_scene.placed(slice(moment, moment + 1))
        if line.look == "teeth"
    ]
    sun, *other_parts = cut
    meshing = [
        (sun, other_parts[0]),
        (other_parts[1], other_parts[2]),
        (sun, other_parts[3]),
        (other_parts[4], other_parts[5]),
    ]
    return max(a.intersection(b).area for a, b in meshing), max(a.distance(b) for a, b in meshing)


@pytest.mark.parametrize("moment", [0, 47, 133, 200, 291])
def test_teeth_mesh_wherever_the_carrier_is(device_scene: Scene, moment: int) -> None:
    """Drawn outlines share no more, and are no farther apart, than they are thinned."""
    area, distance = shared(device_scene, moment)
    assert area < 1e-3
    assert distance < 1e3 * scene.WITHIN


def test_a_gear_turned_by_half_a_tooth_does_not_mesh(device_scene: Scene) -> None:
    sun, *other_bodies = device_scene.bodies
    turned = replace(sun.parts[0], turn=sun.parts[0].turn + 180 / 31)
    area, _ = shared(
        replace(device_scene, bodies=(replace(sun, parts=[turned]), *other_bodies)), 47
    )
    assert area > 1


def test_where_no_teeth_can_be_made_the_pitch_curves_are_drawn(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert build_scene(device, device.design).toothed
    monkeypatch.setattr(scene, "ORDER", ToothOrder(teeth=8, keep="size"))
    plain = build_scene(device, device.design)
    assert not plain.toothed
    assert draw_picture(plain) == draw_picture(build_scene(device, device.design, toothed=False))


def test_the_nozzle_ends_where_the_tip_is(device: Device, device_scene: Scene) -> None:
    turn = device.columns(device.design, sample_angles(device_scene.moments, 2 * np.pi))
    carrier = device_scene.bodies[1]
    arm, planet = carrier.parts[0], carrier.parts[0].parts[1]
    phi = device_scene.pose(carrier)[2]
    x, y, rotation, *_ = device_scene.pose(planet)
    heading, at = np.radians(phi), np.radians(phi + rotation)
    length = device.machine.nozzle.tip_distance_mm
    tip = np.array(
        [
            np.cos(heading) * x - np.sin(heading) * y + length * np.cos(at),
            np.sin(heading) * x + np.cos(heading) * y + length * np.sin(at),
        ]
    )
    assert arm.turn == 0
    assert tip == pytest.approx(np.array([turn["tip_machine_x_mm"], turn["tip_y_mm"]]), abs=1e-9)


def test_nozzles_change_where_the_paper_marks_swings() -> None:
    """Fig. 9 of the paper: the lower nozzle closes near 100 deg, the upper one opens near 160 and
    closes near 280, the lower one opens near 340.
    """
    paper = Device(load("wang2017"))
    changes = list_nozzle_changes(paper, paper.design)
    assert [change.side for change in changes] == [2, 1, 1, 2]
    assert [change.opens for change in changes] == [False, True, False, True]
    angles = [change.angle_deg for change in changes]
    assert angles == pytest.approx([100, 160, 280, 340], abs=5)
    assert np.array(angles[2:]) - angles[:2] == pytest.approx([180, 180])
    tips = paper.columns(paper.design, np.radians(angles))
    lowest = float(paper.columns(paper.design, sample_angles(360, 2 * np.pi))["tip_y_mm"].min())
    assert tips["tip_y_mm"][1] == pytest.approx(lowest, abs=1.0)


def test_soil_lies_beneath_the_machine_where_the_file_has_it(device_scene: Scene) -> None:
    (soil,) = (body for body in device_scene.bodies if body.name == "soil")
    surface = soil.outlines[0].points[:, 1].max()
    (tip,) = (point for point in device_scene.points if point.traced)
    assert surface - np.min(tip.y) == pytest.approx(60.0)  # the depth of the file
    paper = Device(load("wang2017"))
    assert all(
        body.name != "soil" for body in build_scene(paper, paper.design, toothed=False).bodies
    )


def test_packed_series_unpack_as_single_floats(device_scene: Scene) -> None:
    record = pack_scene(device_scene)
    for body, channels in zip(device_scene.all_bodies(), record["bodies"], strict=True):
        for channel, channel_record in zip(device_scene.pose(body), channels, strict=True):
            assert unpacked(record, channel_record) == pytest.approx(
                channel.astype(np.float32), abs=1e-6
            )
    for curve, channel_values in zip(device_scene.curves, record["curves"], strict=True):
        assert unpacked(record, channel_values["values"]) == pytest.approx(
            curve.values.astype(np.float32), abs=1e-6
        )


def test_uniform_series_is_packed_as_step(device_scene: Scene) -> None:
    assert pack_scene(device_scene)["places"] == {"from": 0.0, "step": pytest.approx(1.0)}
    bent = replace(device_scene, places=device_scene.places + 1e-6 * np.sin(device_scene.places))
    assert "series" in pack_scene(bent)["places"]


def test_half_cycle_repetition_is_packed_once(device_scene: Scene) -> None:
    values = np.sin(np.linspace(0, 2 * np.pi, device_scene.moments, endpoint=False)) + 0.3
    twins = [Curve("one", "", values), Curve("two", "", np.roll(values, device_scene.moments // 2))]
    record = pack_scene(
        replace(device_scene, bodies=(), points=(), forces=(), curves=twins, travel=None)
    )
    assert len(base64.b64decode(record["data"])) == 4 * device_scene.moments
    assert unpacked(record, record["curves"][1]["values"]) == pytest.approx(
        twins[1].values, abs=1e-6
    )


def test_units_of_curves_are_typeset(device_scene: Scene) -> None:
    values = np.ones(device_scene.moments)
    curves = tuple(Curve(unit, unit, values) for unit in ("deg", "rad/s2", ""))
    record: Any = pack_scene(replace(device_scene, curves=curves))
    assert [curve["unit"] for curve in record["curves"]] == ["°", "rad/s²", ""]


def test_names_are_text_and_never_markup(device_scene: Scene) -> None:
    curves = [replace(device_scene.curves[0], name="</script><b>bold</b>")]
    text = MotionBlock(replace(device_scene, title="<i>&", curves=curves)).html("s1")
    assert "<i>" not in text
    assert "<b>" not in text
    assert text.count("</script>") == 1


def moving_page(device_scene: Scene) -> str:
    return render_page("A machine", [Section("Motion", [MotionBlock(device_scene)])])


def test_page_policy_allows_only_local_script(device_scene: Scene, tmp_path: Path) -> None:
    """A reader's browser moves the drawing; of a page whose script was changed it runs nothing."""
    text = moving_page(device_scene)
    (tmp_path / "own.html").write_text(text, encoding="utf-8")
    match = re.search(
        r'class="told">([^<]*)<', page_after_scripts(tmp_path / "own.html", tmp_path / "profile")
    )
    force = f"{device_scene.curves[0].values[0]:.5g}"
    assert match
    assert match[1] == f"carrier angle 0\N{DEGREE SIGN}, vertical support force {force} N"
    (tmp_path / "changed.html").write_text(
        text.replace("const SPEEDS", "const  SPEEDS"), encoding="utf-8"
    )
    assert 'class="told"' not in page_after_scripts(tmp_path / "changed.html", tmp_path / "profile")
    still = render_page("A machine", [Section("Motion", [])])
    assert "script-src 'none'" in still


def scenes(machine: str) -> list[Scene]:
    subject = open_machine(machine, {})
    return list(
        subject.scenes(
            {control.path: control.value for control in subject.controls}, subject.models[0]
        )
    )


def strayed(places: Array, values: Array, dense: Array, exact: Array) -> float:
    """Largest distance of straight pieces from an exact curve, in parts of its range."""
    return float(np.abs(np.interp(dense, places, values) - exact).max() / np.ptp(exact))


@pytest.mark.parametrize(
    ("curve", "tolerance"),
    [
        (np.sin, 2 * TOLERANCE),
        (lambda t: np.abs(np.sin(7 * t)), 1e-2),
        (lambda t: np.sqrt(np.abs(t - 2)), 1e-2),
    ],
)
def test_pieces_follow_a_curve(curve: Callable[[Array], Array], tolerance: float) -> None:
    """Halved at most ROUNDS times, the pieces beside a corner are short enough to follow it within
    a hundredth.
    """
    dense, even = np.linspace(0.0, 2 * np.pi, 7001), np.linspace(0.0, 2 * np.pi, 37)
    places = refine_places(lambda t: [curve(t)], even)
    assert strayed(places, curve(places), dense, curve(dense)) < tolerance
    assert strayed(even, curve(even), dense, curve(dense)) > tolerance


def test_a_jump_is_drawn_steep() -> None:
    places = refine_places(lambda t: [np.floor(t)], np.linspace(0.0, 2.5, 11))
    neighbours = places[np.argsort(np.abs(places - 1.0))[:2]]
    assert np.ptp(neighbours) < 0.25 / 64
    assert len(places) < 40


def test_a_straight_line_needs_no_more() -> None:
    places = np.linspace(0.0, 1.0, 5)
    assert refine_places(lambda t: [3 * t, 0 * t], places) == pytest.approx(places)


def test_clutch_curve_meets_zeros() -> None:
    """The body needs no more than its width wherever a vertex points at a side: every 12 deg."""
    (scene,) = scenes("shi2021")
    (curve,) = scene.curves
    at = [int(np.argmin(np.abs(scene.places - angle))) for angle in range(0, 360, 12)]
    assert scene.places[at] == pytest.approx(range(0, 360, 12))
    assert np.abs(curve.values[at]).max() < 1e-12
    middles = [int(np.argmin(np.abs(scene.places - angle))) for angle in range(6, 360, 12)]
    assert scene.places[middles] == pytest.approx(range(6, 360, 12))
    assert curve.values[middles] == pytest.approx(curve.values.max(), rel=1e-9)


def test_tip_paths_of_linkages_are_smooth() -> None:
    """Corners between neighbouring pieces are flat but where the path is short against its
    pieces.
    """
    for linkage in scenes("sun2019")[:2]:
        (tip,) = (point for point in linkage.points if point.traced)
        path = np.append(tip.x, np.take(tip.x, 0)) + 1j * np.append(tip.y, np.take(tip.y, 0))
        steps = np.diff(path)
        bends = np.abs(np.angle(steps[1:] / steps[:-1]))
        bulges = (
            np.minimum(np.abs(steps[1:]), np.abs(steps[:-1])) * bends / 8
        )  # of an arc from its chord
        assert bulges.max() < 2e-3 * max(np.ptp(path.real), np.ptp(path.imag))
        assert (np.diff(linkage.times) > 0).all()


def test_pickup_slope_jumps_at_dwell_start() -> None:
    (scene,) = scenes("yu2023")
    slope = next(curve for curve in scene.curves if curve.name.startswith("slope"))
    jump = int(np.argmax(np.abs(np.diff(slope.values))))
    begins = next(event.place for event in scene.events if event.name == "the dwell begins")
    ends = next(event.place for event in scene.events if event.name == "the dwell ends")
    assert min(abs(scene.places[jump] - begins), abs(scene.places[jump] - ends)) < 0.02
    assert np.diff(scene.places)[jump] < 0.02


UNIT = st.floats(0, 1)


@settings(
    max_examples=60, derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
@given(st.lists(st.tuples(UNIT, UNIT), min_size=1, max_size=12, unique=True))
def test_names_keep_apart_and_their_lines_do_not_cross(points: list[tuple[float, float]]) -> None:
    anchors = np.array(points)
    labels = place_labels(anchors, 0.05, 1.0)
    for right in (False, True):
        side_labels = [index for index, place in enumerate(labels) if place.right == right]
        heights = [labels[index].height for index in side_labels]
        assert all(abs(a - b) >= 0.05 - 1e-9 for a, b in combinations(heights, 2))
        assert all(0 <= height <= 1 for height in heights)
        assert find_crossing(anchors[side_labels], heights, 1.0 if right else 0.0) is None


def test_a_crossing_is_noticed_and_taken_away() -> None:
    anchors = np.array([[0.5, 0.2], [0.5, 0.8]])
    assert find_crossing(anchors, [0.8, 0.2], 0.0) == (0, 1)
    assert find_crossing(anchors, arrange_column(anchors, 0.1, 0.0), 0.0) is None


def test_marks_measure_themselves() -> None:
    origin = np.zeros(2)
    assert Length(("a",), origin, np.array([3.0, 4.0])).size == 5
    turned = Angle.between(("b",), origin, np.array([0.0, 2.0]), np.array([-1.0, 0.0]), 1.0)
    assert (turned.start, turned.turn) == pytest.approx((90, 90))
    assert np.hypot(*turned.outline().T) == pytest.approx(1.0)
    assert turned.anchor == pytest.approx([-np.sqrt(0.5), np.sqrt(0.5)])
