"""Columns of the clutch's CSV files."""

from __future__ import annotations

OF_SHAPE = {
    "theta_deg": "rotation of the polygon relative to the hexagon",
    **{
        f"{axis}_{corner}_mm": f"corner {corner} of the polygon, {axis}"
        for corner in "ABC"
        for axis in "xy"
    },
    "x_M_mm": "middle of the polygon, x",
    "y_M_mm": "middle of the polygon, y",
    "overlap_mm": (
        "how far the polygon reaches beyond the hexagon's sides; below zero it is clear of them"
    ),
}
OF_ENGAGEMENT = {
    "time_s": "time since the halves first touch",
    "link_deg": "rotation of the link",
    "sleeve_mm": "axial place of the sleeve",
    "load_N": "force between the teeth",
    "output_rpm": "speed of the driven shaft",
}
OF_FIELD_TEST = {
    "speed_m_s": "forward speed of the machine",
    "clutch": "mean of the clutch on trial",
    "reference": "mean of the clutch that it is compared with",
    "difference": "reference less clutch",
    "reduction_percent": "that difference as a share of the reference",
    "p_value": "probability of as large a difference by chance (Welch)",
    "p_holm": "the same, corrected for the number of comparisons (Holm)",
    "ss": "sum of squares",
    "df": "degrees of freedom",
    "ms": "mean square",
    "F": "ratio of mean squares",
    "p": "probability of as large a ratio by chance",
    "level": "level of the factor",
    "k": "mean response at that level",
    "R": "range of these means",
    **{factor: f"factor {factor}, its level" for factor in "ABC"},
    **{response: f"response {response}" for response in ("Y1", "Y2")},
}


def columns() -> dict[str, tuple[str, str]]:
    """Meaning and source of each column that holds numbers."""
    parts = {"shape": OF_SHAPE, "engagement": OF_ENGAGEMENT, "field test": OF_FIELD_TEST}
    return {
        name: (meaning, part)
        for part, meanings in parts.items()
        for name, meaning in meanings.items()
    }
