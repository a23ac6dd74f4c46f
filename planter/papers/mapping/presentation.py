"""The presentations of `design synthesise` and `design train`: what the terminal prints and the
folders contain.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from planter.kernels.formulas import load
from planter.papers.mapping import model, scene
from planter.papers.mapping.train import GEARS, polar_curves
from planter.report import files
from planter.report.animation import MotionBlock
from planter.report.labels import count_things, load_names
from planter.report.presentation import ModelAssumptions, ResultPresentation, list_record_sections

if TYPE_CHECKING:
    from planter.kernels import Array
    from planter.papers.mapping.results import SynthesisFound
    from planter.papers.mapping.synthesis import Synthesis
    from planter.papers.mapping.train import Training

CYCLE_ROWS = 721
CAPTIONS = {
    "dyads": "Poses as arrows along the arm's x axis, with the circle and the bars of each dyad.",
    "angle_curve": "Rotation of the arm relative to the carrier over a cycle. Dots: the angles that the poses "
    "require. A negative slope means gears that reverse.",
    "ratios": "Angle curve with its points; total ratio and its split into two stages.",
    "pitch_curves": "Pitch curves in mesh on the carrier, at the first carrier angle of the curve.",
    "tip_path": ("Path of the tip as the gears drive it, and the poses."),
}
LINKAGE = "Linkage of dyads {} and {} with the poses and the path of the tip on each circuit."
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
            f"{count_things(result.complex_pairs, 'complex pair')}. {_describe_rotation(result)}"
        ),
        record=result,
        sections=list(list_record_sections(result, NAMES)),
        document=synthesis.file,
        model=_assumptions(),
        motions=lambda: [
            MotionBlock(motion)
            for linkage in synthesis.linkages
            for motion in scene.build_linkage_scenes(linkage, synthesis.poses).values()
        ],
        figures=lambda: scene.draw_synthesis(synthesis),
        captions=CAPTIONS
        | {f"linkage_{i}_{j}": LINKAGE.format(i, j) for i, j in (x.dyads for x in result.linkages)},
        tables=partial(_tabulate_paths, synthesis),
        comments=files.list_comments(synthesis.file, "poses"),
    )


def present_train(training: Training, source: str) -> ResultPresentation:
    """Return the presentation of a gear train for the angle curve of the file `source`."""
    result, provenance = training.result, _list_sources(training, source)
    moving = scene.build_train_scene(training)
    title = f"Non-circular gear train of {source}"
    return ResultPresentation(
        title=title,
        record=result,
        conclusion=f"The ratio of the train is between {result.ratio_min:.4g} and "
        f"{result.ratio_max:.4g}; "
        f"{sum(result.convex)} of 4 pitch curves are convex, and the module is at most "
        f"{result.module_max_mm:.4g} mm.",
        sections=list(list_record_sections(result, NAMES)),
        model=_assumptions(),
        motions=lambda: [] if moving is None else [MotionBlock(moving)],
        figures=lambda: scene.draw_train(training),
        captions=CAPTIONS,
        tables=lambda: {
            "cycle.csv": _tabulate_cycle(training),
            "pitch_curves.csv": _tabulate_pitch_curves(training),
        },
        comments=[f"curve: {source}", f"curve_sha256: {provenance['curve_sha256']}"],
        provenance=provenance,
    )


def _assumptions() -> ModelAssumptions:
    return ModelAssumptions(
        "Design by kinematic mapping", load(model.MODEL).sidecar["assumptions"], {}
    )


def _describe_rotation(result: SynthesisFound) -> str:
    """Return whether the arm can turn one way, else between which poses it must turn back."""
    if result.monotone is None:
        return "There is no dyad, and so no carrier."
    carrier = f"Carrier on dyad {result.carrier_dyad}"
    if result.monotone.possible:
        return f"{carrier}: a one-way rotation of the arm relative to it passes all poses."
    pairs = [
        f"by {row.deg:.6g} deg between poses {row.from_pose} and {row.to_pose}"
        for row in result.monotone.reversals
    ]
    return f"{carrier}: the arm would have to reverse {', '.join(pairs)}."


def _tabulate_paths(synthesis: Synthesis) -> Columns:
    """Return the points of angle curves, as `design train` reads them, and the coupler paths."""
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


def _list_sources(training: Training, source: str) -> dict[str, Any]:
    """Return what repeats the run: versions, options, a hash of the points."""
    curve = training.train.curve
    points = np.array([curve.carrier, curve.relative])
    return {
        **files.list_versions(),
        "curve": source,
        "curve_sha256": hashlib.sha256(points.tobytes()).hexdigest(),
        "centre_distance_mm": training.train.distance * 1e3,
        "crank_mm": None if training.crank is None else training.crank * 1e3,
    }
