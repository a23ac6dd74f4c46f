"""What keeps pitch curves of positive slope from being gears: teeth that reach past an axis, and cusps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from planter.kernels import Array

GEARS = {"sun": ("R1", "kappa1"), "intermediate gear": ("R2", "kappa2")}
"""The non-circular gears, each with the names of its pitch radius and curvature."""
BACKWARD = -0.02
"""Slope below which the arm turns back, and not by what a spline through points overshoots [-]."""


def reaches(teeth: Array) -> dict[str, float]:
    """How far the teeth of its mate reach into the pitch curve of each gear [m]."""
    return {"sun": float(teeth[2] * teeth[0]), "intermediate gear": float(teeth[1] * teeth[0])}


def addenda(teeth: Array) -> dict[str, float]:
    """How far the teeth of each gear reach beyond its own pitch curve [m]."""
    return {"sun": float(teeth[1] * teeth[0]), "intermediate gear": float(teeth[2] * teeth[0])}


def excesses(curves: Mapping[str, Array], teeth: Array) -> dict[tuple[str, str], Array]:
    """By how much each limit is broken at angles (n,) of positive slope, not negative where it is; by gear and kind.

    A pitch radius is more than the mate's teeth reach into it. The radius of curvature is more
    than the depth of the roots where the curve is convex, and than the height of the tips where it is hollow: else
    the curve of the roots, or of the tips, has a cusp.
    """
    found = {}
    for gear, (radius, kappa) in GEARS.items():
        found[gear, "radius"] = reaches(teeth)[gear] - curves[radius]
        found[gear, "sharp"] = curves[kappa] * reaches(teeth)[gear] - 1
        found[gear, "hollow"] = -curves[kappa] * addenda(teeth)[gear] - 1
    return found


def broken(curves: Mapping[str, Array], teeth: Array) -> Array:
    """Whether any limit is broken (n,)."""
    return np.asarray(np.max(list(excesses(curves, teeth).values()), axis=0) >= 0)
