"""Statements and consequences of the audit: each computed, each able to fail, and gone where
nothing is at fault.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from decimal import Decimal
from typing import Any

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import linprog

from planter.audit import numbers, verdicts
from planter.audit.registry import FORMULAS, Inputs
from planter.errors import PlanterError
from planter.papers.clutch.printed import formulas
from planter.papers.pickup.printed import inverse
from planter.papers.planting.printed import support_force as force
from tests.planter.papers.pickup import pickups

LAW = {
    "L1_mm": 93.3377,
    "L2_mm": 163.0,
    "law_p": 0.35,
    "dwell_deg": [210, 270],
    "phi5_far_deg": 40,
    "gamma_deg": 150,
    "centre_distance_mm": 44.6,
}


def inputs(**arguments: Any) -> Inputs:
    return Inputs(arguments, {}, {})


@pytest.fixture(scope="module")
def audit() -> dict[str, Any]:
    return verdicts.audit()


# ---- every number and statement can fail
# ---------------------------------------------------------------------------


def scaled(value: Any, factor: float) -> Any:
    """All measures in a value grown by a factor; texts, counts of items and choices stay."""
    if isinstance(value, bool | str):
        return value
    if isinstance(value, int | float):
        return value * factor
    if isinstance(value, list):
        return [scaled(item, factor + 0.013 * i) for i, item in enumerate(value)]
    return (
        {key: scaled(item, factor) for key, item in value.items()}
        if isinstance(value, dict)
        else value
    )


CHOICES = {
    "axis",
    "bar",
    "component",
    "dyad",
    "entry",
    "level",
    "levels",
    "against",
    "column_A",
    "column_B",
    "column_C",
    "value_points",
}


def changed(table: dict[str, Any]) -> dict[str, Any]:
    """The data with every input another one."""
    other = copy.deepcopy(table)
    for part in ("disclosed", "assumed"):
        for entry in other[part].values():
            for i, (name, value) in enumerate(entry.items()):
                entry[name] = value if name in CHOICES else scaled(value, 1.07 + 0.011 * (i % 7))
    for row in (*other["number"], *other["claim"]):
        for where in ("with", "each"):
            for i, (name, value) in enumerate(row.get(where, {}).items()):
                if name not in CHOICES:
                    row[where][name] = scaled(value, 1.09 + 0.017 * i)
    return other


def test_another_print_makes_no_number_equal() -> None:
    """Each is moved by two units of its last digit, and by all that the rounding of its inputs
    leaves open.
    """
    table = copy.deepcopy(numbers.load_numbers())

    def shifted(number: numbers.PrintedNumber) -> str:
        low, high = numbers.recompute(number, numbers.load_numbers()).computed.interval or (
            0.0,
            0.0,
        )
        place = Decimal(1).scaleb(int(Decimal(number.printed).as_tuple().exponent))
        return str(Decimal(number.printed) + (2 + round((high - low) / float(place))) * place)

    moved = iter([shifted(number) for number in numbers.list_numbers(numbers.load_numbers())])
    for row in table["number"]:
        printed = row["printed"]
        row["printed"] = (
            [next(moved) for _ in printed] if isinstance(printed, list) else next(moved)
        )
    was = {
        (e["paper"], e["quantity"])
        for e in numbers.judge_numbers()
        if e["verdict"] in ("reproduced", "consistent")
    }
    now = {(e["paper"], e["quantity"]): e["verdict"] for e in numbers.judge_numbers(content=table)}
    assert len(was) > 120
    assert all(now[key] not in ("reproduced", "consistent") for key in was)


def test_formulas_depend_on_their_inputs() -> None:
    """Other inputs give other values: of each formula, at least for one of the numbers or
    statements that use it.
    """
    table = numbers.load_numbers()
    other = changed(table)
    moved: dict[str, bool] = {}
    for before, after in zip(numbers.list_numbers(table), numbers.list_numbers(other), strict=True):
        moved[before.by] = moved.get(before.by, False) or differs(
            before.by, before.arguments, after.arguments, before.paper, other
        )
    for row, second in zip(table["claim"], other["claim"], strict=True):
        arguments = (row.get("with", {}), second.get("with", {}))
        moved[row["by"]] = moved.get(row["by"], False) or differs(
            row["by"], *arguments, row["paper"], other
        )
    discrete = {
        "not computed",
        "degrees of freedom",
        "real dyads",
        "eigenvalues that vanish",
        "driver is a crank",
        "place in the order of influence",
        "best level by level means",
        "best level by prediction",
        "best level by ranks",
        "freedom of interactions over what they take",
        "rotation of the crank gear by both equations",
        "poses in the assembly of one of them",
        "support force",
        "optimum",
        "printed rule for the direction of the tip",
        "round trip of the law",
        "round trip of the path",
        "outline by both sections",
        "distance from the centre of the corner's path",
        "angle from the major axis of the corner's path",
        "mismatch with the third pair of sides",
        "play that the hexagon lacks",
        "semi-axis of the corner's path",
        "curvature radius where the path meets the side",
    }
    assert {by for by, was in moved.items() if not was} <= discrete


def differs(by: str, arguments: Any, other_own: Any, paper: str, other: dict[str, Any]) -> bool:
    table = numbers.load_numbers()
    before = FORMULAS[by](Inputs(arguments, table["disclosed"][paper], table["assumed"][paper]))
    try:
        after = FORMULAS[by](Inputs(other_own, other["disclosed"][paper], other["assumed"][paper]))
    except (PlanterError, ValueError, KeyError, IndexError, np.linalg.LinAlgError):
        return True
    if before is None or after is None:
        return before is not after
    return not math.isclose(before, after, rel_tol=1e-6, abs_tol=1e-9)


@pytest.mark.parametrize(
    ("claim", "change"),
    [
        ("chosen tip radius", {"tip_radius_mm": 10.4}),
        ("chosen fillet", {"fillet_mm": 4.4}),
        ("centre of the corner's path", {"centre_over_width": [-0.28, 0.5]}),
        ("foci of the corner's path", {"foci_slope": -1.7}),
        ("circumscribed alike", {"outline_angle_deg": 30}),
        ("gives back the law", {"law_p": -1.2}),
        ("arctan(yS/xS)", {"phi5_far_deg": 100}),
        ("a1 larger than a2", {"centre_distance_mm": 50}),
    ],
)
def test_another_input_changes_whether_a_statement_holds(
    claim: str, change: dict[str, Any]
) -> None:
    table = copy.deepcopy(numbers.load_numbers())
    (before,) = [e for e in verdicts.judge_claims() if claim in e["claim"]]
    for name, value in change.items():
        part = "disclosed" if name in table["disclosed"][before["paper"]] else "assumed"
        assert name in table[part][before["paper"]]
        table[part][before["paper"]][name] = value
    (after,) = [e for e in verdicts.judge_claims(content=table) if claim in e["claim"]]
    assert after["holds"] is not before["holds"]


@pytest.mark.parametrize(
    ("value", "must", "holds"),
    [
        (0.0, "= 0", True),
        (1e-6, "= 0", False),
        (3.0, "= 3", True),
        (0.05, "< 0.05", False),
        (-1e-12, ">= 0", True),
        (-1e-6, ">= 0", False),
        (1e-12, "<= 0", True),
        (0.0, "> 0", False),
    ],
)
def test_measures_satisfy_their_definitions(value: float, must: str, holds: bool) -> None:
    assert verdicts.meets(value, must) is holds


# ---- the polygon in the hexagon
# ------------------------------------------------------------------------------------


def boundary(count: int = 4001) -> np.ndarray:
    """A Reuleaux pentagon of width 1 as points: arcs about its corners through the two corners
    opposite.
    """
    corners = np.exp(2j * np.pi * np.arange(5) / 5) / (2 * np.sin(np.radians(72)))
    arcs = []
    for i, centre in enumerate(corners):
        first, second = corners[(i + 2) % 5] - centre, corners[(i + 3) % 5] - centre
        turn = np.angle(second / first) * np.linspace(0, 1, count)
        arcs.append(centre + first * np.exp(1j * turn))
    return np.concatenate(arcs)


def reach(directions: np.ndarray) -> np.ndarray:
    """Distance from the centre to the tangents of the pentagon with normals in these directions
    (n,).
    """
    points = boundary()
    return np.array(
        [(points * np.exp(-1j * direction)).real.max() for direction in directions.ravel()]
    )


def missed(support: Callable[[np.ndarray], np.ndarray]) -> float:
    """Largest miss of the third pair of sides by a curve of width 1, two pairs held, from its
    support distances.

    Across a pair the centre lies at 1/2 less the support distance; the directions across three
    pairs, 60 deg apart, have n1 + n3 = n2.
    """
    turned = np.linspace(0, 2 * np.pi / 5, 181)
    first, second, third = (0.5 - support(angle - turned) for angle in np.radians([30, 90, 150]))
    return float(abs(first + third - second).max())


def test_mismatch_equals_curve_and_vanishes_for_circle() -> None:
    assert formulas.mismatch(inputs()) == pytest.approx(missed(reach), rel=1e-4)
    assert missed(lambda directions: np.full(len(directions), 0.5)) == 0


def test_the_least_play_lets_the_polygon_turn_and_less_does_not() -> None:
    """By linear programming: least distance of opposite sides that holds the curve in each of many
    positions.
    """
    normals = np.radians([30, 90, 150, 210, 270, 330])
    n = np.column_stack([np.cos(normals), np.sin(normals)])
    needed = []
    for turned in np.linspace(0, np.radians(72), 145):
        solution = linprog(
            [0, 0, 1],
            A_ub=np.column_stack([n, -0.5 * np.ones(6)]),
            b_ub=-reach(normals - turned),
            bounds=[(None, None)] * 3,
        )
        needed.append(solution.fun - 1)
    assert formulas.lacking_play(inputs()) == pytest.approx(max(needed), rel=1e-3)
    assert min(needed) > -1e-6


# ---- trials
# --------------------------------------------------------------------------------------------------------


def test_welch_test_equals_test_of_samples() -> None:
    rng = np.random.default_rng(5)
    first, second = rng.normal(1, 2, 5), rng.normal(4, 1, 5)
    arguments = inputs(
        first=[first.mean(), first.std(ddof=1)],
        second=[second.mean(), second.std(ddof=1)],
        repeats=5,
    )
    assert formulas.welch(arguments) == pytest.approx(
        stats.ttest_ind(first, second, equal_var=False).pvalue, rel=1e-12
    )


def test_prediction_of_an_additive_response_is_the_response() -> None:
    table = numbers.load_numbers()["disclosed"]["shi2021"]
    effects = {"A": [-3.0, 0.0, 3.5], "B": [1.0, -2.0, 0.5], "C": [0.2, 0.3, -0.9]}
    runs = [sum(effects[f][table[f"column_{f}"][i] - 1] for f in "ABC") for i in range(9)]
    arguments = {"responses": ["runs"], "runs": runs, "factors": ["A", "B", "C"]}
    columns = {name: table[name] for name in ("column_A", "column_B", "column_C")}
    best = [
        formulas.best_predicted_level(Inputs({**arguments, "factor": f}, columns, {}))
        for f in "ABC"
    ]
    sums = {
        (a, b, c): abs(effects["A"][a] + effects["B"][b] + effects["C"][c])
        for a in range(3)
        for b in range(3)
        for c in range(3)
    }
    assert sums[tuple(int(level) - 1 for level in best)] == pytest.approx(
        min(sums.values()), abs=1e-12
    )


# ---- linkage
# -------------------------------------------------------------------------------------------------------


def on_rocker(crank: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Poses (n, 3) [mm, mm, deg] on a crank-rocker (frame 200, crank 60, coupler 180, rocker 160),
    by hand.

    At crank angles (n,) [deg], the rocker's moving hinge on the left (1) or the right (-1) of the
    line to its fixed one. The origin of the body lies off both hinges.
    """
    hinge = 60 * np.exp(1j * np.radians(crank))
    across = 200 - hinge
    reached = abs(across)
    at = np.arccos((reached**2 + 180**2 - 160**2) / (2 * reached * 180))
    turn = np.angle(across) + sides * at
    place = hinge - (30 + 20j) * np.exp(1j * turn)
    return np.column_stack([place.real, place.imag, np.degrees(turn)])


