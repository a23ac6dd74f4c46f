"""The toothed gears of a planting device: both stages, as designed or scaled to standard modules, in their places.

Gears of both sides are identical: the second side rolls on the same sun as the first, half a turn behind, and its
gears are put together by the same marks.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planter.errors import InputError
from planter.gear_geometry import families
from planter.gear_geometry.cutting import ToothedPair, ToothOrder, cut_teeth
from planter.gear_geometry.pitch_curves import build_stage_pair
from planter.gears.gear_set import GearSet
from planter.gears.options import Keep
from planter.gears.parts import PlacedGear
from planter.gears.request import Teeth
from planter.gears.results import Scaled
from planter.kernels import Array
from planter.numerics.arrays import wrap_angle
from planter.planting.friction.summary import rubbing
from planter.planting.model import Device
from planter.planting.report.gearing import gearing
from planter.planting.requirements.measures import Measures
from planter.planting.requirements.record import record
from planter.report import files

NAMES = (("sun", "gear 5"), ("gear 6", "planet gear"))
SENSES = (1, -1)
"""Of the inner gears' polar angles in their own frames: the sun's runs with the carrier, gear 6's against its shaft."""
_TURN = np.linspace(0, 2 * np.pi, 721)


@dataclass(frozen=True)
class Train:
    """Both stages with teeth, and the design (p,) [SI] that they are of."""

    device: Device
    x: Array
    stages: tuple[ToothedPair, ...]

    @property
    def scaled(self) -> bool:
        return any(stage.sized.scale != 1 for stage in self.stages)

    def placed(self) -> list[PlacedGear]:
        """The four gears of side 1 where they are while the carrier is at 0, each with its shaft's mark.

        The marks are the directions of x: the frame's for the sun, the middle body's for gears 5 and 6, which share a
        shaft, the nozzle's for the planet gear.
        """
        device, x = self.device, self.x
        side = {name: float(row[0]) for name, row in device.side(x, np.zeros(1)).items()}
        at = gearing(device, x)
        nozzle = np.arctan2(side["y_tip"] - side["y_B1"], side["x_tip"] - side["x_B1"])
        found = []
        for k, (stage, axes, contact) in enumerate(zip(self.stages, (("O", "A1"), ("A1", "B1")), "PQ", strict=True)):
            own = SENSES[k] * side[f"t{k + 1}"], -SENSES[k] * self._turned(k, side[f"t{k + 1}"])
            marks = (0.0, 0.0) if k == 0 else (0.0, nozzle)
            for gear, axis, polar, mark in zip(stage.gears, axes, own, marks, strict=True):
                arm = at.contacts[contact] - at.centres[axis]
                angle = float(np.arctan2(arm[1], arm[0])) - polar
                x_, y_ = at.centres[axis] * 1e-3
                found.append(PlacedGear(gear, angle, (float(x_), float(y_)), float(wrap_angle(mark - angle))))
        return found

    def _turned(self, stage: int, t: float) -> float:
        """How far the mate of a stage has turned where the inner gear is in contact at t."""
        pair, parameters = self.device.stages[stage], self.device.of_stage(stage, self.x)
        hoisted = pair.prologue(parameters=parameters)["hoisted"]
        return float(pair.contact(t=np.array([t]), parameters=parameters, hoisted=hoisted)["turned"][0, 0])

    def change(self) -> Scaled | None:
        """What the scaling does to the machine; None where nothing was scaled."""
        if not self.scaled:
            return None
        paths = [self._tip(x) for x in (self.device.design, self.x)]
        return Scaled(
            design=self.device.named(self.x),
            tip_moved_max_mm=float(np.hypot(*(paths[1] - paths[0])).max()) * 1e3,
            broken_before=_broken(self.device, self.device.design),
            broken=_broken(self.device, self.x),
        )

    def _tip(self, x: Array) -> Array:
        side = self.device.side(x, _TURN)
        return np.array([side["x_tip"], side["y_tip"]])


def gears(
    device: Device, teeth: Teeth, modules_mm: Sequence[float | None], counts: Sequence[int], keep: Keep | None
) -> GearSet:
    """The gears of a device's own design, by the options of a command: modules and teeth of each stage.

    Raises InputError for teeth of one stage alone, and as `toothed` does.
    """
    if len(counts) == 1:
        raise InputError(f"--teeth {counts[0]} is not allowed: it must be Z1,Z2, the teeth of stage 1 and of stage 2")
    orders = [teeth.order(counts[k] if counts else None, module, keep) for k, module in enumerate(modules_mm)]
    made = train(device, orders)
    told = files.provenance(device.machine)
    friction = rubbing(device, made.x, made.stages)
    return GearSet(device.machine.name, made.stages, made.placed(), made.change(), told, friction)


def train(device: Device, orders: Sequence[ToothOrder], design: Array | None = None) -> Train:
    """Both stages of a design (p,) [SI], the device's own unless given, with the teeth that are ordered for each.

    Raises as `toothed` does.
    """
    x = (device.design if design is None else design).copy()
    stages = []
    for k, order in enumerate(orders):
        pair = build_stage_pair(device.stages[k], device.of_stage(k, x), SENSES[k])
        found = cut_teeth(pair, order, f"{device.machine.source}: stage {k + 1}", NAMES[k])
        stages.append(found)
        x[_lengths(device, k)] *= found.sized.scale
    return Train(device, x, tuple(stages))


def _lengths(device: Device, stage: int) -> list[int]:
    """Places of a stage's lengths in the design vector."""
    own = device.stages[stage]
    entries = families.load_sidecar(own.family)["parameters"]
    return [device.names.index(name) for name, entry in zip(own.names, entries, strict=True) if entry["unit"] == "m"]


def _broken(device: Device, x: Array) -> list[str] | None:
    """Names of the requirements that a design (p,) breaks; None where its machine has none."""
    if device.machine.requirements is None:
        return None
    return list(_names(device, x))


def _names(device: Device, x: Array) -> Iterator[str]:
    for entry in record(Measures(device), x):
        if entry.margin < 0:
            yield entry.name
