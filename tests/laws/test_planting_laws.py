"""Laws that every first-principles model of the planting device obeys, on built-in machines and
random valid ones.

The motion is written from the geometry alone (tests/support/kinematics.py). Each law is a function
that returns by how much it is broken; beside it stands a case in which it is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.model import Device
from tests.support import kinematics, machines, model
from tests.support.jets import Place
from tests.support.joints import panels

Array = NDArray[np.float64]
TURN = 2 * np.pi
every_machine = pytest.mark.parametrize("name", machines.sampled(2, 4))


def angles(count: int = 200) -> Array:
    return np.random.default_rng(0).uniform(0, TURN, count)


# --- momentum
# --------------------------------------------------------------------------------------


def weight(machine: PlantingMachine) -> float:
    side = (
        machine.si("middle_kg")
        + machine.si("planet_kg")
        + 2 * (machine.si("half_C1_kg") + machine.si("half_C2_kg"))
    )
    return machine.si("gravity_m_s2") * (machine.si("sun_kg") + machine.si("carrier_kg") + 2 * side)


def momentum_rate(machine: PlantingMachine, phi: Array) -> tuple[Array, Array]:
    """Sum over all bodies of mass times acceleration, horizontal and vertical."""
    device = kinematics.Device(machine)
    parts = [part for angle in (phi, phi - np.pi) for part in device.side(angle).weights()]
    x, y = (
        sum(machine.si(mass) * place[axis].acceleration for mass, place in parts) for axis in (0, 1)
    )
    return x, y


def momentum_gap(device: Device, bodies: PlantingMachine) -> float:
    phi = angles()
    totals = model.cycle(device, phi).totals
    x, y = momentum_rate(bodies, phi)
    return float(
        np.max(np.abs([totals["F_support_x"] - x, totals["F_support"] - y - weight(bodies)]))
    )


@every_machine
def test_support_force_is_weight_and_rate_of_momentum(name: str) -> None:
    assert momentum_gap(machines.device(name), machines.machine(name)) < 1e-10


@pytest.mark.parametrize(
    "path",
    [
        "mass.planet_kg",
        "nozzle.C2_mm[2]",
        "centroid.middle_angle_deg",
        "design.theta_deg",
        "cam.opening_deg",
    ],
)
def test_momentum_detects_error_of_1_percent(path: str) -> None:
    assert momentum_gap(machines.device("wang2017"), machines.tampered("wang2017", path)) > 1e-5


# --- a cycle
# ---------------------------------------------------------------------------------------


def lost_power(machine: PlantingMachine, outputs: model.Outputs, phi: Array) -> Array:
    """Power that friction takes on both sides: each contact force against the relative velocity
    there.
    """
    device, total = kinematics.Device(machine), np.zeros(len(phi))
    for angle, side in zip((phi, phi - np.pi), outputs.sides, strict=True):
        motion = device.side(angle)
        x, z = motion.sliding
        total -= side["F_Ex"] * x + side["F_Ez"] * z
        for stage, force in ((1, "F_P"), (2, "F_Q")):
            u, v = slip(motion, stage, motion.mesh(stage).place)
            total -= side[f"{force}x"] * u + side[f"{force}y"] * v
    return total


def slip(motion: kinematics.Side, stage: int, place: tuple[Array, Array]) -> tuple[Array, Array]:
    """Velocity of the inner gear of a stage less that of the outer one at a place, as rigid
    bodies.
    """
    speed = motion.phi.rate
    middle = body_velocity(motion.A1, speed + motion.phi52.rate, place)
    if stage == 1:
        return -middle[0], -middle[1]
    planet = body_velocity(motion.B1, speed + motion.phi72.rate, place)
    return middle[0] - planet[0], middle[1] - planet[1]


def body_velocity(centre: Place, spin: Array, place: tuple[Array, Array]) -> tuple[Array, Array]:
    x, y, _ = centre
    return x.rate - spin * (place[1] - y.value), y.rate + spin * (place[0] - x.value)


def work_gap(name: str, moving: PlantingMachine) -> float:
    """Input work of a turn less friction work, with the sliding of the machine that is `moving`."""
    phi, weights = panels(name)
    outputs = model.cycle(machines.device(name), phi)
    return float(
        weights
        @ (outputs.totals["M_L"] - lost_power(moving, outputs, phi) / moving.si("speed_rpm"))
    )


@every_machine
def test_input_work_is_friction_work(name: str) -> None:
    assert abs(work_gap(name, machines.machine(name))) < 1e-9


def test_work_shows_the_sliding_of_another_machine() -> None:
    assert abs(work_gap("wang2017", machines.tampered("wang2017", "cam.base_radius_mm"))) > 1e-5


@every_machine
def test_model_loss_is_force_times_sliding(name: str) -> None:
    phi, _ = panels(name)
    outputs = model.cycle(machines.device(name), phi)
    loss = outputs.side1["F_E_loss"] + outputs.side2["F_E_loss"]
    assert loss == pytest.approx(lost_power(machines.machine(name), outputs, phi), abs=1e-10)


@every_machine
def test_no_friction_no_input_work(name: str) -> None:
    smooth = {"contact.cam_friction_angle_deg": 0.0, "contact.tooth_friction_angle_deg": 0.0}
    device = Device(machines.machine(name).with_numbers(smooth))
    phi, weights = panels(name)
    totals = model.cycle(device, phi).totals
    assert abs(weights @ totals["M_L"]) < 1e-9
    assert np.abs(totals["M_L"]).max() > 1e-2


# --- symmetry and scaling
# --------------------------------------------------------------------------


@every_machine
def test_frame_force_repeats_every_half_turn(name: str) -> None:
    phi, device = angles(), machines.device(name)
    now, later = (model.cycle(device, angle) for angle in (phi, phi + np.pi))
    for key, values in now.totals.items():
        assert values == pytest.approx(later.totals[key], abs=1e-9), key
    for key, values in now.side1.items():
        assert values == pytest.approx(later.side2[key], abs=1e-9), key


def test_single_side_has_no_half_turn_symmetry() -> None:
    device = machines.device("wang2017")
    side = model.cycle(device, np.array([1.0, 1.0 + np.pi])).side1
    assert abs(np.diff(side["F_B1y"])[0]) > 1


@every_machine
@pytest.mark.parametrize(
    "path",
    ["design.gamma_deg", "design.A6_mm", "centroid.sun_radius_mm", "inertia.J7_about_B1_kg_m2"],
)
def test_support_force_depends_on_common_centroid_only(name: str, path: str) -> None:
    """Shafts of the two sides lie opposite each other: where they are does not matter, nor does any
    inertia.
    """
    both = machines.device(name), Device(machines.tampered(name, path))
    base, changed = (model.cycle(device, angles(50)).totals for device in both)
    for force in ("F_support", "F_support_x"):
        assert base[force] == pytest.approx(changed[force], abs=1e-10)


def speed_gap(name: str, power: int) -> float:
    """How far the force less the weight is from scaling with a power of the speed."""
    phi, base = angles(50), machines.machine(name)
    faster = Device(machines.tampered(name, "operation.speed_rpm", 1.5))
    slow, fast = (
        model.cycle(d, phi).totals["F_support"] - weight(base)
        for d in (machines.device(name), faster)
    )
    return float(np.abs(fast - 1.5**power * slow).max())


@every_machine
def test_force_less_weight_scales_with_speed_squared(name: str) -> None:
    assert speed_gap(name, 2) < 1e-10
    assert speed_gap(name, 3) > 1e-2


# --- contacts
# --------------------------------------------------------------------------------------


@every_machine
def test_teeth_push(name: str) -> None:
    side = model.cycle(machines.device(name), angles()).side1
    assert side["F_NP"].min() >= 0
    assert side["F_NQ"].min() >= 0


@pytest.mark.parametrize("name", machines.BUILT_IN)
def test_the_roller_is_pushed_in_the_built_in_machines(name: str) -> None:
    assert model.cycle(machines.device(name), TURN * np.arange(720) / 720).side1["F_E"].min() > 0


def test_without_a_spring_the_roller_would_have_to_be_pulled() -> None:
    slack = machines.machine("wang2017").with_numbers(
        {"spring.preload_N": 0.0, "spring.rate_N_m": 0.0}
    )
    assert model.cycle(Device(slack), TURN * np.arange(720) / 720).side1["F_E"].min() < 0


@every_machine
def test_cam_friction_opposes_sliding_within_cone(name: str) -> None:
    phi, machine = angles(), machines.machine(name)
    side = model.cycle(machines.device(name), phi).side1
    x, z = kinematics.Device(machine).side(phi).sliding
    speed = np.hypot(x, z)
    tangential, across = (
        (side["F_Ex"] * x + side["F_Ez"] * z) / speed,
        (side["F_Ez"] * x - side["F_Ex"] * z) / speed,
    )
    mu = np.tan(machine.si("cam_friction_angle_deg"))
    assert tangential == pytest.approx(-mu * across, abs=1e-9)
    assert (tangential * side["F_E"] < 0).all()
    assert (side["F_E_loss"] * side["F_E"] > 0).all()


def test_other_friction_would_show() -> None:
    phi, machine = angles(), machines.tampered("wang2017", "contact.cam_friction_angle_deg")
    side = model.cycle(machines.device("wang2017"), phi).side1
    expected = np.array(kinematics.Device(machine).side(phi).cam_direction) * side["F_E"]
    assert np.abs(expected - [side["F_Ex"], side["F_Ez"]]).max() > 1e-3


@every_machine
def test_teeth_do_not_slide_at_the_pitch_point(name: str) -> None:
    motion = kinematics.Device(machines.machine(name)).side(angles())
    for stage in (1, 2):
        x, y = motion.mesh(stage).place
        assert np.abs(slip(motion, stage, (x, y))).max() < 1e-14
        assert np.abs(slip(motion, stage, (x + 1e-3, y))).max() > 1e-3


@every_machine
def test_the_other_flank_would_have_to_pull(name: str) -> None:
    phi = angles()
    side, motion = (
        model.cycle(machines.device(name), phi).side1,
        kinematics.Device(machines.machine(name)).side(phi),
    )
    for stage, tooth in ((1, "P"), (2, "Q")):
        flank = np.where(side[f"M_{tooth}"] > 0, 1, -1)
        for bearing, sign in ((flank, 1), (-flank, -1)):
            assert (sign * side[f"M_{tooth}"] * motion.mesh(stage).lever(bearing) > 0).all()


@every_machine
def test_tooth_forces_lie_at_the_pressure_angle_less_friction(name: str) -> None:
    phi, machine = angles(), machines.machine(name)
    side, motion = (
        model.cycle(machines.device(name), phi).side1,
        kinematics.Device(machine).side(phi),
    )
    for stage, tooth in ((1, "P"), (2, "Q")):
        mesh = motion.mesh(stage)
        expected, printed_force = (
            mesh.force(side[f"M_{tooth}"]),
            (side[f"F_{tooth}x"], side[f"F_{tooth}y"]),
        )
        assert np.array(printed_force) == pytest.approx(np.array(expected), abs=1e-10)
        turned = replace(mesh, lean=mesh.lean + np.radians(0.1)).force(side[f"M_{tooth}"])
        assert np.abs(np.subtract(printed_force, turned)).max() > 1e-4
        size = side[f"F_N{tooth}"] / np.cos(machine.si("tooth_friction_angle_deg"))
        assert np.hypot(*printed_force) == pytest.approx(size, abs=1e-10)
