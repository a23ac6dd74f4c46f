"""The presentations of `planter synthesise` and `planter train`: what the terminal prints and the
folders contain.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from importlib import metadata
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.mapping import model
from planter.mapping.train import GEARS, polar_curves
from planter.report import files
from planter.report.html import Block, Cell, Items, Keys, Section, Table, Text
from planter.report.labels import clean_zero, count_things, tabulate_named, tabulate_rows
from planter.report.presentation import ModelAssumptions, ResultPresentation, list_warning_sections
from planter.version import __version__
from planter.view.names import load_names

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.kernels import Array
    from planter.mapping.results import LinkageFound, Missed, SynthesisFound, TrainFound
    from planter.mapping.synthesis import Synthesis
    from planter.mapping.train import Training

CYCLE_ROWS = 721
CAPTIONS = {
    "dyads": "Poses as arrows along the arm's x axis, with the circle and the bars of each dyad.",
    "angle_curve": "Rotation of the arm relative to the carrier over a cycle. Dots: the angles that the poses "
    "require. A negative slope means gears that reverse.",
    "ratios": "Angle curve with its points; total ratio and its split into two stages.",
    "pitch_curves": "Pitch curves in mesh on the carrier, at the first carrier angle of the curve.",
    "tip_path": ("Path of the tip as the gears drive it, and the poses."),
}
POSE_KEYS = (
    "pose",
    "crank_angle_deg",
    "assembly",
    "circuit",
    "transmission_deg",
    "position_error_mm",
)
MISS_KEYS = ("pose", "carrier_deg", "position_error_mm", "hinge_error_mm", "angle_error_deg")

NAMES = load_names(__package__).with_symbols()
Columns = Mapping[str, Mapping[str, "Array"]]


def present_synthesis(synthesis: Synthesis) -> ResultPresentation:
    """Return the presentation of a synthesis: dyads, linkages with the poses on them, angle
    curve.
    """
    result = synthesis.result
    return ResultPresentation(
        title=f"Synthesis of {synthesis.file.name}",
        conclusion=(
            f"{count_things(result.poses, 'pose')}: "
            f"{count_things(len(result.dyads), 'real dyad')}, "
            f"{count_things(result.complex_pairs, 'complex pair')}."
        ),
        record=result,
        sections=[
            Section("Dyads", list(_describe_dyads(result))),
            *(
                Section(
                    "Linkage of dyads {} and {}".format(*linkage.dyads),
                    list(_describe_linkage(linkage)),
                )
                for linkage in result.linkages
            ),
            Section("Angle curve", list(_describe_curves(result))),
        ],
        document=synthesis.file,
        model=_assumptions(),
        motions=partial(_animate_linkages, synthesis),
        figures=partial(_draw_synthesis, synthesis),
        captions={
            _figure_name(
                linkage.dyads
            ): "Linkage of dyads {} and {} with the poses and the path of the tip on "
            "each circuit.".format(*linkage.dyads)
            for linkage in result.linkages
        }
        | CAPTIONS,
        tables=partial(_tabulate_paths, synthesis),
        comments=files.list_comments(synthesis.file, "poses"),
    )


def present_train(training: Training, source: str) -> ResultPresentation:
    """Return the presentation of a gear train for the angle curve of the file `source`."""
    result, provenance = training.result, dict(_list_sources(training, source))
    title = f"Non-circular gear train of {source}"
    return ResultPresentation(
        title=title,
        record=result,
        conclusion=f"The ratio of the train is between {result.ratio_min:.4g} and "
        f"{result.ratio_max:.4g}; "
        f"{sum(result.convex)} of 4 pitch curves are convex, and the module is at most "
        f"{result.module_max_mm:.4g} mm.",
        sections=list(_describe_train(result)),
        model=_assumptions(),
        motions=partial(_animate_train, training),
        figures=partial(_draw_train, training),
        captions=CAPTIONS,
        tables=lambda: {
            "cycle.csv": _tabulate_cycle(training),
            "pitch_curves.csv": _tabulate_pitch_curves(training),
        },
        comments=[f"curve: {source}", f"curve_sha256: {provenance['curve_sha256']}"],
        provenance=provenance,
    )


def _assumptions() -> ModelAssumptions:
    return ModelAssumptions("Design by kinematic mapping", model.assumptions(), {})


def _describe_dyads(result: SynthesisFound) -> Iterator[Block]:
    yield Keys({"singular values": ", ".join(f"{value:.4g}" for value in result.singular_values)})
    if result.warnings:
        yield Items(result.warnings, "warning")
    if result.dyads:
        head = (
            "dyad",
            "x / mm",
            "y / mm",
            "X / mm",
            "Y / mm",
            "radius / mm",
            "largest miss / mm",
            "outside",
        )
        rows = [
            (
                k,
                *dyad.moving_point_mm,
                *dyad.centre_mm,
                dyad.radius_mm,
                clean_zero(dyad.largest_miss_mm),
                dyad.outside,
            )
            for k, dyad in enumerate(result.dyads, 1)
        ]
        caption = (
            "Moving point, centre and radius; is the centre outside the polyline of the poses?"
        )
        yield Table(head, rows, caption, ("outside",))
    straight = [(row.kind, *row.point_mm, *row.normal, row.offset_mm) for row in result.straight]
    if straight:
        yield Table(
            ("kind", "x", "y", "normal x", "normal y", "offset / mm"),
            straight,
            "With a hinge at infinity",
        )
    if result.family:
        yield Text(
            f"The poses leave a family with "
            f"{count_things(result.family.parameters, 'free parameter')}; "
            f"in summary.json "
            f"{count_things(len(result.family.dyads), 'member is', 'members are')} listed."
        )


def _describe_linkage(linkage: LinkageFound) -> Iterator[Block]:
    defects = [name for name, is_present in linkage.defects.table().items() if is_present]
    keys = ("type", "grashof", "frame_mm", "crank_mm", "coupler_mm", "rocker_mm", "arm_length_mm")
    values: dict[str, Cell] = {
        key: getattr(linkage, key) for key in (*keys, "transmission_min_deg")
    }
    yield tabulate_named(values | {"defects": ", ".join(defects) or "none"}, NAMES)
    yield tabulate_rows([pose.table() for pose in linkage.poses], POSE_KEYS, "Poses", names=NAMES)


def _describe_curves(result: SynthesisFound) -> Iterator[Block]:
    rotation = result.monotone
    if rotation is None:
        yield Text("There is no dyad, and so no carrier.")
        return
    carrier = f"Carrier on dyad {result.carrier_dyad}"
    if rotation.possible:
        yield Text(
            f"{carrier}: a one-way rotation of the arm relative to the carrier passes all poses."
        )
    else:
        yield Text(
            f"{carrier}: no one-way rotation passes all poses: the arm would have to reverse.",
            "warning",
        )
        yield Items(
            [
                f"by {row.deg:.6g} deg between poses {row.from_pose} and {row.to_pose}"
                for row in rotation.reversals
            ]
        )
    curves = (
        (result.nearest, "Closest monotone curve"),
        (result.curve, "Curve through points of both paths"),
    )
    for curve, caption in curves:
        if curve:
            yield _tabulate_misses(curve.poses, caption)
            values = {
                key: getattr(curve, key) for key in ("slope_min", "slope_max", "monotone", "rms_mm")
            }
            yield tabulate_named(values, NAMES)


def _tabulate_misses(rows: Sequence[Missed], caption: str) -> Table:
    return tabulate_rows([row.table() for row in rows], MISS_KEYS, caption, names=NAMES)


def _describe_train(result: TrainFound) -> Iterator[Section]:
    yield from list_warning_sections(result.warnings)
    keys = (
        "ratio_min",
        "ratio_max",
        "module_max_mm",
        "slope_min",
        "slope_max",
        "carrier_bend_deg",
        "x_s",
    )
    values: dict[str, Cell] = {key: getattr(result, key) for key in keys}
    values |= {
        f"closure_error_{stage}_rad": clean_zero(error)
        for stage, error in enumerate(result.closure_error_rad, 1)
    }
    by_gear = ("radius_min_mm", "radius_max_mm", "curvature_radius_min_mm", "convex")
    gears = [
        {
            "gear": gear,
            **{key: getattr(result, key)[k] for key in by_gear},
            "concave_at_deg": _join(result.concave_deg[k]),
        }
        for k, gear in enumerate(GEARS)
    ]
    pitch_curves = tabulate_rows(
        gears, ("gear", *by_gear), "Pitch curves", ("concave_at_deg",), NAMES
    )
    yield Section("Gear train", [tabulate_named(values, NAMES), pitch_curves])
    if result.poses:
        yield Section(
            "Poses", [_tabulate_misses(result.poses, "Poses where the path comes closest to them")]
        )


def _join(ranges: Sequence[tuple[float, float]]) -> str | None:
    return ", ".join(f"{start:.4g} to {end:.4g}" for start, end in ranges) or None


def _figure_name(dyads: Sequence[int]) -> str:
    return f"linkage_{dyads[0]}_{dyads[1]}"


def _animate_linkages(synthesis: Synthesis) -> Iterator[Block]:
    from planter.mapping import scene
    from planter.view.animation import MotionBlock

    for linkage in synthesis.linkages:
        for circuit in sorted({standing.circuit for standing in linkage.standings}):
            yield MotionBlock(scene.linkage(linkage, synthesis.poses, circuit))


def _animate_train(training: Training) -> Iterator[Block]:
    from planter.mapping import scene
    from planter.view.animation import MotionBlock

    moving = scene.train(training)
    if moving is not None:
        yield MotionBlock(moving)


def _draw_synthesis(synthesis: Synthesis) -> dict[str, Figure]:
    from planter.mapping.figures import draw_synthesis

    return draw_synthesis(synthesis)


def _draw_train(training: Training) -> dict[str, Figure]:
    from planter.mapping.figures import draw_train

    return draw_train(training)


def _tabulate_paths(synthesis: Synthesis) -> Columns:
    """Return the points of angle curves, as `planter train` reads them, and the coupler paths."""
    nearest = None if synthesis.nearest is None else synthesis.nearest.curve
    tables = {
        f"{name}_curve.csv": {
            "carrier_deg": np.degrees(curve.carrier),
            "relative_deg": np.degrees(curve.relative),
        }
        for name, curve in (("nearest", nearest), ("points", synthesis.path_curve))
        if curve is not None
    }
    for linkage in synthesis.linkages:
        for circuit in range(1, len(linkage.bar.reaches) + 1):
            path = linkage.bar.path(circuit)
            tables[f"coupler_{linkage.numbers[0]}_{linkage.numbers[1]}_circuit{circuit}.csv"] = {
                "crank_deg": np.degrees(path.theta),
                "assembly": path.assembly,
                "phi_deg": np.degrees(path.phi),
                "tip_x_mm": path.tip[0] * 1e3,
                "tip_y_mm": path.tip[1] * 1e3,
                "transmission_deg": np.degrees(path.transmission),
            }
    return tables


def _tabulate_cycle(training: Training) -> dict[str, Array]:
    curve = training.train.curve
    theta = np.linspace(curve.carrier[0], curve.carrier[-1], CYCLE_ROWS)
    gears = training.train.gears(theta)
    columns = {"carrier_deg": np.degrees(theta), "relative_deg": np.degrees(curve.at(theta))}
    columns |= {name: gears[name] for name in ("i", "i1", "i2")}
    if training.dyad is not None:
        tip = model.arm(theta, curve.at(theta) + theta, training.dyad.vector)
        columns |= {"tip_x_mm": tip[0] * 1e3, "tip_y_mm": tip[1] * 1e3}
    return columns


def _tabulate_pitch_curves(training: Training) -> dict[str, Array]:
    psi, radii = polar_curves(training.train)
    columns: dict[str, Array] = {}
    for k, gear in enumerate(GEARS):
        name = gear.replace(" ", "_")
        columns |= {f"{name}_polar_deg": np.degrees(psi[k]), f"{name}_radius_mm": radii[k] * 1e3}
    return columns


def _list_sources(training: Training, source: str) -> Iterator[tuple[str, Any]]:
    """Yield what repeats the run: versions, options, a hash of the points."""
    curve = training.train.curve
    yield "planter", __version__
    yield from ((name, metadata.version(name)) for name in ("casadi", "numpy", "scipy"))
    yield "python", platform.python_version()
    yield "curve", source
    yield (
        "curve_sha256",
        hashlib.sha256(np.array([curve.carrier, curve.relative]).tobytes()).hexdigest(),
    )
    yield "centre_distance_mm", training.train.distance * 1e3
    yield "crank_mm", None if training.crank is None else training.crank * 1e3
