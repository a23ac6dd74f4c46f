"""Machine files of planting devices: TOML in, a validated `PlantingMachine` out, numbers with unit
and origin.

Values stay as in the file, in mm, deg, r/min, kg, N: a key ends in its unit. Points are those of
the closed nozzle: x', y', z' in the planet frame at B1, xi, eta, zeta in the half frame at the
hinge.
"""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, field_validator

from planter import paths
from planter.engine.measures import Limit, Measure, format_sum, parse_sum
from planter.engine.sections import GeneticAlgorithm, parse_holds, with_whole_limits
from planter.errors import InputError
from planter.files.csv_rows import inline_points
from planter.files.document import Document, Origins
from planter.files.fields import (
    FileSection,
    Line,
    NotNegative,
    Pair,
    Positive,
    PositiveTriple,
    Problems,
    Real,
    Triple,
    Whole,
    check,
    invalid_value_problem,
    missing_value_problem,
    raise_problems,
    value_error,
)
from planter.measured.section import MeasurementSection
from planter.papers.planting import functions
from planter.papers.planting.requirements_section import Requirements

_ROUNDING = 1e-12


class OperationSection(FileSection):
    """Operating conditions; the machine travels at `forward_speed_m_s`, of either sign."""

    speed_rpm: Positive
    gravity_m_s2: NotNegative
    forward_speed_m_s: Real


class ContactAngles(FileSection):
    """Pressure angle of the teeth; friction angles mu1 at the cam and mu2 at the teeth."""

    pressure_angle_deg: Annotated[Positive, Field(lt=45)]
    cam_friction_angle_deg: Annotated[NotNegative, Field(lt=45)]
    tooth_friction_angle_deg: NotNegative

    @check
    def _teeth_push(self) -> Problems:
        if self.tooth_friction_angle_deg >= self.pressure_angle_deg:
            yield invalid_value_problem(
                "tooth_friction_angle_deg",
                self.tooth_friction_angle_deg,
                f"it must be less than pressure_angle_deg = {self.pressure_angle_deg:g}",
            )


class Mass(FileSection):
    """Masses; each of the two sides has one middle body, one planet body and two nozzle halves C1 +
    C2.
    """

    sun_kg: Positive
    middle_kg: Positive
    planet_kg: Positive
    carrier_kg: Positive
    half_C1_kg: Positive
    half_C2_kg: Positive


class Inertia(FileSection):
    """Moments of inertia: middle body about A1, planet body about B1, centroidal for a half's two
    parts.
    """

    J56_about_A1_kg_m2: Positive
    J7_about_B1_kg_m2: Positive
    C1_centroidal_xx_yy_zz_kg_m2: PositiveTriple
    C2_centroidal_xx_yy_zz_kg_m2: PositiveTriple

    @check
    def _bodies_exist(self) -> Problems:
        for key in ("C1_centroidal_xx_yy_zz_kg_m2", "C2_centroidal_xx_yy_zz_kg_m2"):
            tensor: tuple[float, float, float] = getattr(self, key)
            if 2 * max(tensor) > sum(tensor) * (1 + _ROUNDING):
                yield invalid_value_problem(
                    key,
                    tensor,
                    "it must be a body's: none of the three may exceed the sum of the other two",
                )


class Centroid(FileSection):
    """Centroids: sun and middle body polar (direction at phi = 0, global), planet body in x',
    y'.
    """

    sun_radius_mm: NotNegative
    sun_angle_deg: Real
    middle_radius_mm: NotNegative
    middle_angle_deg: Real
    planet_xy_mm: Pair


class Nozzle(FileSection):
    """Inner nozzle half: hinge in x', y', z'; from there two centroids and the spring hook; tip
    along x'.
    """

    hinge_A_mm: Triple
    C1_mm: Triple
    C2_mm: Triple
    hook_F_mm: Triple
    tip_distance_mm: Positive


class CamSection(FileSection):
    """End-face cam and rocker: the nozzle opens over the rise and closes over the fall of cam angle
    delta.
    """

    rocker_length_mm: Positive
    psi0_deg: Annotated[Real, Field(gt=-90, lt=90)]
    base_radius_mm: Positive
    opening_deg: Annotated[Positive, Field(lt=90)]
    rise_delta_deg: Pair
    fall_delta_deg: Pair
    flank: str

    @field_validator("flank")
    @classmethod
    def _flank_is_known(cls, flank: str) -> str:
        if flank not in functions.list_flank_laws():
            close = paths.find_similar(flank, functions.list_flank_laws())
            hint = f"did you mean {close[0]!r}? " if close else ""
            raise invalid_value_problem(
                "",
                flank,
                f"{hint}it must be one of {', '.join(map(repr, functions.list_flank_laws()))}",
            )
        return flank

    @check
    def _flanks_fit_a_turn(self) -> Problems:
        for key in ("rise_delta_deg", "fall_delta_deg"):
            start, end = getattr(self, key)
            if not 0 <= start < end <= 360:
                yield invalid_value_problem(
                    key, [start, end], "it must be [start, end] with 0 <= start < end <= 360"
                )
        if self.fall_delta_deg[0] < self.rise_delta_deg[1]:
            allowed = (
                f"it must start where the rise has ended, at {self.rise_delta_deg[1]:g} or later"
            )
            yield invalid_value_problem("fall_delta_deg", self.fall_delta_deg, allowed)

    @check
    def _rocker_faces_the_cam(self) -> Problems:
        if self.psi0_deg + self.opening_deg >= 90:
            allowed = f"it must be less than 90 - opening_deg = {90 - self.opening_deg:g}"
            yield invalid_value_problem("psi0_deg", self.psi0_deg, allowed)


