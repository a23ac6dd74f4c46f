"""The switching of a clutch as a machine of the engine: the linkage's own numbers over the way,
there and back.
"""

from __future__ import annotations

import numpy as np
import pytest

from planter.engine.machine import Machine, load_machine
from planter.engine.summary import summarise_machine
from planter.errors import GeometryError
from planter.kernels import formulas
from planter.papers.clutch.file import load_clutch
from planter.papers.clutch.model import (
    CrankLinkage,
    collect_values,
    load_model,
)
from tests.support.responses import values_of

CRANK = ("l_AB", "l_BC", "l_AC")


@pytest.fixture(scope="module")
def machine() -> Machine:
    return load_machine("shi2021")


def test_the_sleeve_goes_as_the_linkage_pushes_it(machine: Machine) -> None:
    clutch = load_clutch("shi2021")
    sizes = collect_values(clutch)
    angles = np.linspace(0, machine.turn / 2, 23)
    values = values_of(machine, angles)
    linkage = CrankLinkage(sizes["l_AB"], sizes["l_BC"], sizes["l_AC"])
    for name, expected in linkage.evaluate(values["shift"]).items():
        np.testing.assert_allclose(values[name], expected, rtol=1e-12, err_msg=name)
    pushed = load_model()(
        "push",
        shift=values["shift"],
        crank=[sizes[name] for name in CRANK],
        F1=sizes["F1"],
        r_A=sizes["r_A"],
    )
    for name in ("tooth_force", "side_force"):
        np.testing.assert_allclose(values[name], pushed[name], rtol=1e-13)
    assert values["shift"][[0, -1]] == pytest.approx([0, clutch.si("sleeve.travel_mm")], abs=1e-15)


def test_machine_motion_agrees_with_dynamics(machine: Machine) -> None:
    sizes, speed = collect_values(load_clutch("shi2021")), machine.data[machine.speed]
    start, lift = np.pi / 2 - sizes["gamma"], machine.turn / 2
    times = np.linspace(0.1, 0.9, 9) * lift / speed
    link = [sizes["k"], sizes["gamma"], start, start + lift, speed]
    course = formulas.load("clutch_motion")(
        "course", t=times, crank=[sizes[name] for name in CRANK], link=link
    )
    values = values_of(machine, speed * times)
    for name, expected in (
        ("alpha", "link_angle"),
        ("shift", "pushed"),
        ("v_sleeve", "pushed_dot"),
    ):
        np.testing.assert_allclose(values[name], course[expected], rtol=1e-11, atol=1e-14)


def test_the_link_comes_back_as_it_went(machine: Machine) -> None:
    angles = np.linspace(0, machine.turn / 2, 7)[1:-1]
    start, back, later = (
        values_of(machine, x) for x in (angles, machine.turn - angles, angles + machine.turn)
    )
    for name in start:
        sign = -1 if name in ("v_sleeve", "M_link") else 1
        np.testing.assert_allclose(back[name], sign * start[name], rtol=1e-10, atol=1e-15)
        np.testing.assert_allclose(later[name], start[name], rtol=1e-10, atol=1e-15)


def test_link_work_equals_sleeve_work(machine: Machine) -> None:
    up = machine.turn / 2 * np.array([0.2, 0.5, 0.9])
    values = values_of(machine, up)
    np.testing.assert_allclose(
        values["M_link"] * machine.data[machine.speed], 60.0 * values["v_sleeve"], rtol=1e-13
    )
    np.testing.assert_allclose(values["M_link"] * 14 / 46, 60.0 * values["lever"], rtol=1e-12)
    fastest = values_of(machine, np.array([0.4999999 * machine.turn]))["v_sleeve"][0]
    motor = summarise_machine(machine).motor
    assert motor is not None
    assert motor.peak_power_W == pytest.approx(60.0 * fastest, rel=1e-6)


def test_linkage_without_closure_is_refused() -> None:
    with pytest.raises(GeometryError, match=r"rod_mm = 70.*crank and rod meet"):
        load_machine("shi2021", {"linkage.rod_mm": 70.0})
