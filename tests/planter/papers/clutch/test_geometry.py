"""Polygon in its hexagon: generated functions against poses placed by hand, closed forms, laws and
the print.
"""

import math

import numpy as np
import pytest

from planter.errors import GeometryError
from planter.kernels import formulas
from planter.papers.clutch import file
from planter.papers.clutch.model import collect_values, compute_geometry, load_model
from planter.papers.clutch.rotor import Rotor, body_outline

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


@pytest.mark.parametrize(("vertices", "sides"), [(5, 6), (7, 5), (5, 3)])
def test_sliding_vertices_touch_the_sides(vertices, sides):
    """Over their rotations, and no further, both vertices reach as far as the whole body does."""
    slides = Rotor(vertices, sides).slides()
    rho = slides.packed(2)[0]

    def reach(r, i):
        normal = slides.rotor.normals[i * slides.side_step]
        return rho * np.cos(normal - r - slides.packed(2)[3 + i])

    first, last = slides.rotations
    for rotation, touches in (
        (first + 1e-3, True),
        (last - 1e-3, True),
        (first - 1e-3, False),
        (last + 1e-3, False),
    ):
        body = slides.rotor.supports(np.array([rotation]))[:, 0]
        off = max(abs(reach(rotation, i) - body[i * slides.side_step]) for i in (0, 1))
        assert bool(off < 1e-13) is touches


def test_corner_ellipse_agrees_with_general_rotor():
    """In the hexagon vertices A and B of the clutch slide; C is opposite to both."""
    slides, ellipse = Rotor(5, 6).slides(), Rotor(5, 6).ellipse
    opposite = slides.ellipse(3)
    for key in ("x_E", "y_E", "s_1", "s_2"):
        assert opposite[key] == pytest.approx(ellipse[key], abs=1e-14)
    assert slides.rotations[1] - slides.rotations[0] == pytest.approx(ellipse["lead"], abs=1e-15)


def test_printed_vertices_leave_their_sides():
    """(2) with its A1, and the printed turn of axes: B is off its side by half a width."""
    side = 0.017
    theta = np.linspace(math.radians(66), math.pi / 2, 25)
    apothem = side * math.sqrt(3) / 2
    exact, printed = (
        load_model(name)("path", theta=theta, a=side) for name in ("exact", "printed")
    )
    assert np.abs(exact["Y_B"] - apothem).max() < 1e-14
    assert np.abs(exact["y_A"] - apothem).max() < 1e-14
    assert np.abs(printed["y_A"] - apothem).max() < 1e-14
    assert np.abs(printed["Y_B"] - apothem).min() > 1e-3


def test_curvature_where_the_path_meets_the_side_by_differences():
    rotor = Rotor(5, 6)
    h = 1e-4
    path = rotor.path(math.pi / 2 + h * np.arange(-2, 3))
    x, y = path["x_C"], path["y_C"]
    first = np.array([1, -8, 0, 8, -1]) / (12 * h)
    second = np.array([-1, 16, -30, 16, -1]) / (12 * h**2)
    dx, dy, ddx, ddy = first @ x, first @ y, second @ x, second @ y
    radius = np.hypot(dx, dy) ** 3 / abs(dx * ddy - dy * ddx)
    assert radius == pytest.approx(rotor.ellipse["tangency"], rel=1e-6)
    assert abs(dy) < 1e-10


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


def test_perimeter_is_pi_times_the_width():
    """Barbier's theorem, from the radius of curvature over all normals."""
    psi = (np.arange(20000) + 0.5) * 2 * np.pi / 20000
    radius = formulas.load("clutch_rotor")("support", psi=psi, shape=Rotor(5, 6).shape())["radius"]
    assert radius.mean() * 2 * np.pi == pytest.approx(np.pi, abs=1e-12)


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


def test_harmonics_and_largest_miss_agree():
    """Three strips miss by three times the sum of the harmonics of order 3 mod 6."""
    rotor = Rotor(5, 6)
    rotations = np.linspace(0, 2 * np.pi / 15, 400)
    bad = [h for h in rotor.harmonics(3000) if not h.rotor]
    series = 3 * sum(h.amplitude_over_R * np.cos(h.order * (np.pi / 2 - rotations)) for h in bad)
    assert np.abs(np.abs(rotor.misses(rotations)).max(axis=0) - np.abs(series)).max() < 1e-6


@pytest.mark.parametrize(
    ("vertices", "sides", "free"),
    [(3, 4, True), (7, 4, True), (5, 6, False), (3, 6, False), (7, 8, False)],
)
def test_odd_polygons_turn_in_squares_and_some_in_others(vertices, sides, free):
    rotor = Rotor(vertices, sides)
    assert all(h.rotor for h in rotor.harmonics(30)) is free
    assert (2 * rotor.smallest_apothem - 1 < 1e-9) is free
    assert (rotor.miss < 1e-12) is free


