"""The clutch's generated models: `exact` from first principles, `printed` as the paper has it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from planter.files import units
from planter.kernels import formulas
from planter.kernels.formulas import Formulas
from planter.papers.clutch.file import ClutchFile
from planter.papers.clutch.results import InequalityResult

Model = Literal["exact", "printed"]
MODELS: tuple[Model, ...] = ("exact", "printed")


def load_model(name: Model = "exact") -> Formulas:
    """Return the generated functions of a model."""
    return formulas.load(f"clutch_{name}")


def collect_values(clutch: ClutchFile) -> dict[str, float]:
    """Return the clutch's numbers in SI units under the names of the derivation."""
    entries = [entry for vector in load_model().sidecar["vectors"].values() for entry in vector]
    values = {entry["name"]: clutch.si(entry["shown"]) for entry in entries if "shown" in entry}
    linkage = (
        ("r_A", "crank_gear_radius_mm"),
        ("r_D", "rack_radius_mm"),
        ("gamma", "rack_phase_deg"),
        ("m", "module_mm"),
    )
    values |= {name: clutch.si(f"linkage.{key}") for name, key in linkage}
    return values | {
        "flats": clutch.si("shaft.flat_to_flat_mm"),
        "k": values["r_A"] / values["r_D"],
    }


def pack_crank(values: Mapping[str, float]) -> list[float]:
    """Return the lengths of crank, rod and engaged distance [m] as the formulas take them."""
    return [values["l_AB"], values["l_BC"], values["l_AC"]]


def evaluate_conditions(
    values: Mapping[str, float], name: Model = "exact"
) -> list[InequalityResult]:
    """Return every inequality of a working clutch with its margin, positive if satisfied, in
    display units.

    `share` is the margin over the bounded value.
    """
    formulas_ = load_model(name)
    packed = [values[entry["name"]] for entry in formulas_.sidecar["vectors"]["clutch"]]
    margins = formulas_.at("conditions", clutch=packed)
    rows = formulas_.sidecar["vectors"]["conditions"]
    return [
        build_condition(
            row["meaning"],
            row["source"],
            row["unit"],
            margins[row["name"]],
            values.get(_BOUND[row["name"]], 1.0),
        )
        for row in rows
    ]


def build_condition(
    name: str, source: str, unit: str, margin: float, value: float
) -> InequalityResult:
    """Return an inequality as results have it; `margin` and `value` in the SI unit `unit`."""
    key = units.display_key("margin", unit)
    return InequalityResult(
        condition=name,
        source=source,
        margin=margin / units.unit_factor(key),
        unit=units.display_unit(key) or "1",
        share=margin / abs(value),
        holds=margin >= -ROUNDING * abs(value),
    )


ROUNDING = 1e-12
"""Share by which a margin may be below zero: sizes at their least values hold with equality."""
_BOUND = {
    "margin_fillet": "r",
    "margin_tips": "b1",
    "margin_roots": "b2",
    "margin_travel": "c",
    "margin_slide": "F1",
    "margin_material": "",
    "margin_least_angle": "phi",
    "margin_largest_angle": "phi",
}
"""What each inequality bounds, under its name in the derivation."""
