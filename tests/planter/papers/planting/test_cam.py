"""The end-face cam of a planting device: a roller led along touches it, unrolled and in space; the
command.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from shapely import Point, Polygon

from planter import simulate
from planter.gears.workshop.cam import find_lift_off
from planter.kernels import Array
from planter.papers.planting import cam, file
from planter.papers.planting.model import Device
from tests.support.cli import answer, refusal
from tests.support.outlines import read_dxf

ROLLER = 0.006
NEAR = 2e-4
"""How near to the station a place counts as in its section [m]."""
FINE = np.linspace(0, 2 * np.pi, 3601)


@pytest.fixture(scope="module")
def device() -> Device:
    return Device(file.load("wang2017"))


@pytest.fixture(scope="module")
def face(device: Device) -> cam.EndFace:
    return cam.EndFace(device, ROLLER)


def gaps(face: cam.EndFace, station: float, by: float = 0.0) -> Array:
    """Least distance of each of some places of the cam from the roller's axis while the cam turns,
    less its radius.

    `by` raises the cam.
    """
    course = face.section(station)
    profile, way = course(np.radians(np.arange(0, 360, 7))), course(FINE)
    swing, height = way["theta1"], way["height"]
    x, y, z = (profile[f"surface_{axis}"][:, None] for axis in "xyz")
    projected = x * np.cos(FINE) - y * np.sin(FINE)
    depth = x * np.sin(FINE) + y * np.cos(FINE)
    machine = face.device.machine
    roller = machine.si("hinge_A_mm[0]") - machine.si("rocker_length_mm") * np.cos(
        machine.si("psi0_deg") + swing
    )
    is_near = np.abs(depth - station) < NEAR
    distance = np.where(is_near, np.hypot(projected - roller, z + by - height), np.inf)
    smallest: Array = distance.min(axis=1) - ROLLER
    return smallest


@pytest.mark.parametrize("station", [0.025, 0.030, 0.036])
def test_a_roller_in_space_touches_the_surface_and_never_cuts_it(
    face: cam.EndFace, station: float
) -> None:
    assert np.abs(gaps(face, station)).max() < 2e-6


def test_a_raised_cam_would_be_cut(face: cam.EndFace) -> None:
    assert gaps(face, 0.030, by=5e-6).min() < -4e-6


def test_the_unrolled_cam_touches_the_roller_everywhere(face: cam.EndFace) -> None:
    contact = face.at(face.radius)
    part = cam.build_cam(face.device, ROLLER, 1e-7, 0.01).part
    strip = Polygon(part.lines[0].arcs.points(1e-8))
    places = contact.course(np.linspace(0.05, 2 * np.pi - 0.05, 80))
    off = [
        strip.distance(Point(x, y)) - ROLLER
        for x, y in zip(*(places[p] for p in contact.pitch), strict=True)
    ]
    assert np.abs(off).max() < 3e-7


def test_dwell_pressure_angle_equals_rocker(face: cam.EndFace) -> None:
    angles = np.degrees(face.at(face.radius).course(np.radians([10.0, 200.0]))["pressure"])
    machine = face.device.machine.cam
    np.testing.assert_allclose(
        angles, [abs(machine.psi0_deg), machine.psi0_deg + machine.opening_deg], rtol=1e-12
    )


@pytest.mark.parametrize(
    "changes", [{}, {"cam.opening_deg": 14.0, "design.R3_mm": 30.6, "speed_rpm": 31.0}]
)
def test_the_part_is_as_steep_as_the_running_device_finds_it(changes: dict[str, float]) -> None:
    """Two derivations, one of the cam by its own angle, one of the machine as it runs."""
    other = Device(file.load("wang2017", changes))
    steepest = (
        cam.EndFace(other, ROLLER).at(other.machine.si("base_radius_mm")).find_largest("pressure")
    )
    designer = simulate(other, 16).result.designer
    assert designer.cam_pressure_angle_max_deg == pytest.approx(
        np.degrees(steepest.value), rel=1e-9
    )


def test_force_vanishes_at_lift_off_speed_squared(device: Device) -> None:
    push, speed = cam.build_push(device), device.machine.si("speed_rpm")
    lift_off = find_lift_off(push, speed)
    assert lift_off is not None
    angles = np.linspace(0, 2 * np.pi, 721)
    rest, low_force, high_force = (push(angles, share * speed) for share in (1e-3, 1.0, 2.0))
    np.testing.assert_allclose(high_force - rest, 4 * (low_force - rest), atol=1e-3)
    place, limit = np.radians([lift_off.angle_deg]), lift_off.speed_rpm * np.pi / 30
    assert abs(push(place, limit)[0]) < 1e-6
    assert push(angles, 0.999 * limit).min() > 0 > push(place, 1.001 * limit)[0]
    np.testing.assert_allclose(low_force, device.side(device.design, angles)["F_E"], rtol=1e-12)


def test_command_writes_listed_files(tmp_path: Path) -> None:
    result = answer("cam", "wang2017", "--roller-mm", "5", "--out", str(tmp_path))
    assert all((tmp_path / name).is_file() for name in result["files"])
    assert json.loads((tmp_path / "summary.json").read_text())["roller"] == result["roller"]
    document, lines = read_dxf((tmp_path / "contour.dxf").read_bytes())
    assert not document.audit().errors
    assert lines["CONTOUR"][0].closed
    assert 0 < result["contour"]["deviation_um"] <= 1
    assert result["lift_off"]["speed_rpm"] > result["lift_off"]["own_speed_rpm"] == 40


def test_a_solid_reads_back_valid(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("OCP", reason="planter[step] is not installed: Open CASCADE, 477 MB")
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.STEPControl import STEPControl_Reader

    result = answer("cam", "wang2017", "--roller-mm", "5", "--step", "--out", str(tmp_path))
    assert "cam.step" in result["files"]
    assert capfd.readouterr().out == ""
    reader = STEPControl_Reader()
    reader.ReadFile(str(tmp_path / "cam.step"))
    reader.TransferRoots()
    assert BRepCheck_Analyzer(reader.OneShape()).IsValid()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            ("--roller-mm", "9"),
            "wang2017: a roller of a radius of 9 mm undercuts the contour at a cam angle of 257.",
        ),
        (("--roller-mm", "0"), "--roller-mm = 0: give a radius above 0 and up to 1000"),
        (("--roller-mm", "nan"), "--roller-mm = nan"),
        (
            ("--roller-mm", "5", "--width-mm", "60"),
            "less than the base cylinder's diameter of 60 mm",
        ),
        (("--roller-mm", "5", "--step"), "--step needs --out DIR to write the solid to"),
        (("--roller-mm", "5", "--force", "F_E"), "--force is for a mechanism of your own"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(options: tuple[str, ...], message: str) -> None:
    assert message in refusal("cam", "wang2017", *options)
