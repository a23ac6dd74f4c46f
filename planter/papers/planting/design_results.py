"""The designer's summary and the integer tooth numbers of a design, as records and as tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from planter.engine.summary import CycleSummary, MotorTorque
from planter.engine.tables import Cells, summary_tables
from planter.files.record import Record
from planter.papers.planting.model import CONTACTS, VECTORS
from planter.report.html import Block, Table, Text


@dataclass(frozen=True)
class StressFound(Record):
    """Largest stress over a turn; `bending` by Lewis for both gears of the pair, null outside its
    formula's range.
    """

    contact_MPa: float
    contact_phi_deg: float
    bending_MPa: list[float | None]
    bending_phi_deg: list[float | None]


@dataclass(frozen=True)
class GearFound(Record):
    """A gear's pitch curve: least radius of curvature, least curvature (below zero: hollow), pitch
    radii.

    `teeth_min` is the least number of teeth of a circular gear that has such a curvature, where a
    module is given.
    """

    gear: str
    curvature_radius_min_mm: float
    curvature_min_per_mm: float
    pitch_radius_min_mm: float
    pitch_radius_max_mm: float
    teeth_min: float | None


@dataclass(frozen=True)
class StageFound(Record):
    """A gear stage; pressure angles over a turn and both flanks; contact ratio and stress where
    [gears] give them.
    """

    stage: int
    centre_distance_mm: float
    gears: list[GearFound]
    pressure_angle_min_deg: float
    pressure_angle_max_deg: float
    pressure_angle_max_phi_deg: float
    contact_ratio_min: float | None
    stress: StressFound | None


@dataclass(frozen=True)
class DesignersSummary(CycleSummary):
    """Loads for which motor, bearings, gears and cam are sized; `notes` say what is missing."""

    motor: MotorTorque
    stages: list[StageFound]
    cam_pressure_angle_max_deg: float
    cam_pressure_angle_max_phi_deg: float
    notes: list[str]


def list_design_tables(summary: DesignersSummary) -> Iterator[Table]:
    """Yield the tables of a machine's summary, then those of gears and stages."""
    yield from summary_tables(summary)
    gears = [_gear(gear) for stage in summary.stages for gear in stage.gears]
    yield Table(
        ("gear", "least bend radius", "pitch radius", "to", "least teeth"),
        gears,
        "Gears, lengths in mm",
    )
    yield Table(("", "stage 1", "stage 2"), _stages(summary.stages), "Stages")


def describe_design(summary: DesignersSummary) -> Iterator[str]:
    """Yield the cam's pressure angle, whether anything jumps, and what is missing."""
    cam = (
        f"{summary.cam_pressure_angle_max_deg:.4g} deg at "
        f"{summary.cam_pressure_angle_max_phi_deg:.4g} deg"
    )
    yield f"Largest pressure angle of the cam {cam}."
    if not summary.shocks:
        yield "No discontinuities: accelerations, forces and torques are continuous."
    for note in summary.notes:
        yield f"{note[0].upper()}{note[1:]}."


def compare_peaks(start: DesignersSummary, optimum: DesignersSummary) -> Table:
    """Return the table of the peaks of two designs."""
    rows: list[Cells] = [
        ("motor torque, largest", start.motor.max_Nm, optimum.motor.max_Nm, "N m"),
        ("motor torque, root mean square", start.motor.rms_Nm, optimum.motor.rms_Nm, "N m"),
    ]
    rows += [
        (a.name.replace("_", " "), a.max, b.max, a.unit)
        for a, b in zip(start.peaks, optimum.peaks, strict=True)
        if a.name in (*CONTACTS, *VECTORS)
    ]
    for a, b in zip(start.stages, optimum.stages, strict=True):
        rows.append(
            (f"centre distance {a.stage}", a.centre_distance_mm, b.centre_distance_mm, "mm")
        )
    return Table(
        ("largest over a cycle", "start", "optimum", "unit"), rows, "Peaks before and after"
    )


COMPARED = {
    "motor / N m": (),
    "teeth / N": ("F_NP", "F_NQ"),
    "bearings / N": ("bearing_A1", "bearing_B1"),
    "cam / N": ("F_E",),
}
"""Peaks by which devices are compared, by their heads: the largest of some forces, or the
torque.
"""
BORNE = {
    "motor_torque_max_Nm": "largest torque of the motor over a turn",
    "tooth_force_max_N": "largest normal force between teeth over a turn",
    "bearing_force_max_N": "largest force in the bearings A1 and B1 over a turn",
    "cam_force_max_N": "largest force of the cam on the roller over a turn",
}
"""The same as columns of a file, with what they mean."""


