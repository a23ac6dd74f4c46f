"""The drawing: what it shows is where the mechanism is, packed and unpacked, and the page lets its script alone run."""

from __future__ import annotations

import base64
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import Polygon

from planter.gear_geometry.cutting import ToothOrder
from planter.kernels import Array
from planter.planting import cycle
from planter.planting.file import load
from planter.planting.model import Device
from planter.planting.report import scene
from planter.planting.report.scene import build_scene
from planter.report.html import Section, page
from planter.view.animation import Motion, packed
from planter.view.picture import picture
from planter.view.scene import Curve, Scene
from tests.support.browser import page_after_scripts
from tests.support.scenes import placed

TOUCHING = 0.02
"""Pitch curves that touch come closer than this [mm]: they are polygons of 180 sides."""


@pytest.fixture(scope="module")
def device() -> Device:
    return Device(load("wang2017-wide"))


@pytest.fixture(scope="module")
def shown(device: Device) -> Scene:
    return build_scene(device, device.design)


def unpacked(record: Any, told: Any) -> Array:
    """Series that a record tells, as the drawing's script reads it."""
    count = record["moments"]
    if isinstance(told, float):
        return np.full(count, told)
    if "step" in told:
        return told["from"] + told["step"] * np.arange(count)
    every = np.frombuffer(base64.b64decode(record["data"]), dtype="<f4").reshape(-1, count)
    return np.roll(every[told["series"]], -told["ahead"]).astype(float)


def gaps(shown: Scene, moment: int) -> list[float]:
    at = placed(shown, moment)
    found = []
    for side in (1, 2):
        five, six = at[f"middle body, side {side}"]
        found += [at["sun"][0].distance(five), six.distance(at[f"planet and nozzle, side {side}"][0])]
    return found


@pytest.mark.parametrize("moment", [0, 47, 133, 200, 291])
def test_gears_touch_wherever_the_carrier_is(shown: Scene, moment: int) -> None:
    assert max(gaps(shown, moment)) < TOUCHING


def test_a_gear_drawn_at_a_wrong_place_does_not_touch(shown: Scene) -> None:
    sun, carrier, *others = shown.bodies
    moved = [replace(part, at=(part.at[0] + 0.2, part.at[1] + 0.2)) for part in carrier.parts]
    wrong = replace(shown, bodies=(sun, replace(carrier, parts=moved), *others))
    assert max(gaps(wrong, 47)) > TOUCHING


def shared(shown: Scene, moment: int) -> tuple[float, float]:
    """Largest area [mm2] and distance [mm] between teeth that mesh, of both sides."""
    cut = [Polygon(points[0]) for line, points in shown.placed(slice(moment, moment + 1)) if line.look == "teeth"]
    sun, *others = cut
    meshing = [(sun, others[0]), (others[1], others[2]), (sun, others[3]), (others[4], others[5])]
    return max(a.intersection(b).area for a, b in meshing), max(a.distance(b) for a, b in meshing)


@pytest.mark.parametrize("moment", [0, 47, 133, 200, 291])
def test_teeth_mesh_wherever_the_carrier_is(shown: Scene, moment: int) -> None:
    """Drawn outlines share no more, and are no farther apart, than they are thinned."""
    area, distance = shared(shown, moment)
    assert area < 1e-3
    assert distance < 1e3 * scene.WITHIN


def test_a_gear_turned_by_half_a_tooth_does_not_mesh(shown: Scene) -> None:
    sun, *others = shown.bodies
    turned = replace(sun.parts[0], turn=sun.parts[0].turn + 180 / 31)
    area, _ = shared(replace(shown, bodies=(replace(sun, parts=[turned]), *others)), 47)
    assert area > 1


def test_where_no_teeth_can_be_made_the_pitch_curves_are_drawn(device: Device, monkeypatch: pytest.MonkeyPatch) -> None:
    assert build_scene(device, device.design).toothed
    monkeypatch.setattr(scene, "ORDER", ToothOrder(teeth=8, keep="size"))
    plain = build_scene(device, device.design)
    assert not plain.toothed
    assert picture(plain) == picture(build_scene(device, device.design, toothed=False))


