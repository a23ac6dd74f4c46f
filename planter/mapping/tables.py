"""Results of the mapping as printed tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from planter.mapping.train import GEARS
from planter.terminal.console import Console

if TYPE_CHECKING:
    from planter.mapping.results import (
        CurveOfPaths,
        DyadFound,
        LinkageFound,
        Missed,
        NearestCurve,
        SynthesisFound,
        TrainFound,
    )


def synthesis(console: Console, result: SynthesisFound) -> None:
    """Dyads, linkages with the poses on them, angle curve."""
    dyads = result.dyads
    print(f"{result.poses} poses: {len(dyads)} real dyads, {result.complex_pairs} complex pairs\n")
    if dyads:
        header = ("dyad", "x / mm", "y / mm", "X / mm", "Y / mm", "radius / mm", "largest miss / mm")
        console.table("Dyads: moving point, centre, radius", header, _dyad_rows(dyads))
    if result.straight:
        rows = [(s.kind, *s.point_mm, *s.normal, s.offset_mm) for s in result.straight]
        console.table("With a hinge at infinity", ("kind", "x", "y", "normal x", "normal y", "offset / mm"), rows)
    if result.family:
        print(f"Family with {result.family.parameters} free parameters: {len(result.family.dyads)} members")
    for linkage in result.linkages:
        _linkage(console, linkage)
    _monotone(result)
    if result.nearest:
        _curve(console, "Closest monotone angle curve", result.nearest)
    if result.curve:
        _curve(console, "Curve through points of both paths", result.curve)
    for warning in result.warnings:
        console.say(f"note: {warning}")


def _dyad_rows(dyads: Sequence[DyadFound]) -> list[tuple[Any, ...]]:
    return [(k, *d.moving_point_mm, *d.centre_mm, d.radius_mm, d.largest_miss_mm) for k, d in enumerate(dyads, 1)]


def _linkage(console: Console, linkage: LinkageFound) -> None:
    lengths = ", ".join(f"{n} {getattr(linkage, f'{n}_mm'):.6g}" for n in ("frame", "crank", "coupler", "rocker"))
    wrong = [name for name, is_there in linkage.defects.table().items() if is_there]
    title = f"Linkage of dyads {linkage.dyads[0]} and {linkage.dyads[1]}: {linkage.type}, {lengths} mm"
    header = ("pose", "crank / deg", "assembly", "circuit", "transmission / deg", "error / mm")
    keys = ("pose", "crank_angle_deg", "assembly", "circuit", "transmission_deg", "position_error_mm")
    console.table(title, header, [tuple(getattr(row, key) for key in keys) for row in linkage.poses])
    print(f"defects: {', '.join(wrong) or 'none'}; least transmission angle {linkage.transmission_min_deg:.4g} deg\n")


def _monotone(result: SynthesisFound) -> None:
    rotation = result.monotone
    if rotation is None:
        return
    carrier = f"carrier on dyad {result.carrier_dyad}"
    if rotation.possible:
        print(f"{carrier}: a one-way rotation of the arm against the carrier passes all poses\n")
        return
    reversals = ", ".join(f"by {r.deg:.5g} deg between poses {r.from_pose} and {r.to_pose}" for r in rotation.reversals)
    print(f"{carrier}: no one-way rotation passes all poses: the arm would have to reverse {reversals}\n")


def _curve(console: Console, title: str, curve: NearestCurve | CurveOfPaths) -> None:
    _poses(console, title, curve.poses)
    print(f"slope from {curve.slope_min:.5g} to {curve.slope_max:.5g}\n")


def _poses(console: Console, title: str, rows: Sequence[Missed]) -> None:
    header = ("pose", "carrier / deg", "tip off / mm", "hinge off / mm", "angle off / deg")
    keys = ("pose", "carrier_deg", "position_error_mm", "hinge_error_mm", "angle_error_deg")
    console.table(title, header, [tuple(getattr(row, key) for key in keys) for row in rows])


def train(console: Console, result: TrainFound) -> None:
    """Split, closure, pitch curves, and the poses if there are any."""
    rows = [(name, getattr(result, name)) for name in ("x_s", "slope_min", "slope_max", "ratio_min", "ratio_max")]
    rows += [(f"closure error of stage {k} / rad", e) for k, e in enumerate(result.closure_error_rad, 1)]
    rows.append(("bend of the carrier / deg", result.carrier_bend_deg))
    rows.append(("largest module without a cusp / mm", result.module_max_mm))
    console.table("Gear train", ("", "value"), rows)
    keys = ("radius_min_mm", "radius_max_mm", "curvature_radius_min_mm")
    gears = [(g, *(getattr(result, key)[k] for key in keys), result.convex[k]) for k, g in enumerate(GEARS)]
    header = ("gear", "least radius / mm", "largest radius / mm", "sharpest / mm", "convex")
    console.table("Pitch curves", header, gears)
    if result.poses:
        _poses(console, "Poses and the path of the train", result.poses)
    for warning in result.warnings:
        print(f"Note: {warning.message}.")
