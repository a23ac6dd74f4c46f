"""Points that the tip's path must pass, and the soil at a level of the machine's frame."""

from pathlib import Path

import numpy as np
import pytest

from planter.engine.solvers.sampled_cycle import sample_angles
from planter.errors import ComputationError, InputError
from planter.files import examples
from planter.papers.planting import file
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.papers.planting.requirement_rows import RequirementRows
from planter.papers.planting.requirements import evaluate_requirements
from planter.papers.planting.swept import ADAPTER
from planter.rows.robust import Settings, find_robust
from planter.text_files import parse_toml
from tests.support.cli import answer

EXAMPLE = Path(__file__).parents[4] / "docs" / "examples" / "tip_path.csv"
POINTS = [[-150.0, -100.0, 30.0], [60.0, -300.0, 5.0], [0.0, 0.0, 2.0]]


def machine(*lines: str, drop: str = "", source: str = "wide.toml") -> PlantingMachine:
    """The wide machine with more lines among its requirements."""
    text = examples.example("wang2017-wide").replace(
        "[requirements]", "[requirements]\n" + "\n".join(lines), 1
    )
    kept_lines = [line for line in text.splitlines() if not drop or not line.startswith(drop)]
    return PlantingMachine.read(parse_toml("\n".join(kept_lines), source), source)


@pytest.fixture(scope="module")
def measures(kernel_cache: None) -> RequirementRows:
    return RequirementRows(Device(machine(f"points_mm = {POINTS}", "tube_excess_max_mm = 0")))


def tip(device: Device, x: np.ndarray) -> np.ndarray:
    """Many points of the path in the machine's frame [mm], (n, 2)."""
    turn = device.columns(x, sample_angles(40_000, 2 * np.pi))
    return np.column_stack([turn["tip_machine_x_mm"], turn["tip_y_mm"]])


def rows(measures: RequirementRows) -> list[int]:
    return [k for k, row in enumerate(measures.rows) if row.kind.name == "tube_excess"]


def test_distance_equals_nearest_dense_point(measures: RequirementRows) -> None:
    x = measures.device.design
    path = tip(measures.device, x)
    expected = [np.hypot(*(path - point[:2]).T).min() - point[2] for point in POINTS]
    np.testing.assert_allclose(1e3 * measures.at(x).values[rows(measures)], expected, atol=1e-4)


def test_slopes_and_curvature_are_those_of_differences(measures: RequirementRows) -> None:
    device, row = measures.device, rows(measures)
    x, width = device.design, device.upper - device.lower
    slopes = measures.slopes(x)[row] * width
    weights = np.zeros(len(measures.rows))
    weights[row] = 1.0, -0.5, 0.3
    bent = measures.curvature(x, weights) * np.outer(width, width)
    for j, step in enumerate(1e-5 * np.diag(width)):
        forward, back = (measures.at(x + sign * step).values[row] for sign in (1, -1))
        np.testing.assert_allclose(slopes[:, j], (forward - back) / 2e-5, atol=2e-8)
        up, down = (weights @ measures.slopes(x + sign * step) * width for sign in (1, -1))
        np.testing.assert_allclose(bent[j], (up - down) / 2e-5, atol=2e-5 * np.abs(bent).max())
    assert np.abs(slopes).max() > 1e-3


def test_worst_point_is_named_by_number(measures: RequirementRows) -> None:
    (requirement,) = [
        requirement
        for requirement in evaluate_requirements(measures, measures.device.design)
        if requirement.name == "tube_excess"
    ]
    assert (requirement.of, requirement.verdict) == ("point 3", "fail")
    assert requirement.value == pytest.approx(
        1e3 * max(measures.at(measures.device.design).values[rows(measures)])
    )


def test_points_in_a_csv_are_the_same_points(tmp_path: Path) -> None:
    lines = "\n".join(",".join(map(str, point)) for point in POINTS)
    (tmp_path / "path.csv").write_text(f"# wanted\nx_mm,y_mm,tube_mm\n{lines}\n")
    changed_machine = machine(
        'points_csv = "path.csv"', "tube_excess_max_mm = 0", source=str(tmp_path / "wide.toml")
    )
    assert changed_machine.table()["requirements"]["points_mm"] == POINTS
    assert "points_csv" not in changed_machine.table()["requirements"]


