"""The designer's summary: laws of work, dense turns, circular gears by hand, and what a jump of the
cam does.
"""

import math

import numpy as np
import pytest

from planter import simulate
from planter.errors import InputError
from planter.kernels.formulas import load as formulas
from planter.papers.planting import design_results
from planter.papers.planting import design_summary as summary
from planter.papers.planting.design_results import DesignersSummary
from planter.papers.planting.design_summary import DesignTurn
from planter.papers.planting.file import PlantingMachine, load
from planter.papers.planting.model import Device
from tests.support import machines

TEETH = {"module_mm": 1.5, "face_width_mm": 12.0, "youngs_modulus_GPa": 206.0, "poisson_ratio": 0.3}
PHI = np.linspace(0, 2 * np.pi, 7201)


def summarise_machine(name: str, model: str = "exact") -> tuple[Device, DesignersSummary]:
    device = machines.device(name, "printed" if model == "printed" else "exact")
    return device, summary.summarise_design(device, device.design)


def with_teeth(machine: PlantingMachine, **changes: float) -> PlantingMachine:
    return PlantingMachine.read({**machine.table(), "gears": {**TEETH, **changes}}, machine.source)


@pytest.mark.parametrize("name", ["wang2017", "random 2"])
def test_the_motor_s_mean_torque_does_the_work_of_friction(name: str) -> None:
    device, designer = summarise_machine(name)
    assert 2 * math.pi * designer.motor.mean_Nm == pytest.approx(
        simulate(device).result.work["friction_J"], rel=1e-8
    )


def test_printed_summary_omits_unreported_quantities() -> None:
    _, designer = summarise_machine("wang2017", "printed")
    assert not [force for force in designer.peaks if force.name.startswith("hinge")]
    assert min(force.min for force in designer.peaks if force.name == "F_NP") < -50


def test_nearly_circular_gears_equal_textbook() -> None:
    """Stage 2 of almost equal circles: sizes, and stress by the textbook's formulas at the largest
    normal force.
    """
    base = with_teeth(machines.machine("wang2017"))
    wide = {**base.bounds, "k6": (1e-9, 0.1), "m61": (0.9, 1.5)}
    table = {**base.table(), "bounds": wide, "design": {**base.design, "k6": 1e-8, "m61": 1.0}}
    device = Device(PlantingMachine.read(table, "own"))
    designer = summary.summarise_design(device, device.design)
    (stage,) = designer.stages[1:]
    radius = base.design["A6_mm"]
    for gear in stage.gears:
        assert gear.curvature_radius_min_mm == pytest.approx(radius, rel=1e-6)
        assert gear.teeth_min == pytest.approx(2 * radius / TEETH["module_mm"], rel=1e-6)
    assert stage.pressure_angle_max_deg == pytest.approx(20, abs=1e-5)
    normal = next(force.max for force in designer.peaks if force.name == "F_NQ")
    assert stage.stress is not None
    curvature = 2 / (radius * 1e-3 * math.sin(math.radians(20)))
    expected = 189.8e3 * math.sqrt(normal / (TEETH["face_width_mm"] * 1e-3) * curvature) * 1e-6
    assert stage.stress.contact_MPa == pytest.approx(expected, rel=3e-4)
    assert stage.stress.contact_phi_deg == pytest.approx(
        next(force.max_phi_deg for force in designer.peaks if force.name == "F_NQ"), abs=1e-4
    )