def of_poses(by: str, poses: np.ndarray, **arguments: Any) -> Any:
    values = {f"pose {i}": pose.tolist() for i, pose in enumerate(poses, 1)}
    return FORMULAS[by](
        inputs(poses="five", five=list(values), counted=list(values), **values, **arguments)
    )


@pytest.mark.parametrize(
    ("crank", "sides"),
    [
        ([105, 135, 165, 215, 280], [1, 1, 1, 1, 1]),
        ([105, 135, 165, 215, 280], [-1, -1, -1, -1, -1]),
        ([235, 255, 305, 335, 355], [1, 1, 1, -1, -1]),
        ([15, 85, 115, 280, 350], [1, 1, 1, -1, -1]),
    ],
)
def test_assembly_and_crank_of_a_known_linkage(crank: list[int], sides: list[int]) -> None:
    poses = on_rocker(np.array(crank), np.array(sides))
    assert of_poses("dyad", poses, dyad=1, part="r") == pytest.approx(60)
    assert of_poses("dyad", poses, dyad=2, part="r") == pytest.approx(160)
    assert of_poses("poses in the assembly of one of them", poses) == sides.count(sides[0])
    assert of_poses("driver is a crank", poses) == 1
    if len(set(sides)) == 1:
        assert of_poses("largest reversal between neighbouring poses", poses) == 0