def test_the_documented_example_runs(tmp_path: Path) -> None:
    (tmp_path / "tip_path.csv").write_bytes(EXAMPLE.read_bytes())
    more = (
        '[requirements]\npoints_csv = "tip_path.csv"\ntube_excess_max_mm = 0\nsoil_line_mm = -270'
    )
    text = examples.example("wang2017-wide").replace("[requirements]", more, 1)
    text = "\n".join(line for line in text.splitlines() if not line.startswith("soil_depth_mm"))
    (tmp_path / "mine.toml").write_text(text)
    requirements = {
        requirement["name"]: requirement
        for requirement in answer("validate", str(tmp_path / "mine.toml"))["requirements"]
    }
    assert requirements["tube_excess"]["of"].startswith("point ")
    assert requirements["depth"]["value"] > 0


REFUSED = {
    "another header": ("x_mm,y_mm\n1,2\n", "path.csv: line 1", "it must be x_mm,y_mm,tube_mm"),
    "a word": (
        "x_mm,y_mm,tube_mm\n1,two,3\n",
        "path.csv: line 2, column y_mm",
        "it must be a finite number",
    ),
    "no room": (
        "x_mm,y_mm,tube_mm\n1,2,0\n",
        "requirements.points_mm[0][2]",
        "it must be greater than 0",
    ),
}


@pytest.mark.parametrize(("text", "place", "allowed"), REFUSED.values(), ids=REFUSED.keys())
def test_invalid_points_are_refused_with_place(
    tmp_path: Path, text: str, place: str, allowed: str
) -> None:
    (tmp_path / "path.csv").write_text(text)
    with pytest.raises(InputError) as refused:
        machine(
            'points_csv = "path.csv"', "tube_excess_max_mm = 0", source=str(tmp_path / "wide.toml")
        )
    assert place in refused.value.message
    assert allowed in refused.value.message


def test_points_and_limit_require_each_other() -> None:
    with pytest.raises(InputError, match="points_mm or in a CSV, not in both"):
        machine(f"points_mm = {POINTS}", 'points_csv = "path.csv"')
    with pytest.raises(InputError, match="points_mm is missing: tube_excess is limited"):
        machine("tube_excess_max_mm = 0")
    with pytest.raises(InputError, match="not both"):
        machine("soil_line_mm = -270")


def test_a_soil_line_at_the_depths_level_is_the_same_soil(kernel_cache: None) -> None:
    deep = RequirementRows(Device(file.load("wang2017-wide")))
    x = deep.device.design
    line = 1e3 * float(tip(deep.device, x)[:, 1].min() / 1e3) + 60
    level = RequirementRows(Device(machine(f"soil_line_mm = {line}", drop="soil_depth_mm")))
    np.testing.assert_allclose(level.at(x).values, deep.at(x).values, rtol=1e-4, atol=1e-6)
    depth = [row.kind.name for row in deep.rows].index("depth")
    assert not np.abs(deep.slopes(x)[depth]).any()
    width = deep.device.upper - deep.device.lower
    slope = level.slopes(x)[depth] * width
    for j, step in enumerate(1e-5 * np.diag(width)):
        forward, back = (level.at(x + sign * step).values[depth] for sign in (1, -1))
        assert abs(slope[j] - (forward - back) / 2e-5) < 1e-7
    assert np.abs(slope).max() > 1e-3


def test_unreached_soil_line_is_reported() -> None:
    far = RequirementRows(Device(machine("soil_line_mm = -900", drop="soil_depth_mm")))
    with pytest.raises(ComputationError, match="never reaches the soil with soil_line_mm = -900"):
        far.at(far.device.design)


@pytest.mark.long
def test_a_robust_design_keeps_the_requirements(kernel_cache: None) -> None:
    changed_machine = machine().with_numbers({"objective.samples": 60})
    settings = Settings(machines=2, starts=1)
    robust = find_robust(ADAPTER.build_robust(changed_machine, {}, {}, settings), settings, None)
    device = Device(changed_machine)
    values = {
        requirement.name: requirement.verdict
        for requirement in evaluate_requirements(RequirementRows(device), device.x(**robust.design))
    }
    assert "fail" not in values.values()
