"""Where the bodies of a scene are at a moment, as shapely has them."""

from __future__ import annotations

import numpy as np
from shapely import LineString, affinity

from planter.report.scene import Body, Scene


def placed(scene: Scene, moment: int) -> dict[str, list[LineString]]:
    """Every body's outlines in the machine at a moment [mm]."""
    placed_lines: dict[str, list[LineString]] = {}

    def place(body: Body, x: float, y: float, turned: float) -> None:
        bx, by, turn, *scale = (float(channel[moment]) for channel in scene.pose(body))
        c, s = np.cos(np.radians(turned)), np.sin(np.radians(turned))
        position, heading = (x + c * bx - s * by, y + s * bx + c * by), turned + turn
        lines = [
            scale * (np.vstack([o.points, o.points[:1]]) if o.closed else o.points)
            for o in body.outlines
        ]
        turns = [affinity.rotate(LineString(line), heading, origin=(0, 0)) for line in lines]
        placed_lines[body.name] = [affinity.translate(line, *position) for line in turns]
        for part in body.parts:
            place(part, *position, heading)

    for body in scene.bodies:
        place(body, 0.0, 0.0, 0.0)
    return placed_lines
