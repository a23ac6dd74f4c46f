"""Clutch files: TOML in, a validated `Clutch` out, every number with its unit and its origin."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from planter.engine.measures import Limit
from planter.engine.sections import LimitsSection, parse_holds, with_whole_limits
from planter.files.document import Document, Origins
from planter.files.fields import (
    FileSection,
    NotNegative,
    Pair,
    Positive,
    Problems,
    Real,
    Whole,
    check,
    invalid_value_problem,
)

Acute = Annotated[Positive, Field(lt=90)]


def _some_numbers(value: Any) -> Any:
    if not isinstance(value, list | tuple) or not 1 <= len(value) <= 20:
        raise invalid_value_problem("", value, "it must be a list of 1 to 20 numbers")
    return value


class Sleeve(FileSection):
    """Hexagonal hole that confines the body, its taper and travel, and the forces along the
    axis.
    """

    hexagon_side_mm: Positive
    axial_angle_deg: Acute
    travel_mm: Positive
    length_mm: Positive
    right_radius_mm: Positive
    friction: Positive
    engaging_force_N: Positive
    spring_preload_N: NotNegative
    switching_speed_mm_s: Positive


class Shaft(FileSection):
    """Output shaft: a hexagon with rounded corners, overhanging its bearing."""

    flat_to_flat_mm: Positive
    fillet_mm: Positive
    overhang_mm: Positive
    modulus_GPa: Positive
    density_kg_m3: Positive

    @check
    def _flats_are_left(self) -> Problems:
        if not self.fillet_mm < self.flat_to_flat_mm / 2:
            allowed = f"it must be less than half of flat_to_flat_mm, {self.flat_to_flat_mm / 2:g}"
            yield invalid_value_problem("fillet_mm", self.fillet_mm, allowed)


class ToothSection(FileSection):
    """Distances of tooth tips and roots from the centroid of the body."""

    tip_mm: Positive
    root_mm: Positive


class LinkageSection(FileSection):
    """Crank gear on its rack, crank, rod, and the distance of the crank's axis from the sleeve's
    pin when engaged.
    """

    crank_gear_radius_mm: Positive
    rack_radius_mm: Positive
    rack_phase_deg: Annotated[Positive, Field(le=90)]
    module_mm: Positive
    crank_mm: Positive
    rod_mm: Positive
    distance_mm: Positive


class Engagement(FileSection):
    """Masses, radius, speed and load when the clutch engages."""

    body_kg: Positive
    """mass of the body that slides"""
    contact_radius_mm: Positive
    """radius at which body and sleeve touch"""
    input_speed_rpm: Positive
    """speed of the input"""
    load_Nm: NotNegative
    """torque of the load"""


class SlipSection(FileSection):
    """Angle and forces of a tooth that slips."""

    angle_deg: Acute
    """angle at which a tooth slips"""
    reaction_N: NotNegative
    """radial reaction of the slider"""
    friction_N: NotNegative
    """friction of tooth and shaft"""


class Places(FileSection):
    """Places along the row: of the first and last seed, of the opener's entry and exit."""

    first_seed_mm: Real
    """place of the first seed along the row"""
    entry_mm: Real
    """place of the opener's entry"""
    last_seed_mm: Real
    """place of the last seed along the row"""
    exit_mm: Real
    """place of the opener's exit"""


class LevelsSection(FileSection):
    """Axial angles to compare, each with the rod for its travel."""

    axial_angles_deg: Annotated[tuple[Acute, ...], BeforeValidator(_some_numbers)]
    """axial angles to compare"""
    rods_mm: Annotated[tuple[Positive, ...], BeforeValidator(_some_numbers)]
    """length of the rod for the travel at each of them"""

    @check
    def _one_rod_for_each_angle(self) -> Problems:
        if len(self.rods_mm) != len(self.axial_angles_deg):
            yield invalid_value_problem(
                "rods_mm",
                self.rods_mm,
                f"it must have a rod for each of {len(self.axial_angles_deg)} axial angles",
            )


class SizingSection(FileSection):
    """Travel, space and limits that a clutch is sized for."""

    wanted_travel_mm: Positive
    """travel that the sleeve shall have"""
    space_radius_mm: Positive
    """space for the corners of the hexagonal hole"""
    space_length_mm: Positive
    """space for the body and the way of the sleeve"""
    wall_mm: NotNegative
    """wall between tooth roots and outline, at the thin end of the body"""
    lift_limit_deg: Acute
    """inclination of the links with the row unit up"""


class ClutchLimitsSection(FileSection):
    """Limits of sizing and optimisation."""

    normal_force_N: Positive
    """largest normal force of body and sleeve"""
    tooth_force_N: Positive
    """largest force of crank gear and rack, while the sleeve is pushed"""
    rod_angle_deg: Acute
    """largest angle between rod and guide"""
    length_mm: Positive
    """largest length from the crank's axis to the sleeve's pin, disengaged"""
    rack_least_mm: Positive
    """least radius of the rack"""
    teeth_least: Annotated[Whole, Field(ge=5)]
    """least number of teeth of the crank gear: fewer are undercut"""


