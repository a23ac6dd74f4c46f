"""A cam's result as tables."""

from __future__ import annotations

from planter.terminal.console import Console
from planter.workshop.cams.results import Cam


def cam(console: Console, found: Cam) -> None:
    """Roller, pressure angle, lift-off, contour and files."""
    roller, most, lifted = found.roller, found.pressure_angle_deg, found.lift_off
    rows: list[tuple[str, float | None, str, float | None]] = [
        ("radius of the roller", roller.radius_mm, "mm", None),
        ("least radius of the pitch curve towards the cam", roller.least_curvature_radius_mm, "mm", roller.at_deg),
        ("1 - the one / the other", roller.margin, "", None),
        ("largest pressure angle", most.max, "deg", most.at_deg),
        ("length of the contour", found.contour.length_mm, "mm", None),
        ("arcs of the contour", found.contour.arcs, "", None),
        ("which stray by", found.contour.deviation_um, "um", None),
    ]
    console.table(f"{found.machine}: {found.kind} cam", ("quantity", "value", "unit", "cam angle / deg"), rows)
    if lifted is not None:
        speeds = [("lifts off at", lifted.speed_rpm, lifted.angle_deg), ("own speed", lifted.own_speed_rpm, None)]
        console.table("Roller", ("", "r/min", "angle / deg"), speeds)
    if found.files:
        console.table("Files", ("name",), [(name,) for name in found.files])
