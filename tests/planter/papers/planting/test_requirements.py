"""Requirements: what they measure, that their derivatives are exact, and what happens where they
cannot be kept.
"""

import json
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planter.engine.machine import load_machine
from planter.engine.search import SearchSpec
from planter.engine.solvers import certificate
from planter.engine.solvers.constraints import FEASIBILITY_TOLERANCE
from planter.engine.solvers.feasibility import find_feasible_or_nearest, minimise_violation
from planter.engine.solvers.problem import Problem
from planter.errors import InputError
from planter.files import examples
from planter.mechanism.optimisation import optimise_machine
from planter.papers.planting import file as machine
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from planter.papers.planting.objective import build_problem as problem_with
from planter.papers.planting.requirement_rows import RequirementRows
from planter.papers.planting.requirements import (
    RequirementConstraints,
    build_infeasibility_error,
    evaluate_requirements,
    measure_excess,
)
from planter.papers.planting.requirements_section import KINDS
from tests.support.cli import answer, refusal, run

WIDE = "wang2017-wide"


@pytest.fixture(scope="module")
def device() -> Device:
    return Device(machine.load(WIDE))


@pytest.fixture(scope="module")
def measures(device: Device) -> RequirementRows:
    return RequirementRows(device)


@pytest.fixture(scope="module")
def entries(device: Device, measures: RequirementRows) -> dict[str, dict]:
    return {entry.name: entry for entry in evaluate_requirements(measures, device.design)}


@pytest.fixture(scope="module")
def path(device: Device) -> dict[str, np.ndarray]:
    """A turn of side 1 around its lowest point, densely sampled."""
    phi = np.linspace(-np.pi / 2, 3 * np.pi / 2, 40_001)
    return {"phi": phi, **device.columns(device.design, phi)}


# --- what they measure: against dense samples of the motion
# -------------------------------------------


def test_every_requirement_has_a_margin(entries: dict[str, dict]) -> None:
    assert list(entries) == [kind.name for kind in KINDS if kind.needs != ("points_mm",)]
    for entry in entries.values():
        rooms = [entry.value - entry.lower] if entry.lower is not None else []
        rooms += [entry.upper - entry.value] if entry.upper is not None else []
        assert entry.margin == pytest.approx(min(rooms))
        assert entry.origin.startswith("assumed")
        verdicts = {"fail": entry.margin < 0, "pass": entry.margin >= entry.wanted_margin}
        assert verdicts.get(entry.verdict, 0 <= entry.margin < entry.wanted_margin), entry.name


def test_spacing_is_half_a_turn_of_travel(entries: dict[str, dict]) -> None:
    assert entries["spacing"].value == pytest.approx(0.667 * 60 / 40 / 2 * 1e3)


def test_values_are_those_of_the_path(
    entries: dict[str, dict], path: dict[str, np.ndarray]
) -> None:
    x, y, tilt = path["tip_x_mm"], path["tip_y_mm"], path["alpha_deg"] - 90
    low, high = int(y.argmin()), int(y.argmax())
    soil = y[low] + 60
    inside = y < soil
    cut = x[inside] + (soil - y[inside]) * np.tan(np.radians(tilt[inside]))
    speed = np.gradient(x, path["phi"]) * 40 * np.pi / 30
    x_b, y_b = path["x_B1_mm"], path["y_B1_mm"]
    expected = {
        "release_tilt": abs(tilt[low]),
        "soil_tilt": np.abs(tilt[inside]).max(),
        "depth": 60.0,
        "ground_speed_ratio": abs(speed[low]) / 667,
        "hole_length": np.ptp(cut),
        "path_height": np.ptp(y),
        "catching_tilt": abs(tilt[high]),
        "funnel_speed": np.hypot(x_b[0], y_b[0]) * 40 * np.pi / 30 / 1e3,
    }
    for name, value in expected.items():
        assert entries[name].value == pytest.approx(value, rel=1e-3), name
    assert entries["release_tilt"].phi_deg == pytest.approx(
        np.degrees(path["phi"][low]) % 360, abs=0.02
    )


