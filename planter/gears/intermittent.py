"""Pairs that dwell as results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from planter.errors import GeometryError
from planter.gearing.teeth.incomplete.gear import IncompleteGear
from planter.gearing.teeth.incomplete.locking import Intermittent
from planter.gearing.teeth.incomplete.proof import FREE, POSITIONS, Loose, Turn
from planter.gears import parts, results
from planter.gears.asked import Teeth
from planter.gears.parts import Part, Parts, Placed
from planter.gears.results import Extent, GearsFound, IncompleteCut, LooseMotion, LooseTurn, Ratio
from planter.kernels import Array
from planter.progress import Listener

LARGEST = 2.5e-10
"""Area that rounding may let outlines share which touch, in modules squared."""
_MM = 1e3


def make(
    found: Intermittent, machine: str, teeth: Teeth, made: Parts, provenance: Mapping[str, Any], out: Path | None,
    progress: Listener | None = None,
) -> GearsFound:  # fmt: skip
    """What is found of a pair that dwells; files where a folder is given.

    Raises GeometryError where the outlines run into each other, InputError for a bore that leaves too thin a rim or a
    folder that cannot be written.
    """
    ready = parts.check(_placed(found), made)
    turn = Turn(found)
    told = GearsFound(
        machine, teeth.pressure_angle, teeth.addendum, teeth.clearance, teeth.backlash_mm, teeth.centre_error_mm,
        teeth.process.value, [], None, told_of(turn, machine, ready, teeth.centre_error_mm / _MM), None, [],
    )  # fmt: skip
    if out is None:
        return told
    from planter.gears.report import results as report

    return report.write_dwelling(out, told, turn, ready, provenance, progress)


def told_of(turn: Turn, machine: str, ready: Sequence[Part], farther: float = 0.0) -> results.Intermittent:
    """Return the result of a pair with its gears as they are made, their outlines laid over each other over a turn.

    `farther` is an error of the centre distance [m].

    Raises GeometryError where they overlap.
    """
    found, rolling, ratios = turn.gears, turn.gears.rolling, turn.mesh.contact_ratios
    leaning = np.degrees(turn.mesh.pressure_angles(turn.rolled))
    overlap, held = float(turn.rolling.max()), float(turn.held.max())
    if max(overlap, held) > LARGEST * found.gear.rack.module**2:
        where = "over the teeth" if overlap > held else "in the dwell"
        raise GeometryError(
            f"{machine}: the gears run into each other by {max(overlap, held) * _MM**2:.3g} mm2 {where}: a smaller "
            f"addendum or some play would help"
        )
    middle = np.argmin(np.abs(turn.loose.at - rolling.over[1] - rolling.dwell / 2))
    return results.Intermittent(
        z=found.gear.z,
        pitches=rolling.length / found.gear.rack.pitch,
        module_mm=found.gear.rack.module * _MM,
        centre_distance_mm=rolling.pair.distance * _MM,
        toothed_arc_mm=rolling.length * _MM,
        locking_radius_mm=found.radius * _MM,
        end_radii_mm=(rolling.ends[0] * _MM, rolling.ends[1] * _MM),
        horns_deg=_degrees(tuple(horn.reach for horn in found.phase.horns)),
        apart_mm=found.apart * _MM,
        dwell_deg=float(np.degrees(rolling.dwell)),
        gears=[_gear(gear, part) for gear, part in zip(found.gears, ready, strict=True)],
        undriven_deg=_degrees(turn.undriven),
        undriven_least_deg=_degrees(found.phase.least),
        unheld_deg=_degrees(turn.unheld),
        slack_deg=_degrees((turn.loose.behind[middle], turn.loose.ahead[middle])),
        loose=_loose(turn.loose),
        farther_loose=_loose(turn.farther(farther).loose) if farther else None,
        contact_ratio=Ratio(float(ratios.min()), float(ratios.max()), float(ratios.mean())),
        pressure_angle_deg=Extent(float(leaning.min()), float(leaning.max())),
        transmission_error_rad=float(np.abs(turn.contacts.errors).max()),
        sliding_max_mm=float(turn.contacts.sliding.max()) * _MM,
        overlap_mm2=overlap * _MM**2,
        dwell_overlap_mm2=held * _MM**2,
        positions=POSITIONS,
    )


def _degrees(angles: Sequence[float]) -> tuple[float, float]:
    first, last = np.degrees(angles).tolist()
    return first, last


def _loose(found: Loose) -> LooseTurn:
    after, driven, before, dwell = (
        LooseMotion(*(_most(turns[found.part == part]) for turns in (found.behind, found.ahead))) for part in range(4)
    )
    return LooseTurn(after, driven, before, dwell)


def _most(turns: Array) -> float | None:
    """The largest of some turns in deg, None where nothing stops them."""
    most = float(turns.max())
    return None if most >= FREE else float(np.degrees(most))


def _gear(gear: IncompleteGear, part: Part) -> IncompleteCut:
    margins, lands = gear.row.flanks.margins, gear.row.top_lands
    worst, thin = int(np.argmin(margins)), int(np.argmin(lands))
    return IncompleteCut(
        gear.name, gear.z, float(shapely.Polygon(gear.points).area) * _MM**2, float(margins[worst]),
        int(gear.row.flanks.tooth[worst]), float(lands[thin]) * _MM, thin, len(gear.pieces), gear.joins * _MM, part.rim,
    )  # fmt: skip


def _placed(found: Intermittent) -> list[Placed]:
    """Both gears where they are in the middle of the dwell."""
    where = found.rolling.held(np.array([0.5]))
    return [
        Placed(gear, float(angle), (float(x), float(y)))
        for gear, ((angle,), (x,), (y,)) in zip(found.gears, where, strict=True)
    ]
