"""Measures of a mechanism made least: derivatives against differences, optima against closed forms and dense grids."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from derive.__main__ import main as derive
from planter.engine.measures import parse_limit, parse_sum
from planter.engine.response import Samples
from planter.errors import ComputationError, InputError
from planter.mechanism.file import load
from planter.mechanism.goal import Goal, Limits
from planter.mechanism.machines import build_machine
from planter.mechanism.model import Model
from planter.mechanism.optimisation import optimise
from planter.records import schema
from tests.support.cli import answer, refusal

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


def test_derivatives_are_those_of_differences(file: Path) -> None:
    names = ["F_Ox", "M_in", "s"]
    samples = Samples(build_machine(load(file)), names, 2 * np.pi * np.arange(40) / 40)
    least = parse_sum("range F_Ox + 3 rms M_in + 0.5 variance s + mean s + max abs M_in + s at 90")
    holds = [parse_limit(text) for text in ("abs F_Ox <= 9", "rms M_in <= 1", "range s <= 70", "s at 45 >= 120")]
    goal = Goal(samples, names, least, holds)
    limits, y = Limits(goal), goal.start(samples.design)
    weights = np.random.default_rng(3).random(limits.count)

    def gradient(point: np.ndarray) -> np.ndarray:
        return goal.gradient(point) + limits.slopes(point).T @ weights

    def value(point: np.ndarray) -> float:
        return goal.value(point) + limits.values(point) @ weights

    steps = 1e-6 * np.maximum(np.abs(y), 1e-1)
    first = [(value(y + h) - value(y - h)) / (2 * h.sum()) for h in np.diag(steps)]
    assert gradient(y) == pytest.approx(first, rel=1e-6, abs=1e-6)
    second = [(gradient(y + h) - gradient(y - h)) / (2 * h.sum()) for h in np.diag(steps)]
    bent = goal.hessian(y) + limits.curvature(y, weights)
    assert bent == pytest.approx(np.array(second), rel=1e-5, abs=1e-4 * np.abs(bent).max())


def test_an_optimum_is_that_of_the_closed_form(file: Path) -> None:
    """The stroke of a crank and rod with offset e: sqrt((l+r)^2 - e^2) - sqrt((l-r)^2 - e^2); the least at r = 30."""
    found = optimise(load(file), "range s", ["s at 0 >= 170"], starts=2).result
    assert found.design["r_mm"] == pytest.approx(30, abs=1e-9)
    assert found.design["e_mm"] == pytest.approx(0, abs=0.3), "flat there, and the ends fall between samples"
    assert found.objective == pytest.approx(60, rel=1e-5)
    assert found.certificate.kkt_residual < 1e-6
    assert found.holds[0].value >= 170 - 1e-4


def test_an_optimum_under_a_limit_is_that_of_a_dense_grid(file: Path) -> None:
    machine = load(file)
    found = optimise(machine, "max abs M_in", ["s at 180 >= 100"], starts=2)
    best = np.inf
    phi = np.radians(np.arange(0.0, 360.0, 2.0))
    for r in (30.0, 31.0):
        for length in np.linspace(120, 200, 5):
            for e in (-15.0, 0.0, 15.0):
                turned = Model(machine.moved_to({"r_mm": r, "l_mm": float(length), "e_mm": e}))
                if turned(np.array([np.pi]))["s"][0] >= 0.1:
                    best = min(best, np.abs(turned(phi)["M_in"]).max())
    assert found.result.objective <= best * (1 + 2e-3), "the grid of angles misses a peak by as much"
    assert found.result.certificate.agreeing_starts == 2
    peak = np.abs(Model(found.machine)(np.radians(np.arange(0.0, 360.0, 0.05)))["M_in"]).max()
    assert peak == pytest.approx(found.result.objective, rel=1e-5)


def test_a_limit_that_no_design_keeps_is_named_with_what_is_reached(file: Path) -> None:
    with pytest.raises(
        ComputationError, match=r"no design within the bounds keeps s at 180 >= 500: the best .* reaches 1"
    ):
        optimise(load(file), "range s", ["s at 180 >= 500"], starts=1)


@pytest.mark.parametrize(
    ("least", "hold", "said"),
    [
        ("range F_Oxx", None, "press has no such quantity; did you mean F_Ox"),
        ("s", None, "s needs a measure"),
        ("range", None, "range needs a measure"),
        ("mean abs s", None, "mean takes no abs"),
        ("-1 max s", None, "the weight -1 is negative"),
        ("range s", "s < 3", "it must be .MEASURE. .abs. NAME"),
        ("range s", "max s >= 3", "only max <=, min >= and range <= are limits"),
    ],
)
def test_what_cannot_be_meant_is_refused(file: Path, least: str, hold: str | None, said: str) -> None:
    with pytest.raises(InputError, match=said):
        optimise(load(file), least, [hold] if hold else [], starts=1)


@pytest.mark.usefixtures("blank_figures")
def test_the_command_writes_an_optimum_that_the_commands_take(file: Path, tmp_path: Path) -> None:
    out = tmp_path / "best"
    found = answer("optimise", str(file), "--least", "range F_Ox", "--starts", "2", "--out", str(out))
    jsonschema.validate(found, json.loads((schema.FOLDER / "optimise-least.json").read_text(encoding="utf-8")))
    assert found["objective"] < found["start_objective"]
    turned = answer("turn", str(out / "optimum.toml"))["quantities"]["F_Ox_N"]
    assert turned["max"] - turned["min"] == pytest.approx(found["objective"], rel=1e-3)
    assert "# was 40.0 mm" in (out / "optimum.toml").read_text(encoding="utf-8")


def test_options_of_the_planting_device_do_not_go_with_it(file: Path) -> None:
    assert "--method does not go with --least" in refusal("optimise", str(file), "--least", "range s", "--method", "ga")
