"""Simulate, check and optimise the mechanisms of planting machines: forces, gears, cams and motion.

The numeric part: it reads machine files, evaluates the generated equations of motion and optimises
designs. SI units and radians throughout, but in results: their attributes are the keys of the
commands' JSON and end in their units. Nothing heavy is imported before a name is used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from planter.version import __version__

if TYPE_CHECKING:
    from planter.audit.verdicts import audit as audit_papers
    from planter.engine.machine import load_machine
    from planter.engine.outputs import CycleObjective as Turns
    from planter.engine.outputs import OutputBatch, evaluate_many
    from planter.engine.outputs import OutputBatch as Batch
    from planter.errors import (
        ComputationError,
        GeometryError,
        InputError,
        Interrupted,
        PlanterError,
    )
    from planter.files.record import Record
    from planter.kernels import CallError, Kernel
    from planter.measured.posterior import Posterior, load_posterior
    from planter.measured.reading import Columns
    from planter.mechanism.cycle import simulate_machine as simulate
    from planter.mechanism.cycle import validate_machine as validate
    from planter.mechanism.model import MechanismCycle as Simulation
    from planter.mechanism.optimisation import compute_objective_sensitivity as sensitivity
    from planter.mechanism.optimisation import optimise_machine as optimise_machine
    from planter.mechanism.state_space.model import load_dynamics
    from planter.papers.clutch.field import evaluate_field, plan_field
    from planter.papers.clutch.file import load_clutch
    from planter.papers.clutch.modal_engagement import evaluate_engagement as engage_clutch
    from planter.papers.clutch.model import compute_geometry as clutch_geometry
    from planter.papers.clutch.sizing import optimise_clutch, size_clutch
    from planter.papers.mapping.curve import load_curve
    from planter.papers.mapping.file import load_poses
    from planter.papers.mapping.synthesis import synthesise
    from planter.papers.mapping.train import build_training as train
    from planter.papers.pickup.analysis import analyse_pickup as pick_up
    from planter.papers.planting.calibration import calibrate
    from planter.papers.planting.family_comparison import compare_families
    from planter.papers.planting.model import Device
    from planter.papers.planting.optimisation import Optimisation
    from planter.papers.planting.optimisation import optimise as optimise_device
    from planter.report.animation import show

__all__ = [
    "Batch",
    "CallError",
    "Columns",
    "ComputationError",
    "Device",
    "GeometryError",
    "InputError",
    "Interrupted",
    "Kernel",
    "Optimisation",
    "OutputBatch",
    "PlanterError",
    "Posterior",
    "Record",
    "Simulation",
    "Turns",
    "__version__",
    "audit_papers",
    "calibrate",
    "clutch_geometry",
    "compare_families",
    "engage_clutch",
    "evaluate_field",
    "evaluate_many",
    "load_clutch",
    "load_curve",
    "load_dynamics",
    "load_machine",
    "load_poses",
    "load_posterior",
    "optimise_clutch",
    "optimise_device",
    "optimise_machine",
    "pick_up",
    "plan_field",
    "sensitivity",
    "show",
    "simulate",
    "size_clutch",
    "synthesise",
    "train",
    "validate",
]

_HOMES = {
    "audit.verdicts": ("audit_papers:audit",),
    "papers.clutch.modal_engagement": ("engage_clutch:evaluate_engagement",),
    "papers.clutch.field": ("evaluate_field", "plan_field"),
    "papers.clutch.file": ("load_clutch",),
    "papers.clutch.model": ("clutch_geometry:compute_geometry",),
    "papers.clutch.sizing": ("optimise_clutch", "size_clutch"),
    "mechanism.state_space.model": ("load_dynamics",),
    "engine.outputs": (
        "Batch:OutputBatch",
        "OutputBatch",
        "Turns:CycleObjective",
        "evaluate_many",
    ),
    "engine.machine": ("load_machine",),
    "errors": ("ComputationError", "GeometryError", "InputError", "Interrupted", "PlanterError"),
    "kernels": ("CallError", "Kernel"),
    "papers.mapping.curve": ("load_curve",),
    "papers.mapping.file": ("load_poses",),
    "papers.mapping.synthesis": ("synthesise",),
    "papers.mapping.train": ("train:build_training",),
    "measured.posterior": ("Posterior", "load_posterior"),
    "measured.reading": ("Columns",),
    "mechanism.cycle": (
        "simulate:simulate_machine",
        "validate:validate_machine",
    ),
    "mechanism.model": ("Simulation:MechanismCycle",),
    "mechanism.optimisation": ("optimise_machine", "sensitivity:compute_objective_sensitivity"),
    "papers.pickup.analysis": ("pick_up:analyse_pickup",),
    "papers.planting.family_comparison": ("compare_families",),
    "papers.planting.calibration": ("calibrate",),
    "papers.planting.model": ("Device",),
    "papers.planting.optimisation": ("Optimisation", "optimise_device:optimise"),
    "files.record": ("Record",),
    "report.animation": ("show",),
}
"""Names by the module that they stand in, with their own name there where it is another."""


def __getattr__(name: str) -> object:
    for module, names in _HOMES.items():
        for entry in names:
            public, _, attribute = entry.partition(":")
            if public == name:
                return getattr(import_module(f"{__name__}.{module}"), attribute or public)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
