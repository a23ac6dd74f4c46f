"""Shape of the clutch: polygon in its hexagon against poses placed by hand, closed forms and laws;
crank, rod and gears; the commands from outside."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from planter.errors import ComputationError, GeometryError
from planter.files import examples
from planter.papers.clutch import file
from planter.papers.clutch.model import (
    CrankLinkage,
    collect_values,
    compute_geometry,
    evaluate_conditions,
    find_linkages,
    load_model,
    steepest_rod_angle,
)
from planter.papers.clutch.rotor import Rotor, body_outline
from tests.support.cli import below
from tests.support.tables import read_cycle_csv

SHI = file.load_clutch("shi2021")
PAIRS = [(5, 6), (3, 4), (5, 4), (7, 6), (7, 8), (9, 10), (7, 12)]


def unit(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def posed(vertices: int, sides: int, theta: float) -> dict[str, np.ndarray]:
    """A rigid polygon of width 1, turned so that AC points theta below x, shifted until A and B are
    on their sides.

    Only the corners of a regular polygon and two linear equations: no formula of the derivation.
    """
    rho = 0.5 / math.cos(math.pi / (2 * vertices))
    corners = rho * unit(2 * np.pi * np.arange(vertices) / vertices)
    A, B, C = corners[:, vertices // 2], corners[:, vertices // 2 + 1], corners[:, 0]
    turn = -theta - math.atan2(*(C - A)[::-1])
    rotation = np.array([unit(turn), unit(turn + np.pi / 2)]).T
    A, B, C, M = (rotation @ p for p in (A, B, C, np.zeros(2)))
    normals = np.array([unit(np.pi / 2), unit(np.pi / 2 + 2 * np.pi / sides)])
    shift = np.linalg.solve(normals, [0.5 - normals[0] @ A, 0.5 - normals[1] @ B])
    return {"A": A + shift, "B": B + shift, "C": C + shift, "M": M + shift}


@pytest.mark.parametrize(("vertices", "sides"), PAIRS)
def test_vertex_path_agrees_with_poses_and_ellipse(vertices, sides):
    rotor = Rotor(vertices, sides)
    theta = np.linspace(*rotor.passage, 1000)
    path, oval = rotor.path(theta), rotor.ellipse
    poses = [posed(vertices, sides, t) for t in theta]
    for name in "ABCM":
        placed = np.array([pose[name] for pose in poses]).T
        assert np.abs(placed - [path[f"x_{name}"], path[f"y_{name}"]]).max() < 1e-12
    direction, across = unit(oval["axis"]), unit(oval["axis"] + np.pi / 2)
    from_centre = np.array([pose["C"] for pose in poses]) - [oval["x_E"], oval["y_E"]]
    on_ellipse = (from_centre @ direction / oval["s_1"]) ** 2 + (
        from_centre @ across / oval["s_2"]
    ) ** 2
    assert np.abs(on_ellipse - 1).max() < 1e-12


def test_clutch_formulas_agree_with_general_rotor():
    side = 0.017
    width = side * math.sqrt(3)
    rotor = Rotor(5, 6, width)
    theta = np.linspace(*rotor.passage, 50)
    actual, general = load_model()("path", theta=theta, a=side), rotor.path(theta)
    assert np.abs(actual["x_C"] - general["x_C"]).max() < 1e-16
    assert np.abs(actual["y_C"] - general["y_C"]).max() < 1e-16
    sizes, oval = load_model().at("polygon", a=side), rotor.ellipse
    for angle, other in (
        ("x_E", "x_E"),
        ("y_E", "y_E"),
        ("s_1", "s_1"),
        ("s_2", "s_2"),
        ("rho_C", "tangency"),
        ("b", "circumradius"),
    ):
        assert sizes[angle] == pytest.approx(oval[other], rel=1e-14)
    assert load_model().at("fillet", flats=width)["r"] == pytest.approx(oval["fillet"], rel=1e-13)
    assert load_model().at("rotor", a=side)["miss"] == pytest.approx(rotor.miss, rel=1e-9)
    assert load_model().at("rotor", a=side)["free"] == pytest.approx(
        2 * rotor.smallest_apothem, rel=1e-13
    )


@pytest.mark.parametrize(
    ("vertices", "sides"), [(5, 6), (3, 4), (5, 3), (7, 5), (3, 3), (5, 12), (9, 7), (3, 8)]
)
def test_any_two_vertices_on_any_two_sides(vertices, sides):
    """Poses by two linear equations again, for sides in pairs or not; the ellipse holds every
    pose.
    """
    rotor = Rotor(vertices, sides)
    slides = rotor.slides()
    rotations = np.linspace(*slides.rotations, 200)
    rho = 0.5 / math.cos(math.pi / (2 * vertices))
    apothem = 0.5 if sides % 2 == 0 else rotor.smallest_apothem
    normals = np.array([unit(np.pi / 2), unit(np.pi / 2 + slides.side_step * rotor.turn)])
    for vertex in (i for i in range(vertices) if i not in (0, slides.vertices)):
        path, oval = slides.path(vertex, rotations), slides.ellipse(vertex)
        polar = 2 * np.pi / vertices * np.array([0, slides.vertices, vertex])
        for i, rotation in enumerate(rotations):
            A, B, C = rho * unit(rotation + polar).T
            centroid = np.linalg.solve(
                normals, apothem - np.array([normals[0] @ A, normals[1] @ B])
            )
            for name, place in (("A", A), ("B", B), ("C", C), ("M", 0 * C)):
                assert (
                    np.abs(centroid + place - [path[f"x_{name}"][i], path[f"y_{name}"][i]]).max()
                    < 1e-12
                )
        off = np.array([path["x_C"] - oval["x_E"], path["y_C"] - oval["y_E"]])
        direction, across = unit(oval["axis"]) @ off, unit(oval["axis"] + np.pi / 2) @ off
        assert np.abs((direction / oval["s_1"]) ** 2 + (across / oval["s_2"]) ** 2 - 1).max() < 1e-9


def test_reuleaux_triangle_in_a_square_is_the_textbook_s():
    """Corner arc x = 1 - cos b - sqrt3 sin b, y = 1 - sin b - sqrt3 cos b, area share 2 sqrt3 +
    pi/6 - 3, side 2.

    Weisstein, Reuleaux Triangle, MathWorld.
    """
    rotor = Rotor(3, 4, 2.0)
    path = rotor.path(np.linspace(*rotor.passage, 200))
    x, y = -path["x_C"], path["y_C"]  # the corner at the lower left
    b = np.linspace(np.pi / 6, np.pi / 3, 20001)
    expected = np.array(
        [1 - np.cos(b) - np.sqrt(3) * np.sin(b), 1 - np.sin(b) - np.sqrt(3) * np.cos(b)]
    )
    nearest = np.hypot(expected[0][:, None] - x, expected[1][:, None] - y).min(axis=0)
    assert nearest.max() < 1e-4
    track = rotor.track(4001)
    area = 0.5 * abs(np.sum(track[0] * np.roll(track[1], -1) - track[1] * np.roll(track[0], -1)))
    assert area / 4 == pytest.approx((2 * math.sqrt(3) + math.pi / 6 - 3), abs=1e-7)


@pytest.mark.parametrize("vertices", [3, 5, 7, 11])
def test_outline_has_constant_width_and_support_function(vertices):
    rotor = Rotor(vertices, 6)
    psi = np.linspace(-7, 7, 997)
    assert np.abs(rotor.support(psi) + rotor.support(psi + np.pi) - 1).max() < 1e-14
    points = body_outline(rotor, 0.3, np.zeros(2), 400)
    reached = (np.array([np.cos(psi + 0.3), np.sin(psi + 0.3)]).T @ points).max(axis=1)
    assert np.abs(reached - rotor.support(psi)).max() < 2e-6
    assert reached.max() <= rotor.support(psi).max() + 1e-12


@pytest.mark.parametrize("vertices", [3, 5, 9])
def test_harmonics_are_the_fourier_coefficients_of_the_support(vertices):
    rotor = Rotor(vertices, 6)
    n = 2 * vertices * 3600
    psi = 2 * np.pi * np.arange(n) / n
    spectrum = np.fft.rfft(rotor.support(psi)).real / n
    for row in rotor.harmonics(4):
        assert row.amplitude_over_R == pytest.approx(2 * spectrum[row.order], abs=1e-9)
    even = np.abs(spectrum[2 : 8 * vertices]).copy()
    even[[row.order - 2 for row in rotor.harmonics(4)]] = 0
    assert even.max() < 1e-12


@pytest.mark.parametrize(
    ("vertices", "sides", "free"),
    [(3, 4, True), (7, 4, True), (5, 6, False), (3, 6, False), (7, 8, False)],
)
def test_odd_polygons_turn_in_squares_and_some_in_others(vertices, sides, free):
    rotor = Rotor(vertices, sides)
    assert all(h.rotor for h in rotor.harmonics(30)) is free
    assert (2 * rotor.smallest_apothem - 1 < 1e-9) is free
    assert (rotor.miss < 1e-12) is free


def test_the_rule_in_print_is_the_wrong_way_round():
    """Fillets below the printed 0.24 R are said to clear; 0.10 R does not, as the derived limit
    says.
    """
    values = collect_values(file.load_clutch("shi2021", {"fillet_mm": 2.0}))
    assert not evaluate_conditions(values)[0].holds
    assert evaluate_conditions(values, "printed")[0].holds


RESULT = compute_geometry(SHI)


def test_shape_follows_closed_forms():
    cosine, sine = math.cos(math.radians(24)), math.sin(math.radians(24))
    assert pytest.approx((2 * cosine - 1) / math.sqrt(3), rel=1e-14) == RESULT.A1
    assert RESULT.ellipse.semi_axes_over_R == pytest.approx([1.1295, 0.4158], abs=5e-5)
    assert RESULT.ellipse.tangency_radius_over_R == pytest.approx(4 / 3 * sine**2, rel=1e-13)
    ratios = [row.printed_mm / row.exact_mm for row in RESULT.travel]
    assert ratios == pytest.approx([2, 2, 2], rel=1e-12)


def test_unreachable_rod_is_named():
    geometry = compute_geometry(file.load_clutch("shi2021", {"levels.rods_mm[1]": 70}))
    assert [row.crank_rotation_deg is None for row in geometry.linkage] == [False, True, False]
    (warning,) = geometry.warnings
    assert "shi2021: levels.rods_mm[1] = 70: it must be between" in warning
    assert RESULT.warnings == []


@pytest.mark.parametrize(
    ("vertices", "sides", "word"),
    [(4, 6, "odd"), (1, 6, "odd"), (5, 2, "from 3"), (5, 200, "from 3")],
)
def test_invalid_polygons_are_refused(vertices, sides, word):
    with pytest.raises(GeometryError, match=word):
        Rotor(vertices, sides)


def test_nonexistent_paths_are_refused():
    with pytest.raises(GeometryError, match="must be even"):
        _ = Rotor(5, 5).ellipse
    with pytest.raises(GeometryError, match="must be less than 6"):
        _ = Rotor(3, 6).ellipse


OWN = CrankLinkage(0.015, 0.0471, 0.040)


def test_lever_is_the_derivative_of_the_way_and_keeps_the_work():
    shift, h = np.linspace(0.0003, 0.004, 20), 1e-7
    angle = lambda s: OWN.evaluate(s)["crank_angle"]  # noqa: E731
    slope = (angle(shift - h) - angle(shift + h)) / (2 * h)
    lever = OWN.evaluate(shift)["lever"]
    assert lever == pytest.approx(1 / slope, rel=1e-7)
    way = np.linspace(0, 0.0042, 2001)
    tooth = load_model()("push", shift=way, crank=OWN.packed, F1=60.0, r_A=0.014)["tooth_force"]
    turned = OWN.evaluate(way)["crank_angle"]
    assert -np.trapezoid(tooth * 0.014, turned) == pytest.approx(60 * 0.0042, rel=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_rod_length_gives_the_required_travel(seed):
    random = np.random.default_rng(seed)
    crank, distance, travel = random.uniform([0.012, 0.035, 0.002], [0.018, 0.045, 0.007])
    rotation = travel / crank * random.uniform(1.02, 1.3)
    linkages = find_linkages(crank, distance, travel, rotation)
    for linkage in linkages:
        assert linkage.rotation(travel) == pytest.approx(rotation, abs=1e-12)
    assert [steepest_rod_angle(linkage, travel) for linkage in linkages] == sorted(
        steepest_rod_angle(linkage, travel) for linkage in linkages
    )
    low, high = distance + travel - crank + 1e-6, distance + crank - 1e-6
    grid = np.linspace(low, high, 400)
    off = [CrankLinkage(crank, rod, distance).rotation(travel) - rotation for rod in grid]
    roots = [
        brentq(
            lambda rod: CrankLinkage(crank, rod, distance).rotation(travel) - rotation,
            a,
            b,
            xtol=1e-15,
        )
        for a, b, left, right in zip(grid, grid[1:], off, off[1:], strict=False)
        if left * right < 0
    ]
    assert sorted(linkage.rod for linkage in linkages) == pytest.approx(sorted(roots), abs=1e-11)


def test_too_much_to_ask_of_a_crank():
    with pytest.raises(ComputationError, match="a crank of 15 mm makes at most"):
        find_linkages(0.015, 0.040, 0.0042, 0.1)
    with pytest.raises(GeometryError, match=r"here = 10: it must be between 29.2 and 55"):
        CrankLinkage(0.015, 0.010, 0.040).check(0.0042, "here")
    with pytest.raises(
        GeometryError, match="no rod reaches over the travel of 31 mm, the crank must be longer"
    ):
        OWN.check(0.031, "here")


def test_drive_undoes_the_gears():
    values = collect_values(file.load_clutch("shi2021"))
    drive = load_model().at(
        "drive",
        k=values["k"],
        span=values["r_A"] + values["r_D"],
        gamma=values["gamma"],
        theta_Amax=0.3,
    )
    assert drive["r_A"] == pytest.approx(0.014, rel=1e-14)
    assert drive["r_D"] == pytest.approx(0.046, rel=1e-14)
    back = load_model().at("gears", alpha=drive["alpha_max"], k=values["k"], gamma=values["gamma"])[
        "theta_AR"
    ]
    assert back == pytest.approx(0.3, rel=1e-13)


run, answer, refusal = below("clutch")


def tampered(folder: Path, old: str, new: str) -> str:
    text = examples.example("shi2021")
    assert text.count(old) == 1
    path = folder / "my.toml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return str(path)


@pytest.mark.usefixtures("blank_figures")
def test_geometry_files_are_consistent(tmp_path):
    assert run("geometry", "shi2021", "--out", str(tmp_path))[0] == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    _, columns = read_cycle_csv(tmp_path / "poses.csv")
    assert abs(columns["y_A_mm"] - summary["R_mm"] / 2).max() < 1e-12
    assert abs(columns["overlap_mm"]).max() / summary["R_mm"] == pytest.approx(
        summary["rotor"]["mismatch_over_R"], rel=1e-3
    )
    assert "no clearance" in (tmp_path / "report.html").read_text()


@pytest.mark.usefixtures("blank_figures")
def test_optimisation_is_within_limits(tmp_path):
    assert run("optimise", "shi2021", "--starts", "2", "--out", str(tmp_path))[0] == 0
    _, columns = read_cycle_csv(tmp_path / "way.csv")
    limits = SHI.limits
    assert columns["tooth_force_N"].max() <= limits.tooth_force_N * (1 + 2e-6)
    assert columns["rod_angle_deg"].max() <= limits.rod_angle_deg


@pytest.mark.usefixtures("blank_figures")
def test_infeasible_design_exits_1_and_writes_result(tmp_path):
    code, out, err = run("design", "shi2021", "--radius-mm", "12", "--json", "--out", str(tmp_path))
    assert code == 1
    assert json.loads(out)["error"]["name"] == "ComputationError"
    assert "no clutch fits: corners of the hexagonal hole within the space fails by" in err
    assert json.loads((tmp_path / "summary.json").read_text())["feasible"] is False


@pytest.mark.usefixtures("blank_figures")
def test_rotors_in_general(tmp_path):
    result = answer("rotor", "--vertices", "3", "--sides", "4")
    assert result["exact"] is True
    assert result["smallest_over_R"] == pytest.approx(1, abs=1e-12)
    pentagon, geometry = answer("rotor"), answer("geometry", "shi2021")
    for key in ("centre_over_R", "semi_axes_over_R", "axis_deg", "tangency_radius_over_R"):
        assert pentagon["ellipse"][key] == pytest.approx(geometry["ellipse"][key], rel=1e-12)
    assert (
        answer("rotor", "--vertices", "5", "--sides", "3", "--out", str(tmp_path))["ellipse"]
        is None
    )
    assert "vertices_apart" in (tmp_path / "report.html").read_text()
    assert "vertices = 4: must be odd" in refusal("rotor", "--vertices", "4")


REFUSED = [
    ("fillet_mm = 4.8\n", "fillet_mm = 12\n", "shaft.fillet_mm = 12.0: it must be less than half"),
    ("[42.0, 44.8, 47.1]", "[42.0]", "levels.rods_mm = [42.0]: it must have a rod"),
    ("lift_limit_deg = 10 ", "lift_limit_deg = 5 ", "wanted.lift_limit_deg = 5.0: it must be gr"),
    ("[0.25, 0.55]", "[0.6, 0.5]", "search.ratio_bounds = [0.6, 0.5]: it"),
    ('\ntravel_mm = "paper', '\ntravel_mm = "guess', 'origin.travel_mm = "guess (4.2)": it must s'),
]


@pytest.mark.parametrize(("old", "new", "sentence"), REFUSED)
def test_invalid_clutch_files_exit_with_single_line(tmp_path, old, new, sentence):
    path = tampered(tmp_path, old, new)
    for command in ("geometry", "design", "optimise"):
        assert refusal(command, path).startswith(f"planter: {path}: {sentence}")
