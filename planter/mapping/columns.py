"""Columns of the CSV files of synthesis and gear train."""

from __future__ import annotations

from planter.mapping.train import GEARS

OF_CURVES = {
    "carrier_deg": "rotation of the carrier",
    "relative_deg": "rotation of the arm relative to the carrier",
    "crank_deg": "rotation of the crank",
    "assembly": (
        "side of the line between the moving hinge 1 and the fixed hinge 2 on which the "
        "moving hinge 2 lies"
    ),
    "phi_deg": "rotation of the coupler",
    "tip_x_mm": "pose point, x",
    "tip_y_mm": "pose point, y",
    "transmission_deg": "angle between coupler and rocker",
    "i": "ratio of the whole train: rotation of the carrier per relative rotation of the arm",
    "i1": "ratio of the first pair of gears",
    "i2": "ratio of the second pair of gears",
}


def columns() -> dict[str, tuple[str, str]]:
    """Return the meaning and source of each column."""
    meanings = {name: (meaning, "motion") for name, meaning in OF_CURVES.items()}
    for gear in GEARS:
        name = gear.replace(" ", "_")
        meanings[f"{name}_polar_deg"] = (f"polar angle of the pitch curve of {gear}", "gears")
        meanings[f"{name}_radius_mm"] = (f"pitch radius of {gear} there", "gears")
    return meanings