def test_hexagon_overlap_agrees_with_support_function():
    """The overlap that was derived pose by pose against the support function, which knows no
    pose.
    """
    rotor = Rotor(5, 6)
    theta = np.linspace(*rotor.passage, 4001)
    overlap = load_model()("path", theta=theta, a=1 / math.sqrt(3))["e_3"]
    assert np.abs(overlap).max() == pytest.approx(rotor.miss, rel=1e-6)
    assert np.abs(overlap[[0, 2000, -1]]).max() < 1e-14
    assert 2 * rotor.smallest_apothem == pytest.approx(1 + 2 * rotor.miss / 3, rel=1e-12)
    assert load_model("printed")("path", theta=theta, a=1.0)["e_3"].max() == 0


@pytest.mark.parametrize(("vertices", "sides"), PAIRS)
def test_path_clears_fillets_from_the_limit(vertices, sides):
    rotor = Rotor(vertices, sides)
    arc = rotor.path(np.linspace(*rotor.passage, 2001))
    C = np.array([arc["x_C"], arc["y_C"]])
    corner = -np.pi / 2 + rotor.turn / 2

    def depth(radius: float) -> float:
        """How deep the path goes into a polygon with that fillet."""
        centre = (0.5 - radius) / math.cos(rotor.turn / 2) * unit(corner)
        off = C - centre[:, None]
        angle = np.angle(np.exp(1j * (np.arctan2(off[1], off[0]) - corner)))
        at_fillet = np.abs(angle) <= rotor.turn / 2
        beyond = np.where(
            at_fillet,
            np.hypot(*off) - radius,
            np.max([unit(corner + s * rotor.turn / 2) @ C - 0.5 for s in (-1, 1)], axis=0),
        )
        return float(-beyond.min())

    limit = rotor.ellipse["fillet"]
    assert depth(limit) < 1e-12
    assert depth(1.2 * limit) < 1e-12
    assert depth(0.97 * limit) > 1e-7


def test_the_rule_in_print_is_the_wrong_way_round():
    """Fillets below the printed 0.24 R are said to clear; 0.10 R does not, as the derived limit
    says.
    """
    geometry = compute_geometry(file.load_clutch("shi2021", {"fillet_mm": 2.0}))
    assert not geometry.conditions[0].holds
    assert geometry.printed.conditions[0].holds


# --- the result
# ------------------------------------------------------------------------------------

RESULT = compute_geometry(SHI)


CONTRACT = [
    "R_mm",
    "a_mm",
    "b_mm",
    "A1",
    "A2",
    "ellipse",
    "rotor",
    "tooth",
    "travel",
    "linkage",
    "ellipse.centre_over_R",
    "ellipse.semi_axes_over_R",
    "ellipse.axis_deg",
    "ellipse.tangency_radius_over_R",
    "rotor.mismatch_over_R",
    "rotor.smallest_hexagon_over_R",
    "rotor.fillet_limit_over_R",
    "tooth.b1_min_mm",
    "tooth.b2_min_mm",
    "tooth.xi_deg",
    "travel.axial_angle_deg",
    "travel.printed_mm",
    "travel.exact_mm",
    "linkage.axial_angle_deg",
    "linkage.crank_rotation_deg",
]


@pytest.mark.parametrize("key", CONTRACT)
def test_keys_of_the_contract(key):
    table = RESULT.table()
    for part in key.split("."):
        table = table[0] if isinstance(table, list) else table
        table = table[part]


def test_printed_numbers_at_printed_precision():
    assert [round(row.printed_mm, 1) for row in RESULT.travel] == [8.6, 5.7, 4.2]
    assert round(RESULT.tooth.b1_min_mm, 1) == 10.5
    assert RESULT.tooth.xi_deg == pytest.approx(144, abs=1e-12)
    assert RESULT.ellipse.centre_over_R == pytest.approx([-math.sqrt(3) / 6, 0.5], abs=1e-15)
    assert RESULT.ellipse.axis_deg == pytest.approx(120, abs=1e-12)


def test_exact_geometry_and_print_differ():
    assert (
        pytest.approx((2 * math.cos(math.radians(24)) - 1) / math.sqrt(3), rel=1e-14) == RESULT.A1
    )
    assert (
        pytest.approx((2 * math.sqrt(3) * math.cos(math.radians(24)) - 1) / 3, rel=1e-14)
        == RESULT.printed.A1
    )
    assert RESULT.ellipse.semi_axes_over_R == pytest.approx([1.1295, 0.4158], abs=5e-5)
    assert RESULT.ellipse.tangency_radius_over_R == pytest.approx(
        4 / 3 * math.sin(math.radians(24)) ** 2, rel=1e-13
    )
    assert [row.printed_mm / row.exact_mm for row in RESULT.travel] == pytest.approx(
        [2, 2, 2], rel=1e-12
    )


def test_travel_frees_the_outline_circle():
    """After the least travel the hexagon's sides, moved out by the taper, touch the body's
    circle.
    """
    values = collect_values(SHI)
    for row in RESULT.travel:
        gain = row.exact_mm * 1e-3 * math.tan(math.radians(row.axial_angle_deg))
        assert math.sqrt(3) / 2 * values["a"] + gain == pytest.approx(RESULT.b_mm * 1e-3, rel=1e-13)


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
