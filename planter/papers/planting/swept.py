"""Sweeps and tolerances of planting devices: `ADAPTER`, as `planter.rows.adapter` has it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from planter.engine.goal import Goal, resolve_limit
from planter.engine.limits import MeasureLimits
from planter.engine.machine import Machine
from planter.engine.outputs import SampledOutputs
from planter.engine.solvers.constraints import Constraints, join_constraints
from planter.errors import InputError
from planter.files import units
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.machines import DEVIATIONS, add_deviations
from planter.papers.planting.model import Device, build_machine
from planter.papers.planting.requirements import RequirementConstraints
from planter.rows.adapter import MachineAdapter
from planter.rows.points import Spread
from planter.rows.robust import RobustGoal, Settings

Ends = Mapping[str, tuple[float, float]]
ToleranceSpec = dict[str, Any]
SPEEDS: ToleranceSpec = {"from": 35, "to": 45}
"""Of the carrier in the paper's experiment [r/min]."""
MASS: ToleranceSpec = {"percent": 2}
CENTROID: dict[str, ToleranceSpec] = {"mm": {"plus_minus": 0.5}, "deg": {"plus_minus": 2}}
PHASE: ToleranceSpec = {"plus_minus": 0.1}
"""Of a gear on its shaft, and of the mounting [deg]."""
DISTANCE: ToleranceSpec = {"plus_minus": 0.05}
"""Of centres [mm]."""
CURVE: dict[str, ToleranceSpec] = {"mm": {"plus_minus": 0.02}, "": {"plus_minus": 0.002}}
"""Of a pitch curve's parameters, beside the size of all."""
FRICTION: ToleranceSpec = {"plus_minus": 2, "distribution": "uniform"}
"""Of an angle of friction [deg]."""
SECTIONS = ("centroid.", "nozzle.C1_mm", "nozzle.C2_mm")
"""Where centroids stand in a file."""


class PlantingSweepAdapter(MachineAdapter):
    """Planting devices; centre distances may deviate from those of the pitch curves."""

    choices: Mapping[str, Sequence[str]] = {"model": ("exact", "printed")}

    def build(self, machine: PlantingMachine) -> Machine:
        """Return the machine of a file, with deviations of its centre distances."""
        return _build_machine(Device(machine), DEVIATIONS)

    def default_outputs(self, machine: PlantingMachine) -> Sequence[str]:
        """Return the objective, its components, and the motor's torque."""
        return "objective", "support_range_N", "support_max_N", "M_L_max_Nm", "M_L_rms_Nm"

    def frozen(self, machine: PlantingMachine) -> dict[str, Any]:
        """Return its table."""
        return {"table": machine.table(), "source": machine.source}

    def thaw(self, frozen: Mapping[str, Any]) -> PlantingMachine:
        """Return the file of a table."""
        return PlantingMachine.read(frozen["table"], frozen["source"])

    def tolerances(self, machine: PlantingMachine) -> dict[str, dict[str, Any]]:
        """Return assumed ones of masses, centroids, phases, centre distances, curves and friction;
        speeds measured.
        """
        return dict(_list_tolerances(Device(machine)))

    def subject(
        self,
        frozen: Mapping[str, Any],
        choices: Mapping[str, str],
        inputs: Ends,
        outputs: Sequence[str],
    ) -> SampledOutputs:
        """Return the outputs of a device in one of its models.

        Raises InputError if its file does not allow an end of an input, GeometryError if a corner
        has no gears.
        """
        device = _build_device(self.thaw(frozen), choices, inputs)
        return SampledOutputs(_build_machine(device, inputs), tuple(inputs), outputs)

    def build_robust(
        self,
        machine: PlantingMachine,
        choices: Mapping[str, str],
        spreads: Mapping[str, Spread],
        settings: Settings,
    ) -> RobustGoal | None:
        """Return the objective over machines as the tolerances make them, under the file's
        requirements.

        Another sum, and other values that are varied, are searched as of any machine, without the
        requirements.
        """
        if settings.is_stated:
            return super().build_robust(machine, choices, spreads, settings)
        # A design's deviations leave the file's bounds by little; those are what its gears are
        # checked on.
        ends = {
            name: (spread.low, spread.high)
            for name, spread in spreads.items()
            if not name.startswith("design.")
        }
        device = _build_device(machine, choices, ends)
        built, samples = _build_machine(device, spreads), machine.objective.samples
        parts: list[Constraints | None] = [RequirementConstraints.from_device(device)]
        if built.limits:
            limits = [resolve_limit(built, limit) for limit in built.limits]
            parts.append(MeasureLimits(Goal(built, (), limits)))
        required = join_constraints([part for part in parts if part is not None])
        return RobustGoal(built, spreads, settings, samples, required)


def _build_machine(device: Device, inputs: Sequence[str] | Mapping[str, Any]) -> Machine:
    """Return the machine of a device, with deviations of its centre distances if they are among the
    inputs.
    """
    machine = build_machine(device)
    return add_deviations(machine, device) if set(DEVIATIONS) & set(inputs) else machine


def _build_device(machine: PlantingMachine, choices: Mapping[str, str], inputs: Ends) -> Device:
    """Return a device with the ends of varied design parameters as their bounds, so that all
    corners have gears.

    Raises InputError if the file does not allow an end.
    """
    try:
        for end in (0, 1):
            for name, ends in inputs.items():
                if name not in DEVIATIONS:
                    machine.with_numbers({name: ends[end]})
    except InputError as error:
        raise InputError(f"an end of a varied input: {error}") from None
    table = machine.table()
    for name, (low, high) in inputs.items():
        section, _, key = name.partition(".")
        if section == "design":
            table["design"][key] = low
            if low < high:
                table["bounds"][key] = [low, high]
    return Device(
        type(machine).read(table, machine.source),
        "printed" if choices.get("model") == "printed" else "exact",
    )


def _list_tolerances(device: Device) -> Iterator[tuple[str, ToleranceSpec]]:
    data = [entry["shown"] for entry in device.sidecar["vectors"]["machine"]]
    nominal = device.machine.numbers()
    for path in data:
        if path.startswith("mass.") and nominal[path]:
            yield path, MASS
        elif path.startswith(SECTIONS):
            yield path, CENTROID[units.display_unit(path)]
        elif path.endswith("friction_angle_deg"):
            yield path, _above_zero(FRICTION, nominal[path])
    for name, entry in zip(device.names, device.entries, strict=True):
        yield f"design.{name}", PHASE if entry["unit"] == "rad" else CURVE[units.display_unit(name)]
    for path in DEVIATIONS:
        yield path, DISTANCE
    yield "operation.speed_rpm", SPEEDS


def _above_zero(tolerance: ToleranceSpec, nominal: float) -> ToleranceSpec:
    """A tolerance that leaves nothing negative."""
    return tolerance | {
        "plus_minus": min(tolerance["plus_minus"], nominal) or tolerance["plus_minus"]
    }


ADAPTER = PlantingSweepAdapter(__package__)