def test_nozzles_come_as_close_as_points_along_them(
    entries: dict[str, dict], path: dict[str, np.ndarray]
) -> None:
    subset = slice(0, None, 50)
    travelled = 1e3 * -0.667 * path["phi"] / (40 * np.pi / 30)
    s = np.linspace(0, 1, 60)
    ends = []
    for tail, lag in (("", 0), ("_2", 1e3 * -0.667 * 60 / 40 / 2)):
        funnel = path[f"x_B1{tail}_mm"] + 1j * path[f"y_B1{tail}_mm"]
        tip = path[f"tip_x{tail}_mm"] - (travelled - lag) + 1j * path[f"tip_y{tail}_mm"]
        ends.append(funnel[subset, None] + s * (tip - funnel)[subset, None])
    distance = np.abs(ends[0][:, :, None] - ends[1][:, None, :]).min()
    assert entries["nozzle_distance"].value == pytest.approx(distance, rel=0.02)
    assert entries["nozzle_distance"].value <= distance


def test_the_leaving_halves_pass_the_seedling(
    entries: dict[str, dict], path: dict[str, np.ndarray]
) -> None:
    """Every point of a half, sampled: hinge 30 mm from B1, tip 210 mm, swung out of the plane by
    theta1.
    """
    x, y = path["tip_x_mm"], path["tip_y_mm"]
    low = int(y.argmin())
    soil, top, plant = y[low] + 60, y[low] + 180, x[low]
    after = np.arange(len(y)) > low
    chosen = np.flatnonzero(after & (y >= soil) & (y <= top))[::20]
    alpha, theta = np.radians(path["alpha_deg"][chosen]), np.radians(path["theta1_deg"][chosen])
    root_x, root_y = x[chosen] - 180 * np.cos(alpha), y[chosen] + 180 * np.sin(alpha)
    s = np.linspace(0, 180, 721)[:, None]
    px, py = root_x + s * np.cos(theta) * np.cos(alpha), root_y - s * np.cos(theta) * np.sin(alpha)
    distance = np.where(py <= top, np.hypot(px - plant, s * np.sin(theta)), np.inf).min() - 30
    assert entries["seedling_clearance"].value == pytest.approx(distance, abs=0.2)


def test_pitch_curves_bend_as_their_points_do(device: Device, entries: dict[str, dict]) -> None:
    from planter.papers.planting.toothed import locate_pitch_curves

    smallest, greatest = [], []
    for curve in locate_pitch_curves(device, device.design, samples=20_000).curves:
        x, y = curve.points[:, :-1]
        dx, dy = (np.roll(v, -1) - np.roll(v, 1) for v in (x, y))
        ddx, ddy = (4 * (np.roll(v, -1) - 2 * v + np.roll(v, 1)) for v in (x, y))
        bend = np.abs((dx * ddy - dy * ddx) / np.hypot(dx, dy) ** 3)
        smooth = np.abs(np.diff(bend, append=bend[0])) < 1e-3
        smallest.append(bend[smooth].min())
        greatest.append(bend[smooth].max())
    assert entries["pitch_curvature"].value == pytest.approx(min(smallest), rel=2e-3)
    assert entries["curvature_radius"].value == pytest.approx(1 / max(greatest), rel=2e-3)


# --- derivatives
# --------------------------------------------------------------------------------------


def differences(
    measures: RequirementRows, x: np.ndarray, width: np.ndarray, step: float
) -> np.ndarray:
    steps = np.eye(len(x)) * step * width
    return np.array(
        [(measures.at(x + e).values - measures.at(x - e).values) / (2 * step) for e in steps]
    ).T


def worst(measures: RequirementRows, x: np.ndarray, width: np.ndarray, slopes: np.ndarray) -> float:
    deviations = differences(measures, x, width, 1e-5)
    return float(
        (np.abs(deviations - slopes).max(axis=1) / np.abs(deviations).max(axis=1).clip(1e-5)).max()
    )


def test_gradients_are_exact_on_both_sides_of_the_joints(
    device: Device, measures: RequirementRows
) -> None:
    """The lowest tip point on the joint of the sun's pitch curve, and a little to either side of
    it.
    """
    from scipy.optimize import root_scalar

    width, m31 = device.upper - device.lower, device.names.index("m31")
    low = [row.kind.name for row in measures.rows].index("release_tilt")

    def at(m: float) -> np.ndarray:
        return np.where(np.arange(len(width)) == m31, m, device.design)

    def build_device_with(m: float) -> float:
        x = at(m)
        return float(measures.at(x).angles[low] + x[device.names.index("alpha3_deg")] - np.pi / m)

    joint = root_scalar(build_device_with, x0=1.0, x1=1.05, xtol=1e-13).root
    assert abs(build_device_with(joint)) < 1e-9
    for aside in (-1e-3, 0.0, 1e-3):
        x = at(joint + aside)
        slopes = measures.slopes(x) * width
        assert worst(measures, x, width, slopes) < (2e-5 if aside else 2e-4)
    assert worst(measures, x, width, slopes * (1 + 1e-3)) > 5e-4


