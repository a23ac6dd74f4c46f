"""Results of intermittent pairs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from planter.errors import GeometryError
from planter.gear_geometry.intermittent_gears import IncompleteGear, IntermittentPair
from planter.gear_geometry.intermittent_proof import FREE_ANGLE, POSITIONS, IncompleteGearCycle, LooseAngles
from planter.gears import results
from planter.gears.parts import GearPart, PartSettings, PlacedGear, check_parts
from planter.gears.request import Teeth
from planter.gears.results import Extent, GearsFound, IncompleteCut, LooseMotion, LooseTurn, Ratio
from planter.kernels import Array
from planter.progress import Listener

OVERLAP_TOLERANCE = 2.5e-10
"""Overlap of touching outlines that rounding may cause, in modules squared."""
_MM = 1e3


def make_intermittent_pair(
    pair: IntermittentPair,
    machine: str,
    teeth: Teeth,
    settings: PartSettings,
    provenance: Mapping[str, Any],
    out: Path | None,
    progress: Listener | None = None,
) -> GearsFound:
    """Return the result of an intermittent pair, and write its files if a folder is given.

    Raises GeometryError if the outlines overlap, InputError for a bore that leaves too thin a rim or a
    folder that cannot be written.
    """
    parts = check_parts(_place_in_dwell(pair), settings)
    turn = IncompleteGearCycle(pair)
    result = GearsFound(
        machine,
        teeth.pressure_angle,
        teeth.addendum,
        teeth.clearance,
        teeth.backlash_mm,
        teeth.centre_error_mm,
        teeth.process.value,
        [],
        None,
        summarise_intermittent_pair(turn, machine, parts, teeth.centre_error_mm / _MM),
        None,
        [],
    )
    if out is None:
        return result
    from planter.gears.report import page as report

    return report.write_intermittent_pair(out, result, turn, parts, provenance, progress)


def summarise_intermittent_pair(
    turn: IncompleteGearCycle, machine: str, parts: Sequence[GearPart], farther: float = 0.0
) -> results.Intermittent:
    """Return the result of a pair and its manufactured gears, whose outlines are intersected over a turn.

    `farther` is an error of the centre distance [m].

    Raises GeometryError if the outlines overlap.
    """
    gears, rolling, ratios = turn.gears, turn.gears.rolling, turn.mesh.contact_ratios
    pressure_angles = np.degrees(turn.mesh.pressure_angles(turn.rolled))
    overlap, dwell_overlap = float(turn.rolling.max()), float(turn.dwell_overlaps.max())
    if max(overlap, dwell_overlap) > OVERLAP_TOLERANCE * gears.gear.rack.module**2:
        where = "over the teeth" if overlap > dwell_overlap else "in the dwell"
        raise GeometryError(
            f"{machine}: the gears overlap by {max(overlap, dwell_overlap) * _MM**2:.3g} mm2 {where}: reduce the "
            f"addendum or add backlash"
        )
    middle = np.argmin(np.abs(turn.loose.at - rolling.over[1] - rolling.dwell / 2))
    return results.Intermittent(
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
        gears=[_summarise_gear(gear, part) for gear, part in zip(gears.gears, parts, strict=True)],
        undriven_deg=_to_degrees(turn.undriven),
        undriven_least_deg=_to_degrees(gears.phase.best_undriven),
        unheld_deg=_to_degrees(turn.unheld),
        slack_deg=_to_degrees((turn.loose.behind[middle], turn.loose.ahead[middle])),
        loose=_summarise_loose(turn.loose),
        farther_loose=_summarise_loose(turn.farther(farther).loose) if farther else None,
        contact_ratio=Ratio(float(ratios.min()), float(ratios.max()), float(ratios.mean())),
        pressure_angle_deg=Extent(float(pressure_angles.min()), float(pressure_angles.max())),
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
        LooseMotion(*(_find_largest(angles[motion.part == part]) for angles in (motion.behind, motion.ahead)))
        for part in range(4)
    )
    return LooseTurn(after, driven, before, dwell)


def _find_largest(angles: Array) -> float | None:
    """Return the largest of the angles (n,) [rad] in deg, or None if nothing limits the motion."""
    largest = float(angles.max())
    return None if largest >= FREE_ANGLE else float(np.degrees(largest))


def _summarise_gear(gear: IncompleteGear, part: GearPart) -> IncompleteCut:
    margins, lands = gear.row.flanks.margins, gear.row.top_lands
    worst, thin = int(np.argmin(margins)), int(np.argmin(lands))
    return IncompleteCut(
        gear.name, gear.z, float(shapely.Polygon(gear.points).area) * _MM**2, float(margins[worst]),
        int(gear.row.flanks.tooth[worst]), float(lands[thin]) * _MM, thin, len(gear.pieces), gear.joins * _MM, part.rim,
    )  # fmt: skip


def _place_in_dwell(pair: IntermittentPair) -> list[PlacedGear]:
    """Return both gears in the middle of the dwell."""
    positions = pair.rolling.dwell_positions(np.array([0.5]))
    return [
        PlacedGear(gear, float(angle), (float(x), float(y)))
        for gear, ((angle,), (x,), (y,)) in zip(pair.gears, positions, strict=True)
    ]
