"""`planter gears`: keys of the contract, files, own curves, results fed back, one sentence for bad
input.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import shapely

from planter.files import examples
from planter.gears.geometry.cutting import ToothOrder
from planter.gears.geometry.polygons import build_polygon
from planter.gears.parts import PlacedGear
from planter.papers.mapping.curve import AngleCurve
from planter.papers.mapping.train import Train, polar_curves
from planter.papers.planting import toothed
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from tests.support.cli import answer, refusal
from tests.support.outlines import read_dxf
from tests.support.schemas import load_schema
from tests.support.tables import write_cycle_csv

NAMES = [["sun", "gear 5"], ["gear 6", "planet gear"]]


@pytest.fixture(scope="module")
def device() -> Device:
    return Device(load("wang2017"))


def curve_file(path: Path, radius_mm: np.ndarray, sense: int = 1) -> str:
    """A curve with as many points as radii, the first once more at the end."""
    polar = sense * np.linspace(0, 360, len(radius_mm) + 1)
    write_cycle_csv(
        path, ["measured"], {"polar_deg": polar, "radius_mm": [*radius_mm, radius_mm[0]]}
    )
    return str(path)


def wavy(size: float = 40.0, wave: float = 3.0, count: int = 60, lobes: int = 1) -> np.ndarray:
    return size + wave * np.cos(2 * np.pi * lobes * np.arange(count) / count + 0.4)


def test_flanks_keep_their_gap_and_friction_its_work() -> None:
    result = answer("gears wang2017 --teeth 31,33 --backlash-mm 0.05")
    jsonschema.validate(result, load_schema("gears"))
    gap = pytest.approx(0.025 * np.cos(np.pi / 9), abs=1e-10)
    for stage, names, z in zip(result["stages"], NAMES, (31, 33), strict=True):
        assert [gear["name"] for gear in stage["gears"]] == names
        assert (stage["z"], stage["scale"], stage["overlap_mm2"]) == ([z, z], 1.0, 0)
        length = np.pi * z * stage["module_mm"]
        assert stage["perimeter_mm"] == pytest.approx([length, length], rel=1e-10)
        assert stage["gap_mm"] == {"min": gap, "max": gap}
        assert stage["transmission_error_rad"] < 1e-11
    assert (result["scaled"], result["files"]) == (None, [])
    sliding = result["friction"]["sliding"]
    assert sliding["motor_work_J"] == pytest.approx(sum(sliding["lost_J"].values()), rel=1e-7)
    assert sliding["motor_work_J"] > result["friction"]["convention"]["motor_work_J"]


@pytest.mark.parametrize(("error_mm", "sense"), [(0.3, 1), (3.9, -1)])
def test_conjugate_of_a_curve_at_a_larger_distance(
    tmp_path: Path, error_mm: float, sense: int
) -> None:
    """Teeth lose contact at the larger error."""
    file = curve_file(tmp_path / "own.csv", wavy(), sense)
    options = ("--backlash-mm", "0.1", "--centre-error-mm", str(error_mm))
    result = answer(f"gears --curve {file} --teeth 40 --keep size", *options)
    (stage,), touches = result["stages"], error_mm < 1
    assert (result["friction"], stage["z"], stage["overlap_mm2"]) == (None, [40, 40], 0)
    assert stage["transmission_error_rad"] < 1e-11
    single, both = stage["lost_motion_deg"], stage["lost_motion_total_deg"]
    assert 2 * single["min"] <= both["min"] <= both["max"] <= 2 * single["max"]
    for key in ("farther_lost_motion_deg", "farther_total_deg", "farther_contact_ratio"):
        assert (stage[key] is not None) == touches
    if touches:
        assert stage["farther_total_deg"]["min"] > both["min"]
        assert stage["farther_contact_ratio"]["min"] < stage["contact_ratio"]["min"]


def test_standard_module_scales_pair_and_reports_effects() -> None:
    result = answer("gears wang2017 --module1 2 --module2 1.5 --keep module")
    design_distance = answer("simulate wang2017")["centre_distance_mm"]
    for stage, module, name in zip(result["stages"], (2, 1.5), ("a1", "a2"), strict=True):
        assert stage["module_mm"] == pytest.approx(module, rel=1e-14)
        assert stage["centre_distance_mm"] == pytest.approx(
            stage["scale"] * design_distance[name], rel=1e-12
        )
    scaled = result["scaled"]
    again = answer("simulate wang2017", *(f"--set={k}={v!r}" for k, v in scaled["design"].items()))
    distances = [stage["centre_distance_mm"] for stage in result["stages"]]
    assert list(again["centre_distance_mm"].values()) == pytest.approx(distances, rel=1e-12)
    assert 0.01 < scaled["tip_moved_max_mm"] < 5
    assert scaled["broken"] is None


def test_gears_mesh_where_an_assembly_puts_them(device: Device) -> None:
    train = toothed.cut_gear_train(device, [ToothOrder()] * 2)
    shapes = [shape(placed) for placed in train.place_gears()]
    for first, second in ((0, 1), (2, 3)):
        assert shapely.intersection(shapes[first], shapes[second]).area < 1e-13
        assert shapely.distance(shapes[first], shapes[second]) < 2e-7
    turned = [PlacedGear(p.gear, p.angle + 1e-3, p.centre) for p in train.place_gears()]
    assert shapely.intersection(shapes[0], shape(turned[1])).area > 1e-9


def test_flank_cut_at_turning_point_is_reported(device: Device) -> None:
    """There the flank stands still, and its arc length is known to half the digits."""
    slender = ToothOrder(
        pressure_angle=np.radians(14.5), addendum=1.3, process="wire", allow_undercut=True
    )
    train = toothed.cut_gear_train(device, [replace(slender, teeth=45), replace(slender, teeth=60)])
    assert all(shape(placed).is_valid for placed in train.place_gears())


def shape(placed: PlacedGear) -> shapely.Polygon:
    c, s = np.cos(placed.angle), np.sin(placed.angle)
    return shapely.Polygon(build_polygon(placed.gear) @ np.array([[c, s], [-s, c]]) + placed.centre)


def test_marks_of_gears_on_a_shaft_agree(device: Device) -> None:
    """The angle between the teeth of gears 5 and 6 follows from gamma, beta6 and the sun's
    phase.
    """
    _, five, six, _ = toothed.cut_gear_train(device, [ToothOrder(module=2e-3)] * 2).place_gears()
    assert five.key is not None
    assert six.key is not None
    assert np.exp(1j * (five.angle + five.key)) == pytest.approx(
        np.exp(1j * (six.angle + six.key)), abs=1e-12
    )
    design = dict(zip(device.names, device.design, strict=True))
    between = six.angle - five.angle
    expected = design["gamma_deg"] + design["beta6_deg"] - np.pi - _turned(device)
    assert np.exp(1j * between) == pytest.approx(np.exp(1j * expected), abs=1e-9)


def _turned(device: Device) -> float:
    """How far gear 5 has turned from where the sun's curve begins to where the machine starts."""
    stage, parameters = device.stages[0], device.of_stage(0, device.design)
    hoisted = stage.prologue(parameters=parameters)["hoisted"]
    alpha3 = device.design[device.names.index("alpha3_deg")]
    return float(
        stage.contact(t=np.array([alpha3]), parameters=parameters, hoisted=hoisted)["turned"][0, 0]
    )


