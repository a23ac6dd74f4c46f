"""Both gear stages as a designer sees them: pitch curves, pressure angles, contact ratio, stress."""

from __future__ import annotations

import math

import numpy as np

from planter.kernels import Array
from planter.numerics import extrema
from planter.numerics.arrays import to_degrees
from planter.numerics.extrema import ExtremePoint
from planter.planting import cycle
from planter.planting.designer.quantities import GEARS
from planter.planting.designer.results import GearFound, StageFound, StressFound
from planter.planting.designer.turn import DesignTurn
from planter.planting.requirements import pitch
from planter.planting.requirements.places import PITCH, Course

LEWIS_ANGLE_DEG = 20.0
FEWEST_TEETH = 12
"""Pressure angle and least number of teeth that the form factor is known for."""
MILLI = 1e3
MEGA = 1e-6
AROUND = 180
"""Places of a pitch curve between which its extreme radii are looked for."""


def of(turn: DesignTurn) -> tuple[list[StageFound], list[str]]:
    """Both stages at a design, and what could not be told of them."""
    found = [_stage(turn, index) for index in (0, 1)]
    return found, _notes(turn, found)


def module(turn: DesignTurn) -> float | None:
    """Module of the teeth [m], where the machine's file gives one."""
    machine = turn.device.machine
    if machine.gears is not None:
        return machine.si("gears.module_mm")
    required = machine.requirements
    return None if required is None or required.module_mm is None else machine.si("requirements.module_mm")


def _stage(turn: DesignTurn, index: int) -> StageFound:
    known = module(turn)
    courses = _courses(turn, index, known)
    ratio = None if known is None else min(_over(courses, pitch.RATIO, -1))
    steepest, flattest = (_pressure(turn, index, sign) for sign in (1, -1))
    distance = cycle.find_centre_distances(turn.device, turn.at)[index]
    radii = _radii(turn, index)
    gears = [
        _gear(name, max(_over(courses, row, 1)), min(_over(courses, row, -1)), radius, known)
        for name, row, radius in zip(
            GEARS[index], (pitch.INNER, pitch.OUTER), (radii, (distance - radii[1], distance - radii[0])), strict=True
        )
    ]
    return StageFound(
        stage=index + 1,
        centre_distance_mm=float(distance * MILLI),
        gears=gears,
        pressure_angle_min_deg=math.degrees(flattest.value),
        pressure_angle_max_deg=math.degrees(steepest.value),
        pressure_angle_max_phi_deg=to_degrees(steepest.place),
        contact_ratio_min=ratio,
        stress=_stress(turn, index, gears),
    )


def _courses(turn: DesignTurn, index: int, known: float | None) -> list[Course]:
    """Curvatures and contact ratio along both segments of a stage."""
    stage = turn.device.stages[index]
    parameters = turn.device.of_stage(index, turn.x)
    hoisted = stage.prologue(parameters=parameters)["hoisted"]
    teeth = pitch.Teeth(known or 1.0, turn.device.machine.si("pressure_angle_deg"))
    kernels = (pitch.kernel(pitch.segment(stage, second, teeth)) for second in (False, True))
    return [Course(kernel, parameters=parameters, hoisted=hoisted) for kernel in kernels]


def _over(courses: list[Course], row: int, sign: int) -> list[float]:
    return [course.of_row(row).extreme(0.0, np.pi, sign, PITCH).value for course in courses]


def _radii(turn: DesignTurn, index: int) -> tuple[float, float]:
    """Least and largest pitch radius of the inner gear [m]."""
    stage, parameters = turn.device.stages[index], turn.device.of_stage(index, turn.x)
    hoisted = stage.prologue(parameters=parameters)["hoisted"]
    places = 2 * np.pi * np.arange(AROUND) / AROUND

    def radius(t: Array) -> Array:
        found: Array = stage.contact(t=t, parameters=parameters, hoisted=hoisted)["r"][0]
        return found

    return extrema.find_minimum(radius, places, closed=True).value, extrema.find_maximum(
        radius, places, closed=True
    ).value


def _gear(name: str, sharpest: float, flattest: float, radii: tuple[float, float], known: float | None) -> GearFound:
    return GearFound(
        gear=name,
        curvature_radius_min_mm=MILLI / sharpest,
        curvature_min_per_mm=flattest / MILLI,
        pitch_radius_min_mm=radii[0] * MILLI,
        pitch_radius_max_mm=radii[1] * MILLI,
        teeth_min=None if known is None else 2 / (known * sharpest),
    )


def _pressure(turn: DesignTurn, index: int, sign: int) -> ExtremePoint:
    """Over both flanks of the teeth."""
    both = (turn.extreme(f"{flank}{index + 1}", sign) for flank in ("towards", "against"))
    return max(both, key=lambda one: sign * one.value)


def _stress(turn: DesignTurn, index: int, gears: list[GearFound]) -> StressFound | None:
    if f"contact{index + 1}" not in turn.names:
        return None
    contact = turn.extreme(f"contact{index + 1}", 1)
    bent = [turn.extreme(f"bending, {gear.gear}", 1) if _formed(turn, gear) else None for gear in gears]
    return StressFound(
        contact_MPa=contact.value * MEGA,
        contact_phi_deg=to_degrees(contact.place),
        bending_MPa=[None if one is None else one.value * MEGA for one in bent],
        bending_phi_deg=[None if one is None else to_degrees(one.place) for one in bent],
    )


def _formed(turn: DesignTurn, gear: GearFound) -> bool:
    """Whether Lewis's form factor is known for the teeth of a gear."""
    angle = turn.device.machine.contact.pressure_angle_deg
    return angle == LEWIS_ANGLE_DEG and gear.teeth_min is not None and gear.teeth_min >= FEWEST_TEETH


def _notes(turn: DesignTurn, found: list[StageFound]) -> list[str]:
    machine = turn.device.machine
    if module(turn) is None:
        return ["contact ratio and stress need the module of the teeth: [gears] module_mm in the machine file"]
    if machine.gears is None or not machine.gears.give_stress:
        return ["stress needs [gears] with module_mm, face_width_mm, youngs_modulus_GPa and poisson_ratio"]
    if machine.contact.pressure_angle_deg != LEWIS_ANGLE_DEG:
        return [f"no bending stress: the form factor is that of {LEWIS_ANGLE_DEG:g} deg teeth"]
    few = [gear for stage in found for gear in stage.gears if not _formed(turn, gear)]
    return [f"no bending stress of the {gear.gear}: its sharpest place is that of a gear with {gear.teeth_min:.3g} "
            f"teeth, the form factor begins at {FEWEST_TEETH}" for gear in few]  # fmt: skip
