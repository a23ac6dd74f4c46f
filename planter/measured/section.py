"""The table of machine files that says what a sensor measures: a quantity, and what stands before
the signal.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from planter.files.fields import (
    FileSection,
    Line,
    Pair,
    Positive,
    Problems,
    Quadruple,
    Real,
    check,
    invalid_value_problem,
    missing_value_problem,
)

SECTION = "measurement"
"""Name of the table in files."""
PAIRS = (("drive", "lever_mm"), ("mount_Hz", "mount_damping"))
"""Keys that belong together."""
AXES = "x", "y", "z"
"""Axes of the world."""


def name_carried_force(axis: str) -> str:
    """Return the key of the force of the ground on the bodies that a sensor carries, along an axis
    of the world.
    """
    return f"F_carried_{axis}_N"


class MeasurementSection(FileSection):
    """The sensor of a machine: the quantity that it measures, and what stands between the rigid
    machine and it.
    """

    quantity: Annotated[
        Line | None, Field(description="name of the quantity that the sensor measures")
    ] = None
    bodies: Annotated[
        list[Line] | None,
        Field(
            min_length=1,
            description="names of bodies that the sensor carries: the force of the ground on them",
        ),
    ] = None
    axis: Annotated[
        Literal["x", "y", "z"] | None,
        Field(description="axis of the world along which the sensor measures bodies"),
    ] = None
    axis_deg: Annotated[
        Real | None,
        Field(description="instead of axis: angle from x towards y of the direction of the sensor"),
    ] = None
    enclosed: Annotated[
        list[Line] | None,
        Field(
            min_length=1,
            description="names of further quantities, in the same unit, that the sensor also sees",
        ),
    ] = None
    shares: Annotated[
        list[Real] | None,
        Field(
            min_length=1,
            description="share of each enclosed quantity in the signal, 1 unless the file says it",
        ),
    ] = None
    drive: Annotated[
        Line | None, Field(description="name of the torque whose reaction the sensor also sees")
    ] = None
    lever_mm: Annotated[
        Real | None,
        Field(
            description="lever at which the reaction of the drive acts; negative on the other side"
        ),
    ] = None
    imbalance_kg_m: Annotated[
        Pair | None,
        Field(
            description="mass times radius of an imbalance of the drive, along and across the "
            "sensor at angle 0"
        ),
    ] = None
    speed_harmonics: Annotated[
        Quadruple | None,
        Field(
            description="shares of the speed by which it swings: [cos1, sin1, cos2, sin2] of the "
            "drive's angle"
        ),
    ] = None
    mount_Hz: Annotated[
        Positive | None,
        Field(description="natural frequency of the elastic mount that the machine stands on"),
    ] = None
    mount_damping: Annotated[
        Positive | None,
        Field(description="damping of the elastic mount, as a share of the critical one"),
    ] = None
    gain: Annotated[
        Positive | None, Field(description="factor by which the sensor magnifies the signal")
    ] = None
    corner_Hz: Annotated[
        Positive | None,
        Field(description="corner frequency of an amplifier that passes no direct current"),
    ] = None

    default_quantity: ClassVar[str | None] = None
    """Name of the quantity that is measured if the file names neither one nor bodies."""

    @check
    def _subject_is_stated_once(self) -> Problems:
        axes = [key for key in ("axis", "axis_deg") if getattr(self, key) is not None]
        if self.bodies is None:
            if self.quantity is None and self.default_quantity is None:
                yield missing_value_problem(
                    "quantity", "it must be given, or else bodies with axis or axis_deg"
                )
            for key in axes:
                yield missing_value_problem(
                    "bodies", f"it must be given with {key} = {getattr(self, key)}"
                )
            return
        if self.quantity is not None:
            yield invalid_value_problem(
                "bodies", self.bodies, "quantity must be left out beside it"
            )
        if not axes:
            yield missing_value_problem(
                "axis", f"it, or axis_deg, must be given with bodies = {self.bodies}"
            )
        if len(axes) > 1:
            yield invalid_value_problem(
                "axis_deg", self.axis_deg, f"it must be left out beside axis = {self.axis}"
            )
        if len(set(self.bodies)) < len(self.bodies):
            yield invalid_value_problem("bodies", self.bodies, "each body must be in it once")
        if self.axis_deg is not None and self.speed_harmonics is not None:
            yield invalid_value_problem(
                "axis_deg", self.axis_deg, "speed_harmonics takes an axis: use axis"
            )

    @check
    def _shares_belong_to_enclosed(self) -> Problems:
        enclosed = self.enclosed or []
        if self.shares is not None and len(self.shares) != len(enclosed):
            allowed = f"it must have as many numbers as enclosed has names, {len(enclosed)}"
            yield invalid_value_problem("shares", self.shares, allowed)

    @check
    def _pairs_are_complete(self) -> Problems:
        for pair in PAIRS:
            for key, other in (pair, pair[::-1]):
                if getattr(self, key) is None and (value := getattr(self, other)) is not None:
                    yield missing_value_problem(key, f"it must be given with {other} = {value}")

    @check
    def _lever_is_not_zero(self) -> Problems:
        if self.lever_mm == 0:
            yield invalid_value_problem(
                "lever_mm", self.lever_mm, "it must not be 0; leave out drive and lever_mm"
            )

    @check
    def _speed_keeps_its_sign(self) -> Problems:
        if self.speed_harmonics is None:
            return
        swing = math.hypot(*self.speed_harmonics[:2]) + math.hypot(*self.speed_harmonics[2:])
        if swing >= 1:
            allowed = (
                f"its amplitudes must add up to less than 1, but they are {swing:.4g}: the "
                f"speed would reverse"
            )
            yield invalid_value_problem("speed_harmonics", list(self.speed_harmonics), allowed)

    @property
    def axis_key(self) -> str:
        """The key that states the direction of the sensor."""
        return "axis" if self.axis_deg is None else "axis_deg"

    @property
    def carried_axes(self) -> tuple[str, ...]:
        """The axes of the world along which forces on the bodies are measured; none without
        bodies.
        """
        if self.bodies is None:
            return ()
        return AXES[:2] if self.axis is None else (self.axis,)

    @property
    def measured(self) -> str:
        """The name of the quantity that is measured; with axis_deg the force along x, which is
        turned.
        """
        if self.carried_axes:
            return name_carried_force(self.carried_axes[0])
        name = self.quantity or self.default_quantity
        assert name is not None
        return name

    @property
    def shares_of_enclosed(self) -> list[float]:
        """The share of each enclosed quantity."""
        return self.shares or [1.0] * len(self.enclosed or ())
