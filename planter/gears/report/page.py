"""The page and the files of a set of toothed gears."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.gear_geometry.cutting import ToothedPair
from planter.gear_geometry.intermittent_proof import IncompleteGearCycle
from planter.gear_geometry.pitch_curves import RACK
from planter.gears import tables
from planter.gears.friction import HEAD, FrictionCurves, tabulate_friction
from planter.gears.parts import GearPart, build_part_files
from planter.gears.report import dwelling, figures
from planter.gears.results import Friction, GearCut, GearsFound, IncompleteCut, Intermittent, StageCut
from planter.progress import Listener
from planter.report import bundle, files
from planter.report.folder import renews
from planter.report.html import Block, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import provenance_section
from planter.view.animation import Motion
from planter.view.scene import Scene

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAPTIONS = {
    "assembly": "All gears in their mounting positions, pitch curves dashed.",
    "mesh": "Teeth about the pitch point at four positions of a period, with their contacts.",
    "teeth": "Contact ratio of every pair of teeth; margin against undercut of both flanks and top land of each tooth.",
    "play": "Lost motion of the mate to either side and of both, the gap of the outlines as polygons, and the error of "
    "transmission at every contact, without play.",
    "dwell": "Locking arcs and the adjacent teeth, about the line of centres.",
    "loose": "How many flanks touch over a turn, and how far the driven gear can turn from its law, the "
    "driving gear fixed: behind the law and ahead of it.",
    "lands": "Margin against undercut of both flanks and top land of each tooth, as the rack leaves them.",
    "friction": "What friction of the teeth adds over a turn to the forces in the joints, to the motor's torque M_L "
    "and to the power lost at both meshes of side 1: by the paper's convention, and against the sliding.",
}


def format_page(
    result: GearsFound, svgs: Mapping[str, str], provenance: Mapping[str, Any], moving: Sequence[Block] = ()
) -> str:
    """Return the page: gears, mesh, motion, figures and the assumptions of the geometry."""
    parts = [Section("Rack", list(_describe_rack(result)))]
    error = result.centre_error_mm
    parts += [
        Section(f"Pair {pair.stage}: {pair.gears[0].name} and {pair.gears[1].name}", list(_describe_stage(pair, error)))
        for pair in result.stages
    ]
    if result.intermittent:
        parts += _describe_dwell(result.intermittent)
    if result.scaled:
        parts.append(Section("What the scaling does", list(_describe_scaling(result))))
    if result.friction:
        parts.append(Section("Friction of the teeth", list(_describe_friction(result.friction))))
    figures = [FigureSvg(svg, CAPTIONS[name.rpartition("_")[2]]) for name, svg in svgs.items()]
    parts += [
        *([Section("Motion", moving)] if moving else []),
        Section("Figures", figures),
        Section("Geometry", [Text("The geometry assumes:"), Items(RACK.sidecar["assumptions"])]),
        provenance_section(provenance),
    ]
    return page(f"Gears of {result.machine}", parts)


def _describe_rack(result: GearsFound) -> Iterator[Block]:
    keys = ("pressure_angle_deg", "addendum", "clearance", "backlash_mm", "centre_error_mm", "process")
    yield Keys({key: getattr(result, key) for key in keys})


def _describe_stage(stage: StageCut, centre_error_mm: float) -> Iterator[Block]:
    yield Keys({
        "teeth": ", ".join(map(str, stage.z)),
        **{key: getattr(stage, key) for key in ("module_mm", "scale", "centre_distance_mm")},
        "contact ratio, least": stage.contact_ratio.min,
        "contact ratio, mean": stage.contact_ratio.mean,
        "pressure angle, least / deg": stage.pressure_angle_deg.min,
        "pressure angle, largest / deg": stage.pressure_angle_deg.max,
        "error of transmission / rad": stage.transmission_error_rad,
        "gap of flanks, least / mm": stage.gap_mm.min,
        "gap of polygons, least / mm": stage.polygon_gap_mm.min,
        "overlap of polygons / mm2": stage.overlap_mm2,
        "penetration of polygons / modules": stage.penetration_modules,
        "sliding per rotation rate, largest / mm": stage.sliding_max_mm,
    })  # fmt: skip
    yield Table(
        ("", "least", "largest"),
        [(name, extent.min, extent.max) for name, extent in tables.list_lost_motions(stage)],
        "Lost motion: turn of the second gear, the first gear fixed, from the central position to contact on "
        "one side, and from contact on one side to contact on the other",
    )
    if centre_error_mm and stage.farther_contact_ratio is None:
        yield Text(f"With the axes {centre_error_mm:g} mm farther apart the teeth lose contact.")
    keys = ("name", "teeth", "area_mm2", "margin", "top_land_mm", "root_radius_min_mm", "keyway_phase_deg")
    head = ("gear", "teeth", "area / mm2", "margin", "top land / mm", "root radius / mm", "keyway / deg")
    yield Table(head, [tuple(getattr(gear, key) for key in keys) for gear in stage.gears])
    yield from _describe_rims(stage.gears)
    undercut: Sequence[tuple[Any, ...]] = [
        (gear.name, flank.tooth, flank.flank, flank.margin) for gear in stage.gears for flank in gear.undercut
    ]
    if undercut:
        yield Table(("gear", "tooth", "flank", "margin"), undercut, "Undercut flanks")


def _describe_rims(gears: Sequence[GearCut] | Sequence[IncompleteCut]) -> Iterator[Block]:
    for gear in gears:
        if gear.rim is not None:
            yield Text(f"{gear.name}: {tables.describe_rim(gear.rim)}.")


def _describe_dwell(pair: Intermittent) -> Iterator[Section]:
    first, second = pair.gears
    yield Section(f"Pair: {first.name} and {second.name}", [
        Keys({
            "teeth": f"{pair.z} on {pair.pitches:.6g} pitches",
            **{key: getattr(pair, key) for key in ("module_mm", "centre_distance_mm", "toothed_arc_mm")},
            "contact ratio, least": pair.contact_ratio.min,
            "contact ratio, mean": pair.contact_ratio.mean,
            "pressure angle, least / deg": pair.pressure_angle_deg.min,
            "pressure angle, largest / deg": pair.pressure_angle_deg.max,
            "error of transmission / rad": pair.transmission_error_rad,
            "sliding per rotation rate, largest / mm": pair.sliding_max_mm,
            "overlap of polygons over the teeth / mm2": pair.overlap_mm2,
            "overlap of polygons in the dwell / mm2": pair.dwell_overlap_mm2,
        }),
        Table(("gear", "teeth", "area / mm2", "margin", "top land / mm"),
              [(gear.name, gear.teeth, gear.area_mm2, gear.margin, gear.top_land_mm) for gear in pair.gears]),
        *_describe_rims(pair.gears),
    ])  # fmt: skip
    yield Section("Dwell", [
        Text(
            f"While the {second.name} rests, over {pair.dwell_deg:.4g} deg of the {first.name}, locking arcs "
            f"hold it: of {pair.locking_radius_mm:.5g} mm in radius, {pair.apart_mm:.3g} mm apart. They remove "
            "teeth next to the dwell; the phase of the teeth minimises the angle without drive."
        ),
        Table(("", "after the dwell", "before it"), tables.tabulate_dwell_ends(pair)),
        Table(("loose motion", "behind the law / deg", "ahead of it / deg"),
              [(part, turns.behind_deg, turns.ahead_deg) for part, turns in tables.list_loose_motions(pair.loose)],
              "How far the driven gear can turn, the driving gear fixed; a dash if nothing limits it"),
    ])  # fmt: skip


def _describe_friction(friction: Friction) -> Iterator[Block]:
    yield Text(
        f"Angle of friction {friction.friction_angle_deg:.4g} deg, pressure angle {friction.pressure_angle_deg:.4g} "
        "deg. By the paper's convention friction acts at the pitch point, outwards, and does no work; teeth that slide "
        "rub in their contacts along the flanks, against the sliding. The pairs that are in contact at once bear the "
        "same, or the one nearest to the pitch point or farthest from it bears all; no sharing makes a force larger "
        f"than the last column. The support force changes by {friction.support_changed_N:.2g} N at most, so that the "
        f"objective, {friction.objective:.6g}, does not depend on friction."
    )
    yield Table(HEAD, list(tabulate_friction(friction)))


def _describe_scaling(result: GearsFound) -> Iterator[Block]:
    scaled = result.scaled
    assert scaled is not None
    yield Text(f"Scaled to whole teeth of standard modules, the path of the tip moves by up to "
               f"{scaled.tip_moved_max_mm:.4g} mm.")  # fmt: skip
    if scaled.broken is not None:
        yield Text(f"Requirements that are broken as designed: {', '.join(scaled.broken_before or ()) or 'none'}; as "
                   f"scaled: {', '.join(scaled.broken) or 'none'}.")  # fmt: skip
    yield Keys(scaled.design)


@renews
def write_gear_set(
    out: Path,
    result: GearsFound,
    pairs: Sequence[ToothedPair],
    parts: Sequence[GearPart],
    friction: FrictionCurves | None,
    provenance: Mapping[str, Any],
    progress: Listener | None = None,
) -> GearsFound:
    """Write drawings, solids, tables, figures, report.html and summary.json; return the result with their paths.

    Raises InputError if the folder cannot be written, or if solids need a package that is not installed.
    """
    contents = dict(build_part_files(parts))
    if friction:
        comments = [f"machine: {result.machine}", "angles stand close to each other on both sides of every jump"]
        contents["friction.csv"] = files.cycle_csv("friction.csv", comments, friction.columns()).encode()
    plots = figures.build_figures(pairs, [part.placed for part in parts], friction)
    return _write(out, result, contents, plots, [figures.build_scene(pair) for pair in pairs], provenance, progress)


@renews
def write_intermittent_pair(
    out: Path, result: GearsFound, turn: IncompleteGearCycle, parts: Sequence[GearPart], provenance: Mapping[str, Any],
    progress: Listener | None = None,
) -> GearsFound:  # fmt: skip
    """Write the files of an intermittent pair. Raises as `write_gear_set` does."""
    plots = dwelling.build_figures(turn, [part.placed for part in parts])
    return _write(out, result, dict(build_part_files(parts)), plots, [dwelling.build_scene(turn)], provenance, progress)


def _write(
    out: Path, result: GearsFound, contents: Mapping[str, bytes], plots: Mapping[str, Figure], scenes: Sequence[Scene],
    provenance: Mapping[str, Any], progress: Listener | None,
) -> GearsFound:  # fmt: skip
    folder = files.output_folder(out)
    rendered = bundle.drawn(plots, progress)
    listed = replace(result, files=[str(folder / name) for name in contents])
    svgs = {name: figure.svg for name, figure in rendered.items()}
    texts = {
        "report.html": format_page(listed, svgs, provenance, [Motion(scene) for scene in scenes]),
        "summary.json": files.summary_text({**listed.table(), "provenance": dict(provenance)}),
    }
    bundle.write(out, {**contents, **texts}, rendered)
    return listed
