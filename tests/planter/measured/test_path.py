"""`planter calibrate --data` without an angle: measured points laid over the path of a point."""

from __future__ import annotations

from pathlib import Path

import jsonschema
import numpy as np
import pytest

from planter.engine.machine import Machine, load_machine
from planter.engine.response import MachineResponse
from planter.kernels import Array
from planter.measured.curve import Chosen
from planter.measured.logger_table import read_logger_table
from planter.measured.path_comparison import PathComparison
from planter.measured.path_curve import PathCurve
from planter.measured.reading import Columns, read_path
from planter.mechanism.calibration import MeasuredSource, compare_path_to_data
from planter.mechanism.file import load
from planter.task import Means
from tests.support import own
from tests.support.cli import answer, refusal
from tests.support.schemas import load_schema

pytestmark = pytest.mark.usefixtures("kernel_cache")

ARM = "transplanting_arm"
TIP = ("x_tip_mm", "y_tip_mm")
COLUMNS = Columns(("x", "y"))
TRUE = {"p_mm": 252.5, "n_mm": -71.25, "a_mm": 47.0}
BOUNDS = {"p_mm": (200.0, 280.0), "n_mm": (-140.0, -40.0), "a_mm": (35.0, 60.0)}
FRAME_BOUNDS = {
    "frame_deg": (-180.0, 180.0),
    "frame_x_mm": (-300.0, 300.0),
    "frame_y_mm": (-300.0, 300.0),
}
PLACED = {"frame_deg": 115.0, "frame_x_mm": 30.0, "frame_y_mm": -50.0}


def trace(machine: Machine, keys: tuple[str, str], phi: Array) -> tuple[Array, Array]:
    """Return points (2, n) [mm] of a path, and their derivatives in the angle."""
    quantities = [machine.find_quantity(key) for key in keys]
    response = MachineResponse(machine, [quantity.name for quantity in quantities])
    factors = np.array([quantity.factor for quantity in quantities])[:, None]
    values, rates = response.derivatives(response.at_data(machine.data), phi)
    return values / factors, rates / factors


def unplace(points: Array) -> Array:
    """Return points in the frame whose pose in that of the machine is `PLACED`."""
    angle = np.radians(PLACED["frame_deg"])
    rotation = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    origin = np.array([[PLACED["frame_x_mm"]], [PLACED["frame_y_mm"]]])
    return rotation.T @ (points - origin)


def write(path: Path, points: Array, header: str = "x [mm],y [mm]", factor: float = 1.0) -> Path:
    rows = [",".join(f"{number / factor:.15g}" for number in row) for row in points.T]
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def compare(
    machine: Machine, data: Path, keys: tuple[str, str] = TIP, **bounds: tuple[float, float]
) -> PathComparison:
    source = MeasuredSource(machine, data, COLUMNS, keys)
    return compare_path_to_data(source, bounds, means=Means(1))


def build_path_curve(data: Path, **bounds: tuple[float, float]) -> PathCurve:
    machine = own.machine(ARM)
    measured = read_path(read_logger_table(data), COLUMNS)
    return PathCurve(machine, Chosen.from_bounds(machine, bounds), measured, TIP)


def test_distance_is_square_to_the_path_and_least(tmp_path: Path) -> None:
    """At the nearest point the line to it is a normal, and no point of a fine polygon is nearer."""
    machine, rng = own.machine(ARM), np.random.default_rng(2)
    fine, _ = trace(machine, TIP, np.linspace(0, 2 * np.pi, 20_001))
    middle, extent = fine.mean(axis=1, keepdims=True), np.ptp(fine, axis=1)[:, None]
    points = middle + extent * rng.uniform(-1, 1, (2, 40))
    result = compare(machine, write(tmp_path / "far.csv", points)).distances
    nearest, rates = trace(machine, TIP, result.angles)
    offsets = points - nearest
    cosines = (offsets * rates).sum(axis=0) / np.hypot(*offsets) / np.hypot(*rates)
    assert np.abs(cosines).max() < 1e-9
    sampled = np.hypot(*(points[:, :, None] - fine[:, None, :])).min(axis=1)
    chord = np.hypot(*np.diff(fine)).max()
    lengths = np.abs(result.distances)
    assert (lengths <= sampled * (1 + 1e-12)).all()
    assert (np.sqrt(lengths**2 + chord**2 / 4) >= sampled * (1 - 1e-6)).all()
    assert {-1.0, 1.0} == set(np.sign(result.distances))