def test_hessians_are_the_derivatives_of_the_gradients(
    device: Device, measures: RequirementRows
) -> None:
    width, x = device.upper - device.lower, device.design
    weights = np.random.default_rng(0).normal(size=len(measures.rows)) / np.abs(
        measures.slopes(x) * width
    ).max(1).clip(1)
    exact = measures.curvature(x, weights) * np.outer(width, width)
    steps = np.eye(len(x)) * 1e-5 * width
    slopes = np.array(
        [
            (measures.slopes(x + e).T - measures.slopes(x - e).T) @ weights * width / 2e-5
            for e in steps
        ]
    )
    assert np.abs(slopes - exact).max() < 1e-5 * np.abs(exact).max()


# --- as constraints
# -----------------------------------------------------------------------------------


def problem_of(device: Device) -> tuple[Problem, RequirementConstraints]:
    constraints = RequirementConstraints(device)
    return problem_with(device, "refined", constraints), constraints


def test_feasible_point_satisfies_margins(device: Device) -> None:
    problem, constraints = problem_of(device)
    assert not problem.is_feasible(problem.start)
    point = minimise_violation(problem, constraints, problem.start)
    assert point.is_feasible
    for entry in evaluate_requirements(constraints.measures, problem.design(point.u)):
        assert entry.verdict == "pass", entry


def test_infeasibility_error_suggests_sufficient_limit() -> None:
    """The list's own margin of the funnel's speed conflicts with the distance of the nozzles."""
    strict = machine.load(WIDE, {"funnel_speed_margin_m_s": 0.05})
    problem, constraints = problem_of(Device(strict))
    nearest = find_feasible_or_nearest(problem, constraints, [problem.start])
    assert not nearest.is_feasible
    error = build_infeasibility_error(constraints, problem, nearest, 1)
    assert error.exit_code == 1
    assert len(error.violations) == 1
    broken = error.violations[0]
    assert broken.name in error.message
    assert (
        f"1 start, none satisfies all limits; the closest misses {broken.name} by" in error.message
    )
    assert f"{broken.amount:.3g}" in error.message
    assert {"funnel_speed", "nozzle_distance"} <= set(error.partial["conflict"])
    changes = {change["name"]: change for change in error.partial["relaxations"]}
    assert changes["funnel_speed"]["relaxed"] == pytest.approx(broken.relaxed, abs=1e-6)
    for share, is_feasible in ((1.0, True), (0.9, False)):
        limit = broken.limit + share * (broken.relaxed - broken.limit)
        relaxed = strict.with_numbers({f"requirements.{broken.key}": limit})
        again, rows = problem_of(Device(relaxed))
        u = (error.design - again.box.origin) / again.box.unit
        assert (rows.violation(again.design(u)) < 1e-6) is is_feasible
        assert (minimise_violation(again, rows, np.clip(u, 0, 1)).total < 1e-6) is is_feasible


def test_the_certificate_knows_the_multipliers_of_requirements(device: Device) -> None:
    """A linear objective would do: here a corner made of one requirement's gradient, judged without
    a solver.
    """
    problem, constraints = problem_of(device)
    u = minimise_violation(problem, constraints, problem.start).u
    m = certificate.estimate_multipliers(problem, u)
    assert len(m.required) == constraints.count
    right = certificate.check_conditions(problem, u, m)
    active = int(
        np.argmin(np.minimum(constraints.upper, 1e9) - constraints.values(problem.design(u)))
    )
    wrong = np.zeros(constraints.count)
    inactive = int(
        np.argmax(np.minimum(constraints.upper, 1e9) - constraints.values(problem.design(u)))
    )
    assert inactive != active
    wrong[inactive] = problem.scale
    assert (
        certificate.check_conditions(
            problem, u, replace(m, required=m.required + wrong)
        ).complementarity
        > 1e-3
    )
    assert right.feasibility < 1e-6
    assert (
        certificate.check_conditions(
            problem, problem.start, certificate.estimate_multipliers(problem, problem.start)
        ).feasibility
        > 1
    )