def test_largest_reversal_is_where_coupler_outruns_crank() -> None:
    """By hand from places of the moving hinge: neighbours in the order of the crank angles."""
    table = numbers.load_numbers()["disclosed"]["sun2019"]
    for first, sign in ((10, 1), (-10, -1)):
        poses = np.array(
            [[235, 120, first], *(table[f"pose {i}"] for i in range(2, 6))], dtype=float
        )
        x, y, X, Y = (of_poses("dyad", poses, dyad=1, part=part) for part in "xyXY")
        arm = np.exp(1j * np.radians(poses[:, 2]))
        crank = (
            np.degrees(np.angle(poses[:, 0] + 1j * poses[:, 1] + (x + 1j * y) * arm - (X + 1j * Y)))
            % 360
        )
        order = np.argsort(crank)
        after = np.roll(order, -1)
        outruns = poses[after, 2] - poses[order, 2] - (crank[after] - crank[order]) % 360
        assert sum(outruns) == pytest.approx(-360)
        result = of_poses("largest reversal between neighbouring poses", poses)
        assert result == pytest.approx(outruns.max(), rel=1e-9)
        assert (result > 50) == (sign > 0)


def test_distance_from_the_polygon_of_the_poses() -> None:
    """Poses on a circle about the fixed hinge: it lies inside, by the distance of the polygon's
    nearest side.
    """
    turn = np.radians([0, 50, 130, 210, 300])
    point, spin = 7 - 4j, np.radians([5, 40, -20, 70, -60])
    place = 30 - 20j + 40 * np.exp(1j * turn) - point * np.exp(1j * spin)
    poses = np.column_stack([place.real, place.imag, np.degrees(spin)])
    radii = [of_poses("dyad", poses, dyad=k, part="r") for k in (1, 2, 3, 4)]
    dyad_number = 1 + int(np.argmin([np.inf if r is None else abs(r - 40) for r in radii]))
    result = of_poses("distance of a hinge outside the poses", poses, dyad=dyad_number)
    ends = np.roll(place, -1)
    share = np.linspace(0, 1, 20001)[:, None]
    nearest = abs(place + share * (ends - place) - (30 - 20j)).min()
    assert result == pytest.approx(-nearest, rel=1e-6)


