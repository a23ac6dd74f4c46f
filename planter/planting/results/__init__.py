"""What the planting device's commands return, key by key."""

from planter.engine.drive import DriveResult
from planter.engine.sensitivity import SensitivityFound
from planter.measured.findings import MeasuredFound
from planter.mechanism.results import MachineValidation, Turn
from planter.planting.results.calibrated import CalibrationFound
from planter.planting.results.compared import ComparisonFound
from planter.planting.results.driven import DriveFound
from planter.planting.results.optimised import OptimisationFound
from planter.planting.results.simulated import SimulationFound, Validation
from planter.workshop.cams.results import Cam

COMMANDS = {
    "drive": DriveFound | DriveResult,
    "simulate": SimulationFound | Turn,
    "turn": SimulationFound | Turn,
    "sensitivity": SensitivityFound,
    "validate": Validation | MachineValidation,
    "calibrate": CalibrationFound | MeasuredFound,
    "compare": ComparisonFound,
    "optimise": OptimisationFound,
    "cam": Cam,
}