class Spring(FileSection):
    """Return spring between the hooks of a side's two halves, along z'."""

    preload_N: NotNegative
    rate_N_m: NotNegative


class GearPair(FileSection):
    """A pair of gears: the family of its inner pitch curve (on the sun in stage 1, on gear 6 in
    stage 2).
    """

    family: Annotated[str, Field(min_length=1)]


class GearsSection(FileSection):
    """Teeth and material of all gears, for contact ratio and stress; stress takes all four of the
    numbers.
    """

    module_mm: Annotated[Positive, Field(ge=0.1, le=50)]
    """module of all gears"""
    face_width_mm: Annotated[Positive | None, Field(le=1000)] = None
    """face width of all gears"""
    youngs_modulus_GPa: Annotated[Positive | None, Field(ge=0.1, le=1000)] = None
    """Young's modulus of the gears"""
    poisson_ratio: Annotated[NotNegative | None, Field(lt=0.5)] = None
    """Poisson's ratio of the gears"""

    @property
    def give_stress(self) -> bool:
        """Whether all that stress takes is there."""
        return None not in (self.face_width_mm, self.youngs_modulus_GPa, self.poisson_ratio)


class DeviceMeasurementSection(MeasurementSection):
    """The sensor of a planting device, which measures the support force unless the file says
    another force.
    """

    default_quantity: ClassVar[str | None] = "support_N"


class ForceObjectiveSection(FileSection):
    """Objective to be minimised: weight_range * range + weight_variance * spread of the support
    force.

    The spread is the population variance (N2) for kind "paper", equation (31) of Wang et al.
    (2017), and the standard deviation (N) for kind "newton". `samples` angles over a turn.
    """

    weight_range: NotNegative
    """weight of the range of the support force [1/N]"""
    weight_variance: NotNegative
    """weight of its spread"""
    samples: Annotated[Whole, Field(ge=8, le=100_000)]
    """number of angles over a turn"""
    kind: Literal["paper", "newton"]
    """"paper": the spread is the variance (N2); "newton": the standard deviation (N)"""
    least: Line | None = None
    """sum of measures that `planter optimise` minimises instead, such as range F_support"""

    def weighted(self, variance: Any, sqrt: Callable[[Any], Any] = math.sqrt) -> Any:
        """Return the weighted spread of a variance [N2]: a float or, with a matching `sqrt`, a
        symbol or array.
        """
        return self.weight_variance * (variance if self.kind == "paper" else sqrt(variance))

    def value(self, range_N: float, variance_N2: float) -> float:
        """Return the objective of a range [N] and a variance [N2]."""
        return float(self.weight_range * range_N + self.weighted(variance_N2))

    @check
    def _something_counts(self) -> Problems:
        if self.weight_range == self.weight_variance == 0:
            yield invalid_value_problem(
                "weight_range", self.weight_range, "it must be above 0 where weight_variance is 0"
            )


def minimum_inertia(mass_kg: float, offset_mm: tuple[float, ...]) -> float:
    """Least moment of inertia [kg m2] of a body about an axis that its centroid is off by
    `offset_mm`.
    """
    return mass_kg * math.hypot(*offset_mm) ** 2 * 1e-6


