"""Machine files: TOML in, a validated `Machine` out, every number with its unit and its origin."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, field_validator

from planter.errors import InputError
from planter.files.csv_rows import inline_points
from planter.files.document import Document, Origins
from planter.files.fields import Pair, Problems, Real, check, lacking, problem, refuse, refused
from planter.optimise.sections import GeneticAlgorithm
from planter.planting.requirements.section import Requirements
from planter.planting.sections import (
    Cam,
    Centroid,
    ContactAngles,
    GearPair,
    Gears,
    Inertia,
    Mass,
    Nozzle,
    Objective,
    Operation,
    Spring,
    least_inertia,
)


class Machine(Document):
    """A planting device: two gear stages on a carrier, a cam-driven nozzle on each of two sides.

    Sections hold the values as the file shows them; `si` gives the value inside. The names in `design` and
    `bounds` are open here: which ones a device needs follows from its gear families.
    """

    operation: Operation
    contact: ContactAngles
    mass: Mass
    inertia: Inertia
    centroid: Centroid
    nozzle: Nozzle
    cam: Cam
    spring: Spring
    stage1: GearPair
    stage2: GearPair
    gears: Gears | None = None
    design: Annotated[dict[str, Real], Field(min_length=1)]
    bounds: dict[str, Pair]
    objective: Objective
    genetic_algorithm: GeneticAlgorithm
    requirements: Requirements | None = None
    origins: Origins = Field(alias="origin")

    @classmethod
    def read(
        cls, table: Mapping[str, Any], source: str, changes: Mapping[str, float] | None = None,
        changed: tuple[str, ...] = (),
    ) -> Self:  # fmt: skip
        """The validated content of a file, as `Document.read`; points of the tip's path may stand in a CSV beside."""
        return super().read(inline_points(table, "requirements", source), source, changes, changed)

    def check_names(self, names: tuple[str, ...]) -> None:
        """Raise InputError unless the design holds exactly these names (those that its gear families ask for)."""
        allowed = f"the design of this device is {', '.join(names)}"
        missing = [f"design.{name} is missing: {allowed}" for name in names if name not in self.design]
        odd = [problem(f"design.{name}", value, allowed) for name, value in self.design.items() if name not in names]
        if missing or odd:
            raise InputError(f"{self.source}: {'; '.join([*missing, *odd])}")

    @field_validator("design", "bounds")
    @classmethod
    def _names_are_plain(cls, named: dict[str, Any]) -> dict[str, Any]:
        odd = (name for name in named if not (name.isascii() and name.isidentifier()))
        refuse([refused("", name, "a name must be made of letters, digits and underscores") for name in odd])
        return named

    @field_validator("bounds")
    @classmethod
    def _bounds_are_upright(cls, bounds: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
        allowed = "it must be [lower, upper] with lower less than upper"
        refuse([refused(name, list(pair), allowed) for name, pair in bounds.items() if not pair[0] < pair[1]])
        return bounds

    @check
    def _bounds_belong_to_the_design(self) -> Problems:
        for name in self.design:
            if name not in self.bounds:
                yield lacking(f"bounds.{name}", "every name in [design] must have its [lower, upper]")
        for name, pair in self.bounds.items():
            if name not in self.design:
                allowed = f"it must be a name in [design]: {', '.join(self.design)}"
                yield refused(f"bounds.{name}", pair, allowed)

    @check
    def _requirements_have_a_speed(self) -> Problems:
        speed = self.operation.forward_speed_m_s
        if self.requirements is not None and speed == 0:
            yield refused("operation.forward_speed_m_s", speed, "[requirements] needs a value above 0, such as 0.667")

    @check
    def _gears_have_one_module(self) -> Problems:
        if self.gears is None or self.requirements is None:
            return
        module = self.requirements.module_mm
        if module is not None and module != self.gears.module_mm:
            yield refused("gears.module_mm", self.gears.module_mm, f"it must be requirements.module_mm = {module:g}")

    @check
    def _inertia_fits_mass_and_centroid(self) -> Problems:
        inertia, mass, centroid = self.inertia, self.mass, self.centroid
        least = {
            "J56_about_A1_kg_m2": least_inertia(mass.middle_kg, (centroid.middle_radius_mm,)),
            "J7_about_B1_kg_m2": least_inertia(mass.planet_kg, centroid.planet_xy_mm),
        }
        for key, bound in least.items():
            if getattr(inertia, key) < bound:
                allowed = f"it must be at least mass times squared centroid distance, {bound:.6g}"
                yield refused(f"inertia.{key}", getattr(inertia, key), allowed)


def load(source: str | Path, changes: Mapping[str, float] | None = None) -> Machine:
    """The machine in a file, or the built-in one of that name, with some numbers set by `changes`.

    A name in `changes` is a full path (`mass.sun_kg`, `nozzle.hinge_A_mm[0]`) or a last part that fits one
    path only; `R3_mm` means the design value, not its bounds. Values are in the unit that the name ends in.

    Raises InputError, one sentence that names file, key, value and what is allowed.
    """
    return Machine.load(source, "planting", changes)
