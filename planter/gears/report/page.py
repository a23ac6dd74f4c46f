"""The page of a set of toothed gears."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from planter.gearing.teeth.rack import RACK
from planter.gears import rubbing, tables
from planter.gears.results import Friction, GearCut, GearsFound, IncompleteCut, Intermittent, StageCut
from planter.report.html import Block, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import provenance_section

CAPTIONS = {
    "assembly": "All gears in their places, pitch curves dashed.",
    "mesh": "Teeth about the pitch point at four positions of a period, with their contacts.",
    "teeth": "Contact ratio of every pair of teeth; margin against undercut of both flanks and top land of each tooth.",
    "play": "Lost motion of the mate to either side and of both, the gap of the outlines as polygons, and the error of "
    "transmission at every contact, without play.",
    "dwell": "Locking arcs and the teeth beside them, about the line of centres.",
    "loose": "How many flanks touch over a turn, and how far the driven gear can turn from where its law has it, the "
    "driving gear held: behind the law and ahead of it.",
    "lands": "Margin against undercut of both flanks and top land of each tooth, as the rack leaves them.",
    "friction": "What friction of the teeth adds over a turn to the forces in the joints, to the motor's torque M_L "
    "and to the power lost at both meshes of side 1: by the paper's convention, and against the sliding.",
}


def text(
    found: GearsFound, svgs: Mapping[str, str], provenance: Mapping[str, Any], moving: Sequence[Block] = ()
) -> str:
    """The page: what the gears are, how they mesh, moving and in figures, what the geometry assumes."""
    parts = [Section("Rack", list(_rack(found)))]
    error = found.centre_error_mm
    parts += [Section(f"Pair {one.stage}: {one.gears[0].name} and {one.gears[1].name}", list(_stage(one, error)))
              for one in found.stages]  # fmt: skip
    if found.intermittent:
        parts += _dwelling(found.intermittent)
    if found.scaled:
        parts.append(Section("What the scaling does", list(_scaled(found))))
    if found.friction:
        parts.append(Section("Friction of the teeth", list(_friction(found.friction))))
    figures = [FigureSvg(svg, CAPTIONS[name.rpartition("_")[2]]) for name, svg in svgs.items()]
    parts += [
        *([Section("Motion", moving)] if moving else []),
        Section("Figures", figures),
        Section("Geometry", [Text("It assumes:"), Items(RACK.sidecar["assumptions"])]),
        provenance_section(provenance),
    ]
    return page(f"Gears of {found.machine}", parts)


def _rack(found: GearsFound) -> Iterator[Block]:
    keys = ("pressure_angle_deg", "addendum", "clearance", "backlash_mm", "centre_error_mm", "process")
    yield Keys({key: getattr(found, key) for key in keys})


def _stage(one: StageCut, centre_error_mm: float) -> Iterator[Block]:
    yield Keys({
        "teeth": ", ".join(map(str, one.z)),
        **{key: getattr(one, key) for key in ("module_mm", "scale", "centre_distance_mm")},
        "contact ratio, least": one.contact_ratio.min,
        "contact ratio, mean": one.contact_ratio.mean,
        "pressure angle, least / deg": one.pressure_angle_deg.min,
        "pressure angle, largest / deg": one.pressure_angle_deg.max,
        "error of transmission / rad": one.transmission_error_rad,
        "gap of flanks, least / mm": one.gap_mm.min,
        "gap of polygons, least / mm": one.polygon_gap_mm.min,
        "overlap of polygons / mm2": one.overlap_mm2,
        "penetration of polygons / modules": one.penetration_modules,
        "sliding per rotation rate, largest / mm": one.sliding_max_mm,
    })  # fmt: skip
    yield Table(("", "least", "largest"), [(name, extent.min, extent.max) for name, extent in tables.lost_motions(one)],
                "Lost motion: turn of the second gear, the first gear fixed, from the central position to contact on "
                "one side, and from contact on one side to contact on the other")  # fmt: skip
    if centre_error_mm and one.farther_contact_ratio is None:
        yield Text(f"With the axes {centre_error_mm:g} mm farther apart the teeth lose contact.")
    keys = ("name", "teeth", "area_mm2", "margin", "top_land_mm", "root_radius_min_mm", "keyway_phase_deg")
    head = ("gear", "teeth", "area / mm2", "margin", "top land / mm", "root radius / mm", "keyway / deg")
    yield Table(head, [tuple(getattr(gear, key) for key in keys) for gear in one.gears])
    yield from _rims(one.gears)
    undercut: Sequence[tuple[Any, ...]] = [
        (gear.name, flank.tooth, flank.flank, flank.margin) for gear in one.gears for flank in gear.undercut
    ]
    if undercut:
        yield Table(("gear", "tooth", "flank", "margin"), undercut, "Undercut flanks")


def _rims(gears: Sequence[GearCut] | Sequence[IncompleteCut]) -> Iterator[Block]:
    for gear in gears:
        if gear.rim is not None:
            yield Text(f"{gear.name}: {tables.describe_rim(gear.rim)}.")


def _dwelling(one: Intermittent) -> Iterator[Section]:
    first, second = one.gears
    yield Section(f"Pair: {first.name} and {second.name}", [
        Keys({
            "teeth": f"{one.z} on {one.pitches:.6g} pitches",
            **{key: getattr(one, key) for key in ("module_mm", "centre_distance_mm", "toothed_arc_mm")},
            "contact ratio, least": one.contact_ratio.min,
            "contact ratio, mean": one.contact_ratio.mean,
            "pressure angle, least / deg": one.pressure_angle_deg.min,
            "pressure angle, largest / deg": one.pressure_angle_deg.max,
            "error of transmission / rad": one.transmission_error_rad,
            "sliding per rotation rate, largest / mm": one.sliding_max_mm,
            "overlap of polygons over the teeth / mm2": one.overlap_mm2,
            "overlap of polygons in the dwell / mm2": one.dwell_overlap_mm2,
        }),
        Table(("gear", "teeth", "area / mm2", "margin", "top land / mm"),
              [(gear.name, gear.teeth, gear.area_mm2, gear.margin, gear.top_land_mm) for gear in one.gears]),
        *_rims(one.gears),
    ])  # fmt: skip
    yield Section("Dwell", [
        Text(
            f"While the {second.name} stands still, over {one.dwell_deg:.4g} deg of the {first.name}, locking arcs "
            f"hold it: of {one.locking_radius_mm:.5g} mm in radius, {one.apart_mm:.3g} mm apart. They take away what "
            "teeth would drive with beside the dwell; the teeth stand in the phase that leaves the least undriven."
        ),
        Table(("", "after the dwell", "before it"), tables.beside_the_dwell(one)),
        Table(("loose motion", "behind the law / deg", "ahead of it / deg"),
              [(part, turns.behind_deg, turns.ahead_deg) for part, turns in tables.parts_of(one.loose)],
              "How far the driven gear can turn, the driving gear held; a dash where nothing stops it"),
    ])  # fmt: skip


def _friction(found: Friction) -> Iterator[Block]:
    yield Text(
        f"Angle of friction {found.friction_angle_deg:.4g} deg, pressure angle {found.pressure_angle_deg:.4g} deg. By "
        "the paper's convention friction acts at the pitch point, outwards, and does no work; teeth that slide rub in "
        "their contacts along the flanks, against the sliding. The pairs that are in contact at once bear the same, "
        "or the one nearest to the pitch point or farthest from it bears all; no sharing makes a force larger than the "
        f"last column. The support force changes by {found.support_changed_N:.2g} N at most, so that the objective, "
        f"{found.objective:.6g}, feels none of it."
    )
    yield Table(rubbing.HEAD, list(rubbing.rows(found)))


def _scaled(found: GearsFound) -> Iterator[Block]:
    scaled = found.scaled
    assert scaled is not None
    yield Text(f"Scaled to whole teeth of standard modules, the path of the tip moves by up to "
               f"{scaled.tip_moved_max_mm:.4g} mm.")  # fmt: skip
    if scaled.broken is not None:
        yield Text(f"Requirements that are broken as designed: {', '.join(scaled.broken_before or ()) or 'none'}; as "
                   f"scaled: {', '.join(scaled.broken) or 'none'}.")  # fmt: skip
    yield Keys(scaled.design)
