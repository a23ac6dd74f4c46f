"""The drawings of poses, linkages and gear trains with their symbols (`planter.view.sheet`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from planter.mapping.synthesis import Synthesis
    from planter.mapping.train import Training
    from planter.view.sheet import Labelled


UNDRAWN: Mapping[str, Sequence[str]] = {
    "a coordinate of the mapping, not of the plane": (
        "Z1",
        "Z2",
        *(f"A_j{k}" for k in range(2, 6)),
        *(f"p{k}" for k in range(2, 6)),
        *(f"v_{name}{k}" for name in ("alpha", "beta", "gamma") for k in range(2, 6)),
    ),
    "of a dyad with a hinge at infinity: planter synthesise lists those": ("normal_X", "normal_Y"),
    "points of the angle curve: planter train draws it": ("curve.", "points."),
    "where on a pitch curve the contact is": ("*_polar_deg",),
}
"""Reasons why names are on no sheet, with patterns of names, of sources, or of the file's tables as
`table.`.
"""


def draw_labelled(source: str, changes: Mapping[str, float]) -> Labelled:
    """The poses in a file, or the built-in ones of that name."""
    from planter.mapping.file import load_poses
    from planter.mapping.scene import sheets
    from planter.mapping.synthesis import synthesise
    from planter.view.sheet import Labelled

    file = load_poses(source, changes)
    synthesis = synthesise(file)
    return Labelled(file.name, file.numbers(), sheets(synthesis, _train(synthesis)))


def _train(synthesis: Synthesis) -> Training | None:
    """The train of the curve that the file's points give, or the nearest monotone one; None where
    neither makes one.
    """
    from planter.errors import PlanterError
    from planter.mapping.train import build_training

    curve = synthesis.path_curve or (None if synthesis.nearest is None else synthesis.nearest.curve)
    if curve is None or synthesis.file.train is None or curve.sense > 0:
        return None
    try:
        return build_training(
            curve, synthesis.file.si("train.centre_distance_mm"), file=synthesis.file
        )
    except PlanterError:
        return None