def list_largest_loads(summary: DesignersSummary) -> list[float]:
    """Return the loads that `COMPARED` lists."""
    by_name = {peak.name: peak.max for peak in summary.peaks}
    return [
        max(by_name[name] for name in names) if names else summary.motor.max_Nm
        for names in COMPARED.values()
    ]


def _gear(gear: GearFound) -> Cells:
    hollow = " (hollow)" if gear.curvature_min_per_mm < 0 else ""
    return (
        f"{gear.gear}{hollow}",
        gear.curvature_radius_min_mm,
        gear.pitch_radius_min_mm,
        gear.pitch_radius_max_mm,
        gear.teeth_min,
    )


def _stages(stages: Sequence[StageFound]) -> list[Cells]:
    rows: list[Cells] = [
        ("centre distance / mm", *(stage.centre_distance_mm for stage in stages)),
        ("pressure angle, least / deg", *(stage.pressure_angle_min_deg for stage in stages)),
        ("pressure angle, largest / deg", *(stage.pressure_angle_max_deg for stage in stages)),
        ("contact ratio, least", *(stage.contact_ratio_min for stage in stages)),
    ]
    stresses = [stage.stress for stage in stages if stage.stress is not None]
    if stresses:
        rows.append(("contact stress / MPa", *(stress.contact_MPa for stress in stresses)))
        for k, gear in enumerate(("inner", "outer")):
            rows.append(
                (
                    f"bending stress, {gear} gear / MPa",
                    *(stress.bending_MPa[k] for stress in stresses),
                )
            )
    return rows


@dataclass(frozen=True)
class ToothCountGear(Record):
    """A gear with its teeth: smallest margin against undercut, smallest top land."""

    name: str
    teeth: int
    margin: float
    top_land_mm: float


@dataclass(frozen=True)
class ToothCountStage(Record):
    """A stage with an integer tooth number.

    `length_error` is the deviation from pi m z as a share of it, `free_teeth` the tooth number of
    the free optimum. The prices are what the objective gains per mm of module and per additional
    tooth. `gears` and `contact_ratio_min` are null if no teeth can be cut; `refused` is the reason
    if `planter gears` needs further options to cut them.
    """

    stage: int
    z: int
    module_mm: float
    pitch_length_mm: float
    length_error: float
    free_teeth: float
    price_per_module_mm: float
    price_per_tooth: float
    gears: list[ToothCountGear] | None
    contact_ratio_min: float | None
    refused: str | None


@dataclass(frozen=True)
class ToothCountCandidate(Record):
    """Tooth numbers that were evaluated: `settled` if the design is feasible and certified.

    The objective is null if no feasible design with them was obtained.
    """

    z: list[int]
    objective: float | None
    kkt_residual: float | None
    settled: bool


@dataclass(frozen=True)
class ToothCountResult(Record):
    """Integer tooth numbers of an optimum, and their price: by how much the objective exceeds the
    free optimum's.

    `tried` are the candidates of the search, null if the numbers were specified; `seconds` counts
    all searches.
    """

    stages: list[ToothCountStage]
    free_objective: float
    free_design: dict[str, float]
    price: float
    tried: list[ToothCountCandidate] | None
    seconds: float


def list_tooth_count_blocks(result: ToothCountResult) -> Iterator[Block]:
    """Yield the price and the tooth numbers, the limits of the gears, and the candidates."""
    yield Text(
        f"Objective {result.price:+.4g} against the free optimum's {result.free_objective:.6g}."
    )
    keys = (
        "stage",
        "z",
        "module_mm",
        "pitch_length_mm",
        "free_teeth",
        "price_per_module_mm",
        "price_per_tooth",
    )
    head = ("stage", "teeth", "module / mm", "length / mm", "free", "per mm of module", "per tooth")
    yield Table(
        head,
        [[getattr(stage, key) for key in keys] for stage in result.stages],
        "Integer tooth numbers",
    )
    gears = [
        (gear.name, gear.teeth, gear.margin, gear.top_land_mm, stage.contact_ratio_min)
        for stage in result.stages
        for gear in stage.gears or ()
    ]
    if gears:
        yield Table(
            ("gear", "teeth", "undercut margin", "top land / mm", "contact ratio"), gears, "Gears"
        )
    for stage in result.stages:
        if stage.refused is not None:
            yield Text(f"planter gears refuses: {stage.refused}.", "warning")
    if result.tried is not None:
        rows = [
            (", ".join(map(str, c.z)), c.objective, c.kkt_residual, c.settled) for c in result.tried
        ]
        yield Table(("teeth", "objective", "KKT residual", "settled"), rows, "Candidates")
