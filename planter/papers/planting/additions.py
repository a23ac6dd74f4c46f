"""What a planting device adds to the general results: weight, centre distances, support force,
objective (31), requirements, gears, and the effects of its assumptions.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from planter.engine.machine import Machine
from planter.engine.summary import CycleSummary, PiecewiseCycle
from planter.errors import InputError
from planter.mechanism.extension import CamRequest, MachineExtension
from planter.mechanism.model import MechanismCycle
from planter.mechanism.presentation import list_cycle_failures
from planter.mechanism.results import (
    MachineValidation,
    MechanismCycleResult,
    MechanismWarning,
)
from planter.papers.planting import design_presentation as shown
from planter.papers.planting import plausible
from planter.papers.planting.design_results import DesignersSummary
from planter.papers.planting.design_summary import DesignTurn, summarise_turn
from planter.papers.planting.file import PlantingMachine
from planter.papers.planting.functions import MODELS, Model
from planter.papers.planting.model import Device
from planter.papers.planting.objective import evaluate_true_extremes
from planter.papers.planting.requirements import evaluate_device_requirements
from planter.papers.planting.results import (
    CentreDistances,
    PlantingCycleResult,
    PlantingValidation,
    RequirementResult,
    Statistics,
)
from planter.report.html import Block, KeyFigure, Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.gears.workshop.cam_report import CamOutput
    from planter.measured.calibration import MachineBuilder
    from planter.report.animation import MotionBlock
    from planter.report.presentation import ResultPresentation


def build_extension(device: Device, machine: Machine) -> MachineExtension:
    """Return the additions of a device to the results of its machine, or of a changed one."""
    stated = machine.document
    if stated is not device.machine:
        assert isinstance(stated, PlantingMachine)
        device = Device(stated, device.model)
    return DeviceExtension(device, machine)


class DeviceExtension(MachineExtension):
    """The additions of a device."""

    def __init__(self, device: Device, machine: Machine) -> None:
        super().__init__(machine)
        self.device = device

    def open_cycle(self) -> PiecewiseCycle:
        """Return the functions of the angle of a machine, with those of its gears and its cam."""
        return DesignTurn(self.device, self.machine.design)

    def summarise(self, cycle: PiecewiseCycle, changing: Collection[str]) -> CycleSummary:
        """Return the designer's summary, with gears and cam."""
        assert isinstance(cycle, DesignTurn)
        return summarise_turn(cycle)

    def list_warnings(self) -> list[MechanismWarning]:
        """Return warnings of implausible values."""
        return plausible.find_implausible_values(self.device.machine)

    @cached_property
    def requirements(self) -> list[RequirementResult] | None:
        """The requirements of the file at its own design, None if it has none."""
        return evaluate_device_requirements(self.device)

    def extend_cycle(self, cycle: MechanismCycle, lift_mm: float | None) -> MechanismCycleResult:
        """Return the result with what `PlantingCycleResult` adds.

        Raises InputError where assumptions of the printed model are to be relaxed.
        """
        device, result = self.device, cycle.result
        if lift_mm is not None and device.model != "exact":
            raise InputError(
                "--lift needs --model exact: the printed model has no assumptions to relax"
            )
        refined = evaluate_true_extremes(device, device.design)
        sampled = replace(Statistics.of_samples(cycle.columns["support_N"]), mean_N=refined.mean_N)
        # both sides lose the same over a cycle, half a turn after each other
        means = {key: statistics.mean or 0.0 for key, statistics in result.quantities.items()}
        work: dict[str, float | None] = {
            "input_J": self.machine.turn * means["M_L_Nm"],
            "friction_J": 2 * cycle.seconds * means["F_E_loss_W"],
        }
        effects = None
        if lift_mm is not None:
            from planter.papers.planting import lifted

            effects = lifted.find_assumption_effects(device, lift_mm)
        distances_mm = 1e3 * device.centre_distances(device.design)
        return PlantingCycleResult(
            **vars(replace(result, work=work)),
            model=device.model,
            design=device.named(device.design),
            weight_N=device.weight,
            centre_distance_mm=CentreDistances(*distances_mm.tolist()),
            support_force=sampled,
            objective=device.machine.objective.value(sampled.range_N, sampled.variance_N2),
            refined=refined,
            requirements=self.requirements,
            lifted=effects,
        )

    def extend_validation(self, result: MachineValidation) -> MachineValidation:
        """Return the result with the requirements of the file."""
        return PlantingValidation(**vars(result), requirements=self.requirements)

    def list_sections(self, result: MechanismCycleResult | MachineValidation) -> Iterator[Section]:
        """Yield the sections of what is added to a result."""
        yield from shown.list_requirement_sections(self.requirements)
        if isinstance(result, PlantingCycleResult):
            sampled = {**result.support_force.table(), "objective": result.objective}
            columns = {
                shown.TRUE: result.refined.table(),
                shown.name_sampling(result.samples): sampled,
            }
            weight = ("weight", result.weight_N, None, "N")
            force = shown.tabulate_force(columns, tuple(shown.FORCE_ROWS), [weight])
            yield Section(shown.FORCE, [force])
            yield shown.tabulate_design(self.device.machine)
            if result.lifted:
                effects = shown.tabulate_assumption_effects(result.lifted)
                yield Section("Relaxed assumptions", [effects])

    def list_summary_blocks(self, summary: CycleSummary) -> Iterable[Block]:
        """Return tables and sentences of the designer's summary, with gears and cam."""
        assert isinstance(summary, DesignersSummary)
        return shown.describe_designer(summary)

    def draw_figures(self) -> Mapping[str, Figure]:
        """Return the support force in both models, the path of the tip, and the pitch curves."""
        device = self.device
        return shown.draw_forces(device, device.design) | shown.draw_motion(device, device.design)

    def animate(self) -> Iterator[MotionBlock]:
        """Yield the device over a cycle."""
        yield shown.animate(self.device, self.device.design)

    def list_parts(self, result: MechanismCycleResult) -> dict[str, Any]:
        """Return the conclusion, the key figures, and captions of the device's figures."""
        assert isinstance(result, PlantingCycleResult)
        force = result.refined
        conclusion = (
            f"The vertical support force is between {force.min_N:#.4g} and {force.max_N:#.4g} N, "
            f"the weight of the machine {result.weight_N:#.4g} N."
        )
        if self.requirements:
            failed = sum(row.verdict == "fail" for row in self.requirements)
            count = len(self.requirements)
            conclusion += f" {count - failed} of {count} requirements are satisfied."
        share = 100 * force.range_N / result.weight_N
        words = f"variation of the support force over a cycle, {share:.2g} % of the weight"
        return {
            "conclusion": conclusion,
            "failures": [
                *list_cycle_failures(result),
                *shown.list_requirement_failures(self.requirements),
            ],
            "key_figures": [KeyFigure(f"{force.range_N:.3g}", "N", words)],
            "captions": shown.CAPTIONS,
            "displayed_inputs": ("design", "bounds"),
        }

    advancing = ("tip_x_mm",)
    measured = ("support_N",)

    def list_builders(self, model: str | None) -> Mapping[str, MachineBuilder]:
        """Return builders of the device in both models."""
        models = sorted(MODELS, key=lambda each: each != (model or "printed"))
        document = self.device.machine
        return {each: partial(_build_engine_machine, document, each) for each in models}

    def fit_to_figures(self, model: str, target: str) -> ResultPresentation:
        """Return the fit to the figures of a paper."""
        from planter.papers.planting.calibration import calibrate
        from planter.papers.planting.presentation import present_calibration

        device = Device(self.device.machine, "exact" if model == "exact" else "printed")
        return present_calibration(calibrate(device.machine, device.model, target), device)

    def build_cam(self, request: CamRequest) -> CamOutput:
        """Return the end-face cam as a part. Raises InputError for options of a disc."""
        from planter.papers.planting.cam import build_cam

        disc_options = {
            "--y": request.centre,
            "--force": request.force,
            "--bore-mm": request.bore,
        }
        for option, value in disc_options.items():
            if value is not None:
                raise InputError(f"{option} is for a mechanism of your own")
        return build_cam(self.device, request.roller, request.tolerance, request.width)

    def build_driven_machine(self) -> Machine:
        """Return the device whose carrier accelerates."""
        from planter.papers.planting.motor_drive import build_driven_machine

        return build_driven_machine(self.device)


def _build_engine_machine(machine: PlantingMachine, model: Model) -> Machine:
    return Device(machine, model).engine
