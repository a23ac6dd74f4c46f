"""Distances of a point from a curve: against segments of their own, differences, and a path that a
machine made.
"""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from planter.engine.goal import Goal, resolve_limit, resolve_measure
from planter.engine.limits import MeasureLimits
from planter.engine.machine import Machine
from planter.engine.measures import parse_limit, parse_sum
from planter.engine.outputs import SampledOutputs
from planter.engine.piecewise import build_clearance, build_distance
from planter.engine.proof.objective import check_provable
from planter.engine.response import MachineResponse
from planter.engine.search import SearchSpec
from planter.engine.solvers.constraints import ConstrainedModel
from planter.errors import ComputationError, InputError
from planter.exports.quantities import SampledGoal
from planter.kernels import Array
from planter.mechanism.file import load
from planter.mechanism.machines import build_machine
from planter.mechanism.optimisation import evaluate_limits, optimise_machine
from planter.mechanism.presentation import format_optimum_file
from planter.rows.points import Plan
from planter.rows.sweep import Sweep
from tests.planter.engine.solvers.toys import check_derivatives
from tests.support import own
from tests.support.reference import evaluate

ANGLES = 48
FEW = SearchSpec(starts=2)


def find_nearest(points: Array, curve: Array) -> tuple[Array, Array]:
    """Return distances (n,) of points (n, 2) from a polyline (k, 2), and the nearest places (n, 2)
    on it.
    """
    begin, edges = curve[:-1], np.diff(curve, axis=0)
    shares = ((points[:, None] - begin) * edges).sum(axis=2) / (edges**2).sum(axis=1)
    places = begin + np.clip(shares, 0, 1)[:, :, None] * edges
    distances = np.linalg.norm(points[:, None] - places, axis=2)
    nearest = distances.argmin(axis=1)
    lanes = np.arange(len(points))
    return distances[lanes, nearest], places[lanes, nearest]


@pytest.mark.parametrize("is_closed", [False, True])
def test_distance_and_slope_are_those_of_the_nearest_place(is_closed: bool) -> None:
    rng = np.random.default_rng(4)
    curve = rng.uniform(-0.3, 0.3, (12, 2))
    curve = np.vstack([curve, curve[:1]]) if is_closed else curve
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    graph = build_distance(x, y, curve)
    function = ca.Function("d", [x, y], [graph, ca.gradient(graph, ca.vertcat(x, y))])
    points = np.vstack([rng.uniform(-0.5, 0.5, (400, 2)), curve, (curve[1:] + curve[:-1]) / 2])
    distances, places = find_nearest(points, curve)
    values, slopes = (np.asarray(out) for out in function(points[:, :1].T, points[:, 1:].T))
    np.testing.assert_allclose(values[0], distances, atol=2e-12)
    slopes = slopes.reshape(2, -1, order="F")[:, distances > 1e-6]
    away = (points - places)[distances > 1e-6] / distances[distances > 1e-6, None]
    np.testing.assert_allclose(slopes.T, away, atol=1e-9)


def write_path(path: Path, x: Array, y: Array) -> str:
    lines = [f"{a!r},{b!r}" for a, b in zip(x.tolist(), y.tolist(), strict=True)]
    path.write_text("\n".join(["x_mm,y_mm", *lines, lines[0]]) + "\n", encoding="utf-8")
    return str(path)


def arm(*moved: str) -> Machine:
    return build_machine(own.file("transplanting_arm")).with_moved(
        dict.fromkeys(moved or ("a_mm", "p_mm", "n_mm"), (0.0, 1000.0))
    )


def write_ellipse(path: Path, width: float, height: float) -> str:
    """An ellipse about the middle of the tip's path, in shares of its extent, of few points."""
    phi = 2 * np.pi * np.arange(ANGLES) / ANGLES
    x, y = (evaluate(arm(), name, phi) for name in ("x_tip", "y_tip"))
    t = np.linspace(0.1, 6.2, 15)
    return write_path(
        path, x.mean() + width * np.ptp(x) * np.cos(t), y.mean() + height * np.ptp(y) * np.sin(t)
    )


@pytest.fixture
def curve(tmp_path: Path) -> str:
    """A curve that the tip stays inside of."""
    return write_ellipse(tmp_path / "path.csv", 0.7, 1.0)


TIP = "distance x_tip y_tip to"


