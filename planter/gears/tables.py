"""Tables of toothed gears for the terminal."""

from __future__ import annotations

from planter.gears import friction
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


def show(console: Console, result: GearsFound) -> None:
    """Print every pair, the effect of scaling, friction and the number of files."""
    for stage in result.stages:
        _show_stage(console, stage, result.centre_error_mm)
    if result.intermittent:
        _show_intermittent(console, result.intermittent)
    for gear in [*(gear for pair in result.stages for gear in pair.gears),
                 *(result.intermittent.gears if result.intermittent else ())]:  # fmt: skip
        if gear.rim is not None:
            print(f"{gear.name}: {describe_rim(gear.rim)}")
    if result.scaled:
        print(f"scaled to the module, the tip's path moves by up to {result.scaled.tip_moved_max_mm:.4g} mm")
        if result.scaled.broken is not None:
            before, after = (
                ", ".join(names or ()) or "none" for names in (result.scaled.broken_before, result.scaled.broken)
            )
            print(f"requirements broken as designed: {before}; as scaled: {after}")
    if result.friction:
        console.table(
            "Friction of the teeth over a turn", friction.HEAD, list(friction.tabulate_friction(result.friction))
        )
    if result.files:
        print(f"{len(result.files)} files written")


def describe_rim(rim: Rim) -> str:
    """Return the rim of a gear in words, with a warning if it weakens the roots."""
    weak = f", below {FULL_RIM:g}: it weakens the roots (ISO 6336-3)" if rim.tooth_depths < FULL_RIM else ""
    return f"the bore leaves a rim of {rim.thickness_mm:.4g} mm, {rim.tooth_depths:.3g} tooth depths{weak}"


def _show_stage(console: Console, stage: StageCut, centre_error_mm: float) -> None:
    rows = [
        (gear.name, gear.teeth, f"{gear.margin:.4g} ({gear.margin_tooth})", len(gear.undercut),
         f"{gear.top_land_mm:.4g} ({gear.top_land_tooth})", gear.root_radius_min_mm, gear.area_mm2,
         gear.keyway_phase_deg)
        for gear in stage.gears
    ]  # fmt: skip
    title = (
        f"Pair {stage.stage}: module {stage.module_mm:.6g} mm, centre distance {stage.centre_distance_mm:.7g} mm, "
        f"scale {stage.scale:.6g}"
    )
    head = ("gear", "teeth", "margin (tooth)", "undercut", "top land / mm (tooth)", "root radius / mm", "area / mm2",
            "keyway / deg")  # fmt: skip
    console.table(title, head, rows)
    ratio, angle, gap = stage.contact_ratio, stage.pressure_angle_deg, stage.gap_mm
    console.table("", ("mesh", "least", "largest"), [
        ("contact ratio", ratio.min, ratio.max),
        ("pressure angle / deg", angle.min, angle.max),
        ("error of transmission / rad", None, stage.transmission_error_rad),
        ("gap of flanks / mm", gap.min, gap.max),
        ("gap of polygons / mm", stage.polygon_gap_mm.min, stage.polygon_gap_mm.max),
        ("overlap of polygons / mm2", None, stage.overlap_mm2),
        ("penetration of polygons / modules", None, stage.penetration_modules),
        *((name, extent.min, extent.max) for name, extent in list_lost_motions(stage)),
    ])  # fmt: skip
    if centre_error_mm and stage.farther_contact_ratio is None:
        print(f"with the axes {centre_error_mm:g} mm farther apart the teeth of pair {stage.stage} lose contact")


def list_lost_motions(stage: StageCut) -> list[tuple[str, Extent | Ratio]]:
    """Return the labelled lost motions of a pair, also with the axes farther apart if the teeth still touch."""
    lines = {
        "lost motion, one side / deg": stage.lost_motion_deg,
        "lost motion, both sides / deg": stage.lost_motion_total_deg,
        "axes farther apart, contact ratio": stage.farther_contact_ratio,
        "axes farther apart, lost motion, one side / deg": stage.farther_lost_motion_deg,
        "axes farther apart, lost motion, both sides / deg": stage.farther_total_deg,
    }
    return [(name, extent) for name, extent in lines.items() if extent is not None]


def _show_intermittent(console: Console, pair: Intermittent) -> None:
    title = f"Incomplete gears: module {pair.module_mm:.6g} mm, centre distance {pair.centre_distance_mm:.7g} mm"
    rows = [(gear.name, gear.teeth, f"{gear.margin:.4g} ({gear.margin_tooth})",
             f"{gear.top_land_mm:.4g} ({gear.top_land_tooth})", gear.area_mm2) for gear in pair.gears]  # fmt: skip
    console.table(title, ("gear", "teeth", "margin (tooth)", "top land / mm (tooth)", "area / mm2"), rows)
    console.table("", ("ends of the dwell", "after it", "before it"), tabulate_dwell_ends(pair))
    console.table("", ("mesh", "least", "largest"), [
        ("contact ratio", pair.contact_ratio.min, pair.contact_ratio.max),
        ("pressure angle / deg", pair.pressure_angle_deg.min, pair.pressure_angle_deg.max),
        ("error of transmission / rad", None, pair.transmission_error_rad),
    ])  # fmt: skip
    for title, motions in (("loose motion / deg", pair.loose), ("with the axes farther apart", pair.farther_loose)):
        if motions is not None:
            console.table("", (title, "behind the law", "ahead of it"), [
                (part, motion.behind_deg, motion.ahead_deg) for part, motion in list_loose_motions(motions)
            ])  # fmt: skip
    console.table("", ("turn", "value"), [
        ("pitches on the toothed arc", pair.pitches),
        ("dwell / deg", pair.dwell_deg),
        ("radius of the locking arcs / mm", pair.locking_radius_mm),
        ("overlap over the teeth / mm2", pair.overlap_mm2),
        ("overlap in the dwell / mm2", pair.dwell_overlap_mm2),
    ])  # fmt: skip


def list_loose_motions(motions: LooseTurn) -> list[tuple[str, LooseMotion]]:
    """Return the labelled parts of a turn with their loose motion."""
    return [("after the dwell", motions.after_dwell), ("driven and braked", motions.driven),
            ("before the dwell", motions.before_dwell), ("in the dwell", motions.dwell)]  # fmt: skip


def tabulate_dwell_ends(pair: Intermittent) -> list[tuple[str, float, float]]:
    """Return rows (label, value after the dwell, value before it)."""
    return [
        ("pitch radius of the driving gear / mm", *pair.end_radii_mm),
        ("horn in the arc / deg", *pair.horns_deg),
        ("without drive / deg", *pair.undriven_deg),
        ("best phase for this side only / deg", *pair.undriven_least_deg),
        ("without braking flanks / deg", *pair.unheld_deg),
    ]
