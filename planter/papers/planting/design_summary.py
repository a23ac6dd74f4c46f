"""The designer's summary: what motor, bearings, gears and cam of a planting device bear over a
cycle.

The functions of the carrier angle are rows of the engine's summary; extremes are true ones,
integrals by quadrature.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import casadi as ca
import numpy as np

from planter.engine.machine import Machine, Quantity
from planter.engine.summary import CycleRow, PiecewiseCycle, build_rows, summarise
from planter.gears.geometry.stage import Stage
from planter.kernels import Array, formulas
from planter.numerics import extrema
from planter.numerics.arrays import to_degrees
from planter.numerics.extrema import ExtremePoint
from planter.papers.planting import angle_functions as pitch
from planter.papers.planting.angle_functions import PITCH_CELLS, AngleFunction
from planter.papers.planting.design_results import (
    DesignersSummary,
    GearFound,
    StageFound,
    StressFound,
)
from planter.papers.planting.model import CONTACTS, Device

STRENGTH = formulas.load("gear_strength")
CAM = formulas.load("planting_cam")
TURNED = ("phi52", "phi72", "theta1")
"""Angles of bodies; their second derivatives are accelerations, since the carrier's speed is
constant.
"""
CENTRE = ("x_tip", "y_tip")
OF_GEARS = {
    "module": "module_mm",
    "b": "face_width_mm",
    "E": "youngs_modulus_GPa",
    "nu": "poisson_ratio",
}
"""Names of the strength formulas, and where their values stand in [gears]."""
GEARS = (("sun", "gear 5"), ("gear 6", "planet gear"))


class DeviceRows:
    """Rows of a device: signed forces and torques, sizes, accelerations, pressure angles, stress if
    [gears] has it.
    """

    def __init__(self, device: Device, machine: Machine) -> None:
        self.device, self.machine = device, machine
        self.phi, self._d, self._h, _ = machine.symbols
        self._constants = {
            value.name: self._d[device.size + i]
            for i, value in enumerate(machine.values[device.size :])
        }

    def build(self) -> list[CycleRow]:
        """Return all rows: those of every machine first."""
        own = [*self._accelerations(), *self._meshing(), self._cam()]
        return [*build_rows(self.machine), *own]

    def _accelerations(self) -> Iterator[CycleRow]:
        for name in (*TURNED, *CENTRE):
            quantity = self.machine.find_quantity(name)
            rate = ca.gradient(ca.gradient(self.machine.graph(name), self.phi), self.phi)
            meaning, unit = f"acceleration of the {quantity.meaning}", f"{quantity.unit}/s2"
            acceleration = Quantity(f"{name}_ddot", unit, meaning, "")
            yield CycleRow(acceleration, rate * self._constants["omega"] ** 2, has_peaks=False)

    def _meshing(self) -> Iterator[CycleRow]:
        for index, (stage, t, force) in enumerate(
            zip(self.device.stages, ("t1", "t2"), CONTACTS, strict=False)
        ):
            parameters, hoisted = self._of_stage(index)
            polar = self.machine.graph(t)
            contact = dict(
                zip(
                    stage.contact.function.name_out(),
                    stage.contact.function(polar, parameters, hoisted),
                    strict=True,
                )
            )
            inputs: dict[str, ca.SX] = {
                "r": contact["r"],
                "dr": contact["dr"],
                "alpha0": self._constants["alpha_n"],
            }
            for name, value in STRENGTH.composed("pressure_angles", inputs).items():
                yield _row(f"{name}{index + 1}", value, "pressure angle", "rad")
            gears = self.device.machine.gears
            if gears is not None and gears.give_stress:
                bends = _curvatures(stage, polar, parameters, hoisted)
                yield from self._stresses(index, inputs | {"F": self.machine.graph(force)}, bends)

    def _stresses(
        self, index: int, inputs: Mapping[str, ca.SX], bends: tuple[ca.SX, ca.SX]
    ) -> Iterator[CycleRow]:
        values = {
            **inputs,
            **{name: self.device.machine.si(f"gears.{key}") for name, key in OF_GEARS.items()},
        }
        contact = STRENGTH.composed(
            "contact_stress", values | {"kappa1": bends[0], "kappa2": bends[1]}
        )
        stress = Quantity(f"contact{index + 1}", "N/m2", "contact stress", "")
        yield CycleRow(stress, contact["square"], has_jumps=False, is_square=True)
        for gear, bend in zip(GEARS[index], bends, strict=True):
            bending = STRENGTH.composed("bending_stress", values | {"kappa1": bend})["sigma"]
            yield _row(f"bending, {gear}", bending, "bending stress", "N/m2")

    def _of_stage(self, index: int) -> tuple[ca.SX, ca.SX]:
        """Return parameters and coefficients of a stage, in the machine's symbols."""
        functions = self.device.functions
        inputs = functions.lane_inputs(functions.phi)[2 + 2 * index : 4 + 2 * index]
        design = self._d[: self.device.size]
        parameters, hoisted = ca.substitute(inputs, [functions.x, functions.h], [design, self._h])
        return parameters, hoisted

    def _cam(self) -> CycleRow:
        theta = self.machine.graph("theta1")
        rate = ca.gradient(theta, self.phi) * self._constants["omega"]
        inputs = {
            **self._constants,
            "theta1": theta,
            "theta1_dot": rate,
            "Omega": self.machine.graph("Omega"),
        }
        return _row(
            "cam", CAM.composed("cam", inputs)["pressure"], "pressure angle of the cam", "rad"
        )


