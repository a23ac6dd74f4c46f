"""Assumptions lifted: with none the model is the exact one; with any the work of the motor is that
of all friction.
"""

import numpy as np
import pytest

from planter import simulate
from planter.engine.solvers.sampled_cycle import sample_angles
from planter.errors import InputError
from planter.papers.planting import lifted
from planter.papers.planting.lifted import LiftedModel
from tests.support import machines

PHI = sample_angles(720, 2 * np.pi)
NAMES = ("wang2017", "random 1", "random 2")


@pytest.mark.parametrize("name", NAMES)
def test_model_without_relaxation_equals_exact_model(name: str) -> None:
    device = machines.device(name)
    turn, side = LiftedModel(device).turn(PHI), device.cycle(device.prologue(device.design), PHI)
    for vector, side_values, its in (
        ("side", turn.one, "side1"),
        ("side", turn.two, "side2"),
        ("totals", turn.totals, "totals"),
    ):
        for row, entry in zip(side[its], device.sidecar["vectors"][vector], strict=True):
            assert side_values[entry["name"]] == pytest.approx(row, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("case", ["teeth", "hinge", "both"])
def test_friction_work_is_motor_work_without_support_effect(name: str, case: str) -> None:
    device = machines.device(name)
    model, phi = LiftedModel(device), sample_angles(5760, 2 * np.pi)
    modelled = model.turn(phi)
    teeth = (
        {"against": 1.0, **model.locate_contacts(modelled, phi, 2e-3)} if case != "hinge" else {}
    )
    turn = model.turn(phi, {**teeth, **({"along_hinge": 1.0} if case != "teeth" else {})})
    speed = device.machine.si("speed_rpm")
    assert turn.motor_work == pytest.approx(turn.friction_loss(speed), rel=2e-5)
    assert turn.friction_loss(speed) > modelled.friction_loss(speed)
    assert turn.totals["F_support"] == pytest.approx(modelled.totals["F_support"], abs=1e-9)
    if case != "hinge":
        wrong = model.turn(
            phi,
            {name: -value if name.startswith("lead") else value for name, value in teeth.items()},
        )
        assert wrong.joint("F_A1") != pytest.approx(turn.joint("F_A1"), rel=1e-4)
        assert all((turn.one[f"F_{tag}_loss"] >= -1e-12).all() for tag in "PQ")


def test_teeth_touch_within_half_a_base_pitch_of_the_pitch_point() -> None:
    model = LiftedModel(machines.device("wang2017"))
    distances = model.locate_contacts(model.turn(PHI), PHI, 2e-3)
    half = np.pi * 2e-3 * np.cos(np.radians(20)) / 2
    for tag in "PQ":
        plus, minus = (
            distances[f"lead_{tag}_{flank}"] * distances[f"away_{tag}_{flank}"]
            for flank in ("plus", "minus")
        )
        assert plus == pytest.approx(-minus, abs=0)
        assert np.abs(plus).max() <= half
        assert plus.min() < -0.9 * half
        assert plus.max() > 0.9 * half


def test_effects_are_reported_for_exact_model_only() -> None:
    effects = {
        case.assumption: case
        for case in lifted.find_assumption_effects(machines.device("wang2017"))
    }
    assert (
        effects["tooth friction inwards"].joints_N["F_O1"]
        > effects["no tooth friction"].joints_N["F_O1"]
        > 1
    )
    assert all(case.support_N < 1e-9 for case in effects.values())
    assert (
        effects["teeth slide, module 2 mm"].friction_work_J
        > effects["no tooth friction"].friction_work_J + 0.1
    )
    simulated = simulate(machines.device("wang2017"), 60, (), 3.0)
    assert "module 3 mm" in simulated.result.lifted[2].assumption
    with pytest.raises(InputError, match="--lift needs --model exact"):
        simulate(machines.device("wang2017", "printed"), 60, (), 2.0)
