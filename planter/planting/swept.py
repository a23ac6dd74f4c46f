"""Sweeps and tolerances of planting devices: `ROOM`, as `planter.tolerance.room` has it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from planter.errors import InputError
from planter.files import examples
from planter.tolerance.machine_room import MachineRoom

if TYPE_CHECKING:
    from planter.engine.machine import Machine
    from planter.engine.outputs import SampledOutputs
    from planter.planting.file import Machine as MachineFile
    from planter.planting.model import Device
    from planter.tolerance.robust import RobustGoal
    from planter.tolerance.room import Settings
    from planter.tolerance.spread import Spread

KIND = "planting"
OWN = {"stage1", "stage2", "nozzle"}
"""Tables that no other kind of file has."""
Ends = Mapping[str, tuple[float, float]]


class Room(MachineRoom):
    """Planting devices; centre distances may deviate from those of the pitch curves."""

    choices: Mapping[str, Sequence[str]] = {"model": ("exact", "printed")}
    banded = ("objective", "support_range_N", "support_max_N", "M_L_max_Nm", "tip_y_min_mm", "tip_x_range_mm")
    curves = ("support_N", "M_L_Nm")
    paths = (("tip_x_mm", "tip_y_mm"),)

    def takes(self, source: str) -> bool:
        """Return whether a source is a built-in name, or a file with the tables of such a machine."""
        return examples.belongs(source, KIND, OWN)

    def build(self, machine: MachineFile) -> Machine:
        """Return the machine of a file, with deviations of its centre distances."""
        from planter.planting.model import Device
        from planter.planting.mounting import DEVIATIONS

        return _build_machine(Device(machine), DEVIATIONS)

    def default_outputs(self, machine: MachineFile) -> Sequence[str]:
        """Return the objective, what it is made of, and the motor's torque."""
        return "objective", "support_range_N", "support_max_N", "M_L_max_Nm", "M_L_rms_Nm"

    def frozen(self, machine: MachineFile) -> dict[str, Any]:
        """Return its table."""
        return {"table": machine.table(), "source": machine.source}

    def thaw(self, frozen: Mapping[str, Any]) -> MachineFile:
        """Return the file of a table."""
        from planter.planting.file import Machine as MachineFile

        return MachineFile.read(frozen["table"], frozen["source"])

    def tolerances(self, machine: MachineFile) -> dict[str, dict[str, Any]]:
        """Return assumed ones of masses, centroids, phases, centre distances, curves and friction; speeds measured."""
        from planter.planting import tolerances

        return tolerances.usual(machine)

    def subject(
        self, frozen: Mapping[str, Any], choices: Mapping[str, str], inputs: Ends, outputs: Sequence[str]
    ) -> SampledOutputs:
        """Return the outputs of a device in one of its models.

        Raises InputError if its file does not allow an end of an input, GeometryError if a corner has no gears.
        """
        from planter.engine.outputs import SampledOutputs

        device = _build_device(self.thaw(frozen), choices, inputs)
        return SampledOutputs(_build_machine(device, inputs), tuple(inputs), outputs)

    def build_robust(
        self, machine: MachineFile, choices: Mapping[str, str], spreads: Mapping[str, Spread], settings: Settings
    ) -> RobustGoal | None:
        """Return the objective over machines as the tolerances make them, under the file's requirements.

        Another sum, and other values that are varied, are searched as of any machine, without the requirements.
        """
        if settings.is_stated:
            return super().build_robust(machine, choices, spreads, settings)
        from planter.planting.requirements.constraints import Required
        from planter.tolerance.robust import RobustGoal

        # A design's deviations leave the file's bounds by little; those are what its gears are checked on.
        ends = {name: (one.low, one.high) for name, one in spreads.items() if not name.startswith("design.")}
        device = _build_device(machine, choices, ends)
        samples = machine.objective.samples
        return RobustGoal(_build_machine(device, spreads), spreads, settings, samples, Required.of(device))


def _build_machine(device: Device, inputs: Sequence[str] | Mapping[str, Any]) -> Machine:
    """Return the machine of a device, with deviations of its centre distances if they are among the inputs."""
    from planter.planting.composition import build_machine
    from planter.planting.mounting import DEVIATIONS, add_deviations

    machine = build_machine(device)
    return add_deviations(machine, device) if set(DEVIATIONS) & set(inputs) else machine


def _build_device(machine: MachineFile, choices: Mapping[str, str], inputs: Ends) -> Device:
    """Return a device with the ends of varied design parameters as their bounds, so that all corners have gears.

    Raises InputError if the file does not allow an end.
    """
    from planter.planting.model import Device
    from planter.planting.mounting import DEVIATIONS

    try:
        for end in (0, 1):
            for name, ends in inputs.items():
                if name not in DEVIATIONS:
                    machine.with_numbers({name: ends[end]})
    except InputError as error:
        raise InputError(f"an end of what is varied is not allowed: {error}") from None
    table = machine.table()
    for name, (low, high) in inputs.items():
        section, _, key = name.partition(".")
        if section == "design":
            table["design"][key] = low
            if low < high:
                table["bounds"][key] = [low, high]
    return Device(
        type(machine).read(table, machine.source), "printed" if choices.get("model") == "printed" else "exact"
    )


ROOM = Room(__package__)
