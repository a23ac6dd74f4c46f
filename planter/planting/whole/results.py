"""What `planter optimise` tells of whole teeth, key by key."""

from __future__ import annotations

from dataclasses import dataclass

from planter.records import Record


@dataclass(frozen=True)
class WholeGear(Record):
    """A gear with its teeth: the least margin against undercut and the least top land."""

    name: str
    teeth: int
    margin: float
    top_land_mm: float


@dataclass(frozen=True)
class WholeStage(Record):
    """A stage with whole teeth.

    `length_error` is the miss of pi m z as a share of it, `free_teeth` what the free optimum would have. The prices are
    what the objective would gain per mm of module and per tooth more. `gears` and `contact_ratio_min` are null where
    no teeth can be made, and `refused` says why these are none that `planter gears` makes without further options.
    """

    stage: int
    z: int
    module_mm: float
    pitch_length_mm: float
    length_error: float
    free_teeth: float
    price_per_module_mm: float
    price_per_tooth: float
    gears: list[WholeGear] | None
    contact_ratio_min: float | None
    refused: str | None


@dataclass(frozen=True)
class TriedTeeth(Record):
    """Teeth that were tried: `settled` where all requirements are kept and the design is certified.

    The objective is null where no design with them that keeps the requirements was found.
    """

    z: list[int]
    objective: float | None
    kkt_residual: float | None
    settled: bool


@dataclass(frozen=True)
class WholeTeeth(Record):
    """Whole teeth of an optimum, and their price: what the objective is above that of the free optimum.

    `tried` are the teeth that were chosen from, null where they were given; `seconds` are those of all searches.
    """

    stages: list[WholeStage]
    free_objective: float
    free_design: dict[str, float]
    price: float
    tried: list[TriedTeeth] | None
    seconds: float
