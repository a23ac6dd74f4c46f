"""Columns of the planting device's CSV files: what the models report, of both sides."""

from __future__ import annotations

from planter.kernels import generated
from planter.planting.design_results import BORNE
from planter.planting.functions import MODELS
from planter.planting.model import list_keys, name_second_side
from planter.planting.tooth_friction import describe_friction_columns

SENSOR = {
    "measured_support_N": (
        "the support force as the sensor sees it by [measurement] of the file",
        "derived",
    ),
}
"""Column of a cycle whose file has [measurement]; that of another quantity has its key behind
`measured_`.
"""


def columns() -> dict[str, tuple[str, str]]:
    """Meaning and source of each column."""
    meanings = {"phi_deg": ("carrier angle, counted for side 1", "input")}
    for model in MODELS:
        vectors = generated.sidecar(f"planting_{model}")["vectors"]
        for vector in ("side", "totals"):
            for key, entry in zip(list_keys(vectors[vector]), vectors[vector], strict=True):
                meanings[key] = (entry["meaning"], entry["source"])
                if vector == "side":
                    meanings[name_second_side(key)] = (
                        f"{entry['meaning']}; side 2, half a turn behind",
                        entry["source"],
                    )
    meanings |= {
        key: (meaning, "derived: assumption lifted")
        for key, meaning in describe_friction_columns().items()
    }
    return (
        meanings
        | SENSOR
        | dict.fromkeys(BORNE, ("the largest over a turn, of the designer's summary", "derived"))
    )
