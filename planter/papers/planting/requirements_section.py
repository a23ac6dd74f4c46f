"""The `[requirements]` of a machine file: which there are, their limits, and what they rest on.

The list is the project's own. A key is the requirement's name, `min`, `max` or `margin`, and the
unit, as in `release_tilt_max_deg`; an optimum keeps away from a limit by its margin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, create_model

from planter.engine.sections import HOLD_MEANING, Holds
from planter.files import units
from planter.files.csv_rows import Points
from planter.files.fields import (
    FileSection,
    NotNegative,
    Positive,
    Problems,
    Real,
    check,
    invalid_value_problem,
    missing_value_problem,
)


@dataclass(frozen=True)
class RequirementKind:
    """A requirement: `sides` that its file may limit, the unit's suffix, and what the number means.

    Violations of two requirements count the same if they are the same number of `step` (in the
    shown unit). `needs` are the settings that it rests on.
    """

    name: str
    sides: tuple[str, ...]
    suffix: str
    step: float
    meaning: str
    needs: tuple[str, ...] = ()

    def key(self, part: str) -> str:
        """Name of one of its numbers in the file: a limit or the margin."""
        return f"{self.name}_{part}_{self.suffix}" if self.suffix else f"{self.name}_{part}"

    @property
    def unit(self) -> str:
        return units.display_unit(self.key("min")) or "1"

    @property
    def factor(self) -> float:
        """SI value of one shown unit."""
        return units.unit_factor(self.key("min"))


_SOIL = ("soil_depth_mm",)
KINDS = tuple(
    RequirementKind(*row)
    for row in (
        ("spacing", ("min", "max"), "mm", 5, "distance between two plants"),
        (
            "release_tilt",
            ("max",),
            "deg",
            2,
            "absolute tilt of the nozzle at release, where the tip is lowest",
        ),
        (
            "soil_tilt",
            ("max",),
            "deg",
            2,
            "absolute tilt of the nozzle while the tip is in the soil",
            _SOIL,
        ),
        (
            "ground_speed_ratio",
            ("max",),
            "",
            0.02,
            "absolute horizontal speed of the tip over ground where it is lowest, over the "
            "machine's",
        ),
        ("depth", ("min", "max"), "mm", 5, "depth of the lowest tip point below the soil", _SOIL),
        (
            "hole_length",
            ("max",),
            "mm",
            5,
            "length that the nozzle's axis cuts at the level of the soil",
            _SOIL,
        ),
        ("path_height", ("min",), "mm", 10, "height of the tip's path"),
        (
            "tube_excess",
            ("max",),
            "mm",
            1,
            "how far the tip's path stays outside the tube of a point, negative inside",
            ("points_mm",),
        ),
        (
            "seedling_clearance",
            ("min",),
            "mm",
            10,
            "least distance of the leaving nozzle halves from the seedling",
            (*_SOIL, "seedling_height_mm", "seedling_width_mm"),
        ),
        (
            "catching_tilt",
            ("max",),
            "deg",
            3,
            "absolute tilt of the nozzle at catching, where the tip is highest",
        ),
        (
            "funnel_speed",
            ("max",),
            "m_s",
            0.05,
            "speed of the funnel's shaft relative to the machine at catching",
        ),
        (
            "nozzle_distance",
            ("min",),
            "mm",
            10,
            "least distance between the two nozzles over a turn",
        ),
        (
            "pitch_curvature",
            ("min",),
            "per_mm",
            0.001,
            "least signed curvature of the four pitch curves",
        ),
        (
            "curvature_radius",
            ("min",),
            "mm",
            1,
            "least radius of curvature of the four pitch curves",
        ),
        ("contact_ratio", ("min",), "", 0.05, "least contact ratio of both stages", ("module_mm",)),
    )
)
BY_NAME = {kind.name: kind for kind in KINDS}
SETTINGS = {
    "soil_depth_mm": "height of the soil above the lowest point of the tip's path",
    "seedling_height_mm": "height of an upright seedling",
    "seedling_width_mm": "width of an upright round seedling",
    "module_mm": "module of the teeth, for their contact ratio",
}
"""What requirements rest on, and what it means."""
LIMIT_WORDS = {"min": "least allowed", "max": "greatest allowed"}
SIGNED = ("tube_excess",)
"""Requirements whose number may be negative."""
SOIL_LINE = "soil_line_mm"
"""Instead of the first of them: the level of the soil in the machine's frame, above O if
positive.
"""


class Limited(FileSection):
    """Base of the section of requirements, whose fields are built from the catalogue.

    `hold` are limits on measures of a cycle, as files of all machines have them.
    """

    hold: Holds | None = Field(None, description=HOLD_MEANING)

    @check
    def _limits_are_usable(self) -> Problems:
        if self.hold is None and not self.kinds:
            yield missing_value_problem(
                KINDS[0].key(KINDS[0].sides[0]), "at least one limit must be given"
            )
        for kind in KINDS:
            yield from self._problems(kind)
        line: float | None = getattr(self, SOIL_LINE)
        if line is not None and getattr(self, *_SOIL) is not None:
            yield invalid_value_problem(
                SOIL_LINE, line, f"the soil level is {SOIL_LINE} or {_SOIL[0]}, not both"
            )

    def _problems(self, kind: RequirementKind) -> Problems:
        low, high, margin = (self.limit(kind.name, side) for side in ("min", "max", "margin"))
        if low is None and high is None:
            if margin is not None:
                yield invalid_value_problem(
                    kind.key("margin"),
                    margin,
                    f"it requires a limit such as {kind.key(kind.sides[0])}",
                )
            return
        for need in kind.needs:
            if getattr(self, need) is None and not (
                need in _SOIL and getattr(self, SOIL_LINE) is not None
            ):
                yield missing_value_problem(need, f"{kind.name} is limited, and rests on it")
        if kind.name == "curvature_radius" and low is not None and low <= 0:
            yield invalid_value_problem(kind.key("min"), low, "it must be greater than 0")
        if low is not None and high is not None and high - low <= 2 * (margin or 0):
            twice = (
                "" if margin is None else f" by more than twice {kind.key('margin')} = {margin:g}"
            )
            yield invalid_value_problem(
                kind.key("max"), high, f"it must exceed {kind.key('min')} = {low:g}{twice}"
            )
        if high is not None and low is None and high <= (margin or 0) and kind.name not in SIGNED:
            yield invalid_value_problem(kind.key("max"), high, "it must be greater than its margin")

    def limit(self, name: str, part: str) -> float | None:
        """A limit or margin as the file shows it; None if the file has no limit."""
        value: float | None = getattr(self, BY_NAME[name].key(part), None)
        return value

    def surface_mm(self, lowest_mm: float) -> float | None:
        """The level of the soil [mm] with the lowest tip point; None where the file says nothing of
        it.
        """
        depth: float | None = getattr(self, *_SOIL)
        line: float | None = getattr(self, SOIL_LINE)
        return line if depth is None else lowest_mm + depth

    @property
    def kinds(self) -> tuple[RequirementKind, ...]:
        """The requirements that the file limits."""
        return tuple(
            k for k in KINDS if any(self.limit(k.name, side) is not None for side in k.sides)
        )


def _fields() -> dict[str, Any]:
    limits = {
        k.key(side): _field(Real, f"{LIMIT_WORDS[side]} {k.meaning}")
        for k in KINDS
        for side in k.sides
    }
    margins = {
        k.key("margin"): _field(
            NotNegative, f"by how much an optimum keeps inside the limits of: {k.meaning}"
        )
        for k in KINDS
    }
    settings = {name: _field(Positive, meaning) for name, meaning in SETTINGS.items()}
    places = {
        SOIL_LINE: _field(
            Real, "height of the soil above O in the machine's frame, in place of soil_depth_mm"
        ),
        "points_mm": _field(
            Points, "points x, y that the tip's path must pass, each with the radius of its tube"
        ),
    }
    return {**settings, **places, **limits, **margins}


def _field(kind: Any, meaning: str) -> tuple[Any, Any]:
    return Annotated[kind | None, Field()], Field(None, description=meaning)


if TYPE_CHECKING:

    class Requirements(Limited):
        """The section: settings, limits and margins, all of them optional, at least one limit."""

        module_mm: float | None
        soil_depth_mm: float | None
        soil_line_mm: float | None
        points_mm: list[tuple[float, float, float]] | None
else:
    Requirements = create_model("Requirements", __base__=Limited, __module__=__name__, **_fields())
