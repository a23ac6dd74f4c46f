"""Toothed gears as tables that a person likes to read."""

from __future__ import annotations

from planter.gears import rubbing
from planter.gears.results import (
    FULL_RIM,
    Extent,
    GearsFound,
    Intermittent,
    LooseMotion,
    LooseTurn,
    Ratio,
    Rim,
    StageCut,
)
from planter.terminal.console import Console


def show(console: Console, found: GearsFound) -> None:
    """Every pair, what the scaling does, files."""
    for one in found.stages:
        _stage(console, one, found.centre_error_mm)
    if found.intermittent:
        _intermittent(console, found.intermittent)
    for gear in [*(gear for pair in found.stages for gear in pair.gears),
                 *(found.intermittent.gears if found.intermittent else ())]:  # fmt: skip
        if gear.rim is not None:
            print(f"{gear.name}: {describe_rim(gear.rim)}")
    if found.scaled:
        print(f"scaled to the module, the tip's path moves by up to {found.scaled.tip_moved_max_mm:.4g} mm")
        if found.scaled.broken is not None:
            before, after = (
                ", ".join(names or ()) or "none" for names in (found.scaled.broken_before, found.scaled.broken)
            )
            print(f"requirements broken as designed: {before}; as scaled: {after}")
    if found.friction:
        console.table("Friction of the teeth over a turn", rubbing.HEAD, list(rubbing.rows(found.friction)))
    if found.files:
        print(f"{len(found.files)} files written")


def describe_rim(rim: Rim) -> str:
    """Return the rim of a gear in words, with a warning if it weakens the roots."""
    weak = f", below {FULL_RIM:g}: it weakens the roots (ISO 6336-3)" if rim.tooth_depths < FULL_RIM else ""
    return f"the bore leaves a rim of {rim.thickness_mm:.4g} mm, {rim.tooth_depths:.3g} tooth depths{weak}"


def _stage(console: Console, one: StageCut, centre_error_mm: float) -> None:
    rows = [
        (gear.name, gear.teeth, f"{gear.margin:.4g} ({gear.margin_tooth})", len(gear.undercut),
         f"{gear.top_land_mm:.4g} ({gear.top_land_tooth})", gear.root_radius_min_mm, gear.area_mm2,
         gear.keyway_phase_deg)
        for gear in one.gears
    ]  # fmt: skip
    title = (
        f"Pair {one.stage}: module {one.module_mm:.6g} mm, centre distance {one.centre_distance_mm:.7g} mm, scale "
        f"{one.scale:.6g}"
    )
    head = ("gear", "teeth", "margin (tooth)", "undercut", "top land / mm (tooth)", "root radius / mm", "area / mm2",
            "keyway / deg")  # fmt: skip
    console.table(title, head, rows)
    ratio, angle, gap = one.contact_ratio, one.pressure_angle_deg, one.gap_mm
    console.table("", ("mesh", "least", "largest"), [
        ("contact ratio", ratio.min, ratio.max),
        ("pressure angle / deg", angle.min, angle.max),
        ("error of transmission / rad", None, one.transmission_error_rad),
        ("gap of flanks / mm", gap.min, gap.max),
        ("gap of polygons / mm", one.polygon_gap_mm.min, one.polygon_gap_mm.max),
        ("overlap of polygons / mm2", None, one.overlap_mm2),
        ("penetration of polygons / modules", None, one.penetration_modules),
        *((name, extent.min, extent.max) for name, extent in lost_motions(one)),
    ])  # fmt: skip
    if centre_error_mm and one.farther_contact_ratio is None:
        print(f"with the axes {centre_error_mm:g} mm farther apart the teeth of pair {one.stage} lose contact")


def lost_motions(one: StageCut) -> list[tuple[str, Extent | Ratio]]:
    """Return the lost motion of a pair in words, and what the axes farther apart make of it if teeth still touch."""
    lines = {
        "lost motion, one side / deg": one.lost_motion_deg,
        "lost motion, both sides / deg": one.lost_motion_total_deg,
        "axes farther apart, contact ratio": one.farther_contact_ratio,
        "axes farther apart, lost motion, one side / deg": one.farther_lost_motion_deg,
        "axes farther apart, lost motion, both sides / deg": one.farther_total_deg,
    }
    return [(name, extent) for name, extent in lines.items() if extent is not None]


def _intermittent(console: Console, one: Intermittent) -> None:
    title = f"Incomplete gears: module {one.module_mm:.6g} mm, centre distance {one.centre_distance_mm:.7g} mm"
    rows = [(gear.name, gear.teeth, f"{gear.margin:.4g} ({gear.margin_tooth})",
             f"{gear.top_land_mm:.4g} ({gear.top_land_tooth})", gear.area_mm2) for gear in one.gears]  # fmt: skip
    console.table(title, ("gear", "teeth", "margin (tooth)", "top land / mm (tooth)", "area / mm2"), rows)
    console.table("", ("beside the dwell", "after it", "before it"), beside_the_dwell(one))
    console.table("", ("mesh", "least", "largest"), [
        ("contact ratio", one.contact_ratio.min, one.contact_ratio.max),
        ("pressure angle / deg", one.pressure_angle_deg.min, one.pressure_angle_deg.max),
        ("error of transmission / rad", None, one.transmission_error_rad),
    ])  # fmt: skip
    for title, loose in (("loose motion / deg", one.loose), ("with the axes farther apart", one.farther_loose)):
        if loose is not None:
            console.table("", (title, "behind the law", "ahead of it"), [
                (part, turns.behind_deg, turns.ahead_deg) for part, turns in parts_of(loose)
            ])  # fmt: skip
    console.table("", ("turn", "value"), [
        ("pitches on the toothed arc", one.pitches),
        ("dwell / deg", one.dwell_deg),
        ("radius of the locking arcs / mm", one.locking_radius_mm),
        ("overlap over the teeth / mm2", one.overlap_mm2),
        ("overlap in the dwell / mm2", one.dwell_overlap_mm2),
    ])  # fmt: skip


def parts_of(loose: LooseTurn) -> list[tuple[str, LooseMotion]]:
    """The parts of a turn in words, with what is loose there."""
    return [("after the dwell", loose.after_dwell), ("driven and held back", loose.driven),
            ("before the dwell", loose.before_dwell), ("in the dwell", loose.dwell)]  # fmt: skip


def beside_the_dwell(one: Intermittent) -> list[tuple[str, float, float]]:
    """What there is on both sides of the dwell: in words, after it, before it."""
    return [
        ("pitch radius of the driving gear / mm", *one.end_radii_mm),
        ("horn in the arc / deg", *one.horns_deg),
        ("without drive / deg", *one.undriven_deg),
        ("best phase for this side alone / deg", *one.undriven_least_deg),
        ("without teeth that hold back / deg", *one.unheld_deg),
    ]
