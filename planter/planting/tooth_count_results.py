"""Integer tooth numbers of an optimum, key by key, and as tables for the terminal and pages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from planter.records import Record
from planter.report.html import Block, Table, Text


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

    `length_error` is the deviation from pi m z as a share of it, `free_teeth` the tooth number of the free optimum. The
    prices are what the objective gains per mm of module and per additional tooth. `gears` and `contact_ratio_min` are
    null if no teeth can be cut; `refused` is the reason if `planter gears` needs further options to cut them.
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
    """Integer tooth numbers of an optimum, and their price: by how much the objective exceeds the free optimum's.

    `tried` are the candidates of the search, null if the numbers were specified; `seconds` counts all searches.
    """

    stages: list[ToothCountStage]
    free_objective: float
    free_design: dict[str, float]
    price: float
    tried: list[ToothCountCandidate] | None
    seconds: float


def list_tooth_count_blocks(result: ToothCountResult) -> Iterator[Block]:
    """Yield the price and the tooth numbers, the limits of the gears, and the candidates."""
    yield Text(f"Objective {result.price:+.4g} against the free optimum's {result.free_objective:.6g}.")
    keys = ("stage", "z", "module_mm", "pitch_length_mm", "free_teeth", "price_per_module_mm", "price_per_tooth")
    head = ("stage", "teeth", "module / mm", "length / mm", "free", "per mm of module", "per tooth")
    yield Table(head, [[getattr(stage, key) for key in keys] for stage in result.stages], "Integer tooth numbers")
    gears = [
        (gear.name, gear.teeth, gear.margin, gear.top_land_mm, stage.contact_ratio_min)
        for stage in result.stages
        for gear in stage.gears or ()
    ]
    if gears:
        yield Table(("gear", "teeth", "undercut margin", "top land / mm", "contact ratio"), gears, "Gears")
    for stage in result.stages:
        if stage.refused is not None:
            yield Text(f"planter gears refuses: {stage.refused}.", "warning")
    if result.tried is not None:
        rows = [(", ".join(map(str, c.z)), c.objective, c.kkt_residual, c.settled) for c in result.tried]
        yield Table(("teeth", "objective", "KKT residual", "settled"), rows, "Candidates")
