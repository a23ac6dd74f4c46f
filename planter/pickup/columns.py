"""Columns of the pick-up's CSV files."""

from __future__ import annotations

OF_TURN = {
    "t_deg": "rotation of the carrier from the far point",
    "phi1_deg": "rotation of the arm relative to the carrier",
    "slope": "rotation of the arm per rotation of the carrier, relative to it",
    "tip_x_mm": "tip of the needle, x",
    "tip_y_mm": "tip of the needle, y",
    "L3_mm": "distance of the tip from the carrier's centre",
    "tip_vx_mm_s": "speed of the tip, x",
    "tip_vy_mm_s": "speed of the tip, y",
    "arm_turned_back_deg": "how far the arm has turned back behind its farthest rotation",
    "x_mm": "point of the tip's path, x",
    "y_mm": "point of the tip's path, y",
}
OF_GEARS = {
    "sun_radius_mm": "pitch radius of the sun at the contact",
    "intermediate_radius_mm": "pitch radius of the intermediate gear there",
    **{
        f"{axis}{k}_mm": f"point of the pitch curve of the {gear}, {axis}"
        for k, gear in ((1, "sun"), (2, "intermediate gear"))
        for axis in "xy"
    },
    "sun_curvature_per_mm": "curvature of the sun's pitch curve, positive where convex",
    "intermediate_curvature_per_mm": (
        "curvature of the intermediate gear's pitch curve, positive where convex"
    ),
    "contact_ratio": "contact ratio of the teeth there",
}


def columns() -> dict[str, tuple[str, str]]:
    """Meaning and source of each column."""
    parts = {"motion": OF_TURN, "gears": OF_GEARS}
    return {
        name: (meaning, part)
        for part, meanings in parts.items()
        for name, meaning in meanings.items()
    }
