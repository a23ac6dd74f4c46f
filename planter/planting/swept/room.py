"""What of planting devices can be swept: `ROOM`, as `planter.sweeps.room` has it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from planter.files import examples

if TYPE_CHECKING:
    from planter.planting.file import Machine
    from planter.planting.functions import Model
    from planter.planting.swept.subject import Planting
    from planter.progress import Listener
    from planter.tolerance.results import RobustFound
    from planter.tolerance.room import Settings
    from planter.tolerance.spread import Spread

KIND = "planting"
OWN = {"stage1", "stage2", "nozzle"}
"""Tables that no other kind of file has."""


class Room:
    """Planting devices."""

    choices: Mapping[str, Sequence[str]] = {"model": ("exact", "printed")}
    banded = ("objective", "support_range_N", "support_max_N", "M_L_max_Nm", "tip_y_min_mm", "tip_x_range_mm")
    curves = ("support_N", "M_L_Nm")
    paths = (("tip_x_mm", "tip_y_mm"),)
    usual = ("objective", "support_range_N", "support_max_N", "M_L_max_Nm", "M_L_rms_Nm")

    def takes(self, source: str) -> bool:
        """A built-in name, or a file with the tables of such a machine."""
        return examples.belongs(source, KIND, OWN)

    def load(self, source: str, changes: Mapping[str, float]) -> Machine:
        """The machine in a file, or the built-in one of that name, some numbers set."""
        from planter.planting import file

        return file.load(source, changes)

    def inputs(self, machine: Machine) -> dict[str, str]:
        """Design parameters, numbers of the file that the model takes, deviations of the centre distances."""
        from planter.planting.model import Device
        from planter.planting.swept import mounting

        device = Device(machine)
        named = {f"design.{name}": entry["meaning"] for name, entry in zip(device.names, device.entries, strict=True)}
        data = {entry["shown"]: entry["meaning"] for entry in device.sidecar["vectors"]["machine"]}
        return named | data | dict(zip(mounting.DEVIATIONS, mounting.MEANINGS, strict=True))

    def outputs(self, machine: Machine) -> dict[str, str]:
        """The objective, and measures of every quantity over a turn."""
        from planter.planting.model import Device
        from planter.planting.swept import subject

        return {name: measure.meaning for name, measure in subject.measures(Device(machine)).items()}

    def nominal(self, machine: Machine) -> dict[str, float]:
        """The value of each input in the file; centre distances do not deviate."""
        from planter.planting.swept import mounting

        own = machine.numbers()
        return {name: own[name] for name in self.inputs(machine) if name in own} | dict.fromkeys(
            mounting.DEVIATIONS, 0.0
        )

    def tolerances(self, machine: Machine) -> dict[str, dict[str, Any]]:
        """Assumed ones of masses, centroids, phases, centre distances, curves and friction; the paper's speeds."""
        from planter.planting.swept import tolerances

        return tolerances.usual(machine)

    def robust(
        self, machine: Machine, choices: Mapping[str, str], spreads: Mapping[str, Spread], settings: Settings,
        progress: Listener | None,
    ) -> RobustFound:  # fmt: skip
        """The design with the least mean plus some standard deviations of the objective."""
        from planter.planting.swept.robust import Robust
        from planter.tolerance.robust import find_robust

        model: Model = "printed" if choices.get("model") == "printed" else "exact"
        return find_robust(Robust(machine, model, spreads, settings), settings, progress)

    def frozen(self, machine: Machine) -> dict[str, Any]:
        """Its table."""
        return {"table": machine.table(), "source": machine.source}

    def subject(
        self, frozen: Mapping[str, Any], choices: Mapping[str, str], inputs: Mapping[str, tuple[float, float]],
        outputs: Sequence[str],
    ) -> Planting:  # fmt: skip
        """A device in one of its models, its inputs between two ends."""
        from planter.planting.file import Machine
        from planter.planting.swept.subject import Planting

        model = choices.get("model", "exact")
        machine = Machine.read(frozen["table"], frozen["source"])
        return Planting(machine, "printed" if model == "printed" else "exact", inputs, outputs)


ROOM = Room()
