"""Results of the commands on field tests of a clutch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from planter.records import Record

if TYPE_CHECKING:
    from pydantic import GetJsonSchemaHandler
    from pydantic_core import CoreSchema

Level = int | float | str


@dataclass(frozen=True)
class FactorLevels(Record):
    """A factor: its levels, and the values that words stand for."""

    label: str
    levels: list[Level]
    values: list[float] | None


@dataclass(frozen=True)
class ResponseLabel(Record):
    """A response and what it means."""

    label: str


@dataclass(frozen=True)
class LevelMeans(Record):
    """Mean of the runs at each level of a factor, and the largest less the least of them."""

    k: list[float]
    R: float


@dataclass(frozen=True)
class Total(Record):
    """Sum of squares and degrees of freedom."""

    ss: float
    df: int


@dataclass(frozen=True)
class Residual(Total):
    """Residual of the factors; null for a mean square without degrees of freedom."""

    ms: float | None


@dataclass(frozen=True)
class Effect(Residual):
    """A factor against the error; null without an error."""

    F: float | None
    p: float | None


@dataclass(frozen=True)
class Compared(Record):
    """Two clutches at a speed: Welch's test, alone and by Holm over all pairs."""

    speed_m_s: float
    measure: str
    clutch: str
    reference: str
    difference: float
    reduction_percent: float | None
    p_value: float | None
    p_holm: float | None


@dataclass(frozen=True)
class Predicted(Record):
    """A combination of levels, and what is predicted of each response: its JSON has the means next to the levels."""

    levels: list[Level]
    means: dict[str, float]

    def table(self) -> dict[str, Any]:
        """Return the levels and the mean of each response by its name."""
        return {"levels": self.levels, **self.means}

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        schema = handler.resolve_ref_schema(handler(core))
        means = schema["properties"].pop("means")
        return schema | {"required": ["levels"], "additionalProperties": means["additionalProperties"]}


@dataclass(frozen=True)
class FieldTest(Record):
    """`planter clutch field`: a field test evaluated. `best` and `range_best` have levels in the factors' order."""

    source: str
    runs: int
    factors: dict[str, FactorLevels]
    responses: dict[str, ResponseLabel]
    blank: list[str]
    orthogonal: bool
    sums_of_squares: str
    goals: dict[str, str]
    range: dict[str, dict[str, LevelMeans]] | None
    order: dict[str, list[str]] | None
    range_best: dict[str, list[Level]] | None
    anova: dict[str, dict[str, Effect | Residual | Total]]
    best: dict[str, list[Level]] | None
    prediction: list[Predicted]
    comparison: list[Compared]
    other_comparisons: list[Compared]
    warnings: list[str]


@dataclass(frozen=True)
class FieldPlan(Record):
    """`planter clutch plan`: a field test to be run; `text` is the CSV to fill in."""

    array: str
    factors: list[str]
    blank: list[str]
    columns: dict[str, list[str]]
    text: str