# --- any sum of measures
# ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "goal",
    [
        pytest.param("max M_L", id="programme", marks=pytest.mark.long),
        pytest.param("range F_support", id="curve"),
    ],
)
def test_search_for_any_sum_satisfies_the_requirements(device: Device, goal: str) -> None:
    built = load_machine(WIDE)
    spec = SearchSpec(sampling=36, starts=1)
    required = RequirementConstraints(device)
    optimum = optimise_machine(built, goal, spec=spec)
    assert required.violation(optimum.x) <= FEASIBILITY_TOLERANCE
    free = optimise_machine(replace(built, requirements=None), goal, spec=spec)
    assert required.violation(free.x) > 0.01
    prices = {
        limit.name: limit.multiplier for limit in optimum.result.certificate.active_constraints
    }
    assert prices
    assert prices.keys() <= {kind.name for kind in required.kinds}
    assert all(price > 0 for price in prices.values())


def test_vary_conflicts_with_requirements() -> None:
    assert "[requirements]" in refusal(
        "optimise", WIDE, "--least", "max M_L", "--vary", "mass.planet_kg=1:2"
    )


# --- the file
# -----------------------------------------------------------------------------------------


def test_a_machine_without_requirements_has_no_constraints() -> None:
    plain = Device(machine.load("wang2017"))
    assert RequirementConstraints.from_device(plain) is None
    with pytest.raises(InputError, match=r"no \[requirements\]"):
        RequirementRows(plain)


def test_huge_curvature_radius_limit_has_an_excess() -> None:
    """Its step in curvature is far below the rounding of the curvature that it bounds."""
    device = Device(machine.load("wang2017-wide", {"curvature_radius_min_mm": 1e15}))
    rows = RequirementRows(device)
    excess = measure_excess(rows, device.design)
    assert np.isfinite(excess).all()
    assert excess.max() > 1e20


def test_the_section_survives_table_and_pickle() -> None:
    wide = machine.load(WIDE, {"release_tilt_max_deg": 12})
    assert pickle.loads(pickle.dumps(wide)) == wide
    assert PlantingMachine.read(wide.table(), WIDE).table() == wide.table()


REFUSED = {
    "upside down": ("spacing_max_mm = 525", "spacing_max_mm = 470", "spacing_max_mm = 470"),
    "no soil": ("soil_depth_mm = 60 ", "# soil ", "soil_depth_mm is missing"),
    "negative margin": (
        "hole_length_margin_mm = 5",
        "hole_length_margin_mm = -5",
        "it must be at least 0",
    ),
    "margin eats the limit": (
        "release_tilt_margin_deg = 2",
        "release_tilt_margin_deg = 11",
        "greater than its margin",
    ),
    "unknown": ("depth_min_mm = 40 ", "dept_min_mm = 40 ", "did you mean depth_min_mm"),
    "text": ("contact_ratio_min = 1.1 ", 'contact_ratio_min = "1.1" ', "it must be a number"),
    "standing": (
        "forward_speed_m_s = -0.667",
        "forward_speed_m_s = 0.0",
        "operation.forward_speed_m_s = 0.0",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_requirements_are_refused_in_a_sentence(case: str, tmp_path: Path) -> None:
    old, new, message = REFUSED[case]
    text = examples.example(WIDE)
    assert old in text
    file = tmp_path / "my.toml"
    file.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        machine.load(file)
    assert message in caught.value.message
    assert "my.toml" in caught.value.message
    assert "\n" not in caught.value.message


# --- the commands
# -------------------------------------------------------------------------------------


def test_simulate_and_validate_report_them() -> None:
    keys = {"name", "value", "unit", "lower", "upper", "margin", "phi_deg"}
    for command in ("simulate", "validate"):
        requirements = answer(command, WIDE)["requirements"]
        assert [entry["name"] for entry in requirements] == [
            kind.name for kind in KINDS if kind.needs != ("points_mm",)
        ]
        assert all(keys <= set(entry) for entry in requirements)
    assert "requirements" not in answer("simulate", "wang2017")


@pytest.mark.long
def test_infeasible_requirements_exit_with_code_1() -> None:
    call = (
        "optimise",
        WIDE,
        "--method",
        "ipopt",
        "--starts",
        "1",
        "--samples",
        "36",
        "--json",
        "--set",
        "funnel_speed_margin_m_s=0.05",
    )
    code, out, err = run(*call)
    assert code == 1
    answer = json.loads(out)
    assert answer["error"]["name"] == "Infeasible"
    assert "funnel_speed" in answer["error"]["message"]
    assert {"name", "amount", "unit", "phi_deg"} <= set(answer["partial"]["violations"][0])
    assert "Traceback" not in err
