"""Measures of a mechanism made least: derivatives against differences, optima against closed forms
and dense grids.
"""

import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from derive.__main__ import main as derive
from planter.engine.goal import resolve_measure
from planter.engine.measures import parse_sum
from planter.engine.problem import build_problem
from planter.engine.search import SearchSpec
from planter.engine.solvers.curve_sum import CurvePart
from planter.engine.solvers.optimiser import METHODS
from planter.errors import ComputationError, InputError
from planter.mechanism.file import load
from planter.mechanism.machines import build_machine
from planter.mechanism.model import Model
from planter.mechanism.optimisation import optimise_machine
from planter.task import Means
from tests.planter.engine.solvers.test_smooth import SHORT
from tests.support import own
from tests.support.cli import answer
from tests.support.schemas import load_schema

STATEMENT = '''
from sympy import cos, sin
from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | rad/s | crank speed    | 12
    r     | mm    | crank          | 40  | 30 60
    l     | mm    | rod            | 150 | 120 200
    e     | mm    | offset         | 5   | -15 15
    m     | kg    | slider         | 1.4
""")
m = Mechanism("press", q, angle=q.phi, speed=q.omega)
beta, s = m.coordinate("beta", "rad", "rod angle"), m.coordinate("s", "m", "slider")
A = m.point("A", m.O, m.frame("crank", q.phi), q.r)
B, slot = m.point("B", A, m.frame("rod", beta), q.l), m.point("slot", m.O, m.world, s, q.e)
m.close(B, slot, start={beta: 0, s: q.l + q.r})
one, two = m.body("crank", m.frame("crank", q.phi)), m.body("rod", m.frame("rod", beta))
three = m.body("slider", m.world, q.m, slot)
m.pin("O", one, m.ground, m.O)
m.pin("A", two, one, A)
m.pin("B", three, two, slot)
m.slide("G", three, m.ground, slot)
m.motor("M_in", one, m.ground, m.O)
SYSTEM = m.system()
'''


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("own")
    (place / "press.py").write_text(STATEMENT, encoding="utf-8")
    assert derive([str(place / "press.py")]) == 0
    return place / "generated" / "press.toml"


def test_restart_forgets_earlier_designs(file: Path) -> None:
    """Loops are closed near where they were before, which must not reach from one descent of a
    worker into the next.
    """
    machine = build_machine(load(file))
    measures = [resolve_measure(machine, term) for term in parse_sum("mean s")]
    problem, angles = build_problem(machine, measures, (), 36), machine.list_angles(36)
    first, second = np.array([0.031, 0.13, -0.01]), np.array([0.055, 0.19, 0.012])
    (part,) = problem.goal.objective.parts
    assert isinstance(part, CurvePart)

    def close(x: np.ndarray) -> bytes:
        return part.response.response.coordinates(machine.build_data(x), angles).tobytes()

    problem.restart()
    alone, _, after = close(second), close(first), close(second)
    problem.restart()
    assert after != alone == close(second)


def test_jump_of_smooth_quantity_is_not_minimised(file: Path) -> None:
    with pytest.raises(InputError, match="jump s: s does not jump at the machine's own design"):
        optimise_machine(build_machine(load(file)), "jump s")


FLAT = '''
from sympy import cos, sin
from derive import Formulas, quantities

q = quantities("""
    t | rad   | angle
    n | r/min | its speed | 60
    a | m     | first     | 0.5 | 0.2 1
    b | m     | second    | 0.7 | 0.3 1.2
    y | m     | constant
    z | m     | wave
""")
f = Formulas("flat", given=q, angle=q.t, speed=q.n)
f.defines(q.y, q.a * sin(q.b / q.a))
f.defines(q.z, q.b * cos(q.t) + q.a)
SYSTEM = f.system()
'''


@pytest.mark.parametrize("objective", ["range y", "std y", "range y + 2 variance y"])
def test_spread_of_constant_is_not_minimised(objective: str) -> None:
    with pytest.raises(InputError, match="y does not change over the cycle"):
        optimise_machine(own.machine(FLAT, "flat"), objective)


