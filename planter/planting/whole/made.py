"""What becomes of an optimum's whole teeth when they are made: their limits, and their price in the objective."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planter.errors import GeometryError
from planter.gear_geometry import cutting
from planter.gear_geometry.cutting import ToothedPair, ToothOrder, cut_teeth
from planter.gear_geometry.gear import Gear
from planter.gear_geometry.pitch_curves import build_stage_pair
from planter.kernels import Array
from planter.optimise.certificate import ActiveConstraint
from planter.planting.toothed import NAMES, SENSES
from planter.planting.whole.lengths import Lengths, name
from planter.planting.whole.results import WholeGear, WholeStage


def stages(lengths: Lengths, x: Array, free: Array, held: list[ActiveConstraint]) -> list[WholeStage]:
    """Every stage that has whole teeth at an optimum x (p,) with its active constraints, beside a free one (p,)."""
    wanted, found = lengths.wanted, []
    slopes = {one.name: one.multiplier * (-1 if one.side == "max" else 1) for one in held}
    misses = lengths.values(x) / lengths.upper - 1
    for k, own, of_free, miss in zip(wanted.stages, lengths.measured(x), lengths.measured(free), misses, strict=True):
        order = ToothOrder(teeth=wanted.teeth[k], module=wanted.modules[k], keep="module")
        made, refused = _made(lengths, k, x, order)
        per_length = slopes.get(name(k), 0.0)
        found.append(
            WholeStage(
                stage=k + 1,
                z=wanted.teeth[k] or 0,
                module_mm=1e3 * (wanted.modules[k] or 0.0),
                pitch_length_mm=1e3 * own,
                length_error=float(miss),
                free_teeth=of_free / wanted.pitch(k),
                price_per_module_mm=per_length * np.pi * (wanted.teeth[k] or 0),
                price_per_tooth=per_length * 1e3 * wanted.pitch(k),
                gears=None if made is None else [_gear(gear) for gear in made.gears],
                contact_ratio_min=None if made is None else float(made.mesh.contact_ratios.min()),
                refused=refused,
            )
        )
    return found


def _made(lengths: Lengths, stage: int, x: Array, order: ToothOrder) -> tuple[ToothedPair | None, str | None]:
    """The teeth of a stage, None where they cannot be made at all, and why not as ordered."""
    device = lengths.device
    pair = build_stage_pair(device.stages[stage], device.of_stage(stage, x), SENSES[stage])
    ways = order, replace(order, process="wire", allow_undercut=True)
    refused = None
    for way in ways:
        try:
            found = cut_teeth(pair, way, f"stage {stage + 1}", NAMES[stage])
            cutting.check_penetration(found.mesh, found.deepest, found.name)
            return found, refused
        except GeometryError as error:
            refused = refused or str(error)
    return None, refused


def _gear(gear: Gear) -> WholeGear:
    return WholeGear(gear.name, gear.z, float(gear.flanks.margins.min()), float(gear.top_lands.min()) * 1e3)
