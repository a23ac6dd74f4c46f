"""The sections of a planting device's machine file, each with what its values must obey.

Values stay as the file shows them, in mm, deg, r/min, kg, N: a key ends in its unit. Points are given with
the nozzle closed: x', y', z' in the planet frame at B1, xi, eta, zeta in the half frame at the hinge.
"""

import math
from typing import Annotated, Literal

from pydantic import Field, field_validator

from planter.files import paths
from planter.files.fields import (
    NotNegative,
    Pair,
    Positive,
    PositiveTriple,
    Problems,
    Real,
    Section,
    Triple,
    Whole,
    check,
    refused,
)
from planter.planting import flanks

_ROUNDING = 1e-12


class Operation(Section):
    """How the device is run; the machine travels at `forward_speed_m_s`, of either sign."""

    speed_rpm: Positive
    gravity_m_s2: NotNegative
    forward_speed_m_s: Real


class ContactAngles(Section):
    """Pressure angle of the teeth; friction angles mu1 at the cam and mu2 at the teeth."""

    pressure_angle_deg: Annotated[Positive, Field(lt=45)]
    cam_friction_angle_deg: Annotated[NotNegative, Field(lt=45)]
    tooth_friction_angle_deg: NotNegative

    @check
    def _teeth_push(self) -> Problems:
        if self.tooth_friction_angle_deg >= self.pressure_angle_deg:
            yield refused(
                "tooth_friction_angle_deg",
                self.tooth_friction_angle_deg,
                f"it must be less than pressure_angle_deg = {self.pressure_angle_deg:g}",
            )


class Mass(Section):
    """Masses; each of the two sides has one middle body, one planet body and two nozzle halves C1 + C2."""

    sun_kg: Positive
    middle_kg: Positive
    planet_kg: Positive
    carrier_kg: Positive
    half_C1_kg: Positive
    half_C2_kg: Positive


class Inertia(Section):
    """Moments of inertia: middle body about A1, planet body about B1, centroidal for a half's two parts."""

    J56_about_A1_kg_m2: Positive
    J7_about_B1_kg_m2: Positive
    C1_centroidal_xx_yy_zz_kg_m2: PositiveTriple
    C2_centroidal_xx_yy_zz_kg_m2: PositiveTriple

    @check
    def _bodies_exist(self) -> Problems:
        for key in ("C1_centroidal_xx_yy_zz_kg_m2", "C2_centroidal_xx_yy_zz_kg_m2"):
            tensor: tuple[float, float, float] = getattr(self, key)
            if 2 * max(tensor) > sum(tensor) * (1 + _ROUNDING):
                yield refused(key, tensor, "it must be a body's: none of the three may exceed the sum of the other two")


class Centroid(Section):
    """Centroids: sun and middle body polar (direction at phi = 0, global), planet body in x', y'."""

    sun_radius_mm: NotNegative
    sun_angle_deg: Real
    middle_radius_mm: NotNegative
    middle_angle_deg: Real
    planet_xy_mm: Pair


class Nozzle(Section):
    """Inner nozzle half: hinge in x', y', z'; from there two centroids and the spring hook; tip along x'."""

    hinge_A_mm: Triple
    C1_mm: Triple
    C2_mm: Triple
    hook_F_mm: Triple
    tip_distance_mm: Positive


class Cam(Section):
    """End-face cam and rocker: the nozzle opens over the rise and closes over the fall of cam angle delta."""

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
        if flank not in flanks.names():
            close = paths.close(flank, flanks.names())
            hint = f"did you mean {close[0]!r}? " if close else ""
            raise refused("", flank, f"{hint}it must be one of {', '.join(map(repr, flanks.names()))}")
        return flank

    @check
    def _flanks_fit_a_turn(self) -> Problems:
        for key in ("rise_delta_deg", "fall_delta_deg"):
            start, end = getattr(self, key)
            if not 0 <= start < end <= 360:
                yield refused(key, [start, end], "it must be [start, end] with 0 <= start < end <= 360")
        if self.fall_delta_deg[0] < self.rise_delta_deg[1]:
            allowed = f"it must start where the rise has ended, at {self.rise_delta_deg[1]:g} or later"
            yield refused("fall_delta_deg", self.fall_delta_deg, allowed)

    @check
    def _rocker_faces_the_cam(self) -> Problems:
        if self.psi0_deg + self.opening_deg >= 90:
            allowed = f"it must be less than 90 - opening_deg = {90 - self.opening_deg:g}"
            yield refused("psi0_deg", self.psi0_deg, allowed)


class Spring(Section):
    """Return spring between the hooks of a side's two halves, along z'."""

    preload_N: NotNegative
    rate_N_m: NotNegative


class GearPair(Section):
    """A pair of gears: the family of its inner pitch curve (on the sun in stage 1, on gear 6 in stage 2)."""

    family: Annotated[str, Field(min_length=1)]


class Gears(Section):
    """Teeth and material of all gears, for contact ratio and stress; stress takes all four of the numbers."""

    module_mm: Annotated[Positive, Field(ge=0.1, le=50)]
    face_width_mm: Annotated[Positive | None, Field(le=1000)] = None
    youngs_modulus_GPa: Annotated[Positive | None, Field(ge=0.1, le=1000)] = None
    poisson_ratio: Annotated[NotNegative | None, Field(lt=0.5)] = None

    @property
    def give_stress(self) -> bool:
        """Whether all that stress takes is there."""
        return None not in (self.face_width_mm, self.youngs_modulus_GPa, self.poisson_ratio)


class Objective(Section):
    """What is made small: weight_range * range + weight_variance * spread of the support force.

    The spread is the population variance (N2) for kind "paper", equation (31) of Wang et al. (2017), and the
    standard deviation (N) for kind "newton". `samples` angles over a turn.
    """

    weight_range: NotNegative
    weight_variance: NotNegative
    samples: Annotated[Whole, Field(ge=8, le=100_000)]
    kind: Literal["paper", "newton"]

    @check
    def _something_counts(self) -> Problems:
        if self.weight_range == self.weight_variance == 0:
            yield refused("weight_range", self.weight_range, "it must be above 0 where weight_variance is 0")


def least_inertia(mass_kg: float, offset_mm: tuple[float, ...]) -> float:
    """Least moment of inertia [kg m2] of a body about an axis that its centroid is off by `offset_mm`."""
    return mass_kg * math.hypot(*offset_mm) ** 2 * 1e-6
