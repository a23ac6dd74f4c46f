"""Figures of a clutch's shape."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from planter.papers.clutch.geometry import CrankLinkage
from planter.papers.clutch.report.drawings import build_rotor_scene, draw_linkage
from planter.papers.clutch.rotor import Rotor, polygon_outline
from planter.report.animation import draw_stills
from planter.report.scene import Body, Outline
from planter.report.sheet import build_still_scene
from planter.report.style import Panel, draw_panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from planter.kernels import Array

_MM = 1e3


def draw_rotor(rotor: Rotor, fillets: Mapping[str, float]) -> dict[str, Figure]:
    """Draw the body in the smallest polygon that lets it turn, and the path of a vertex with
    rounded corners [m] inside, if there are any.
    """
    turning = draw_stills({"": (build_rotor_scene(rotor, "rotor"), 0)})
    if not fillets:
        return {"turning": turning}
    rounded = [polygon_outline(rotor.sides, rotor.width / 2, r, 40) for r in fillets.values()]
    outlines = [
        Outline(_MM * polygon_outline(rotor.sides, rotor.width / 2).T, "frame"),
        Outline(_MM * rotor.track().T, "body", closed=False, shade=0),
        *(
            Outline(_MM * part.T, "gear", closed=False, shade=i)
            for i, part in enumerate(rounded, 2)
        ),
    ]
    radii = ", ".join(f"{name}: {r / rotor.width:.4f} R" for name, r in fillets.items())
    scene = build_still_scene("path", [Body("path", outlines)])
    return {"turning": turning, "vertex_path": draw_stills({f"fillets {radii}": (scene, 0)})}


def draw_travels(angles_deg: Array, curves: Mapping[str, Array], marks: Array) -> Figure:
    """Draw the least travel [mm] over the axial angle, with the file's levels marked."""
    points = {name: (marks, np.interp(marks, angles_deg, curve)) for name, curve in curves.items()}
    series = {name: (angles_deg, curve) for name, curve in curves.items()}
    return draw_panels(
        [Panel("least travel of the sleeve / mm", series, "", points)], "axial angle / deg"
    )


def draw_linkages(linkages: Mapping[str, tuple[CrankLinkage, float, float]]) -> Figure:
    """Draw linkages at both ends of their travel: label -> (linkage, travel [m], pitch radius of
    the crank gear [m]).

    Titles have the rotation of the crank and the travel.
    """
    stills = {}
    for name, (linkage, travel, gear) in linkages.items():
        turned = math.degrees(linkage.rotation(travel))
        title = f"{name}: {turned:.3g}°, {_MM * travel:.3g} mm"
        stills[title] = build_still_scene(name, draw_linkage(linkage, travel, gear)), 0
    return draw_stills(stills, 2.6)
