"""Gears of a planting device: pitch curves at a carrier angle, stages with teeth, the adapter of
`planter gears`.

A point of a gear is named by t, the polar angle of the inner gear's curve (sun, gear 6) at the
contact when it is there. Gears of both sides are identical: the second side rolls on the same sun
as the first, half a cycle behind, and its gears are assembled by the same marks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planter.errors import InputError
from planter.gears.gear_set import GearSet
from planter.gears.geometry import families
from planter.gears.geometry.cutting import ToothedPair, ToothOrder, cut_teeth
from planter.gears.geometry.pitch_curves import build_stage_pair
from planter.gears.parts import PlacedGear
from planter.gears.request import GearOptions
from planter.gears.results import Scaled
from planter.kernels import Array
from planter.numerics.arrays import wrap_angle
from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from planter.papers.planting.requirement_rows import RequirementRows
from planter.papers.planting.requirements import evaluate_requirements
from planter.papers.planting.tooth_friction import compute_friction
from planter.report import files

SAMPLES = 360


@dataclass(frozen=True)
class PlottedPitchCurve:
    """A closed pitch curve: its centre (2,) and its points (2, n), the last one the first again
    [mm].
    """

    name: str
    centre: Array
    points: Array


@dataclass(frozen=True)
class Gearing:
    """Four pitch curves (sun, gear 5, gear 6, planet), centres O, A1, B1 and contacts P, Q, each
    (2,) [mm].
    """

    phi_deg: float
    curves: tuple[PlottedPitchCurve, ...]
    centres: dict[str, Array]
    contacts: dict[str, Array]


def locate_pitch_curves(
    device: Device, x: Array, phi_deg: float = 0.0, samples: int = SAMPLES
) -> Gearing:
    """The pitch curves of side 1 at a carrier angle, for a design x (p,) in SI.

    The first point of each curve is the one in contact.
    """
    phi = float(np.radians(phi_deg))
    side = {name: float(row[0]) for name, row in device.side(x, np.array([phi])).items()}
    a1, a2 = device.centre_distances(x)
    mounting = dict(zip(device.formulas.entries("mounting"), x, strict=False))
    values = side | mounting | {"phi": phi, "a1": a1, "a2": a2}
    centres = {
        "O": np.zeros(2),
        **{name: 1e3 * np.array([side[f"x_{name}"], side[f"y_{name}"]]) for name in ("A1", "B1")},
    }
    curves: list[PlottedPitchCurve] = []
    contacts: dict[str, Array] = {}
    for stage, (names, axes, contact) in enumerate(
        (
            (("sun", "gear 5"), ("O", "A1"), "P"),
            (("gear 6", "planet gear"), ("A1", "B1"), "Q"),
        )
    ):
        t = side[f"t{stage + 1}"] + 2 * np.pi * np.arange(samples + 1) / samples
        points = [1e3 * curve for curve in _compute_points(device, x, stage, values, t)]
        curves += [
            PlottedPitchCurve(name, centres[axis], curve)
            for name, axis, curve in zip(names, axes, points, strict=True)
        ]
        contacts[contact] = points[0][:, 0]
    return Gearing(phi_deg, tuple(curves), centres, contacts)


def _compute_points(
    device: Device, x: Array, stage: int, values: dict[str, float], t: Array
) -> tuple[Array, Array]:
    """Points (2, n) of a stage's inner gear and of its partner that meet at t, whose first is in
    contact [m].
    """
    contact = _evaluate_contact(device, x, stage, t)
    values = values | {f"T{stage + 1}": float(contact["turned"][0])}
    pair = f"pair{stage + 1}"
    names = device.sidecar["functions"][pair]["inputs"]
    point = {"point": np.array([t, contact["r"], contact["turned"]])}
    points = device.formulas(pair, **{name: point.get(name, values.get(name)) for name in names})
    return np.array([points["x_inner"], points["y_inner"]]), np.array(
        [points["x_outer"], points["y_outer"]]
    )


def _evaluate_contact(device: Device, x: Array, stage: int, t: Array) -> dict[str, Array]:
    """Contact of a stage at polar angles (n,) of its inner gear."""
    pair, parameters = device.stages[stage], device.of_stage(stage, x)
    hoisted = pair.prologue(parameters=parameters)["hoisted"]
    return {
        name: row[0]
        for name, row in pair.contact(t=t, parameters=parameters, hoisted=hoisted).items()
    }


NAMES = (("sun", "gear 5"), ("gear 6", "planet gear"))
SENSES = (1, -1)
"""Of the inner gears' polar angles in their own frames: the sun's runs with the carrier, gear 6's
against its shaft.
"""
_TURN = np.linspace(0, 2 * np.pi, 721)


@dataclass(frozen=True)
class PlantingGearTrain:
    """Both stages with teeth, and the design (p,) [SI] that they are of."""

    device: Device
    x: Array
    stages: tuple[ToothedPair, ...]

    def place_gears(self) -> list[PlacedGear]:
        """The four gears of side 1 where they are while the carrier is at 0, each with its shaft's
        mark.

        The marks are the directions of x: the frame's for the sun, the middle body's for gears 5
        and 6, which share a shaft, the nozzle's for the planet gear.
        """
        device, x = self.device, self.x
        side = {name: float(row[0]) for name, row in device.side(x, np.zeros(1)).items()}
        layout = locate_pitch_curves(device, x)
        nozzle = np.arctan2(side["y_tip"] - side["y_B1"], side["x_tip"] - side["x_B1"])
        gears = []
        for k, (stage, axes, contact) in enumerate(
            zip(self.stages, (("O", "A1"), ("A1", "B1")), "PQ", strict=True)
        ):
            t = side[f"t{k + 1}"]
            turned = float(_evaluate_contact(device, x, k, np.array([t]))["turned"][0])
            polar_angles = (SENSES[k] * t, -SENSES[k] * turned)
            marks = (0.0, 0.0) if k == 0 else (0.0, nozzle)
            for gear, axis, polar, mark in zip(stage.gears, axes, polar_angles, marks, strict=True):
                arm = layout.contacts[contact] - layout.centres[axis]
                angle = float(np.arctan2(arm[1], arm[0])) - polar
                x_, y_ = layout.centres[axis] * 1e-3
                gears.append(
                    PlacedGear(gear, angle, (float(x_), float(y_)), float(wrap_angle(mark - angle)))
                )
        return gears

    def change(self) -> Scaled | None:
        """Return the effect of the scaling on the machine, or None if nothing was scaled."""
        if all(stage.sized.scale == 1 for stage in self.stages):
            return None
        paths = [self._tip(x) for x in (self.device.design, self.x)]
        return Scaled(
            design=self.device.named(self.x),
            tip_moved_max_mm=float(np.hypot(*(paths[1] - paths[0])).max()) * 1e3,
            broken_before=_list_broken_requirements(self.device, self.device.design),
            broken=_list_broken_requirements(self.device, self.x),
        )

    def _tip(self, x: Array) -> Array:
        side = self.device.side(x, _TURN)
        return np.array([side["x_tip"], side["y_tip"]])


def cut_gears(source: str, options: GearOptions) -> GearSet:
    """The gears of a device's own design, by the options of a command: modules and teeth of each
    stage.

    Raises InputError for teeth of one stage alone, and as `cut_teeth` does.
    """
    speed = {} if options.speed_rpm is None else {"operation.speed_rpm": options.speed_rpm}
    device = Device(load(source, {**options.changes, **speed}), "exact")
    if len(options.counts) == 1:
        raise InputError(
            f"--teeth {options.counts[0]}: it must be Z1,Z2, the teeth of stage 1 and of stage 2"
        )
    train = cut_gear_train(device, [options.order_pair(k) for k in range(2)])
    return GearSet(
        machine=device.machine.name,
        order=options.order,
        placed=train.place_gears(),
        provenance=files.list_provenance(device.machine),
        pairs=train.stages,
        scaled=train.change(),
        rubbing=compute_friction(device, train.x, train.stages),
    )


def cut_gear_train(
    device: Device, orders: Sequence[ToothOrder], design: Array | None = None
) -> PlantingGearTrain:
    """Both stages of a design (p,) [SI], the device's own unless given, with the teeth that are
    ordered for each.

    Raises as `toothed` does.
    """
    x = (device.design if design is None else design).copy()
    stages = []
    for k, order in enumerate(orders):
        pair = build_stage_pair(device.stages[k], device.of_stage(k, x), SENSES[k])
        toothed_pair = cut_teeth(pair, order, f"{device.machine.source}: stage {k + 1}", NAMES[k])
        stages.append(toothed_pair)
        x[_find_length_indices(device, k)] *= toothed_pair.sized.scale
    return PlantingGearTrain(device, x, tuple(stages))


def _find_length_indices(device: Device, stage: int) -> list[int]:
    """Places of a stage's lengths in the design vector."""
    pair = device.stages[stage]
    entries = families.load_sidecar(pair.family)["parameters"]
    return [
        device.names.index(name)
        for name, entry in zip(pair.names, entries, strict=True)
        if entry["unit"] == "m"
    ]


def _list_broken_requirements(device: Device, x: Array) -> list[str] | None:
    """Names of the requirements that a design (p,) breaks; None if the machine has no
    requirements.
    """
    if device.machine.requirements is None:
        return None
    entries = evaluate_requirements(RequirementRows(device), x)
    return [entry.name for entry in entries if entry.margin < 0]