@pytest.mark.long
def test_files_agree_with_json(tmp_path: Path) -> None:
    result = answer(
        "gears wang2017 --module 2 --bore-mm 14 --stl --out",
        str(tmp_path / "out"),
    )
    names = {Path(file).name for file in result["files"]}
    assert names >= {
        f"{stem}.{kind}"
        for stem in ("sun", "gear_5", "gear_6", "planet_gear")
        for kind in ("dxf", "svg", "stl")
    }
    assert names >= {"assembly.dxf", "assembly.svg", "sun_flanks.csv", "friction.csv"}
    assert all(Path(file).is_file() for file in result["files"])
    document, lines = read_dxf((tmp_path / "out" / "assembly.dxf").read_bytes())
    assert (document.audit().errors, len(lines["TEETH"])) == ([], 4)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["stages"] == result["stages"]
    assert summary["friction"] == result["friction"]
    assert "fetch" not in (page := (tmp_path / "out" / "report.html").read_text())
    assert "planet gear" in page
    head = (tmp_path / "out" / "sun_flanks.csv").read_text().splitlines()[3]
    assert head == "piece,tooth,side,arc_length_mm,x_mm,y_mm,normal_x,normal_y,curvature_per_mm"


def test_curves_of_a_train_are_taken(tmp_path: Path) -> None:
    """Both gears of a stage in one file, points crowded where the slope is least; the mate is held
    to the gear.
    """
    carrier = np.radians(np.arange(0, 361, 15))
    result = Train(AngleCurve(carrier, -carrier + np.radians(8) * np.sin(carrier)), 0.07)
    polar, radii = polar_curves(result)
    columns = {}
    for number, name in enumerate(("driver", "follower")):
        columns[f"{name}_polar_deg"] = np.degrees(polar[number])
        columns[f"{name}_radius_mm"] = 1e3 * radii[number]
    file = tmp_path / "pitch_curves.csv"
    write_cycle_csv(file, ["a train"], columns)
    answered = answer(f"gears --curve {file}:driver --mate {file}:follower --teeth 45")
    assert answered["stages"][0]["centre_distance_mm"] == pytest.approx(70, abs=1e-4)
    text = refusal(f"gears --curve {file}:driver --mate {file}:driver --teeth 45")
    assert "the conjugate of the gear has" in text


