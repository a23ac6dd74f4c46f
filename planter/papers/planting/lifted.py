"""Effects of the exact model's assumptions: the model is evaluated again with one assumption
relaxed.

The derived model `planting_lifted` takes what is lifted as inputs, a value for each angle; with
zeros it is the exact model.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np
import scipy

from planter.kernels import Array, Kernel, generated
from planter.papers.planting.functions import build_flank_function
from planter.papers.planting.model import SIDES, Device
from planter.papers.planting.results import Lifted

NAME = "planting_lifted"
SAMPLES = 1440
"""Angles of a turn: friction against sliding changes its direction many times."""
MODULE_MM = 2.0
"""Module of the teeth where nothing says it; both stages."""
JOINTS = {
    "F_A1": ("F_A1x", "F_A1y"),
    "F_B1": ("F_B1x", "F_B1y"),
    "F_O": ("F_Ox", "F_Oy"),
    "F_O1": ("F_O1x", "F_O1y"),
}
TOTALS = frozenset({"F_O", "F_O1"})
Columns = Mapping[str, Array]
Lifting = Mapping[str, Array | float]


@dataclass(frozen=True)
class LiftedCycle:
    """Quantities of side 1 and totals at equally spaced angles, in SI, by name."""

    one: Columns
    two: Columns
    totals: Columns

    def joint(self, name: str) -> Array:
        """Size of the force in a joint [N], (n,)."""
        x, y = ((self.totals if name in TOTALS else self.one)[part] for part in JOINTS[name])
        size_N: Array = np.hypot(x, y)
        return size_N

    @property
    def motor_work(self) -> float:
        """Work of the motor over a turn [J]."""
        return float(self.totals["M_L"].mean() * 2 * np.pi)

    def friction_loss(self, speed: float) -> float:
        """Work lost to friction over a turn [J], at cams and teeth of both sides."""
        losses = ("F_E_loss", "F_P_loss", "F_Q_loss")
        return float(
            sum(side[name].mean() for side in (self.one, self.two) for name in losses)
            * 2
            * np.pi
            / speed
        )


def build_side_function(device: Device) -> ca.Function:
    """Return (phi, x, c, h, lifted) -> quantities of a side, of a device of the exact model."""
    functions, module = device.functions, generated.module(NAME)
    contacts = [stage.contact.function for stage in device.stages]
    lane = module.lane(*contacts, build_flank_function(device.machine.cam.flank))
    relaxed = ca.SX.sym("lifted", lane.size1_in("lifted"))
    phi, *vectors, c, _ = functions.lane_inputs(functions.phi)
    hoisted = module.prologue(*contacts)(*vectors, c, relaxed)
    side = lane(phi, *vectors, c, relaxed, hoisted)
    return ca.Function("side", [*functions.inputs, relaxed], [side])


class LiftedModel:
    """A device of the exact model whose assumptions can be lifted, at a design (p,) [SI], its own
    unless told.
    """

    def __init__(self, device: Device, x: Array | None = None) -> None:
        self.device = device
        self.vectors = generated.sidecar(NAME)["vectors"]
        self.inputs = tuple(entry["name"] for entry in self.vectors["lifted"])
        self._x = device.design if x is None else x
        self._h = device.prologue(self._x).h

    @cached_property
    def _kernel(self) -> Kernel:
        functions, side = self.device.functions, build_side_function(self.device)
        inputs = [ca.SX.sym(f"lifted{number}", len(self.inputs)) for number in (1, 2)]
        phi, *fixed = functions.inputs
        sides = [
            side(phi + angle, *fixed, relaxed) for angle, relaxed in zip(SIDES, inputs, strict=True)
        ]
        outputs = [*sides, generated.module(NAME).frame()(*sides, functions.c)]
        names = ["phi", "x", "c", "h", "lifted1", "lifted2"]
        outs = ["side1", "side2", "totals"]
        f = ca.Function("lifted", [phi, *fixed, *inputs], outputs, names, outs)
        return Kernel(f, lanes=["phi", "lifted1", "lifted2"])

    def turn(
        self,
        phi: Array,
        lifted: Lifting | None = None,
        changes: Mapping[str, float] | None = None,
        behind: Lifting | None = None,
    ) -> LiftedCycle:
        """A turn with values of what is lifted, one for all or one for each angle of side 1, over a
        whole turn.

        `changes` are other values of constants, in SI, by their paths in the machine file. What is
        lifted is the same on side 2, half a turn behind, unless `behind` has values for it, one for
        each of its angles of a turn.
        """
        rows = self._rows(lifted or {}, len(phi))
        constants = self.device.constants.copy()
        paths = [entry["shown"] for entry in self.vectors["machine"]]
        for path, value in (changes or {}).items():
            constants[paths.index(path)] = value
        second = np.roll(
            rows if behind is None else self._rows(behind, len(phi)), len(phi) // 2, axis=1
        )
        second[self.inputs.index("speed_rate")] = rows[self.inputs.index("speed_rate")]
        outputs = self._kernel(
            phi=phi, x=self._x, c=constants, h=self._h, lifted1=rows, lifted2=second
        )
        return LiftedCycle(
            *(
                dict(zip((e["name"] for e in self.vectors[vector]), outputs[name], strict=True))
                for vector, name in (("side", "side1"), ("side", "side2"), ("totals", "totals"))
            )
        )

    def _rows(self, lifted: Lifting, count: int) -> Array:
        """The inputs (k, n) that are lifted; what is not named is not."""
        rows = np.zeros((len(self.inputs), count))
        for name, values in lifted.items():
            rows[self.inputs.index(name)] = values
        return rows

    def locate_contacts(self, turn: LiftedCycle, phi: Array, module: float) -> dict[str, Array]:
        """Return contact points of teeth of unknown outline, as inputs of both flanks of both
        meshes, (n,) each.

        One pair of teeth bears at a time, from half a base pitch before the pitch point to half
        behind it; the place on the pitch curve counts from its joint at t = 0.
        """
        cosine = np.cos(self.device.machine.si("contact.pressure_angle_deg"))
        pitch = np.pi * module
        inputs: dict[str, Array] = {}
        for tag, sense, arc in zip("PQ", (-1, 1), self._arcs(turn, phi), strict=True):
            distance = sense * cosine * pitch * (np.mod(arc / pitch, 1) - 0.5)
            for flank, way in (("plus", 1), ("minus", -1)):
                inputs |= {
                    f"lead_{tag}_{flank}": np.sign(way * distance),
                    f"away_{tag}_{flank}": np.abs(distance),
                }
        return inputs

    def _arcs(self, turn: LiftedCycle, phi: Array) -> Iterator[Array]:
        """Length of the inner pitch curves that has passed the contact since t = 0, at each angle
        [m], (n,).
        """
        machine = self.device.machine
        polar = (
            phi + machine.si("design.alpha3_deg"),
            turn.one["phi52"] + machine.si("design.beta6_deg"),
        )
        for number, (stage, t) in enumerate(zip(self.device.stages, polar, strict=True)):
            parameters = self.device.of_stage(number, self._x)
            dense = np.linspace(min(0.0, float(t.min())), float(t.max()), 8 * SAMPLES + 1)
            hoisted = stage.prologue(parameters=parameters)["hoisted"]
            contact = stage.contact(t=dense, parameters=parameters, hoisted=hoisted)
            speed = np.hypot(contact["r"][0], contact["dr"][0])
            arc = scipy.integrate.cumulative_simpson(speed, x=dense, initial=0.0)
            yield np.interp(t, dense, arc) - np.interp(0.0, dense, arc)


def find_assumption_effects(device: Device, module_mm: float = MODULE_MM) -> list[Lifted]:
    """Return the effect of relaxing each assumption alone on the largest joint forces and on the
    work of a cycle.
    """
    model, phi = LiftedModel(device), device.engine.list_angles(SAMPLES)
    modelled = model.turn(phi)
    speed = device.machine.si("operation.speed_rpm")
    friction = device.machine.si("contact.tooth_friction_angle_deg")
    inward = {"contact.tooth_friction_angle_deg": -friction}
    cases = {
        "tooth friction inwards": model.turn(phi, changes=inward),
        "no tooth friction": model.turn(phi, changes={"contact.tooth_friction_angle_deg": 0.0}),
        f"teeth slide, module {module_mm:g} mm": model.turn(
            phi, {"against": 1.0, **model.locate_contacts(modelled, phi, module_mm * 1e-3)}
        ),
        "cam rubs along the hinge": model.turn(phi, {"along_hinge": 1.0}),
    }
    return [
        Lifted(
            assumption=name,
            support_N=float(abs(turn.totals["F_support"] - modelled.totals["F_support"]).max()),
            joints_N={
                joint: float(abs(turn.joint(joint) - modelled.joint(joint)).max())
                for joint in JOINTS
            },
            largest_N={joint: float(turn.joint(joint).max()) for joint in JOINTS},
            as_modelled_N={joint: float(modelled.joint(joint).max()) for joint in JOINTS},
            motor_work_J=turn.motor_work,
            friction_work_J=turn.friction_loss(speed),
        )
        for name, turn in cases.items()
    ]