@pytest.mark.parametrize(
    ("objective", "optimum"),
    [("max y", math.sin(0.3) * 1e3), ("range y + range z", 600.0), ("range z", 600.0)],
)
def test_constants_count_in_sums(objective: str, optimum: float) -> None:
    machine = own.machine(FLAT, "flat").with_ranges(
        {"values.a_m": (1.0, 1.0001), "values.b_m": (0.3, 1.2)}
    )
    result = optimise_machine(machine, objective, spec=SearchSpec(starts=2)).result
    assert result.objective == pytest.approx(optimum, rel=1e-6)


def test_optimum_equals_closed_form(file: Path) -> None:
    """The stroke of a crank and rod with offset e: sqrt((l+r)^2 - e^2) - sqrt((l-r)^2 - e^2); the
    least at r = 30.
    """
    optimum = optimise_machine(
        build_machine(load(file)),
        "range s",
        ["s at 0 >= 170"],
        spec=SearchSpec(starts=4),
        means=Means(1),
    ).result
    assert optimum.design["r_mm"] == pytest.approx(30, abs=1e-9)
    assert optimum.design["e_mm"] == pytest.approx(0, abs=0.01), (
        "flat there: 0.0014 mm for each mm2"
    )
    assert optimum.objective == pytest.approx(60, rel=1e-10)
    # a step to e = 0 would gain 4e-11 of the objective, less than what closed loops leave open
    assert optimum.certificate.kkt_residual < 2e-6
    assert optimum.holds[0].value >= 170 - 1e-4


def test_limited_optimum_equals_dense_grid(file: Path) -> None:
    machine = load(file)
    optimum = optimise_machine(
        build_machine(machine), "max abs M_in", ["s at 180 >= 100"], spec=SearchSpec(starts=2)
    )
    best = np.inf
    phi = np.radians(np.arange(0.0, 360.0, 2.0))
    for r in (30.0, 31.0):
        for length in np.linspace(120, 200, 5):
            for e in (-15.0, 0.0, 15.0):
                turned = Model(
                    build_machine(
                        machine.with_values({"r_mm": r, "l_mm": float(length), "e_mm": e})
                    )
                )
                if turned(np.array([np.pi]))["s"][0] >= 0.1:
                    best = min(best, np.abs(turned(phi)["M_in"]).max())
    assert optimum.result.objective <= best * (1 + 2e-3), (
        "the grid of angles misses a peak by as much"
    )
    assert optimum.result.certificate.agreeing_starts == 2
    peak = np.abs(Model(optimum.machine)(np.radians(np.arange(0.0, 360.0, 0.05)))["M_in"]).max()
    assert peak == pytest.approx(optimum.result.objective, rel=1e-5)


def test_infeasible_limit_is_named_with_reached_value(file: Path) -> None:
    with pytest.raises(
        ComputationError,
        match=r"1 start, none satisfies all limits; the closest misses s at 180 >= 500 by "
        r"\d+ mm \(\d+.* for 500 mm\)",
    ):
        optimise_machine(
            build_machine(load(file)), "range s", ["s at 180 >= 500"], spec=SearchSpec(starts=1)
        )