def test_stress_equals_contact_formulas() -> None:
    device = Device(with_teeth(machines.machine("wang2017")))
    stage_summary = summary.summarise_design(device, device.design).stages[0]
    side = device.side(device.design, PHI[:-1:4])
    stage, parameters = device.stages[0], device.of_stage(0, device.design)
    hoisted = stage.prologue(parameters=parameters)["hoisted"]
    contact = {
        k: v[0]
        for k, v in stage.contact(t=side["t1"], parameters=parameters, hoisted=hoisted).items()
    }
    bend = (contact["r"] ** 2 + 2 * contact["dr"] ** 2 - contact["r"] * contact["ddr"]) / np.hypot(
        contact["r"], contact["dr"]
    ) ** 3
    load = np.vstack(
        [side["F_NP"], np.full_like(bend, 12e-3), np.full_like(bend, math.radians(20))]
    )
    stress = formulas("gear_strength")("bending_stress", kappa1=bend, module=1.5e-3, load=load)[
        "sigma"
    ]
    assert stage_summary.stress is not None
    assert stress.max() * 1e-6 == pytest.approx(stage_summary.stress.bending_MPa[0], rel=1e-4)


def test_only_a_cam_whose_acceleration_jumps_gives_shocks() -> None:
    """The harmonic law starts with pi^2/2 of rise over span squared (Norton), seen at the planet's
    own rate.
    """
    base = machines.machine("wang2017")
    assert summary.summarise_design(Device(base), Device(base).design).shocks == []
    device = Device(machines.with_flank(base, "harmonic"))
    shocks = summary.summarise_design(device, device.design).shocks
    events = {(shock.event, shock.side) for shock in shocks}
    assert events == {
        (f"cam, {w} of the {f}", s)
        for w in ("start", "end")
        for f in ("rise", "fall")
        for s in (1, 2)
    }
    start = next(
        shock
        for shock in shocks
        if shock.event == "cam, start of the rise" and shock.quantity == "theta1_ddot"
    )
    low, high = map(math.radians, base.cam.rise_delta_deg)
    phi = math.radians(start.phi_deg)
    turned = device.side(device.design, np.array([phi - 1e-5, phi + 1e-5]))["phi72"]
    rate = float(np.diff(turned)[0]) / 2e-5 * base.si("speed_rpm")
    law = math.radians(base.cam.opening_deg) * math.pi**2 / 2 * (rate / (high - low)) ** 2
    assert (start.before, start.after) == pytest.approx((0.0, law), rel=1e-6)
    assert not [shock for shock in shocks if shock.quantity == "x_tip_ddot"]
    kept_event = next(
        table
        for table in design_results.list_design_tables(
            summary.summarise_design(device, device.design)
        )
        if "Shocks" in table.caption
    )
    assert 0 < len(kept_event.rows) <= 16


def test_missing_gear_values_are_reported() -> None:
    base = machines.machine("wang2017")
    assert "module" in summarise_machine("wang2017")[1].notes[0]
    only = PlantingMachine.read({**base.table(), "gears": {"module_mm": 2.0}}, "own")
    designer = summary.summarise_design(Device(only), Device(only).design)
    assert designer.stages[0].contact_ratio_min is not None
    assert "face_width_mm" in designer.notes[0]
    coarse = Device(with_teeth(base, module_mm=5.0))
    few = summary.summarise_design(coarse, coarse.design)
    assert few.stages[0].stress is not None
    assert few.stages[0].stress.bending_MPa == [None, None]
    assert "the form factor begins at 12" in few.notes[0]
    flat = Device(with_teeth(machines.machine("compact")))
    assert "20 deg" in summary.summarise_design(flat, flat.design).notes[0]


@pytest.mark.parametrize(
    ("gears", "message"),
    [
        ({"module_mm": 0.01}, "at least 0.1"),
        ({"poisson_ratio": 0.5}, "less than 0.5"),
        ({"modul_mm": 2}, "module_mm"),
    ],
)
def test_gears_out_of_range_are_refused(gears: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=rf"gears\..*{message}"):
        with_teeth(machines.machine("wang2017"), **gears)


def test_two_modules_are_refused() -> None:
    wide = load("wang2017-wide")
    assert summary.find_module(DesignTurn(Device(wide), Device(wide).design)) == pytest.approx(2e-3)
    with pytest.raises(InputError, match=r"requirements.module_mm = 2"):
        with_teeth(wide)
    with_teeth(wide, module_mm=2.0)