def _row(name: str, graph: ca.SX, meaning: str, unit: str) -> CycleRow:
    return CycleRow(Quantity(name, unit, meaning, ""), graph, has_jumps=False)


def _curvatures(stage: Stage, t: ca.SX, parameters: ca.SX, hoisted: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Curvatures [1/m] of both pitch curves at a polar angle of the inner gear, on whichever
    segment it is.

    Polar angles are linear in u on a segment, so that two of them determine u.
    """
    polar, bends = stage.polar.function, stage.curvature.function
    angle = t - 2 * np.pi * ca.floor(t / (2 * np.pi))
    ends = zip(polar(0.0, parameters), polar(1.0, parameters), strict=True)
    first, second = ((angle - start) / (unit - start) for start, unit in ends)
    first_curvatures, second_curvatures = (
        bends(first, parameters, hoisted)[:2],
        bends(second, parameters, hoisted)[2:],
    )
    inner, outer = (
        ca.if_else(first <= np.pi, a, b)
        for a, b in zip(first_curvatures, second_curvatures, strict=True)
    )
    return inner, outer


class DesignTurn(PiecewiseCycle):
    """A design (p,) over a turn: its rows by name, each an angle and a value, in SI."""

    def __init__(self, device: Device, x: Array) -> None:
        machine = device.force.machine
        super().__init__(machine, DeviceRows(device, machine).build(), x)
        self.device, self.x, self.at = device, x, device.prologue(x)


LEWIS_ANGLE_DEG = 20.0
FEWEST_TEETH = 12
"""Pressure angle and least number of teeth that the form factor is known for."""
MILLI = 1e3
MEGA = 1e-6
AROUND = 180
"""Places of a pitch curve between which its extreme radii are looked for."""


def summarise_stages(turn: DesignTurn) -> tuple[list[StageFound], list[str]]:
    """Return both stages at a design, and notes on values that are not available."""
    stages = [_stage(turn, index) for index in (0, 1)]
    return stages, _notes(turn, stages)


def find_module(turn: DesignTurn) -> float | None:
    """Module of the teeth [m], where the machine's file gives one."""
    machine = turn.device.machine
    if machine.gears is not None:
        return machine.si("gears.module_mm")
    required = machine.requirements
    return (
        None
        if required is None or required.module_mm is None
        else machine.si("requirements.module_mm")
    )


def _stage(turn: DesignTurn, index: int) -> StageFound:
    module = find_module(turn)
    courses = _courses(turn, index, module)
    ratio = None if module is None else min(_over(courses, pitch.RATIO, -1))
    steepest, flattest = (_pressure(turn, index, sign) for sign in (1, -1))
    distance = turn.device.centre_distances(turn.x)[index]
    radii = _radii(turn, index)
    gears = [
        _gear(name, max(_over(courses, row, 1)), min(_over(courses, row, -1)), radius, module)
        for name, row, radius in zip(
            GEARS[index],
            (pitch.INNER, pitch.OUTER),
            (radii, (distance - radii[1], distance - radii[0])),
            strict=True,
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


def _courses(turn: DesignTurn, index: int, module: float | None) -> list[AngleFunction]:
    """Curvatures and contact ratio along both segments of a stage."""
    stage = turn.device.stages[index]
    parameters = turn.device.of_stage(index, turn.x)
    hoisted = stage.prologue(parameters=parameters)["hoisted"]
    teeth = pitch.RackTeeth(module or 1.0, turn.device.machine.si("pressure_angle_deg"))
    kernels = (
        pitch.build_segment_kernel(pitch.build_segment_function(stage, second, teeth))
        for second in (False, True)
    )
    return [AngleFunction(kernel, parameters=parameters, hoisted=hoisted) for kernel in kernels]


def _over(courses: list[AngleFunction], row: int, sign: int) -> list[float]:
    return [
        course.select_row(row).find_extremum(0.0, np.pi, sign, PITCH_CELLS).value
        for course in courses
    ]


def _radii(turn: DesignTurn, index: int) -> tuple[float, float]:
    """Least and largest pitch radius of the inner gear [m]."""
    stage, parameters = turn.device.stages[index], turn.device.of_stage(index, turn.x)
    hoisted = stage.prologue(parameters=parameters)["hoisted"]

    def evaluate(t: Array) -> dict[str, Array]:
        return stage.contact(t=t, parameters=parameters, hoisted=hoisted)

    def rates(t: Array) -> tuple[Array, Array]:
        contact = evaluate(t)
        return contact["dr"][0], contact["ddr"][0]

    grid = np.linspace(0.0, 2 * np.pi, AROUND + 1)
    stationary, _ = extrema.find_stationary_points(rates, grid, rates(grid)[0])
    radii = evaluate(np.append(grid, stationary))["r"][0]
    return float(radii.min()), float(radii.max())


def _gear(
    name: str, sharpest: float, flattest: float, radii: tuple[float, float], module: float | None
) -> GearFound:
    return GearFound(
        gear=name,
        curvature_radius_min_mm=MILLI / sharpest,
        curvature_min_per_mm=flattest / MILLI,
        pitch_radius_min_mm=radii[0] * MILLI,
        pitch_radius_max_mm=radii[1] * MILLI,
        teeth_min=None if module is None else 2 / (module * sharpest),
    )


def _pressure(turn: DesignTurn, index: int, sign: int) -> ExtremePoint:
    """Over both flanks of the teeth."""
    both = (turn.extreme(f"{flank}{index + 1}", sign) for flank in ("towards", "against"))
    return max(both, key=lambda extreme: sign * extreme.value)


def _stress(turn: DesignTurn, index: int, gears: list[GearFound]) -> StressFound | None:
    if f"contact{index + 1}" not in turn.names:
        return None
    contact = turn.extreme(f"contact{index + 1}", 1)
    bent = [
        turn.extreme(f"bending, {gear.gear}", 1) if _formed(turn, gear) else None for gear in gears
    ]
    return StressFound(
        contact_MPa=contact.value * MEGA,
        contact_phi_deg=to_degrees(contact.place),
        bending_MPa=[None if extreme is None else extreme.value * MEGA for extreme in bent],
        bending_phi_deg=[
            None if extreme is None else to_degrees(extreme.place) for extreme in bent
        ],
    )


def _formed(turn: DesignTurn, gear: GearFound) -> bool:
    """Whether Lewis's form factor is module for the teeth of a gear."""
    angle = turn.device.machine.contact.pressure_angle_deg
    return (
        angle == LEWIS_ANGLE_DEG and gear.teeth_min is not None and gear.teeth_min >= FEWEST_TEETH
    )


def _notes(turn: DesignTurn, stages: list[StageFound]) -> list[str]:
    machine = turn.device.machine
    if find_module(turn) is None:
        return [
            "contact ratio and stress need the module of the teeth: [gears] module_mm in the "
            "machine file"
        ]
    if machine.gears is None or not machine.gears.give_stress:
        return [
            "stress needs [gears] with module_mm, face_width_mm, youngs_modulus_GPa and "
            "poisson_ratio"
        ]
    if machine.contact.pressure_angle_deg != LEWIS_ANGLE_DEG:
        return [f"no bending stress: the form factor is that of {LEWIS_ANGLE_DEG:g} deg teeth"]
    few = [gear for stage in stages for gear in stage.gears if not _formed(turn, gear)]
    return [
        f"no bending stress of the {gear.gear}: its sharpest place is that of a gear with "
        f"{gear.teeth_min:.3g} "
        f"teeth, the form factor begins at {FEWEST_TEETH}"
        for gear in few
    ]


def summarise_design(device: Device, x: Array) -> DesignersSummary:
    """Return the summary of a design x (p,) of a device: true extremes, one-sided at events,
    integrals by quadrature.
    """
    return summarise_turn(DesignTurn(device, x))


def summarise_turn(turn: DesignTurn) -> DesignersSummary:
    """Return the summary of a turn of a device."""
    summary, cam = summarise(turn), turn.largest("cam")
    stages, notes = summarise_stages(turn)
    assert summary.motor is not None
    return DesignersSummary(
        motor=summary.motor,
        peaks=summary.peaks,
        shocks=summary.shocks,
        stages=stages,
        cam_pressure_angle_max_deg=math.degrees(cam.value),
        cam_pressure_angle_max_phi_deg=to_degrees(cam.place),
        notes=notes,
    )
