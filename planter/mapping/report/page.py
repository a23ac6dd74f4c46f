"""The pages of a synthesis and of a gear train."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from planter.mapping import model
from planter.mapping.report import scene
from planter.mapping.train import GEARS
from planter.report.html import Block, Cell, FigureSvg, Items, Keys, Section, Table, Text, page
from planter.report.inputs import provenance_section
from planter.view.block import Motion

if TYPE_CHECKING:
    from planter.mapping.results import LinkageFound, Missed, SynthesisFound
    from planter.mapping.synthesis import Synthesis
    from planter.mapping.training import Training

Summary = Mapping[str, Any]
CAPTIONS = {
    "dyads": "Poses as arrows along the arm's x axis, with the circle of each dyad: fixed hinge (cross), places of the "
    "moving hinge (rings).",
    "angle_curve": "Rotation of the arm against the carrier over a turn of it. Rings: what the poses ask for. A slope "
    "below zero means gears that turn back.",
    "ratios": "Angle curve with its points; total ratio and its split into two stages.",
    "pitch_curves": "Pitch curves in mesh on the carrier, at the first carrier angle of the curve.",
    "tip_path": "Path of the tip as the gears drive it, with carrier and arm at twelve carrier angles, and the poses.",
}
_MISSED = ("pose", "carrier / deg", "tip off / mm", "hinge off / mm", "angle off / deg")
_MISSED_KEYS = ("pose", "carrier_deg", "position_error_mm", "hinge_error_mm", "angle_error_deg")


def synthesis_page(synthesis: Synthesis, figures: Mapping[str, str], provenance: Summary) -> str:
    """The page of a synthesis; `figures` are SVG texts by name."""
    result = synthesis.result
    sections = [Section("Dyads", list(_dyads(result)))]
    sections += [Section(f"Linkage of dyads {x.dyads[0]} and {x.dyads[1]}", list(_linkage(x)))
                 for x in result.linkages]  # fmt: skip
    sections.append(Section("Angle curve", list(_curves(result))))
    moving = [
        Motion(scene.linkage(linkage, synthesis.poses, circuit))
        for linkage in synthesis.linkages
        for circuit in sorted({standing.circuit for standing in linkage.standings})
    ]
    if moving:
        sections.append(Section("Motion", moving))
    sections.append(Section("Figures", list(_figures(figures))))
    numbers = synthesis.file.numbers()
    origins = [(path, numbers[path], origin) for path, origin in synthesis.file.number_origins().items()]
    sections.append(Section("Inputs", [Table(("key", "value", "origin"), origins)]))
    return page(f"Synthesis of {synthesis.file.name}", [*sections, *_last(provenance)], synthesis.file.description)


def train_page(training: Training, figures: Mapping[str, str], provenance: Summary) -> str:
    """The page of a gear train; `figures` are SVG texts by name."""
    result = training.result
    named = ("x_s", "slope_min", "slope_max", "ratio_min", "ratio_max", "carrier_bend_deg", "module_max_mm")
    split: dict[str, Cell] = {name: getattr(result, name) for name in named}
    split |= {f"closure error of stage {k} / rad": e for k, e in enumerate(result.closure_error_rad, 1)}
    keys = ("radius_min_mm", "radius_max_mm", "curvature_radius_min_mm")
    rows = [(g, *(getattr(result, key)[k] for key in keys), result.convex[k], _ranges(result.concave_deg[k]))
            for k, g in enumerate(GEARS)]  # fmt: skip
    head = ("gear", "least radius / mm", "largest radius / mm", "sharpest / mm", "convex", "concave at θ / deg")
    blocks: list[Block] = [Keys(split), Table(head, rows, "Pitch curves")]
    if result.warnings:
        blocks.append(Items([warning.message for warning in result.warnings], "warning"))
    sections = [Section("Gear train", blocks)]
    if result.poses:
        sections.append(Section("Poses", [_missed(result.poses, "Where the path comes closest to each pose")]))
    moving = scene.train(training)
    if moving is not None:
        sections.append(Section("Motion", [Motion(moving)]))
    sections.append(Section("Figures", list(_figures(figures))))
    return page("Non-circular gear train", [*sections, *_last(provenance)])


def _ranges(ranges: Sequence[tuple[float, float]]) -> str | None:
    return ", ".join(f"{a:.4g} to {b:.4g}" for a, b in ranges) or None


def _dyads(result: SynthesisFound) -> Iterator[Block]:
    yield Keys({
        "poses": result.poses, "real dyads": len(result.dyads), "complex pairs": result.complex_pairs,
        "singular values": ", ".join(f"{v:.4g}" for v in result.singular_values),
    })  # fmt: skip
    if result.warnings:
        yield Items(result.warnings, "warning")
    head = ("dyad", "x / mm", "y / mm", "X / mm", "Y / mm", "radius / mm", "largest miss / mm", "outside")
    rows = [(k, *d.moving_point_mm, *d.centre_mm, d.radius_mm, d.largest_miss_mm, d.outside)
            for k, d in enumerate(result.dyads, 1)]  # fmt: skip
    if rows:
        yield Table(head, rows, "Moving point, centre and radius; is the centre outside the polyline of the poses?")
    straight = [(s.kind, *s.point_mm, *s.normal, s.offset_mm) for s in result.straight]
    if straight:
        yield Table(("kind", "x", "y", "normal x", "normal y", "offset / mm"), straight, "With a hinge at infinity")
    if result.family:
        yield Text(f"The poses leave a family with {result.family.parameters} free parameters, of which "
                   f"{len(result.family.dyads)} members are listed in summary.json.")  # fmt: skip


def _linkage(linkage: LinkageFound) -> Iterator[Block]:
    keys = ("frame_mm", "crank_mm", "coupler_mm", "rocker_mm", "type", "grashof", "arm_length_mm")
    single: dict[str, Cell] = {key: getattr(linkage, key) for key in (*keys, "transmission_min_deg")}
    wrong = [name for name, is_there in linkage.defects.table().items() if is_there]
    yield Keys(single | {"defects": ", ".join(wrong) or "none"})
    head = ("pose", "crank / deg", "assembly", "circuit", "transmission / deg", "error / mm")
    columns = ("pose", "crank_angle_deg", "assembly", "circuit", "transmission_deg", "position_error_mm")
    yield Table(head, [tuple(getattr(row, key) for key in columns) for row in linkage.poses], "Poses")


def _curves(result: SynthesisFound) -> Iterator[Block]:
    rotation = result.monotone
    if rotation is None:
        yield Text("There is no dyad, and so no carrier.")
        return
    carrier = f"Carrier on dyad {result.carrier_dyad}"
    if rotation.possible:
        yield Text(f"{carrier}: a one-way rotation of the arm against the carrier passes all poses.")
    else:
        yield Text(
            f"{carrier}: no one-way rotation passes all poses: the arm would have to reverse.",
            "warning",
        )
        yield Items([f"by {r.deg:.6g} deg between poses {r.from_pose} and {r.to_pose}"
                     for r in rotation.reversals])  # fmt: skip
    curves = (result.nearest, "Closest monotone curve"), (result.curve, "Curve through points of both paths")
    for curve, title in curves:
        if curve:
            yield _missed(curve.poses, title)
            yield Keys({name: getattr(curve, name) for name in ("slope_min", "slope_max", "monotone", "rms_mm")})


def _missed(rows: Sequence[Missed], title: str) -> Block:
    return Table(_MISSED, [tuple(getattr(row, key) for key in _MISSED_KEYS) for row in rows], title)


def _figures(figures: Mapping[str, str]) -> Iterator[Block]:
    for name, svg in figures.items():
        yield FigureSvg(svg, CAPTIONS.get(name, f"Linkage {name.removeprefix('linkage_').replace('_', ' and ')} at the "
                                          "poses, with the path of the tip on each circuit."))  # fmt: skip


def _last(provenance: Summary) -> Iterator[Section]:
    yield Section("Model", [Text("It assumes:"), Items(model.assumptions())])
    yield provenance_section(provenance)