class PlantingMachine(Document):
    """A planting device: two gear stages on a carrier, a cam-driven nozzle on each of two sides.

    Sections hold the values as the file shows them; `si` gives the value inside. The names in
    `design` and `bounds` are open here: which ones a device needs follows from its gear families.
    """

    states_goals: ClassVar[bool] = True

    operation: OperationSection
    contact: ContactAngles
    mass: Mass
    inertia: Inertia
    centroid: Centroid
    nozzle: Nozzle
    cam: CamSection
    spring: Spring
    stage1: GearPair
    stage2: GearPair
    gears: GearsSection | None = None
    design: Annotated[dict[str, Real], Field(min_length=1)]
    """numbers that a search finds, by the names that the gear families ask for"""
    bounds: dict[str, Pair]
    """lower and upper end of each number of the design"""
    objective: ForceObjectiveSection
    genetic_algorithm: GeneticAlgorithm
    requirements: Requirements | None = None
    measurement: DeviceMeasurementSection | None = None
    origins: Origins = Field(alias="origin")

    @classmethod
    def read(
        cls,
        table: Mapping[str, Any],
        source: str,
        changes: Mapping[str, float] | None = None,
        changed: tuple[str, ...] = (),
    ) -> Self:
        """Return the validated content of a file; points of the tip's path may be in a CSV file
        next to it.
        """
        return super().read(inline_points(table, "requirements", source), source, changes, changed)

    @property
    def measure_limits(self) -> tuple[Limit, ...]:
        """The limits on measures in [requirements]. Raises InputError if one cannot be parsed."""
        return parse_holds(self.requirements, self.source)

    @property
    def objective_terms(self) -> tuple[Measure, ...]:
        """The measures of objective.least, none without one. Raises InputError if it cannot be
        parsed.
        """
        text = self.objective.least
        return () if text is None else parse_sum(text, f"{self.source}: objective.least =")

    @property
    def limits_motion(self) -> bool:
        """Whether [requirements] limits what its catalogue lists, besides measures of the cycle."""
        return self.requirements is not None and bool(self.requirements.kinds)

    def written_table(self) -> dict[str, Any]:
        """Return the table with whole paths of the curves in objective and limits, for a file in
        any folder.
        """
        table = self.table()
        if terms := self.objective_terms:
            placed_terms = [term.with_whole_paths(self.source) for term in terms]
            table["objective"]["least"] = format_sum(placed_terms)
        return with_whole_limits(table, self.measure_limits, self.source)

    def check_names(self, names: tuple[str, ...]) -> None:
        """Raise InputError unless the design holds exactly these names (those that its gear
        families ask for).
        """
        allowed = f"the design of this device is {', '.join(names)}"
        missing = [
            f"design.{name} is missing: {allowed}" for name in names if name not in self.design
        ]
        odd = [
            str(value_error(f"design.{name}", value, allowed))
            for name, value in self.design.items()
            if name not in names
        ]
        if missing or odd:
            raise InputError(f"{self.source}: {'; '.join([*missing, *odd])}")

    @field_validator("design", "bounds")
    @classmethod
    def _names_are_plain(cls, named: dict[str, Any]) -> dict[str, Any]:
        odd = (name for name in named if not (name.isascii() and name.isidentifier()))
        raise_problems(
            [
                invalid_value_problem(
                    "", name, "a name must be made of letters, digits and underscores"
                )
                for name in odd
            ]
        )
        return named

    @field_validator("bounds")
    @classmethod
    def _bounds_are_upright(
        cls, bounds: dict[str, tuple[float, float]]
    ) -> dict[str, tuple[float, float]]:
        allowed = "it must be [lower, upper] with lower less than upper"
        raise_problems(
            [
                invalid_value_problem(name, list(pair), allowed)
                for name, pair in bounds.items()
                if not pair[0] < pair[1]
            ]
        )
        return bounds

    @check
    def _bounds_belong_to_the_design(self) -> Problems:
        for name in self.design:
            if name not in self.bounds:
                yield missing_value_problem(
                    f"bounds.{name}", "every name in [design] must have its [lower, upper]"
                )
        for name, pair in self.bounds.items():
            if name not in self.design:
                allowed = f"it must be a name in [design]: {', '.join(self.design)}"
                yield invalid_value_problem(f"bounds.{name}", pair, allowed)

    @check
    def _requirements_have_a_speed(self) -> Problems:
        speed = self.operation.forward_speed_m_s
        if self.limits_motion and speed == 0:
            yield invalid_value_problem(
                "operation.forward_speed_m_s",
                speed,
                "[requirements] needs a value above 0, such as 0.667",
            )

    @check
    def _gears_have_one_module(self) -> Problems:
        if self.gears is None or self.requirements is None:
            return
        module = self.requirements.module_mm
        if module is not None and module != self.gears.module_mm:
            yield invalid_value_problem(
                "gears.module_mm",
                self.gears.module_mm,
                f"it must be requirements.module_mm = {module:g}",
            )

    @check
    def _inertia_fits_mass_and_centroid(self) -> Problems:
        inertia, mass, centroid = self.inertia, self.mass, self.centroid
        minima = {
            "J56_about_A1_kg_m2": minimum_inertia(mass.middle_kg, (centroid.middle_radius_mm,)),
            "J7_about_B1_kg_m2": minimum_inertia(mass.planet_kg, centroid.planet_xy_mm),
        }
        for key, bound in minima.items():
            if getattr(inertia, key) < bound:
                allowed = f"it must be at least mass times squared centroid distance, {bound:.6g}"
                yield invalid_value_problem(f"inertia.{key}", getattr(inertia, key), allowed)


def load(source: str | Path, changes: Mapping[str, float] | None = None) -> PlantingMachine:
    """The machine in a file, or the built-in one of that name, with some numbers set by `changes`.

    A name in `changes` is a full path (`mass.sun_kg`, `nozzle.hinge_A_mm[0]`) or a last part that
    fits one path only; `R3_mm` means the design value, not its bounds. Values are in the unit that
    the name ends in.

    Raises InputError, one sentence that names file, key, value and what is allowed.
    """
    return PlantingMachine.load(source, "planting", changes)
