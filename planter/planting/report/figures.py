"""All figures of the planting device in one place. Each takes data in shown units and returns a Figure."""

from planter.planting.report.force import joint_forces, support_force
from planter.planting.report.motion import rotation, tip_path
from planter.planting.report.pitch import pitch_curves
from planter.report.search import convergence, pareto
from planter.report.style import save, svg

__all__ = [
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