def test_offsets_come_back_with_sign_angle_and_arc(tmp_path: Path) -> None:
    machine, phi = own.machine(ARM), np.linspace(0.1, 6.1, 41)
    points, rates = trace(machine, TIP, phi)
    normals = np.array([-rates[1], rates[0]]) / np.hypot(*rates)
    offsets = 0.4 * np.cos(3 * phi)
    compared = compare(machine, write(tmp_path / "beside.csv", points + offsets * normals))
    result, distances = compared.result, compared.distances
    np.testing.assert_allclose(distances.distances, offsets, atol=1e-9)
    np.testing.assert_allclose(distances.angles, phi, atol=1e-9)
    fine, _ = trace(machine, TIP, np.linspace(0, 2 * np.pi, 40_001))
    assert result.length_mm == pytest.approx(np.hypot(*np.diff(fine)).sum(), rel=1e-7)
    first, _ = trace(machine, TIP, np.linspace(0, phi[7], 20_001))
    assert distances.arcs[7] == pytest.approx(np.hypot(*np.diff(first)).sum(), rel=1e-7)
    worst = int(np.abs(offsets).argmax())
    assert result.largest.point == worst + 1
    assert result.largest.phi_deg == pytest.approx(np.degrees(phi[worst]))
    assert result.rms_mm == pytest.approx(np.sqrt(np.mean(offsets**2)))
    assert (result.fit, result.outcome, result.fitted) == (None, None, [])
    assert result.placement.fitted == []


