"""Free-body diagrams: equilibrium with the inertia force (d'Alembert), action and reaction, scale."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planter import load_machine, simulate
from planter.mechanism import labelled
from planter.papers.planting import labelled as device
from planter.report.free_body import FreeBodies, FreeBody, round_down
from planter.report.sheet import Arrow, Length
from tests.support import own
from tests.support.cli import answer, refusal, run

FOUR_BAR = '''
from derive import Mechanism, quantities

q = quantities("""
    phi   | rad   | crank angle
    omega | r/min | crank speed        | 120
    eps   | rad/s2 | its acceleration  | 3
    g     | m/s2  | free fall          | 9.81
    a     | mm    | crank              | 40
    b     | mm    | coupler            | 120
    c     | mm    | rocker             | 90
    d     | mm    | ground             | 130
    m_b   | kg    | mass of the coupler | 0.7
    J_b   | kg m2 | its inertia        | 0.001
    m_c   | kg    | mass of the rocker | 0.5
    J_c   | kg m2 | its inertia        | 0.0006
    T     | N m   | load on the rocker | 1.5
""")
m = Mechanism("four_bar", q, angle=q.phi, speed=q.omega, acceleration=q.eps, gravity=q.g)
beta, gamma = m.coordinate("beta", "rad", "coupler"), m.coordinate("gamma", "rad", "rocker")
crank, bar, arm = m.frame("crank", q.phi), m.frame("coupler", beta), m.frame("rocker", gamma)
A, D = m.point("A", m.O, crank, q.a), m.point("D", m.O, m.world, q.d)
B, C = m.point("B", A, bar, q.b), m.point("C", D, arm, q.c)
m.close(B, C, start={beta: 0.8, gamma: 1.6})
first = m.body("crank", crank)
second = m.body("coupler", bar, q.m_b, m.point("S", A, bar, q.b / 2, q.b / 8), q.J_b)
third = m.body("rocker", arm, q.m_c, m.point("R", D, arm, q.c / 2), q.J_c)
m.pin("O", first, m.ground, m.O)
m.pin("A", second, first, A)
m.pin("B", third, second, B)
m.pin("D", third, m.ground, D)
m.torque("load", third, m.ground, q.T)
m.motor("M_in", first, m.ground, m.O)
SYSTEM = m.system()
'''
STATEMENTS = {"four_bar": FOUR_BAR, "slider_crank": "slider_crank"}
OMEGA = {"four_bar": 4 * np.pi, "slider_crank": 10 * np.pi}
EPS = {"four_bar": 3.0, "slider_crank": 0.0}
STEP_DEG = 0.05
"""Step of the second differences, of whose error a share of 1e-6 is left."""
LAW = 1e-12
"""Sum of the loads on a body over the largest of them: rounding of some thousand operations."""


def file_of(name: str) -> str:
    return str(own.generated(STATEMENTS[name]) / f"{name}.toml")


def cut(name: str, angle_deg: float = 50.0) -> FreeBodies:
    return labelled.cut_bodies(file_of(name), {}, angle_deg)


def imbalance(body: FreeBody) -> float:
    """Return the larger of the shares that sums of forces and moments have of the largest ones."""
    moment = np.abs(body.moment_sum).max() / (body.largest_moment or 1.0)
    return max(np.abs(body.force_sum).max() / body.largest_force, moment)


@pytest.mark.parametrize("name", list(STATEMENTS))
@pytest.mark.parametrize("angle_deg", [0.0, 50.0, 217.3])
def test_loads_of_each_body_are_in_equilibrium(name: str, angle_deg: float) -> None:
    bodies = cut(name, angle_deg).bodies
    assert len(bodies) == 3
    for body in bodies:
        assert imbalance(body) < LAW
        # tampered: without one of its larger loads, or with one reversed, no body is in equilibrium
        loads = sorted(body.loads, key=lambda load: -np.linalg.norm(load.force))
        assert imbalance(replace(body, loads=loads[1:])) > 1e-3
        turned = replace(loads[0], force=-loads[0].force)
        assert imbalance(replace(body, loads=[turned, *loads[1:]])) > 1e-3


@pytest.mark.parametrize("name", list(STATEMENTS))
def test_inertia_force_is_that_of_the_drawn_motion(name: str) -> None:
    """Mass, from the weight, times the second difference of the centroid's place."""
    moments = [cut(name, 50.0 + k * STEP_DEG).bodies for k in (-1, 0, 1)]
    step, checked = np.radians(STEP_DEG), 0
    for bodies in zip(*moments, strict=True):
        loads = [{load.name: load for load in body.loads} for body in bodies]
        if "weight" not in loads[1]:
            continue
        before, now, after = (each["weight"].place for each in loads)
        slope, bend = (after - before) / (2 * step), (after - 2 * now + before) / step**2
        acceleration = bend * OMEGA[name] ** 2 + slope * EPS[name]
        mass = -loads[1]["weight"].force[1] / 9.81
        inertia = loads[1]["inertia"].force
        assert inertia == pytest.approx(
            -mass * acceleration, rel=1e-5, abs=1e-5 * np.abs(inertia).max()
        )
        checked += 1
    assert checked == 2


