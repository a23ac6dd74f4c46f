"""The planting device driven by a motor and a flywheel: its carrier's speed varies, and its energy is told.

The motor's torque falls with the speed, along a line. What the device takes from the shaft is the exact model's torque
at a speed and an acceleration; energies come from its motion alone, so that the energy law tests the forces.
"""

from __future__ import annotations

from ...mechanics.laws import kinetic, potential
from ...mechanics.mechanism import Mechanism
from ...mechanics.twins import Sides
from ...model import ClosedForm, Let, System
from ...quantity import Quantity, Vector
from . import derivation
from . import quantities as q
from .lifted import speed_rate

_SOURCE = "derived: drive"
T_side = Quantity("T_side", "J", "kinetic energy of a side", _SOURCE)
V_side = Quantity("V_side", "J", "potential energy of a side: weights and return spring", _SOURCE)
M_stall = Quantity("M_stall", "N m", "torque of the motor at rest, at the carrier", "given", shown="stall_Nm")
omega_idle = Quantity(
    "omega_idle", "rad/s", "speed of the motor without load, at the carrier", "given", shown="idle_rpm"
)
J_w = Quantity("J_w", "kg m2", "flywheel, rotor and carrier, as the carrier feels them", "given", shown="flywheel_kgm2")
M_motor = Quantity("M_motor", "N m", "torque of the motor, at the carrier", _SOURCE)
surplus = Quantity("surplus", "N m", "torque that is left to the shaft, which vanishes", _SOURCE)
T_w = Quantity("T_w", "J", "kinetic energy of the flywheel", _SOURCE)
DRIVE, MOTOR = Vector("drive", (speed_rate,)), Vector("motor", (M_stall, omega_idle, J_w))
ASSUMPTIONS = (
    "as the exact model, but for the constant speed",
    "the motor's torque falls with the speed along a line",
    "motor and flywheel turn with the carrier, without slip or play",
)


def shaft() -> ClosedForm:
    """Balance of the carrier's shaft between motor, flywheel and device; what the motor and the flywheel add."""
    steps = (
        Let(M_motor, M_stall * (1 - q.omega / omega_idle), "given: the motor's line"),
        Let(surplus, M_motor - q.M_L - J_w * speed_rate, "derived: balance of the shaft"),
        Let(T_w, J_w * q.omega**2 / 2, "derived: energy of the flywheel"),
    )
    return ClosedForm(
        "shaft", (q.omega, speed_rate, q.M_L, MOTOR), steps, Vector("shaft_outputs", (M_motor, surplus, T_w))
    )


def _name_energies(m: Mechanism) -> None:
    """Energies of the bodies of a side and of its spring, whose force is S0 + k_s times its stretch."""
    side = [body for body in m.bodies if body not in m.shared]
    (force,) = (step.expr for step in m.named if step.symbol == q.S)
    stretch = force.diff(q.k_s)
    stored = q.S0 * stretch + q.k_s * stretch**2 / 2
    m.let(T_side, kinetic(m.motion, side, m.world))
    m.let(V_side, potential(m.assembly, side, m.O, m.world) + stored)


def drive() -> System:
    """The device at a carrier speed that varies."""
    m = derivation.device(speed_rate=speed_rate)
    _name_energies(m)
    lane = m.twin_lane(Sides(q.twin, (*q.REPORTED_EXACT, T_side, V_side), q.TOTALS), (*q.INPUTS, DRIVE))
    title = "Planting device, driven by a motor"
    return System("planting_drive", title, "derived (Newton-Euler)", ASSUMPTIONS, lane, (shaft(),))


SYSTEMS = (drive,)