@pytest.mark.parametrize(
    ("objective", "hold", "message"),
    [
        ("range F_Oxx", None, "press has no quantity F_Oxx: did you mean F_Ox"),
        ("s", None, "s needs a measure"),
        ("range", None, "range needs a measure"),
        ("mean abs s", None, "mean takes no abs"),
        ("-1 max s", None, "max s can only be made smaller"),
        ("range s", "s < 3", "it must be .MEASURE. .abs. NAME"),
        ("range s", "jump s >= 3", "only jump <= is a limit"),
        ("range s", "rms abs s >= 3", "rms takes no abs|only abs NAME <="),
    ],
)
def test_invalid_goal_is_refused(
    file: Path, objective: str, hold: str | None, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        optimise_machine(
            build_machine(load(file)), objective, [hold] if hold else [], spec=SearchSpec(starts=1)
        )


@pytest.mark.usefixtures("blank_figures")
def test_command_writes_reusable_optimum(file: Path, tmp_path: Path) -> None:
    out = tmp_path / "best"
    result = answer(
        "optimise", str(file), "--least", "range F_Ox", "--starts", "2", "--out", str(out)
    )
    jsonschema.validate(result, load_schema("optimise least"))
    assert result["objective"] < result["start_objective"]
    turned = answer("turn", str(out / "optimum.toml"))["quantities"]["F_Ox_N"]
    assert turned["max"] - turned["min"] == pytest.approx(result["objective"], rel=1e-3)
    assert "# was 40.0 mm" in (out / "optimum.toml").read_text(encoding="utf-8")


def with_goal(file: Path, folder: Path, goal: str, name: str = "own.toml") -> Path:
    """Write the file with a goal of its own beside the generated functions."""
    text = file.read_text(encoding="utf-8").replace("[values]", f"{goal}\n[values]")
    (folder / name).write_text(f'folder = "{file.parent}"\n{text}', encoding="utf-8")
    return folder / name


SUM = '[objective]\nleast = "range s + max abs M_in while s >= 0.15 m"\n'
LIMITS = ["s at 0 >= 0.233 m", "F_Ox where s is greatest >= -1 kN"]


def test_file_objective_is_used(file: Path, tmp_path: Path) -> None:
    """A turn reports the file's limits; the optimum satisfies them, and prices agree with a limit
    that is moved.
    """
    goal = f"{SUM}[requirements]\nhold = {LIMITS}\n"
    source = with_goal(file, tmp_path, goal)
    result = answer("optimise", str(source), "--starts", "2")
    assert result["met"] is True
    assert result["certificate"]["kkt_residual"] < 1e-6
    (price,) = result["certificate"]["active_constraints"]
    assert (price["name"], price["unit"]) == ("s at 0 >= 233 mm", "mm")
    moved = with_goal(file, tmp_path, goal.replace("0.233 m", "0.23301 m"), "moved.toml")
    dearer = answer("optimise", str(moved), "--starts", "1")
    assert (dearer["objective"] - result["objective"]) / 0.01 == pytest.approx(
        price["multiplier"], rel=1e-2
    )


def test_a_turn_reports_the_limits_of_the_file(file: Path, tmp_path: Path) -> None:
    source = with_goal(file, tmp_path, f"[requirements]\nhold = {[*LIMITS, 'max M_in <= 1e3']}\n")
    turned = answer("turn", str(source))
    assert [hold["met"] for hold in turned["holds"]] == [False, True, True]
    assert turned["met"] is False
    assert turned["holds"][2]["value"] == pytest.approx(
        turned["quantities"]["M_in_Nm"]["max"], rel=1e-3
    )


def test_methods_agree(file: Path, tmp_path: Path) -> None:
    settings = "individuals = 8\ngenerations = 6\nbits_per_variable = 12\nselection_ratio = 0.8\n"
    settings += "crossover_probability = 0.75\nmutation_probability = 0.05\n"
    goal = f'[genetic_algorithm]\n{settings}[objective]\nleast = "rms F_Ox"\nsamples = 60\n'
    source = build_machine(load(with_goal(file, tmp_path, goal)))
    optima = {
        method: optimise_machine(
            source, None, ["s at 0 >= 170"], SearchSpec(60, method, 1, genetic=source.genetic)
        )
        for method in METHODS
    }
    best = optima["ipopt"].result.objective
    assert optima["hybrid"].result.objective == pytest.approx(best, rel=1e-9)
    assert best <= optima["ga"].result.objective < 1.2 * best
    assert optima["ga"].result.holds[0].met


def test_number_of_workers_changes_no_bit(file: Path) -> None:
    """The loops of an optimum are closed from where the search was before, wherever its descents
    ran.
    """
    machine, spec = build_machine(load(file)), SearchSpec(starts=3, method="hybrid", genetic=SHORT)
    alone, shared = (
        optimise_machine(machine, "max abs M_in", ["s at 180 >= 100"], spec, means=Means(n))
        for n in (1, 2)
    )
    assert alone.x.tobytes() == shared.x.tobytes()
    assert (alone.result.certificate, alone.result.evaluations) == (
        shared.result.certificate,
        shared.result.evaluations,
    )


@pytest.mark.parametrize(
    ("goal", "part"),
    [
        ('[objective]\nleast = "rang s"\n', "objective.least = 'rang s': 'rang' at character 1"),
        ('[requirements]\nhold = ["s <= 3", "s < 3"]\n', "requirements.hold[1] = 's < 3'"),
        ("[requirements]\nhold = []\n", "requirements.hold"),
    ],
)
def test_goals_of_files_are_refused_by_their_place(
    file: Path, tmp_path: Path, goal: str, part: str
) -> None:
    with pytest.raises(InputError) as caught:
        load(with_goal(file, tmp_path, goal))
    assert part in caught.value.message