@pytest.mark.parametrize("name", list(STATEMENTS))
def test_action_equals_reaction(name: str) -> None:
    loads = [(body.name, load) for body in cut(name).bodies for load in body.loads if load.by]
    inner = [(on, load) for on, load in loads if load.by != "ground"]
    assert inner
    for on, load in inner:
        (other,) = (x for body, x in inner if (body, x.by, x.name) == (load.by, on, load.name))
        assert other.force == pytest.approx(-load.force)
        assert other.place == pytest.approx(load.place)


def test_device_is_in_equilibrium_and_has_the_simulated_forces() -> None:
    bodies = {body.name: body for body in device.cut_bodies("wang2017", {}, 40.0).bodies}
    assert list(bodies) == [
        "sun", "carrier", "middle body", "planet", "inner half", "outer half",
    ]  # fmt: skip
    assert max(map(imbalance, bodies.values())) < LAW
    cycle = simulate(load_machine("wang2017"))
    row = int(np.argmin(np.abs(cycle.angles_deg - 40.0)))
    (frame,) = (load for load in bodies["sun"].loads if load.name == "O")
    assert frame.force[:2] == pytest.approx([cycle.columns[f"F_O{axis}_N"][row] for axis in "xy"])
    # teeth act at the pitch point, where the moment of the statement about the shaft vanishes
    (teeth,) = (load for load in bodies["middle body"].loads if load.name == "F_P")
    assert teeth.point == "pitch point"
    assert np.abs(teeth.moment).max() < 1e-12
    normal, friction = cycle.columns["F_NP_N"][row], np.radians(5.0)  # mu2 of the file
    assert np.hypot(*teeth.force[:2]) * np.cos(friction) == pytest.approx(normal, rel=1e-6)


def test_arrows_are_to_the_scale_that_is_drawn() -> None:
    bodies = cut("slider_crank")
    for body in bodies.bodies:
        marks = bodies.draw_sheet(body).marks
        arrows = {mark.text: mark for mark in marks if isinstance(mark, Arrow)}
        (scale,) = (mark for mark in arrows.values() if mark.names == ["scale"])
        per_newton = np.hypot(*scale.vector) / float(scale.text.removesuffix(" N"))
        (bar,) = (mark for mark in marks if isinstance(mark, Length))
        assert bar.size == pytest.approx(float(bar.names[0].removesuffix(" mm")))
        for load in body.loads:
            for mark in marks:
                if isinstance(mark, Arrow) and mark.text.startswith(f"{load.words}: "):
                    assert mark.vector == pytest.approx(per_newton * load.force[:2])
                    assert mark.at == pytest.approx(1e3 * load.place[:2])
    assert round_down(99.0) == 50.0


def test_command_writes_a_diagram_of_every_body(tmp_path: Path) -> None:
    result = answer("explain", file_of("four_bar"), "--bodies", "--at", "30")
    assert result["at_deg"] == 30
    assert [body["name"] for body in result["bodies"]] == ["crank", "coupler", "rocker"]
    assert {load["name"] for load in result["bodies"][2]["loads"]} == {
        "B", "D", "load", "weight", "inertia",
    }  # fmt: skip
    code, printed, _ = run(
        "explain", file_of("four_bar"), "--bodies", "--out", str(tmp_path / "out")
    )
    assert code == 0
    assert "add up to zero" in printed
    files = {path.name for path in (tmp_path / "out" / "figures").glob("*.svg")}
    assert files == {"body_crank.svg", "body_coupler.svg", "body_rocker.svg"}


def test_bodies_are_refused_in_words() -> None:
    free = str(own.generated("spinning_top") / "spinning_top.toml")
    assert "no angle drives" in refusal("explain", free, "--bodies")
    assert "not stated by its bodies" in refusal("explain", "shi2021", "--bodies")
    assert "name one machine" in refusal("explain", "--bodies")
    assert "--at has no effect without --bodies" in refusal("explain", "wang2017", "--at", "3")
    assert "finite" in refusal("explain", "wang2017", "--bodies", "--at", "nan")
