"""Toothed pairs as results."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planter.gearing.teeth import limits, remedies
from planter.gearing.teeth.contacts import Contacts
from planter.gearing.teeth.gear import Gear
from planter.gearing.teeth.making import Toothed
from planter.gears.parts import Part
from planter.gears.results import Extent, GearCut, Ratio, StageCut, Undercut
from planter.kernels import Array

_MM = 1e3


def stage(number: int, found: Toothed, parts: Sequence[Part], farther: float = 0.0) -> StageCut:
    """Return the result of a pair, its mesh solved, with its two gears as they are made.

    `farther` is an error of the centre distance [m].

    Raises GeometryError where the polygons of its teeth run into each other.
    """
    remedies.check_penetration(found)
    apart = found.farther(farther) if farther else None
    return StageCut(
        stage=number,
        z=list(found.sized.teeth),
        module_mm=found.sized.module * _MM,
        scale=found.sized.scale,
        centre_distance_mm=found.sized.pair.distance * _MM,
        perimeter_mm=[curve.length * _MM for curve in found.sized.pair.curves],
        gears=[_gear(gear, part) for gear, part in zip(found.gears, parts, strict=True)],
        contact_ratio=_ratio(found.mesh.contact_ratios),
        pressure_angle_deg=_extent(np.degrees(found.pressure_angles)),
        transmission_error_rad=float(np.abs(found.contacts.errors).max()),
        gap_mm=_extent(found.gaps * _MM),
        lost_motion_deg=_extent(np.degrees(found.lost_motion)),
        lost_motion_total_deg=_extent(np.degrees(found.lost_motion.sum(axis=1))),
        farther_lost_motion_deg=_extent(np.degrees(apart.lost_motion)) if apart else None,
        farther_total_deg=_extent(np.degrees(apart.lost_motion.sum(axis=1))) if apart else None,
        farther_contact_ratio=_ratio(apart.contact_ratios) if apart else None,
        sliding_max_mm=float(Contacts(found.mesh, found.mesh.ends).sliding.max()) * _MM,
        penetration_modules=found.deepest.value / found.sized.module,
        overlap_mm2=float(found.overlaps.max()) * _MM**2,
        polygon_gap_mm=_extent(found.polygon_gaps * _MM),
        positions=len(found.mesh.positions),
    )


def _gear(gear: Gear, part: Part) -> GearCut:
    margins, lands = gear.flanks.margins, gear.top_lands
    worst, thin = int(np.argmin(margins)), int(np.argmin(lands))
    kappa = limits.bends(gear.curve)[1]
    tooth, side = gear.flanks.tooth, gear.flanks.side
    return GearCut(
        name=gear.name,
        teeth=gear.z,
        area_mm2=gear.area * _MM**2,
        margin=float(margins[worst]),
        margin_tooth=int(tooth[worst]),
        undercut=[Undercut(int(tooth[k]), int(side[k]), float(margins[k])) for k in np.flatnonzero(margins < 0)],
        top_land_mm=float(lands[thin]) * _MM,
        top_land_tooth=thin,
        root_radius_min_mm=gear.root_radius * _MM,
        curvature_radius_min_mm=_MM / float(kappa.max()),
        hollow_radius_mm=-_MM / float(kappa.min()) if limits.hollow(kappa) else None,
        profile_shift=gear.rack.shift,
        keyway_phase_deg=None if part.placed.key is None else float(np.degrees(part.placed.key)),
        rim=part.rim,
    )


def _extent(values: Array | tuple[float, float]) -> Extent:
    """Return the least and the largest value, without those that are NaN."""
    return Extent(float(np.nanmin(values)), float(np.nanmax(values)))


def _ratio(values: Array) -> Ratio:
    return Ratio(float(values.min()), float(values.max()), float(values.mean()))