# ---- inverse chain
# -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("p", "dwell"), [(0.35, [210, 270]), (0.0, [200, 260]), (-0.2, [230, 231])]
)
def test_the_inverse_chain_finds_bars_law_and_path(p: float, dwell: list[float]) -> None:
    values = {**LAW, "law_p": p, "dwell_deg": dwell}
    assert inverse.bar(inputs(**values, bar=1)) == pytest.approx(93.3377, rel=1e-12)
    assert inverse.bar(inputs(**values, bar=2)) == pytest.approx(163, rel=1e-12)
    assert inverse.law_error(inputs(**values)) < 1e-7
    assert inverse.path_error(inputs(**values)) < 1e-9


def test_law_path_equals_complex_arithmetic() -> None:
    t = np.linspace(0, 2 * np.pi, 721)
    path = inverse.of_law(inputs(**LAW), t)
    by_hand = pickups.arm(t, p=0.35)
    assert path.phi1 == pytest.approx(by_hand, abs=1e-13)
    assert path.tip == pytest.approx(pickups.tips(t, by_hand), abs=1e-14)
    assert path.tip != pytest.approx(pickups.tips(t, by_hand + 1e-9), abs=1e-14)


def test_recovered_angles_equal_triangle() -> None:
    """By half-angle formulas, from the three sides at places on the way out and back."""
    angles = inverse.invert_tip_path(
        inputs(**LAW), path := inverse.of_law(inputs(**LAW), np.linspace(0, 6.28, 315)).tip
    )
    l3, (l1, l2) = np.hypot(*path.T), angles.bars
    s = (l3 + l1 + l2) / 2
    at_planet = 2 * np.arctan(
        np.sqrt(np.maximum((s - l1) * (s - l2) / np.maximum(s * (s - l3), 1e-300), 0))
    )
    assert np.abs(np.cos(angles.phi1) - np.cos(at_planet)).max() < 1e-12
    assert (np.diff(angles.phi1[:150]) > 0).all()


