"""Sets of toothed pairs: their results, and the files that are written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from planter.errors import InputError
from planter.files.text import hash_file
from planter.gear_geometry import cutting
from planter.gear_geometry.contacts import Contacts
from planter.gear_geometry.cutting import ToothedPair, cut_teeth
from planter.gear_geometry.gear import Gear
from planter.gears.curves import find_curve_path, load_pair
from planter.gears.friction import FrictionCurves
from planter.gears.options import Keep
from planter.gears.parts import GearPart, PartSettings, PlacedGear, check_parts
from planter.gears.request import Teeth, parse_tooth_counts
from planter.gears.results import Extent, GearCut, GearsFound, Ratio, Scaled, StageCut, Undercut
from planter.kernels import Array
from planter.progress import Listener
from planter.version import __version__


@dataclass(frozen=True)
class GearSet:
    """A set of toothed pairs, its gears in their mounting positions, and the provenance of both."""

    machine: str
    pairs: Sequence[ToothedPair]
    placed: Sequence[PlacedGear]
    scaled: Scaled | None
    provenance: Mapping[str, Any]
    rubbing: FrictionCurves | None = None


def make_gear_set(
    gears: GearSet, teeth: Teeth, settings: PartSettings, out: Path | None, progress: Listener | None = None
) -> GearsFound:
    """Return the result of a set of gears, and write its files if a folder is given.

    Raises InputError for a bore that leaves too thin a rim or a folder that cannot be written, GeometryError if teeth
    overlap.
    """
    parts = check_parts(gears.placed, settings)
    stages = [
        summarise_stage(k + 1, pair, parts[2 * k : 2 * k + 2], 1e-3 * teeth.centre_error_mm)
        for k, pair in enumerate(gears.pairs)
    ]
    result = GearsFound(
        gears.machine, teeth.pressure_angle, teeth.addendum, teeth.clearance, teeth.backlash_mm,
        teeth.centre_error_mm, teeth.process.value, stages, gears.scaled, None,
        gears.rubbing.result if gears.rubbing else None, [],
    )  # fmt: skip
    if out is None:
        return result
    from planter.gears.report.page import write_gear_set

    return write_gear_set(out, result, gears.pairs, parts, gears.rubbing, gears.provenance, progress)


def build_curve_set(
    curve: str, mate: str | None, turns: int, teeth: Teeth, module_mm: float | None, count: str | None,
    keep: Keep | None,
) -> GearSet:  # fmt: skip
    """Build the pair of a curve in a file. Raises InputError for tooth counts that contradict the ratio of the mate."""
    numbers = parse_tooth_counts(count)
    if len(numbers) == 2 and numbers[1] != turns * numbers[0]:
        raise InputError(
            f"--teeth {count}: the mate turns once in {turns} turns of the gear and needs {turns * numbers[0]} teeth "
            f"if the gear has {numbers[0]}"
        )
    order = teeth.order(numbers[0] if numbers else None, module_mm, keep)
    pair = cut_teeth(load_pair(curve, mate, turns), order, curve, ("gear", "mate"))
    return GearSet(Path(curve).stem, [pair], _place_in_mesh(pair), None, _provenance(curve, mate))


def _place_in_mesh(pair: ToothedPair) -> list[PlacedGear]:
    """Return both gears in the position in which the start of the gear's curve is in contact."""
    return [
        PlacedGear(gear, float(angle), (float(x), float(y)))
        for gear, ((angle,), (x,), (y,)) in zip(pair.gears, pair.mesh.places(np.zeros(1)), strict=True)
    ]


def _provenance(*sources: str | None) -> dict[str, Any]:
    provenance: dict[str, Any] = {"planter": __version__}
    for source in sources:
        if source is not None:
            provenance[f"{Path(source).name} sha256"] = hash_file(find_curve_path(source))
    return provenance


_MM = 1e3


def summarise_stage(number: int, pair: ToothedPair, parts: Sequence[GearPart], farther: float = 0.0) -> StageCut:
    """Return the result of a pair with its solved mesh and its two gears as manufactured.

    `farther` is an error of the centre distance [m].

    Raises GeometryError if the polygons of its teeth overlap.
    """
    cutting.check_pair_penetration(pair)
    farther_pair = pair.farther(farther) if farther else None
    return StageCut(
        stage=number,
        z=list(pair.sized.teeth),
        module_mm=pair.sized.module * _MM,
        scale=pair.sized.scale,
        centre_distance_mm=pair.sized.pair.distance * _MM,
        perimeter_mm=[curve.length * _MM for curve in pair.sized.pair.curves],
        gears=[_summarise_gear(gear, part) for gear, part in zip(pair.gears, parts, strict=True)],
        contact_ratio=_summarise_ratio(pair.mesh.contact_ratios),
        pressure_angle_deg=_find_extent(np.degrees(pair.pressure_angles)),
        transmission_error_rad=float(np.abs(pair.contacts.errors).max()),
        gap_mm=_find_extent(pair.gaps * _MM),
        lost_motion_deg=_find_extent(np.degrees(pair.lost_motion)),
        lost_motion_total_deg=_find_extent(np.degrees(pair.lost_motion.sum(axis=1))),
        farther_lost_motion_deg=_find_extent(np.degrees(farther_pair.lost_motion)) if farther_pair else None,
        farther_total_deg=_find_extent(np.degrees(farther_pair.lost_motion.sum(axis=1))) if farther_pair else None,
        farther_contact_ratio=_summarise_ratio(farther_pair.contact_ratios) if farther_pair else None,
        sliding_max_mm=float(Contacts(pair.mesh, pair.mesh.ends).sliding.max()) * _MM,
        penetration_modules=pair.deepest.value / pair.sized.module,
        overlap_mm2=float(pair.overlaps.max()) * _MM**2,
        polygon_gap_mm=_find_extent(pair.polygon_gaps * _MM),
        positions=len(pair.mesh.positions),
    )


def _summarise_gear(gear: Gear, part: GearPart) -> GearCut:
    margins, lands = gear.flanks.margins, gear.top_lands
    weakest, thin = int(np.argmin(margins)), int(np.argmin(lands))
    kappa = cutting.sample_curvature(gear.curve)[1]
    tooth, side = gear.flanks.tooth, gear.flanks.side
    return GearCut(
        name=gear.name,
        teeth=gear.z,
        area_mm2=gear.area * _MM**2,
        margin=float(margins[weakest]),
        margin_tooth=int(tooth[weakest]),
        undercut=[Undercut(int(tooth[k]), int(side[k]), float(margins[k])) for k in np.flatnonzero(margins < 0)],
        top_land_mm=float(lands[thin]) * _MM,
        top_land_tooth=thin,
        root_radius_min_mm=gear.root_radius * _MM,
        curvature_radius_min_mm=_MM / float(kappa.max()),
        hollow_radius_mm=-_MM / float(kappa.min()) if cutting.is_concave(kappa) else None,
        profile_shift=gear.rack.shift,
        keyway_phase_deg=None if part.placed.key is None else float(np.degrees(part.placed.key)),
        rim=part.rim,
    )


def _find_extent(values: Array | tuple[float, float]) -> Extent:
    """Return the smallest and the largest value, ignoring NaN."""
    return Extent(float(np.nanmin(values)), float(np.nanmax(values)))


def _summarise_ratio(values: Array) -> Ratio:
    return Ratio(float(values.min()), float(values.max()), float(values.mean()))