def test_measures_are_those_of_the_tip_and_the_curve(curve: str) -> None:
    """Coordinates by the other route of the tests, distances from segments of their own, in mm."""
    kinds = {
        "max": np.max,
        "mean": np.mean,
        "rms": lambda d: np.sqrt(np.mean(d**2)),
        "range": np.ptp,
        "std": np.std,
    }
    names = [f"{kind} {TIP} {curve}" for kind in kinds] + [
        f"{TIP} {curve} at 90",
        f"max {TIP} {curve} while y_tip <= 100",
    ]
    outputs = SampledOutputs(arm(), ("a_mm", "n_mm"), names, ANGLES)
    assert outputs.outputs[0].name == f"max {TIP} {curve} [mm]"
    x = outputs.machine.design / outputs.machine.scale
    values, slopes = outputs.slopes(x)
    phi = 2 * np.pi * np.arange(ANGLES) / ANGLES
    tip = np.column_stack([evaluate(arm(), name, phi) for name in ("x_tip", "y_tip")])
    points = np.loadtxt(curve, delimiter=",", skiprows=1)
    distances, _ = find_nearest(tip, points)
    expected = [kind(distances) for kind in kinds.values()]
    np.testing.assert_allclose(values[:-1], [*expected, distances[ANGLES // 4]], rtol=1e-9)
    inside = distances[tip[:, 1] <= 100]
    assert values[-1] == pytest.approx(inside.max(), rel=0.05), "its nodes are others"
    steps = 1e-6 * np.diag(x)
    above, below = outputs.evaluated(x + steps, 1), outputs.evaluated(x - steps, 1)
    differences = ((above - below) / (2 * np.diag(steps))[:, None]).T
    np.testing.assert_allclose(slopes, differences, rtol=1e-5, atol=1e-6)


def test_derivatives_in_goals_are_those_of_differences(curve: str) -> None:
    machine = arm()
    terms = (
        f"max {TIP} {curve} + rms {TIP} {curve} + y_tip where {TIP} {curve} is least"
        f" + mean M_in while {TIP} {curve} >= 5 mm"
    )
    limits = [f"{TIP} {curve} <= 2 cm", f"mean {TIP} {curve} while y_tip <= 100 <= 9"]
    measures = [resolve_measure(machine, measure) for measure in parse_sum(terms)]
    goal = Goal(
        machine, measures, [resolve_limit(machine, parse_limit(text)) for text in limits], 24
    )
    assert goal.limits[0].number == pytest.approx(20)
    x = machine.design
    local, rows = goal.objective.local(x), MeasureLimits(goal).at(x)
    rng, width = np.random.default_rng(3), np.maximum(np.abs(x), 1e-2)
    weights = np.concatenate([[1.0], rng.random(len(local.groups)), rng.random(rows.count)])
    both = ConstrainedModel(local, rows)
    # corners of the polyline are no events: integrals over them lack their curvature, which only
    # steers the steps
    check_derivatives(both, x, weights, width, 1e-6, (1e-6, 0.05))


def test_angle_of_a_corner_has_no_gradient_and_is_refused(curve: str) -> None:
    """The distance is greatest where two places of the curve are equally near."""
    (term,) = parse_sum(f"y_tip where {TIP} {curve} is greatest")
    machine = arm()
    goal = Goal(machine, [resolve_measure(machine, term)], (), 24)
    with pytest.raises(ComputationError, match="is greatest at a corner"):
        goal.evaluate(machine.design)


@pytest.mark.long
def test_search_recovers_arm_from_drawn_path(tmp_path: Path) -> None:
    """The path is a polygon of the true one: what is left is its height over the chords, by their
    number.
    """
    changed_machine = build_machine(own.file("transplanting_arm", p_mm=250, n_mm=-80))
    phi = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    path = write_path(
        tmp_path / "path.csv",
        *(evaluate(changed_machine, name, phi) for name in ("x_tip", "y_tip")),
    )
    machine = build_machine(own.file("transplanting_arm")).with_moved(
        {"p_mm": (200.0, 280.0), "n_mm": (-140.0, -40.0)}
    )
    result = optimise_machine(machine, f"rms {TIP} {path}", spec=FEW).result
    assert result.design == pytest.approx({"p_mm": 250, "n_mm": -80}, abs=0.1)
    assert result.objective < 0.05


def test_distance_limit_is_satisfied(tmp_path: Path) -> None:
    """Between two places of the curve that are equally near the distance has a corner, which a scan
    just misses.
    """
    curve = write_ellipse(tmp_path / "path.csv", 0.5, 0.4)
    machine = build_machine(own.file("transplanting_arm")).with_moved(
        {"p_mm": (200.0, 280.0), "n_mm": (-140.0, -40.0)}
    )
    free = optimise_machine(machine, f"max {TIP} {curve}", spec=FEW).result.objective
    result = optimise_machine(
        machine, "-mean x_tip", [f"{TIP} {curve} <= {free + 2!r} mm"], FEW
    ).result
    assert result.holds[0].active
    design = build_machine(own.file("transplanting_arm", **result.design))
    tip = np.column_stack(
        [evaluate(design, name, np.linspace(0, 2 * np.pi, 721)) for name in ("x_tip", "y_tip")]
    )
    distances, _ = find_nearest(tip, np.loadtxt(curve, delimiter=",", skiprows=1))
    assert free + 2 - 0.1 < distances.max() <= free + 2 + 1e-6


def test_sweep_of_another_curve_is_another_question(tmp_path: Path) -> None:
    t = np.linspace(0, 6, 9)
    path = Path(write_path(tmp_path / "tip.csv", 40 * np.cos(t), 50 * np.sin(t)))
    outputs = [f"max {TIP} {path}"]
    plan = {"machine": "wang2017", "outputs": outputs, "inputs": {"m31": [1.5, 1.52]}}
    sweep = Sweep(Plan.read(plan, "plan.toml"))
    content, question = path.read_text(encoding="utf-8"), sweep.recipe.question
    path.write_text(content.replace("\n", " \n", 1), encoding="utf-8")
    assert sweep.recipe.question != question, "rows of another curve are not gone on with"


def test_curve_path_is_relative_to_machine_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So does an optimum in another folder, by the whole path."""
    source = own.generated("transplanting_arm")
    text = (source / "transplanting_arm.toml").read_text(encoding="utf-8").split("[turn]")[0]
    text = text.replace("[values]", f'folder = "{source}"\n\n[values]', 1)
    more = (
        f'[objective]\nleast = "rms {TIP} path.csv"\n\n[requirements]\nhold = ["{TIP} path.csv '
        f'<= 90 mm"]\n'
    )
    (tmp_path / "arm.toml").write_text(
        f'{text}{more}\n[origin]\ndefault = "assumed"\n', encoding="utf-8"
    )
    t = np.linspace(0, 6, 9)
    write_path(tmp_path / "path.csv", 230 + 40 * np.cos(t), 90 + 50 * np.sin(t))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    machine = build_machine(load(tmp_path / "arm.toml")).with_moved({"p_mm": (200.0, 280.0)})
    (hold,) = evaluate_limits(machine)
    assert hold.met
    optimum = optimise_machine(machine)
    written = tmp_path / "elsewhere" / "optimum.toml"
    written.write_text(format_optimum_file(optimum), encoding="utf-8")
    assert (
        tomllib.loads(written.read_text())["objective"]["least"]
        == f"rms {TIP} {tmp_path / 'path.csv'}"
    )
    assert evaluate_limits(build_machine(load(written)))[0].value == pytest.approx(
        optimum.result.holds[0].value
    )


@pytest.mark.parametrize(
    ("text", "content", "part"),
    [
        (f"{TIP} none.csv", "x_mm,y_mm\n1,2\n3,4\n", "none.csv"),
        ("distance x_tip y_tipp to p.csv", "x_mm,y_mm\n1,2\n3,4\n", "did you mean y_tip"),
        ("distance x_tip M_in to p.csv", "x_mm,y_mm\n1,2\n3,4\n", "must be a length"),
        (f"{TIP} p.csv", "x_mm,z_mm\n1,2\n3,4\n", "no column x_tip_mm"),
        (f"{TIP} p.csv", "x_mm,y_N\n1,2\n3,4\n", "no column x_tip_mm"),
        (f"{TIP} p.csv", "x_mm,y_mm\n1,2\n1,2\n", "2 to 1000 points that differ"),
        (f"{TIP} p.csv", "x_mm,y_mm\n1,a\n1,2\n", "line 2, column y_mm"),
    ],
)
def test_invalid_distance_is_refused(
    text: str, content: str, part: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "p.csv").write_text(content, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=part):
        resolve_measure(arm(), parse_sum(f"max {text}")[0])


@pytest.mark.parametrize(
    ("kind", "part"), [("max", "proof bounds results"), ("jump", "so leave out `jump`")]
)
def test_proof_and_c_take_no_distance_and_no_jump(kind: str, part: str, curve: str) -> None:
    (term,) = parse_sum(f"{kind} {TIP} {curve}")
    with pytest.raises(InputError, match=part):
        check_provable(arm(), [resolve_measure(arm(), term)], "--least")
    assert "has no form in C" in SampledGoal(replace(arm(), objective=(term,))).reason_missing


def test_columns_may_be_those_of_a_motion_in_any_unit(tmp_path: Path) -> None:
    machine = arm()
    for head, factor in (("phi_deg,x_tip_mm,y_tip_mm", 1.0), ("phi_deg,x_m,y_m", 1e-3)):
        (tmp_path / "p.csv").write_text(
            "\n".join(
                [head, *(f"0,{factor * x},{factor * y}" for x, y in ((0, 0), (300, 0), (300, 200)))]
            )
            + "\n"
        )
        (term,) = parse_sum(f"max {TIP} {tmp_path / 'p.csv'}")
        goal = Goal(machine, [resolve_measure(machine, term)], (), ANGLES)
        phi = 2 * np.pi * np.arange(ANGLES) / ANGLES
        tip = np.column_stack([evaluate(machine, name, phi) for name in ("x_tip", "y_tip")])
        expected, _ = find_nearest(tip, np.array([[0.0, 0], [300, 0], [300, 200]]))
        assert goal.evaluate(machine.design) == pytest.approx(expected.max(), rel=1e-9)


def test_clearance_is_the_height_over_the_ground() -> None:
    """Against linear interpolation, level beyond the ends; its slopes against differences."""
    rng = np.random.default_rng(7)
    ground = np.column_stack([np.sort(rng.uniform(-1, 1, 9)), rng.uniform(-0.2, 0.2, 9)])
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    graph = build_clearance(x, y, ground)
    function = ca.Function("h", [x, y], [graph, ca.gradient(graph, ca.vertcat(x, y))])
    at, height = rng.uniform(-1.5, 1.5, 300), rng.uniform(-0.5, 0.5, 300)
    values, slopes = (np.asarray(out) for out in function(at[None], height[None]))
    np.testing.assert_allclose(values[0], height - np.interp(at, *ground.T), atol=1e-13)
    step = 1e-7
    rise = (np.interp(at + step, *ground.T) - np.interp(at - step, *ground.T)) / (2 * step)
    slopes = slopes.reshape(2, -1, order="F")
    inside = np.abs(at[:, None] - ground[:, 0]).min(axis=1) > step
    np.testing.assert_allclose(slopes[0][inside], -rise[inside], atol=1e-6)
    assert (slopes[1] == 1).all()


def test_limits_on_clearance_and_on_the_distance_of_points(tmp_path: Path) -> None:
    """Against positions by the other route of the tests; sizes of joint forces are those of their
    components.
    """
    machine = arm()
    phi = 2 * np.pi * np.arange(720) / 720
    x, y = (evaluate(machine, name, phi) for name in ("x_tip", "y_tip"))
    soil = tmp_path / "soil.csv"
    rows = [(float(x.max()) + 5, 4.0), (float(x.min()) - 5, -6.0), (float(x.mean()), 1.0)]
    soil.write_text("x_mm,y_mm\n" + "".join(f"{a!r},{b!r}\n" for a, b in rows), encoding="utf-8")
    heights = y - np.interp(x, *np.array(sorted(rows)).T)
    force = np.hypot(*(evaluate(machine, name, phi) for name in ("F_Ax", "F_Ay")))
    texts = [
        f"min clearance x_tip y_tip over {soil} >= 10 mm",
        "max distance x_tip y_tip to x_tip y_tip <= 1 mm",
        f"F_A <= {force.max() / 2} N",
    ]
    clearance, same, size = evaluate_limits(replace(machine, limits=tuple(map(parse_limit, texts))))
    assert clearance.value == pytest.approx(heights.min(), abs=0.05)
    assert clearance.met == (clearance.value is not None and clearance.value >= 10)
    assert same.value == pytest.approx(0, abs=1e-6)
    assert size.value == pytest.approx(force.max(), rel=1e-3)
    assert (size.met, size.unit) == (False, "N")


def test_named_points_are_those_at_their_coordinates(tmp_path: Path) -> None:
    soil = tmp_path / "soil.csv"
    soil.write_text("x_mm,y_mm\n-500,-300\n500,-250\n", encoding="utf-8")
    pairs = {
        "distance tip to ground__D": "distance x_tip y_tip to x_ground__D y_ground__D",
        f"clearance coupler__end over {soil}": (
            f"clearance x_coupler__end_mm y_coupler__end over {soil}"
        ),
    }
    response = MachineResponse(arm(), [name for pair in pairs.items() for name in pair])
    values = response.values(response.at(arm().design), np.linspace(0, 6, 7))
    np.testing.assert_allclose(values[::2], values[1::2], rtol=1e-14)
    phi = np.linspace(0, 6, 7)
    tip = [evaluate(arm(), name, phi) / 1e3 for name in ("x_tip", "y_tip")]
    pivot = arm().data[arm().find_index("d_mm")]
    np.testing.assert_allclose(values[0], np.hypot(tip[0] - pivot, tip[1]), rtol=1e-9)


def test_points_in_space_have_three_coordinates() -> None:
    machine, phi = own.machine("rssr"), np.linspace(0, 6, 9)
    points = "crank__B", "ground__D"
    names = [f"{axis}_{point}" for point in points for axis in "xyz"]
    response = MachineResponse(machine, [f"distance {' to '.join(points)}", *names])
    distance, *coordinates = response.values(response.at_data(machine.data), phi)
    vectors = np.array(coordinates[:3]) - np.array(coordinates[3:])
    np.testing.assert_allclose(distance, np.linalg.norm(vectors, axis=0), rtol=1e-12)
    assert np.abs(vectors[2]).max() > 1e-3, "the third counts"
    with pytest.raises(InputError, match="3 coordinates"):
        machine.find_quantity("clearance crank__B over soil.csv")
    with pytest.raises(InputError, match="3 coordinates"):
        machine.find_quantity("distance crank__B to x_ground__D y_ground__D")


def test_slopes_of_points_of_bodies_cross_the_loops() -> None:
    """The coupler's end is where the rocker's is: what moves it is the loop alone for some of the
    lengths.
    """
    machine, phi, step = arm("a_mm", "b_mm", "c_mm", "d_mm"), np.linspace(0.1, 6, 9), 1e-6
    names = ["x_coupler__end", "y_coupler__end", "distance coupler__end to coupler__A"]
    response, x = MachineResponse(machine, names), machine.design
    _, slopes = response.slopes(response.at(x), phi)
    for i in range(len(x)):
        ends = [
            response.values(response.at(x + sign * step * np.eye(len(x))[i]), phi)
            for sign in (1, -1)
        ]
        np.testing.assert_allclose(slopes[:, :, 1 + i], (ends[0] - ends[1]) / (2 * step), atol=1e-7)
    np.testing.assert_allclose(slopes[2, :, 1:], np.tile([0, 1, 0, 0], (len(phi), 1)), atol=1e-12)


def test_limit_on_a_point_of_a_body_binds() -> None:
    """The distance of the coupler's two pins is its length: the limit is a bound of that."""
    machine = build_machine(own.file("transplanting_arm"))
    texts = (
        "max distance coupler__end to coupler__A <= 150 mm",
        "distance coupler__end to ground__O >= 30",
    )
    result = optimise_machine(machine, "range F_Ox", texts, spec=FEW).result
    assert result.design["b_mm"] == pytest.approx(150, abs=1e-6)
    bound, free = result.holds
    assert (bound.active, free.active, free.price) == (True, False, 0)
    assert bound.price > 0


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("distance tipp to ground__D", "did you mean tip?"),
        ("distance tip to ground__Q", "no point"),
        ("distance F_A to tip", "no point F_A"),
        ("clearance tip over soil", "soil"),
    ],
)
def test_unknown_point_is_refused(name: str, part: str) -> None:
    with pytest.raises(InputError) as caught:
        arm().find_quantity(name)
    assert part in caught.value.message


def test_ground_with_two_heights_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "cliff.csv"
    path.write_text("x_mm,y_mm\n0,0\n10,2\n10,5\n", encoding="utf-8")
    with pytest.raises(InputError, match="x = 10 mm"):
        arm().find_quantity(f"clearance x_tip y_tip over {path}")
    with pytest.raises(InputError, match="over FILE"):
        parse_limit("clearance x_tip y_tip to soil.csv >= 3")
    with pytest.raises(InputError, match="F_Ax is in N"):
        arm().find_quantity("distance x_tip y_tip to x_tip F_Ax")