def test_jacobian_matches_differences(tmp_path: Path) -> None:
    machine = own.machine(ARM)
    points, rates = trace(machine, TIP, np.linspace(0, 6, 20))
    data = write(tmp_path / "points.csv", points + 0.02 * rates[::-1])
    curve = build_path_curve(data, **BOUNDS, **FRAME_BOUNDS)
    z = curve.machine_values() + np.array([1e-3, 2e-3, 1e-3, 0.02, 1e-3, -2e-3])
    slopes = curve(z)[1]
    for i in range(len(z)):
        step = np.zeros(len(z))
        step[i] = 1e-6
        difference = (curve(z + step)[0] - curve(z - step)[0]) / 2e-6
        np.testing.assert_allclose(slopes[:, i], difference, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("is_placed", [False, True])
def test_exact_points_give_design_back(tmp_path: Path, is_placed: bool) -> None:
    """A part of the path, reversed, in m, and in a frame of its own."""
    points, _ = trace(own.machine(ARM, **TRUE), TIP, np.linspace(0.4, 4.4, 40)[::-1])
    written = unplace(points) if is_placed else points
    data = write(tmp_path / "part.csv", written, "x / m,y / m", 1e3)
    bounds = {"a_mm": BOUNDS["a_mm"], **FRAME_BOUNDS} if is_placed else BOUNDS
    truth = {"a_mm": 47.0, **PLACED} if is_placed else TRUE
    start = {"p_mm": 252.5, "n_mm": -71.25} if is_placed else {}
    compared = compare(own.machine(ARM, **start), data, **bounds)
    values = {entry.name.removeprefix("values."): entry.value for entry in compared.result.fitted}
    assert values == pytest.approx(truth, rel=1e-6)
    assert compared.result.rms_mm < 1e-6
    assert compared.result.outcome == "explained"
    assert compared.result.placement.fitted == (list(PLACED) if is_placed else [])
    assert compared.machine is not None
    assert compared.machine.si("values.a_mm") == pytest.approx(0.047)


def test_intervals_contain_truth_and_circle_is_refuted(tmp_path: Path) -> None:
    phi = np.linspace(0, 2 * np.pi, 120, endpoint=False)
    points, _ = trace(own.machine(ARM, **TRUE), TIP, phi)
    noisy = points + np.random.default_rng(3).normal(0, 0.2, points.shape)
    result = compare(own.machine(ARM), write(tmp_path / "noisy.csv", noisy), **BOUNDS).result
    assert result.outcome == "explained"
    assert result.rms_mm == pytest.approx(0.2, rel=0.2)
    for entry in result.fitted:
        low, high = entry.interval
        assert low < TRUE[entry.name.removeprefix("values.")] < high
        assert high - low < 0.2 * (entry.upper - entry.lower)
    circle = points.mean(axis=1)[:, None] + 60 * np.array([np.cos(phi), np.sin(phi)])
    refuted = compare(own.machine(ARM), write(tmp_path / "circle.csv", circle), **BOUNDS).result
    assert refuted.outcome != "explained"
    assert refuted.rms_mm > 20


def test_device_tip_and_needle_are_compared(tmp_path: Path) -> None:
    """The planting device's tip in its machine's frame, and the pick-up's needle with its corners."""
    needle = load_machine("yu2023", {"bars.L2_mm": 164.0})
    phi = np.linspace(0, 2 * np.pi, 50, endpoint=False)
    keys = ("x_S_mm", "y_S_mm")
    data = write(tmp_path / "needle.csv", trace(needle, keys, phi)[0])
    base = load_machine("yu2023", {})
    assert compare(base, data, keys).result.rms_mm > 0.3
    result = compare(base, data, keys, **{"bars.L2_mm": (150.0, 180.0)}).result
    assert result.fitted[0].value == pytest.approx(164.0)
    tip = ("tip_machine_x_mm", "tip_y_mm")
    points = trace(load_machine("wang2017", {}), tip, phi)[0] + np.array([[0.5], [0.0]])
    path = str(write(tmp_path / "tip.csv", points))
    call = ("--column", "x", "--column", "y", "--quantity", tip[0], "--quantity", tip[1])
    result = answer("calibrate", "wang2017", "--data", path, *call, "--fit", "frame_x_mm=-2:2")
    assert result["placement"]["x_mm"] == pytest.approx(-0.5)
    assert result["placement"]["fitted"] == ["frame_x_mm"]


def test_command_writes_schema_figure_and_files(tmp_path: Path) -> None:
    points, _ = trace(own.machine(ARM, a_mm=47.0), TIP, np.linspace(0, 6, 30))
    data = write(tmp_path / "path.csv", np.hstack([points, [[np.nan], [1.0]]]))
    path = str(own.generated(ARM) / f"{ARM}.toml")
    call = ("--data", str(data), "--column", "x", "--column", "y")
    named = (*call, "--quantity", TIP[0], "--quantity", TIP[1])
    out = tmp_path / "out"
    result = answer("calibrate", path, *named, "--fit", "a_mm=35:60", "--out", str(out))
    jsonschema.validate(result, load_schema("calibrate"))
    assert result["points"] == 30
    assert result["reading"]["dropped"][0]["lines"] == [32]
    assert load(out / "calibrated.toml").values["a_mm"] == pytest.approx(47.0)
    assert (out / "figures" / "path.svg").is_file()
    lines = (out / "distances.csv").read_text(encoding="utf-8").splitlines()
    header, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    assert header[-2:] == ["arc_mm", "distance_mm"]
    assert len(rows) == 30
    preview = answer("calibrate", path, *named, "--preview")
    assert preview["reading"]["revolutions"] is None
    assert "phase_deg" in refusal("calibrate", path, *named, "--fit", "phase_deg=0:9")
    assert "--explain" in refusal("calibrate", path, *named, "--explain", "--fit", "a_mm=35:60")
    assert "--prior" in refusal("calibrate", path, *named, "--prior", "a_mm=45:1")
    timed = (*named, "--interval-s", "0.01")
    assert "frame_deg" in refusal("calibrate", path, *timed, "--fit", "frame_deg=0:9")
    write(tmp_path / "path.csv", points[:, :2])
    assert "too few" in refusal("calibrate", path, *named)
