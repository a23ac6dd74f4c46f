"""Sections of a clutch file that only the contact model reads: what both clutches share, and the jaws."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from planter.files.complaints import refused
from planter.files.fields import NotNegative, Positive, Problems, Real, Section, Whole, check


class ContactModel(Section):
    """Contact law, masses, spring, slides of the coupling: the same for both clutches."""

    stiffness_N_m15: Positive
    dissipation_s_m: NotNegative
    slip_speed_mm_s: Positive
    output_inertia_kg_m2: Positive
    shaft_damping: Annotated[NotNegative, Field(lt=1)]
    sleeve_kg: Positive
    spring_rate_N_m: NotNegative
    sleeve_gap_mm: NotNegative
    slide_N: Positive
    lock_N: NotNegative
    lock_travel_mm: Positive
    lock_stiffness_N_m: Positive
    phase_deg: Real


class Dog(Section):
    """The dog clutch: jaws of each half, their backlash, rounded edges and overlap, and the fit of the driving half."""

    jaws: Annotated[Whole, Field(ge=2, le=60)]
    backlash_deg: Positive
    edge_mm: Positive
    depth_mm: Positive
    fit_mm: Positive

    @check
    def _jaws_are_left(self) -> Problems:
        if not self.backlash_deg < 180 / self.jaws:
            allowed = f"it must be less than 180 / jaws = {180 / self.jaws:g}"
            yield refused("backlash_deg", self.backlash_deg, allowed)
        if not self.edge_mm < self.depth_mm:
            yield refused("edge_mm", self.edge_mm, f"it must be less than depth_mm = {self.depth_mm:g}")
