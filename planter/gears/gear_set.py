"""Results of toothed pairs, with teeth all round or on part of the turn, and the files that are
written.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from planter import text_files
from planter.errors import GeometryError, InputError
from planter.files import examples
from planter.files.examples import load_part
from planter.gears.geometry import cutting
from planter.gears.geometry.contacts import Contacts
from planter.gears.geometry.cutting import ToothedPair, ToothOrder, cut_teeth
from planter.gears.geometry.gear import Gear
from planter.gears.geometry.intermittent_gears import IncompleteGear, IntermittentPair
from planter.gears.geometry.intermittent_proof import (
    FREE_ANGLE,
    POSITIONS,
    IncompleteGearCycle,
    LooseAngles,
)
from planter.gears.parts import GearPart, PartSettings, PlacedGear, check_parts
from planter.gears.request import GearOptions, GearTurns, find_curve_path, load_pair
from planter.gears.results import (
    FrictionCurves,
    GearCut,
    GearsFound,
    IncompleteCut,
    Intermittent,
    LooseMotion,
    LooseTurn,
    PartExtent,
    Ratio,
    Scaled,
    StageCut,
    Undercut,
)
from planter.kernels import Array
from planter.progress import Listener
from planter.text_files import hash_file
from planter.version import __version__


@dataclass(frozen=True)
class GearSet:
    """Toothed pairs of a machine cut by an order, or an intermittent pair; its gears in their
    mounting positions, and the provenance of both.
    """

    machine: str
    order: ToothOrder
    placed: Sequence[PlacedGear]
    provenance: Mapping[str, Any]
    pairs: Sequence[ToothedPair] = ()
    intermittent: IntermittentPair | None = None
    scaled: Scaled | None = None
    rubbing: FrictionCurves | None = None


def cut_machine(source: str, options: GearOptions) -> GearSet:
    """Return the gears of a machine file or built-in name.

    The package of its kind brings a module `toothed` with a function `cut_gears` of the same
    arguments. Raises InputError if it has none, for an invalid file or option, GeometryError for
    gears that cannot be cut.
    """
    module: Any = load_part(source, "toothed")
    if module is not None:
        return module.cut_gears(source, options)
    text_files.parse_toml(examples.read_source(source), source)
    names = [name for name in examples.list_examples(suffix=".toml") if load_part(name, "toothed")]
    raise InputError(
        f"{source}: `planter gears` does not cut gears of this machine; use one like "
        f"{', '.join(names)}"
    )


def cut_curve(curve: str, mate: str | None, turns: GearTurns, options: GearOptions) -> GearSet:
    """Return the pair of a curve in a file, the faster gear first.

    Raises InputError for tooth counts that contradict the ratio of the mate.
    """
    counts = options.counts
    place = f"--teeth {','.join(map(str, counts))}"
    if counts and counts[0] * turns.gear % turns.mate:
        raise InputError(
            f"{place}: the mate turns {turns.mate} times in a turn of the gear, whose teeth must "
            f"be a multiple of {turns.mate}"
        )
    if len(counts) == 2 and counts[1] * turns.mate != turns.gear * counts[0]:
        raise InputError(
            f"{place}: the mate turns {turns.mate} times in {turns.gear} turns of the gear and "
            f"needs {turns.gear * counts[0] // turns.mate} teeth if the gear has {counts[0]}"
        )
    # the faster gear comes first: with several turns of the mate that is the mate
    first = tuple(count // turns.mate for count in counts)
    names = ("gear", "mate") if turns.mate == 1 else ("mate", "gear")
    order = replace(options, counts=first).order_pair(0)
    pair = cut_teeth(load_pair(curve, mate, turns), order, curve, names)
    provenance: dict[str, Any] = {"planter": __version__}
    for source in (curve, mate):
        if source is not None:
            provenance[f"{Path(source).name} sha256"] = hash_file(find_curve_path(source))
    placed = place_gears(pair.gears, pair.mesh.places(np.zeros(1)))
    return GearSet(Path(curve).stem, options.order, placed, provenance, [pair])


def make_gears(
    gears: GearSet,
    settings: PartSettings,
    farther: float = 0.0,
    out: Path | None = None,
    progress: Listener | None = None,
) -> GearsFound:
    """Return the result of a set of gears, and write its files if a folder is given.

    `farther` is an error of the centre distance [m]. Raises InputError for a bore that leaves too
    thin a rim or a folder that cannot be written, GeometryError if teeth overlap.
    """
    parts, order = check_parts(gears.placed, settings), gears.order
    stages = [
        summarise_stage(k + 1, pair, parts[2 * k : 2 * k + 2], farther)
        for k, pair in enumerate(gears.pairs)
    ]
    cycle = IncompleteGearCycle(gears.intermittent) if gears.intermittent else None
    result = GearsFound(
        machine=gears.machine,
        pressure_angle_deg=float(np.degrees(order.pressure_angle)),
        addendum=order.addendum,
        clearance=order.clearance,
        backlash_mm=order.play * _MM,
        centre_error_mm=farther * _MM,
        process=str(order.process),
        stages=stages,
        scaled=gears.scaled,
        intermittent=summarise_intermittent_pair(cycle, gears.machine, farther) if cycle else None,
        friction=gears.rubbing.result if gears.rubbing else None,
        files=[],
    )
    if out is None:
        return result
    from planter.gears import figures
    from planter.gears.presentation import write_gears

    if cycle:
        plots = figures.build_dwell_figures(cycle, gears.placed)
        scenes = [figures.build_dwell_scene(cycle)]
    else:
        plots = figures.build_figures(gears.pairs, gears.placed, gears.rubbing)
        scenes = [figures.build_scene(pair) for pair in gears.pairs]
    return write_gears(out, result, parts, gears.provenance, plots, scenes, gears.rubbing, progress)


def place_gears(gears: Sequence[Gear], positions: Sequence[Array]) -> list[PlacedGear]:
    """Return both gears at their positions (3, 1): angle [rad] and axis [m]."""
    return [
        PlacedGear(gear, float(angle), (float(x), float(y)))
        for gear, ((angle,), (x,), (y,)) in zip(gears, positions, strict=True)
    ]


_MM = 1e3


def summarise_stage(
    number: int, pair: ToothedPair, parts: Sequence[GearPart], farther: float = 0.0
) -> StageCut:
    """Return the result of a pair with its solved mesh and its two gears as manufactured.

    `farther` is an error of the centre distance [m].

    Raises GeometryError if the polygons of its teeth overlap.
    """
    cutting.check_pair_penetration(pair)
    lost, wider = pair.lost_motion, pair.farther(farther) if farther else None
    farther_lost = wider.lost_motion if wider else None
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
        lost_motion_deg=_find_extent(np.degrees(lost)),
        lost_motion_total_deg=_find_extent(np.degrees(lost.sum(axis=1))),
        farther_lost_motion_deg=None
        if farther_lost is None
        else _find_extent(np.degrees(farther_lost)),
        farther_total_deg=None
        if farther_lost is None
        else _find_extent(np.degrees(farther_lost.sum(axis=1))),
        farther_contact_ratio=_summarise_ratio(wider.contact_ratios) if wider else None,
        sliding_max_mm=float(Contacts(pair.mesh, pair.mesh.ends).sliding.max()) * _MM,
        penetration_modules=pair.deepest.value / pair.sized.module,
        overlap_mm2=float(pair.overlaps.max()) * _MM**2,
        polygon_gap_mm=_find_extent(pair.polygon_gaps * _MM),
        positions=len(pair.mesh.positions),
    )


def _summarise_gear(gear: Gear, part: GearPart) -> GearCut:
    kappa = cutting.sample_curvature(gear.curve)[1]
    margins, tooth, side = gear.flanks.margins, gear.flanks.tooth, gear.flanks.side
    return GearCut(
        **_find_least(gear),
        name=gear.name,
        teeth=gear.z,
        area_mm2=gear.area * _MM**2,
        undercut=[
            Undercut(int(tooth[k]), int(side[k]), float(margins[k]))
            for k in np.flatnonzero(margins < 0)
        ],
        root_radius_min_mm=gear.root_radius * _MM,
        curvature_radius_min_mm=_MM / float(kappa.max()),
        hollow_radius_mm=-_MM / float(kappa.min()) if cutting.is_concave(kappa) else None,
        profile_shift=gear.rack.shift,
        keyway_phase_deg=None if part.placed.key is None else float(np.degrees(part.placed.key)),
    )


def _find_least(gear: Gear) -> dict[str, Any]:
    """Return the least margin against undercut and the least top land, each with its tooth."""
    margins, lands = gear.flanks.margins, gear.top_lands
    weakest, thin = int(np.argmin(margins)), int(np.argmin(lands))
    return {
        "margin": float(margins[weakest]),
        "margin_tooth": int(gear.flanks.tooth[weakest]),
        "top_land_mm": float(lands[thin]) * _MM,
        "top_land_tooth": thin,
    }


def _find_extent(values: Array | tuple[float, float]) -> PartExtent:
    """Return the smallest and the largest value, ignoring NaN."""
    return PartExtent(float(np.nanmin(values)), float(np.nanmax(values)))


def _summarise_ratio(values: Array) -> Ratio:
    return Ratio(float(values.min()), float(values.max()), float(values.mean()))


OVERLAP_TOLERANCE = 2.5e-10
"""Overlap of touching outlines that rounding may cause, in modules squared."""


def summarise_intermittent_pair(
    turn: IncompleteGearCycle, machine: str, farther: float = 0.0
) -> Intermittent:
    """Return the result of a pair, whose outlines are intersected over a turn.

    `farther` is an error of the centre distance [m].

    Raises GeometryError if the outlines overlap.
    """
    gears, rolling = turn.gears, turn.gears.rolling
    pressure_angles = np.degrees(turn.mesh.pressure_angles(turn.rolled))
    overlap, dwell_overlap = float(turn.rolling.max()), float(turn.dwell_overlaps.max())
    if max(overlap, dwell_overlap) > OVERLAP_TOLERANCE * gears.gear.rack.module**2:
        where = "over the teeth" if overlap > dwell_overlap else "in the dwell"
        raise GeometryError(
            f"{machine}: the gears overlap by {max(overlap, dwell_overlap) * _MM**2:.3g} mm2 "
            f"{where}: reduce the "
            f"addendum or add backlash"
        )
    middle = np.argmin(np.abs(turn.loose.at - rolling.over[1] - rolling.dwell / 2))
    return Intermittent(
        z=gears.gear.z,
        pitches=rolling.length / gears.gear.rack.pitch,
        module_mm=gears.gear.rack.module * _MM,
        centre_distance_mm=rolling.pair.distance * _MM,
        toothed_arc_mm=rolling.length * _MM,
        locking_radius_mm=gears.radius * _MM,
        end_radii_mm=(rolling.ends[0] * _MM, rolling.ends[1] * _MM),
        horns_deg=_to_degrees(tuple(horn.reach for horn in gears.phase.horns)),
        apart_mm=gears.arc_clearance * _MM,
        dwell_deg=float(np.degrees(rolling.dwell)),
        gears=[_summarise_incomplete_gear(gear) for gear in gears.gears],
        undriven_deg=_to_degrees(turn.undriven),
        undriven_least_deg=_to_degrees(gears.phase.best_undriven),
        unheld_deg=_to_degrees(turn.unheld),
        slack_deg=_to_degrees((turn.loose.behind[middle], turn.loose.ahead[middle])),
        loose=_summarise_loose(turn.loose),
        farther_loose=_summarise_loose(turn.farther(farther).loose) if farther else None,
        contact_ratio=_summarise_ratio(turn.mesh.contact_ratios),
        pressure_angle_deg=_find_extent(pressure_angles),
        transmission_error_rad=float(np.abs(turn.contacts.errors).max()),
        sliding_max_mm=float(turn.contacts.sliding.max()) * _MM,
        overlap_mm2=overlap * _MM**2,
        dwell_overlap_mm2=dwell_overlap * _MM**2,
        positions=POSITIONS,
    )


def _to_degrees(angles: Sequence[float]) -> tuple[float, float]:
    first, last = np.degrees(angles).tolist()
    return first, last


def _summarise_loose(motion: LooseAngles) -> LooseTurn:
    after, driven, before, dwell = (
        LooseMotion(
            *(
                _find_largest(angles[motion.part == part])
                for angles in (motion.behind, motion.ahead)
            )
        )
        for part in range(4)
    )
    return LooseTurn(after, driven, before, dwell)


def _find_largest(angles: Array) -> float | None:
    """Return the largest of the angles (n,) [rad] in deg, or None if nothing limits the motion."""
    largest = float(angles.max())
    return None if largest >= FREE_ANGLE else float(np.degrees(largest))


def _summarise_incomplete_gear(gear: IncompleteGear) -> IncompleteCut:
    return IncompleteCut(
        **_find_least(gear),
        name=gear.name,
        teeth=gear.z,
        area_mm2=float(shapely.Polygon(gear.points).area) * _MM**2,
        pieces=len(gear.trimmed),
        joins_mm=gear.joins * _MM,
    )
