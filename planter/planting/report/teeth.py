"""Teeth on the pitch curves of a planting device as they are drawn: of the usual module, the size as designed."""

from __future__ import annotations

import numpy as np

from planter.errors import GeometryError, InputError
from planter.gear_geometry.cutting import DEFAULT_MODULE, ToothOrder
from planter.gear_geometry.polygons import build_polygon
from planter.kernels import Array
from planter.planting.gears import train
from planter.planting.model import Device
from planter.view.outlines import simplify_outline
from planter.view.scene import Body, Outline

ORDER = ToothOrder(keep="size", process="wire")
"""What is drawn leaves open what cuts it."""
WITHIN = 0.025 * DEFAULT_MODULE
"""How far a drawn outline may be from the teeth [m]: less than a screen shows."""


def teeth(device: Device, x: Array) -> tuple[Body, ...]:
    """Those of sun, gear 5, gear 6 and planet gear of a design x (p,) in SI; none where they cannot be made.

    Each is turned about its gear's axis as it stands on side 1 while the carrier is at 0.
    """
    try:
        made = train(device, (ORDER, ORDER), x)
    except (GeometryError, InputError):
        return ()
    gears = [gear for stage in made.stages for gear in stage.gears]
    return tuple(
        Body(
            f"teeth of the {gear.name}",
            (Outline(1e3 * simplify_outline(build_polygon(gear), WITHIN), "teeth", shade=shade),),
            turn=float(np.degrees(place.angle)),
        )
        for shade, (gear, place) in enumerate(zip(gears, made.placed(), strict=True))
    )
