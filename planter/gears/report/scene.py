"""A toothed pair in motion: both gears on their axes, a turn of the gear."""

from __future__ import annotations

import numpy as np

from planter.gearing.teeth.making import Toothed
from planter.gearing.teeth.polygons import points
from planter.kernels import Array
from planter.view.outlines import thinned
from planter.view.sampling import refine_places
from planter.view.scene import Body, Curve, Outline, Scene

MOMENTS = 240
SECONDS = 12.0
"""How long a turn is shown: a mesh is the same at any speed."""
WITHIN = 0.01
"""How far what is drawn may be from the teeth, in modules."""
_MM = 1e3


def scene(found: Toothed) -> Scene:
    """A period of the mesh, over the angle by which the gear has turned."""
    mesh = found.mesh

    def turned_at(at: Array) -> list[Array]:
        """Angles of both gears [deg], (n,) each."""
        return [np.degrees(np.unwrap(place[0])) for place in mesh.places(at)]

    end = mesh.period * mesh.pitch
    at = refine_places(turned_at, np.linspace(0, end, MOMENTS + 1))[:-1]
    angles = turned_at(at)
    axes = [(0.0, 0.0), (_MM * mesh.pair.distance, 0.0)]
    bodies = [
        Body(gear.name, (drawn(points(gear), gear.rack.module, shade),), axis, angle)
        for shade, (gear, axis, angle) in enumerate(zip(mesh.gears, axes, angles, strict=True))
    ]
    turned = np.abs(angles[0] - angles[0][0])
    return Scene(
        title=f"{mesh.gear.name} and {mesh.mate.name}",
        place=f"rotation of {mesh.gear.name}",
        unit="deg",
        places=turned,
        seconds=SECONDS,
        bodies=bodies,
        curves=(Curve(f"rotation of {mesh.mate.name}", "deg", np.abs(angles[1] - angles[1][0])),),
        shares=at / end,
    )


def drawn(vertices: Array, module: float, shade: int) -> Outline:
    """A gear's outline (n, 2) [m] with no more points than a drawing shows."""
    return Outline(_MM * thinned(vertices, WITHIN * module), "gear", shade=shade)