class ClutchSearchSection(FileSection):
    """Bounds of the optimisation variables, and the speed of the rising links."""

    axial_angle_bounds_deg: Pair
    """bounds of the axial angle"""
    ratio_bounds: Pair
    """bounds of the ratio of crank gear to rack"""
    crank_bounds_mm: Pair
    """bounds of the crank"""
    rod_bounds_mm: Pair
    """bounds of the rod"""
    distance_bounds_mm: Pair
    """bounds of the distance of the crank's axis from the sleeve's pin, engaged"""
    lift_rad_s: Positive
    """speed of the rising links"""

    @check
    def _bounds_are_upright(self) -> Problems:
        for key in (name for name in type(self).model_fields if "bounds" in name):
            lower, upper = getattr(self, key)
            if not 0 < lower < upper:
                yield invalid_value_problem(
                    key, [lower, upper], "it must be [lower, upper] with 0 < lower < upper"
                )
        if self.axial_angle_bounds_deg[1] >= 90:
            yield invalid_value_problem(
                "axial_angle_bounds_deg", self.axial_angle_bounds_deg, "it must end below 90"
            )


class ContactModel(FileSection):
    """Contact law, masses, spring, slides of the coupling: the same for both clutches."""

    stiffness_N_m15: Positive
    """K of the contact force K d^1.5"""
    dissipation_s_m: NotNegative
    """D of the contact force's factor 1 + D d'"""
    slip_speed_mm_s: Positive
    """speed of slip below which friction fades"""
    output_inertia_kg_m2: Positive
    """moment of inertia of the output"""
    shaft_damping: Annotated[NotNegative, Field(lt=1)]
    """share of critical damping of the shaft's bending"""
    sleeve_kg: Positive
    """mass of the sleeve with its thrust bearing"""
    spring_rate_N_m: NotNegative
    """rate of the spring that pushes the sleeve"""
    sleeve_gap_mm: NotNegative
    """gap of polygon and hole when cut off"""
    slide_N: Positive
    """friction of the coupling's slides"""
    lock_N: NotNegative
    """friction that the thrust bearing adds once it is seated"""
    lock_travel_mm: Positive
    """last part of the sleeve's way, over which the thrust bearing seats"""
    lock_stiffness_N_m: Positive
    """stiffness of the slides while they hold"""
    phase_deg: Real
    """angle of the input when the link begins to move"""


class Dog(FileSection):
    """The dog clutch: jaws of each half, their backlash, rounded edges and overlap, and the fit of
    the driving half.
    """

    jaws: Annotated[Whole, Field(ge=2, le=60)]
    """number of jaws of each half"""
    backlash_deg: Positive
    """backlash of the jaws"""
    edge_mm: Positive
    """edge radii of two jaws that meet, added"""
    depth_mm: Positive
    """overlap of the jaws when engaged"""
    fit_mm: Positive
    """radial gap of the driving half on its shaft"""

    @check
    def _jaws_are_left(self) -> Problems:
        if not self.backlash_deg < 180 / self.jaws:
            allowed = f"it must be less than 180 / jaws = {180 / self.jaws:g}"
            yield invalid_value_problem("backlash_deg", self.backlash_deg, allowed)
        if not self.edge_mm < self.depth_mm:
            yield invalid_value_problem(
                "edge_mm", self.edge_mm, f"it must be less than depth_mm = {self.depth_mm:g}"
            )


class ClutchFile(Document):
    """A clutch of a Reuleaux pentagon in a hexagonal sleeve, its shaft, its linkage and its
    operation.
    """

    sleeve: Sleeve
    shaft: Shaft
    tooth: ToothSection
    linkage: LinkageSection
    engagement: Engagement
    slip: SlipSection
    contact: ContactModel
    dog: Dog
    field: Places
    levels: LevelsSection
    wanted: SizingSection
    limits: ClutchLimitsSection
    search: ClutchSearchSection
    requirements: LimitsSection | None = None
    origins: Origins = Field(alias="origin")

    @property
    def measure_limits(self) -> tuple[Limit, ...]:
        """The limits on measures in [requirements]. Raises InputError if one cannot be parsed."""
        return parse_holds(self.requirements, self.source)

    def written_table(self) -> dict[str, Any]:
        """Return the table with whole paths of the curves in limits, for a file in any folder."""
        return with_whole_limits(self.table(), self.measure_limits, self.source)

    @check
    def _lift_goes_beyond_mesh(self) -> Problems:
        mesh = 90 - self.linkage.rack_phase_deg
        if self.wanted.lift_limit_deg <= mesh:
            allowed = (
                f"it must be greater than 90 - linkage.rack_phase_deg = {mesh:g}, where mesh begins"
            )
            yield invalid_value_problem(
                "wanted.lift_limit_deg", self.wanted.lift_limit_deg, allowed
            )


def load_clutch(source: str | Path, changes: Mapping[str, float] | None = None) -> ClutchFile:
    """Return the clutch in a file, or a built-in one by name, with some numbers replaced by
    `changes`.

    Names are those of `Document.read`, values in the unit [that the name ends in]. Raises
    InputError, one sentence with file, key, value and the allowed values.
    """
    return ClutchFile.load(source, "clutch", changes)
