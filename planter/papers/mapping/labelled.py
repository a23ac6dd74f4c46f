"""Drawings of poses, linkages and gear trains with symbols."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from planter.papers.mapping.synthesis import Synthesis
    from planter.papers.mapping.train import Training
    from planter.report.sheet import Sheet


def draw(source: str, changes: Mapping[str, float]) -> list[Sheet]:
    """Return the sheets of the poses in a file, or of the built-in ones of that name."""
    from planter.papers.mapping.file import load_poses
    from planter.papers.mapping.scene import draw_sheets
    from planter.papers.mapping.synthesis import synthesise

    synthesis = synthesise(load_poses(source, changes))
    return draw_sheets(synthesis, _train(synthesis))


def _train(synthesis: Synthesis) -> Training | None:
    """The train of the curve that the file's points give, or the nearest monotone one; None where
    neither makes one.
    """
    from planter.errors import PlanterError
    from planter.papers.mapping.train import build_training

    curve = synthesis.path_curve or (None if synthesis.nearest is None else synthesis.nearest.curve)
    if curve is None or synthesis.file.train is None or curve.sense > 0:
        return None
    try:
        return build_training(
            curve, synthesis.file.si("train.centre_distance_mm"), file=synthesis.file
        )
    except PlanterError:
        return None
