"""All figures of the planting device in one place. Each takes data in shown units and returns a Figure."""

from planter.planting.report.force import JOINTS, joint_forces, support_force
from planter.planting.report.motion import rotation, tip_path
from planter.planting.report.pitch import pitch_curves
from planter.report.search import convergence, pareto
from planter.report.style import save, svg

__all__ = [
    "DRAWN",
    "convergence",
    "joint_forces",
    "pareto",
    "pitch_curves",
    "rotation",
    "save",
    "support_force",
    "svg",
    "tip_path",
]

_TIP = ("tip_x_mm", "tip_y_mm", "tip_machine_x_mm", "theta1_deg")
_PLACES = ("x_A1_mm", "y_A1_mm", "x_B1_mm", "y_B1_mm")
DRAWN = {
    "support_force": ("phi_deg", "support_N"),
    "joint_forces": ("phi_deg", *(f"{joint}{axis}_N" for joint in JOINTS for axis in "xy")),
    "tip_path": ("phi_deg", *_TIP, *_PLACES),
    "rotation": ("phi_deg", "phi52_deg", "phi72_deg", "omega_rad_s"),
}
"""Columns of a turn that each figure draws."""