BAD = {
    "--module 2 --teeth 40,40": (
        "stage 1: teeth = 40 and module = 2 mm disagree: the pitch curve is 194.467 mm long"
    ),
    "--teeth 5,31": "5 teeth: there must be 6 to 1000",
    "--teeth 12,31": "sun: the flanks of tooth 0, 1, 2, 3, 4, 5 and 6 more are undercut",
    "--module 2 --backlash-mm 0.5": (
        "play = 0.5 mm: the backlash must be at most 0.2 modules, 0.4 mm"
    ),
    "--module 2 --bore-mm 46 --keyway-mm none": "at least 2.25 mm",
    "--teeth 31": "it must be Z1,Z2",
    "--teeth a,b": "--teeth a,b: give Z",
    "--module 2 --module1 2": "--module sets both stages",
    "--set e3_mm=15 --set R3_mm=31 --set m31=1.9": (
        "sun: the pitch curve is concave with a radius of 21.16 mm at"
    ),
    "--keyway-mm 4,2": "needs --bore-mm",
    "--curve own.csv": "either MACHINE or --curve",
    "--turns 2": "--turns goes with --curve, not with MACHINE",
    "--mate own.csv": "--mate goes with --curve, not with MACHINE",
    "--stl": "--stl needs --out DIR",
}


@pytest.mark.parametrize("options", BAD)
def test_invalid_input_exits_with_single_line(options: str) -> None:
    assert BAD[options] in refusal("gears wang2017", *options.split())


@pytest.mark.parametrize(
    ("machine", "message"),
    [
        ("wang2071", "did you mean wang2017"),
        ("shi2021", "use one like compact, wang2017"),
        ("own.toml", "there is no such file"),
    ],
)
def test_machine_without_gears_is_refused(machine: str, message: str) -> None:
    assert message in refusal(f"gears {machine}")


def test_faulty_file_is_reported_by_the_package(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(examples.example("wang2017").replace("[stage1]", "[first]"))
    assert "stage1" in refusal(f"gears {file}")
    file.write_text(examples.example("yu2023").replace("[carrier]", "[carriers]"))
    assert "carrier" in refusal(f"gears {file}")


def test_impossible_curves_are_refused(tmp_path: Path) -> None:
    message = {
        "narrow": (wavy(40, 9, lobes=2), "which no hob can cut"),
        "few": (wavy(count=5), "6 points"),
        "sharp": (wavy(20, 6, lobes=4), "gear: the pitch curve's radius is"),
    }
    for name, (radius, sentence) in message.items():
        file = curve_file(tmp_path / f"{name}.csv", radius)
        assert sentence in refusal(f"gears --curve {file} --module 5")
    file = curve_file(tmp_path / "own.csv", wavy())
    assert "needs 80 teeth" in refusal(f"gears --curve {file} --teeth 40,41 --turns 2")
    for option in ("--module2", "--speed-rpm"):
        message = refusal(f"gears --curve {file} --teeth 40", option, "2")
        assert f"{option} goes with MACHINE, not with --curve" in message
    assert "has no column other_polar_deg" in refusal(f"gears --curve {file}:other --teeth 40")
