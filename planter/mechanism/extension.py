"""What a kind of machine adds to the general results of its cycle: `additions` of the package states it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

from planter.engine import tables
from planter.engine.machine import Machine
from planter.engine.summary import CycleSummary, PiecewiseCycle, build_rows, summarise
from planter.errors import InputError
from planter.report.html import Block, Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.gears.workshop.cam_report import CamOutput
    from planter.measured.calibration import MachineBuilder
    from planter.mechanism.model import MechanismCycle
    from planter.mechanism.results import (
        MachineValidation,
        MechanismCycleResult,
        MechanismWarning,
    )
    from planter.report.animation import MotionBlock
    from planter.report.presentation import ResultPresentation


@dataclass(frozen=True)
class CamRequest:
    """The roller, the largest deviation of the arcs, and the width of a cam [m].

    Of a disc also its bore [m], the `centre` of the roller as sums for x and y, unless the
    statement has it, and the name of the follower's force.
    """

    roller: float
    tolerance: float
    width: float
    bore: float | None = None
    centre: tuple[str, str] | None = None
    force: str | None = None


class MachineExtension:
    """The additions to the results of a machine; this class adds nothing."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine

    def open_cycle(self) -> PiecewiseCycle:
        """Return the functions of the angle whose extremes the summary needs."""
        return PiecewiseCycle(self.machine, build_rows(self.machine))

    def summarise(self, cycle: PiecewiseCycle, changing: Collection[str]) -> CycleSummary:
        """Return the designer's summary of a cycle from `open_cycle`."""
        return summarise(cycle, changing)

    def list_warnings(self) -> list[MechanismWarning]:
        """Return warnings of values of the file."""
        return []

    def extend_cycle(self, cycle: MechanismCycle, lift_mm: float | None) -> MechanismCycleResult:
        """Return the result of a cycle with named values of this kind of machine.

        With `lift_mm`, the module of its teeth, these include the effects of the assumptions of its
        model. Raises InputError if it has none that can be relaxed.
        """
        if lift_mm is not None:
            raise InputError(
                f"--lift does not apply to {self.machine.name}: it relaxes assumptions of the "
                f"planting device"
            )
        return cycle.result

    def extend_validation(self, result: MachineValidation) -> MachineValidation:
        """Return the result of a check with named values of this kind of machine."""
        return result

    def list_sections(self, result: MechanismCycleResult | MachineValidation) -> Iterable[Section]:
        """Return the sections of what is added to a result."""
        return ()

    def list_summary_blocks(self, summary: CycleSummary) -> Iterable[Block]:
        """Return tables and sentences of the designer's summary."""
        return tables.summary_tables(summary)

    def draw_figures(self) -> Mapping[str, Figure]:
        """Return figures by name, which come before those of the quantities."""
        return {}

    def animate(self) -> Iterable[MotionBlock]:
        """Return moving drawings, which replace that of the bodies."""
        return ()

    def list_parts(self, result: MechanismCycleResult) -> dict[str, Any]:
        """Return parts of `planter.report.presentation.ResultPresentation` that replace the general
        ones, but for key figures, which come before them.
        """
        return {}

    advancing: tuple[str, ...] = ()
    """Keys of quantities that a machine which travels does not repeat."""
    measured: tuple[str, ...] = ()
    """Keys of what a measurement is of unless it says so."""

    def list_builders(self, model: str | None) -> Mapping[str, MachineBuilder]:
        """Return builders of the machine in all of its models by name, `model` first; workers
        pickle them.
        """
        return {"derived": partial(self.machine.build, self.machine.document)}

    def fit_to_figures(self, model: str, target: str) -> ResultPresentation:
        """Return the fit to the figures that a paper reports.

        Raises InputError if no paper reports any.
        """
        raise InputError(
            f"--data must name a CSV file with a measured curve, to which {self.machine.name} is "
            f"fitted: no paper reports figures of it"
        )

    def build_cam(self, request: CamRequest) -> CamOutput:
        """Return the disc that turns with the drive's angle, as a part.

        Raises InputError and GeometryError as `planter.mechanism.cam`.
        """
        from planter.mechanism import cam
        from planter.mechanism.model import Model

        model, centre, force = Model(self.machine), request.centre, request.force
        if centre is None:
            centre, force = cam.find_follower_centre(model, force)
        return cam.build_disc_cam(
            model,
            request.roller,
            centre,
            force,
            request.tolerance,
            request.width,
            request.bore or 0.0,
        )

    def build_driven_machine(self) -> Machine:
        """Return the machine that a motor drives."""
        return self.machine


def find_extension(machine: Machine) -> MachineExtension:
    """Return the additions of a machine's kind: those of `additions.build_extension` of the package
    whose object states the machine.
    """
    if machine.subject is None:
        return MachineExtension(machine)
    package = type(machine.subject).__module__.rpartition(".")[0]
    additions = import_module(f"{package}.additions")
    extension: MachineExtension = additions.build_extension(machine.subject, machine)
    return extension