def test_the_nozzle_ends_where_the_tip_is(device: Device, shown: Scene) -> None:
    turn = cycle.evaluate_cycle(device, device.prologue(device.design), cycle.sample_angles(shown.moments)).columns()
    carrier = shown.bodies[1]
    arm, planet = carrier.parts[0], carrier.parts[0].parts[1]
    (_, _, phi), (x, y, own) = shown.pose(carrier), shown.pose(planet)
    heading, at = np.radians(phi), np.radians(phi + own)
    length = device.machine.nozzle.tip_distance_mm
    found = np.array([
        np.cos(heading) * x - np.sin(heading) * y + length * np.cos(at),
        np.sin(heading) * x + np.cos(heading) * y + length * np.sin(at),
    ])  # fmt: skip
    assert arm.turn == 0
    assert found == pytest.approx(np.array([turn["tip_machine_x_mm"], turn["tip_y_mm"]]), abs=1e-9)


def test_what_is_packed_comes_back_as_single_floats(shown: Scene) -> None:
    record = packed(shown)
    for body, told in zip(shown.all_bodies(), record["bodies"], strict=True):
        for channel, one in zip(shown.pose(body), told, strict=True):
            assert unpacked(record, one) == pytest.approx(channel.astype(np.float32), abs=1e-6)
    for curve, one in zip(shown.curves, record["curves"], strict=True):
        assert unpacked(record, one["values"]) == pytest.approx(curve.values.astype(np.float32), abs=1e-6)


def test_what_goes_on_evenly_is_told_by_its_step(shown: Scene) -> None:
    assert packed(shown)["places"] == {"from": 0.0, "step": pytest.approx(1.0)}
    bent = replace(shown, places=shown.places + 1e-6 * np.sin(shown.places))
    assert "series" in packed(bent)["places"]


def test_what_happens_again_half_a_cycle_later_is_packed_once(shown: Scene) -> None:
    values = np.sin(np.linspace(0, 2 * np.pi, shown.moments, endpoint=False)) + 0.3
    twins = [Curve("one", "", values), Curve("two", "", np.roll(values, shown.moments // 2))]
    record = packed(replace(shown, bodies=(), points=(), forces=(), curves=twins, travel=None))
    assert len(base64.b64decode(record["data"])) == 4 * shown.moments
    assert unpacked(record, record["curves"][1]["values"]) == pytest.approx(twins[1].values, abs=1e-6)


def test_a_page_grows_by_less_than_100_kB(shown: Scene) -> None:
    block = Motion(shown)
    assert len(f"{block.html('s1')}{block.script}{block.style}".encode()) < 100_000


def test_names_are_text_and_never_markup(shown: Scene) -> None:
    curves = [replace(shown.curves[0], name="</script><b>bold</b>")]
    text = Motion(replace(shown, title="<i>&", curves=curves)).html("s1")
    assert "<i>" not in text
    assert "<b>" not in text
    assert text.count("</script>") == 1


def test_the_picture_stands_without_a_script(shown: Scene) -> None:
    svg = picture(shown)
    assert svg.count("data-body") == sum(1 for _ in shown.all_bodies())
    assert "<script" not in svg


def moving_page(shown: Scene) -> str:
    return page("A machine", [Section("Motion", [Motion(shown)])])


def test_the_policy_of_a_page_lets_its_own_script_run_alone(shown: Scene, tmp_path: Path) -> None:
    """A reader's browser moves the drawing; of a page whose script was changed it runs nothing."""
    text = moving_page(shown)
    (tmp_path / "own.html").write_text(text, encoding="utf-8")
    told = re.search(r'class="told">([^<]*)<', page_after_scripts(tmp_path / "own.html", tmp_path / "profile"))
    force = f"{shown.curves[0].values[0]:.5g}"
    assert told
    assert told[1] == f"carrier angle 0 deg, vertical support force {force} N"
    (tmp_path / "changed.html").write_text(text.replace("const SPEEDS", "const  SPEEDS"), encoding="utf-8")
    assert 'class="told"' not in page_after_scripts(tmp_path / "changed.html", tmp_path / "profile")
    still = page("A machine", [Section("Motion", [])])
    assert "script-src 'none'" in still