def test_spline_extremes_stay_within_samples() -> None:
    """By dense places of a spline of its own, laid over chord length."""
    t = 2 * np.pi * np.arange(26) / 25
    places = pickups.tips(t, pickups.arm(t, p=0.35))
    places[-1] = places[0]
    chord = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])
    curve = CubicSpline(chord, places, bc_type="periodic")
    distance = np.hypot(*curve(np.linspace(0, chord[-1], 200_001)).T)
    half = np.array([np.ptp(distance), distance.max() + distance.min()]) * 500
    extremes = [inverse.bar_from_points(inputs(**LAW, bar=bar, value_points=25)) for bar in (1, 2)]
    assert extremes == pytest.approx(half, rel=1e-9)
    assert extremes != pytest.approx([93.3377, 163.0], rel=1e-6)


def test_unreachable_path_is_not_inverted() -> None:
    small = inputs(**{**LAW, "centre_distance_mm": 10})
    t = np.linspace(0, 2 * np.pi, 720, endpoint=False)

    def back(path: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        entry = inverse.invert_tip_path(small, np.column_stack([path.real, path.imag]))
        return entry.bars, abs(entry.tip @ [1, 1j] - path)

    assert (
        back(0.2 + 0.04 * np.exp(1j * t))[1].max() < 1e-12
    )  # any path that does not go round the centre
    bars, away = back(0.02 + 0.06 * np.exp(1j * t))
    assert away[-1] < 1e-12
    assert bars == pytest.approx([0.02, 0.06])


def test_the_triangle_of_the_carrier_closes() -> None:
    values = {"L1_mm": 93.3377, "gamma_deg": 150, "centre_distance_mm": 44.6}
    a1 = inverse.centre_distance_margin(inputs(**values)) + 44.6
    cosine = a1**2 + 44.6**2 - 2 * a1 * 44.6 * np.cos(np.radians(150))
    assert cosine == pytest.approx(93.3377**2, rel=1e-12)
    assert inverse.axis_direction(inputs(**values)) == pytest.approx(0, abs=1e-10)
    beta1 = math.degrees(math.asin(44.6 * 0.5 / 93.3377))
    assert inverse.axis_direction_printed(inputs(**values)) == pytest.approx(2 * beta1, rel=1e-12)


# ---- contact load
# --------------------------------------------------------------------------------------------------


def test_largest_load_equals_motion() -> None:
    """The modal equation of motion, integrated: N = F - m1 y''."""
    values = {
        "shaft_flats_mm": 20,
        "tip_radius_mm": 10.5,
        "input_speed_rpm": 45,
        "load_torque_Nm": 1.2,
        "overhang_mm": 60,
        "elastic_modulus_GPa": 206,
        "density_kg_m3": 7850,
        "engaging_mass_kg": 0.35,
    }
    side = 0.02 / math.sqrt(3)
    moment, area = 5 * math.sqrt(3) / 16 * side**4, 1.5 * math.sqrt(3) * side**2
    stiffness = math.pi**4 * 206e9 * moment / (32 * 0.06**3)
    moving = 0.35 + 7850 * area * 0.06 / 2
    driving, speed = 1.2 / 0.0105, 45 * math.pi / 30 * 0.0105
    span = 2 * math.pi * math.sqrt(moving / stiffness)

    def slope(_: float, y: np.ndarray) -> list[float]:
        return [y[1], (driving - stiffness * y[0]) / moving]

    motion = solve_ivp(slope, (0, span), [0, speed], rtol=1e-10, atol=1e-14, max_step=span / 500)
    load = driving - 0.35 * (driving - stiffness * motion.y[0]) / moving
    assert formulas.load(inputs(**values)) == pytest.approx(load.max(), rel=1e-4)
    assert formulas.load_printed(inputs(**values)) > 1.2 * formulas.load(inputs(**values))


# ---- consequences
# --------------------------------------------------------------------------------------------------


def entry_of(entries: list[dict[str, Any]], quantity: str) -> dict[str, Any]:
    (entry,) = [e for e in entries if quantity in e["quantity"]]
    return entry


def test_consequences_have_both_sides_and_reasons(audit: dict[str, Any]) -> None:
    keys = {
        "paper",
        "about",
        "quantity",
        "unit",
        "printed",
        "as_printed",
        "as_derived",
        "rests_on",
        "assumed_inputs",
        "statement",
    }
    equations = {(e["paper"], e["equation"]): e["verdict"] for e in audit["equations"]}
    assert {e["paper"] for e in audit["consequences"]} == set(audit["summary"])
    for entry in audit["consequences"]:
        assert entry.keys() == keys
        for name in entry["rests_on"]:
            record = equations.get((entry["paper"], name))
            assert record in verdicts.FAULTY or any(
                n["quantity"] == name and n["verdict"] == "not reproduced" for n in audit["numbers"]
            )


def test_forces_of_both_models_are_compared_with_table(audit: dict[str, Any]) -> None:
    consequences = [e for e in audit["consequences"] if e["about"] == "support force over a turn"]
    values = {e["quantity"]: (e["printed"], e["as_printed"], e["as_derived"]) for e in consequences}
    assert values["range"] == pytest.approx((122.17, 92.79, 3.13), abs=5e-3)
    assert values["mean"][2] == pytest.approx(9.81 * 9.975, rel=1e-4)
    assert values["objective"] == pytest.approx(
        (0.6 * 122.17 + 0.4 * 1907.32, 211.33, 1.987), abs=5e-3
    )


def test_measured_broken_laws_equal_committed_ones(audit: dict[str, Any]) -> None:
    """The models run here, and the chain as it was judged: the same violations on two grids of
    angles.
    """
    laws = {e["law"]: e for e in audit["laws"]}
    by_law = {
        e["quantity"].partition(":")[0]: e for e in audit["consequences"] if e["about"] == "law"
    }
    assert by_law.keys() == {name for name, law in laws.items() if law["caused_by"]}
    for name, entry in by_law.items():
        if "least normal force" in entry["quantity"]:
            assert laws[name]["violation_literal"] == pytest.approx(-entry["as_printed"], rel=2e-3)
            assert entry["as_derived"] > 0
        elif "largest distance" in entry["quantity"]:
            assert laws[name]["violation_literal"] == pytest.approx(entry["as_printed"], rel=2e-3)
            assert entry["as_derived"] < 1e-4
    mean = next(e for name, e in by_law.items() if name.startswith("mean"))
    assert mean["as_derived"] - mean["as_printed"] == pytest.approx(
        laws["mean vertical support force is the weight"]["violation_literal"], rel=2e-3
    )


def test_each_optimum_is_best_in_same_model(audit: dict[str, Any]) -> None:
    objectives = [
        e
        for e in audit["consequences"]
        if e["about"] == "objective of a design" and e["unit"] == ""
    ]
    assert len(objectives) == 3
    assert (
        min(objectives, key=lambda e: e["as_printed"])["quantity"]
        == "the optimum of the equations as printed"
    )
    assert (
        min(objectives, key=lambda e: e["as_derived"])["quantity"]
        == "the optimum of the exact model"
    )
    paper_value = entry_of(objectives, "paper's design")["as_derived"]
    worth = entry_of(objectives, "equations as printed")["as_derived"]
    change = entry_of(audit["consequences"], "change by optimising")
    assert change["as_derived"] == pytest.approx(100 * (worth / paper_value - 1))
    assert ("worse" if worth > paper_value else "better") in change["statement"].partition(
        " than "
    )[0]


def test_design_score_equals_cycle() -> None:
    machine = force.both("wang2017")
    for model in machine.devices:
        device = machine.devices[model]
        assert machine.score(model, device.design) == pytest.approx(
            machine.headlines(model)["objective"], rel=1e-9
        )
        turn = device.columns(device.design, machine.angles)
        assert machine.support_with(model, {}) == pytest.approx(turn["support_N"], rel=1e-12)


def test_force_dependencies_are_detected() -> None:
    teeth = ["contact.tooth_friction_angle_deg", "contact.pressure_angle_deg"]
    assert force.felt("wang2017", "printed", teeth, 0.1) < 1e-9
    assert force.felt("wang2017", "printed", ["mass.planet_kg"], 0.1) > 1
    assert force.felt("wang2017", "exact", ["contact.cam_friction_angle_deg"], 0.1) < 1e-9


def test_no_faults_have_no_consequences(audit: dict[str, Any]) -> None:
    table = numbers.load_numbers()
    sound = copy.deepcopy({part: audit[part] for part in ("equations", "laws", "numbers")})
    for entry in sound["equations"]:
        entry["verdict"] = "confirmed"
    for entry in sound["laws"]:
        entry["caused_by"] = []
    for entry in sound["numbers"]:
        entry["verdict"] = "reproduced"
    assert verdicts.derive_consequences(None, table, sound) == []
    for entry in sound["equations"]:
        if (entry["paper"], entry["equation"]) == ("yu2023", "14"):
            entry["verdict"] = "misprint"
    (left,) = verdicts.derive_consequences(None, table, sound)
    assert (left["paper"], left["rests_on"]) == ("yu2023", ["14"])
    assert left["as_printed"] > 1.5 * left["as_derived"]


def test_a_repaired_formula_leaves_the_headline_as_it_is(audit: dict[str, Any]) -> None:
    table = copy.deepcopy(numbers.load_numbers())
    for row in table["headline"]:
        row["as_derived"] = row["as_printed"]
        row["with_as_derived"] = row.get("with_as_printed", {})
    same = [
        e
        for e in verdicts.derive_consequences("shi2021", table, audit)
        if e["about"] == verdicts.HEADLINE
    ]
    assert same
    assert all(e["as_printed"] == e["as_derived"] for e in same)
    real = [e for e in audit["consequences"] if e["paper"] == "shi2021"]
    assert all(e["as_printed"] != e["as_derived"] for e in real)
