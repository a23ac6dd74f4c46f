"""The drawing: what it shows is where the mechanism is, packed and unpacked, and the page lets its
script alone run.
"""

from __future__ import annotations

import base64
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import Polygon

from planter.engine.solvers.sampled_cycle import sample_angles
from planter.gears.geometry.cutting import ToothOrder
from planter.kernels import Array
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.papers.planting.report import scene
from planter.papers.planting.report.scene import build_scene
from planter.report.animation import MotionBlock, pack_scene
from planter.report.html import Section, render_page
from planter.report.picture import draw_picture
from planter.report.scene import Curve, Scene
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
    (_, _, phi), (x, y, rotation) = device_scene.pose(carrier), device_scene.pose(planet)
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


def test_a_page_grows_by_less_than_110_kB(device_scene: Scene) -> None:
    block = MotionBlock(device_scene)
    assert len(f"{block.html('s1')}{block.script}{block.style}".encode()) < 110_000


def test_names_are_text_and_never_markup(device_scene: Scene) -> None:
    curves = [replace(device_scene.curves[0], name="</script><b>bold</b>")]
    text = MotionBlock(replace(device_scene, title="<i>&", curves=curves)).html("s1")
    assert "<i>" not in text
    assert "<b>" not in text
    assert text.count("</script>") == 1


def test_the_picture_stands_without_a_script(device_scene: Scene) -> None:
    svg = draw_picture(device_scene)
    assert svg.count("data-body") == sum(1 for _ in device_scene.all_bodies())
    assert "<script" not in svg


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
