"""The clutch's generated models, exact from first principles and printed as the paper has it, and
the geometry that they give: polygon in the hexagon, teeth, travel, linkage."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from planter.errors import ComputationError, GeometryError
from planter.files import units
from planter.kernels import Array, formulas
from planter.kernels.formulas import Formulas
from planter.papers.clutch.file import ClutchFile
from planter.papers.clutch.results import (
    ClutchGeometry,
    Crank,
    InequalityResult,
    PolygonRotation,
    ToothResult,
    Travel,
    VertexPath,
)
from planter.papers.clutch.rotor import Rotor

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


def evaluate_conditions(
    values: Mapping[str, float], name: Model = "exact"
) -> list[InequalityResult]:
    """Return every inequality of a working clutch with its margin, positive if satisfied, in
    display units.

    `share` is the margin over the bounded value.
    """
    formulas_ = load_model(name)
    margins = formulas_.pick("conditions", values)
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


VERTICES, SIDES = 5, 6


def compute_geometry(clutch: ClutchFile) -> ClutchGeometry:
    """Return the shape of a clutch; `warnings` names the rods that do not make the printed
    travel.
    """
    values = collect_values(clutch)
    linkage = list(_linkage(clutch, values))
    sizes = load_model().at("polygon", a=values["a"])
    return ClutchGeometry(
        clutch=clutch.name,
        R_mm=sizes["R"] * 1e3,
        a_mm=values["a"] * 1e3,
        b_mm=sizes["b"] * 1e3,
        A1=sizes["A1"],
        A2=sizes["A2"],
        ellipse=_ellipse(sizes),
        rotor=_rotor(values["a"]),
        tooth=_tooth(values),
        travel=_travel(clutch, values),
        linkage=[row for row, _ in linkage],
        conditions=evaluate_conditions(values),
        warnings=[warning for _, warning in linkage if warning],
    )


def _ellipse(sizes: dict[str, float]) -> VertexPath:
    R = sizes["R"]
    direction = math.atan2(sizes["y_F"] - sizes["y_E"], sizes["x_F"] - sizes["x_E"])
    return VertexPath(
        centre_over_R=(sizes["x_E"] / R, sizes["y_E"] / R),
        semi_axes_over_R=(sizes["s_1"] / R, sizes["s_2"] / R),
        axis_deg=math.degrees(direction) % 180,
        tangency_radius_over_R=sizes["rho_C"] / R,
    )


def _rotor(side: float) -> PolygonRotation:
    rotor, R = load_model().at("rotor", a=side), load_model().at("polygon", a=side)["R"]
    fillet = load_model().at("fillet", flats=R)["r"]
    return PolygonRotation(
        mismatch_over_R=rotor["miss"] / R,
        smallest_hexagon_over_R=rotor["free"] / R,
        fillet_limit_over_R=fillet / R,
        harmonics=Rotor(VERTICES, SIDES).harmonics(6),
    )


def _tooth(values: dict[str, float]) -> ToothResult:
    teeth = load_model().at("teeth", flats=values["flats"], r=values["r"])
    return ToothResult(
        b1_min_mm=teeth["b1"] * 1e3, b2_min_mm=teeth["b2"] * 1e3, xi_deg=math.degrees(teeth["xi"])
    )


def least_travel(values: Mapping[str, float], angle: float, name: Model = "exact") -> float:
    """Return the least travel of the sleeve [m] at an axial angle [rad]: (4)."""
    return load_model(name).pick("travel", {**values, "phi": angle})["c_min"]


def _travel(clutch: ClutchFile, values: dict[str, float]) -> list[Travel]:
    rows = []
    for angle in clutch.levels.axial_angles_deg:
        printed, exact = (
            least_travel(values, math.radians(angle), name) * 1e3 for name in ("printed", "exact")
        )
        rows.append(Travel(axial_angle_deg=angle, printed_mm=printed, exact_mm=exact))
    return rows


def _linkage(clutch: ClutchFile, values: dict[str, float]) -> Iterator[tuple[Crank, str | None]]:
    """Yield the rotation of the crank for the printed travel, with the rod that belongs to it; else
    why it does not get there.
    """
    levels = clutch.levels
    for index, (angle, rod) in enumerate(zip(levels.axial_angles_deg, levels.rods_mm, strict=True)):
        way = least_travel(values, math.radians(angle), "printed")
        linkage = CrankLinkage(values["l_AB"], rod * 1e-3, values["l_AC"])
        try:
            linkage.check(way, f"{clutch.source}: levels.rods_mm[{index}]")
        except GeometryError as error:
            yield Crank(angle, None, rod, None, None), error.message
            continue
        limit = load_model().pick("limit", {**values, "l_BC": linkage.rod, "c": way})
        lift = drive_link(values, limit["theta_Amax"])["lift"]
        turned = math.degrees(limit["theta_Amax"])
        yield Crank(angle, turned, rod, math.degrees(lift), limit["n"]), None


def control_motion(clutch: ClutchFile, values: dict[str, float]) -> dict[str, float] | None:
    """Return how crank and link turn while the linkage of the file makes the sleeve's travel; None
    if the rod cannot.

    Keys: `rotation` of the crank, `lift` of the link, `alpha_max`, its inclination then [rad], and
    the teeth `n`.
    """
    linkage = CrankLinkage.from_lengths(clutch.linkage)
    way = clutch.si("sleeve.travel_mm")
    if not linkage.makes(way):
        return None
    limit = load_model().pick("limit", {**values, "c": way})
    drive = drive_link(values, limit["theta_Amax"])
    return {"rotation": limit["theta_Amax"], "n": limit["n"], **drive}


def drive_link(values: dict[str, float], rotation: float) -> dict[str, float]:
    """Return lift and inclination of the link for a rotation of the crank, and the pitch radii."""
    span = values["r_A"] + values["r_D"]
    return load_model().pick("drive", {**values, "span": span, "theta_Amax": rotation})


@dataclass(frozen=True)
class CrankLinkage:
    """Lengths of crank and rod, and the distance of the crank's axis from the sleeve's pin when
    engaged [m].
    """

    crank: float
    rod: float
    distance: float

    @classmethod
    def from_lengths(cls, part: Any) -> CrankLinkage:
        """Return the linkage of a file's section or a result with its lengths [mm]."""
        return cls(part.crank_mm * 1e-3, part.rod_mm * 1e-3, part.distance_mm * 1e-3)

    @property
    def packed(self) -> list[float]:
        return [self.crank, self.rod, self.distance]

    def makes(self, travel: float) -> bool:
        """Return whether crank and rod meet from end to end of a travel [m]."""
        low, high = abs(self.crank - self.rod), self.crank + self.rod
        return all(low < pin < high for pin in (self.distance, self.distance + travel))

    def check(self, travel: float, where: str) -> None:
        """Raise GeometryError, naming the position of the rod in its file, unless the linkage makes
        the travel [m].
        """
        if not self.makes(travel):
            low = max(abs(self.crank - self.distance), self.distance + travel - self.crank) * 1e3
            high = (self.crank + self.distance) * 1e3
            over = f"over the travel of {travel * 1e3:.4g} mm"
            interval = (
                f"it must be between {low:.6g} and {high:.6g}, where crank and rod meet {over}"
            )
            allowed = interval if low < high else f"no rod reaches {over}, the crank must be longer"
            raise GeometryError.for_value(where, f"{self.rod * 1e3:g}", allowed)

    def rotation(self, travel: float) -> float:
        """Return the rotation of the crank relative to the link [rad] while the sleeve makes a
        travel [m]: (7).
        """
        return load_model().at("limit", crank=self.packed, c=travel, r_A=1.0, m=1.0)["theta_Amax"]

    def evaluate(self, shift: Array) -> dict[str, Array]:
        """Return crank angle, crank pin, rod angle and lever at shifts of the sleeve (n,) [m,
        rad].
        """
        return load_model()("slider", shift=shift, crank=self.packed)


def find_linkages(
    crank: float, distance: float, travel: float, rotation: float
) -> list[CrankLinkage]:
    """Return the linkages whose crank makes a travel [m] of the sleeve in a rotation [rad], smaller
    rod angle first.

    Raises ComputationError if this crank cannot.
    """
    closure = load_model().at("rod", l_AB=crank, l_AC=distance, c=travel, theta_Amax=rotation)
    if closure["share"] > 1:
        raise ComputationError(
            f"a crank of {crank * 1e3:.4g} mm makes at most {travel / closure['share'] * 1e3:.4g} "
            f"mm in {np.degrees(rotation):.4g} deg, the travel is {travel * 1e3:.4g} mm: it must "
            "be longer or turn further"
        )
    base = CrankLinkage(crank, 0.0, distance)
    both = [replace(base, rod=closure[name]) for name in ("l_BC_1", "l_BC_2")]
    feasible = [
        linkage
        for linkage in both
        if linkage.makes(travel) and _in_one_sense(linkage, travel, rotation)
    ]
    if not feasible:
        raise ComputationError("no rod lets the crank make the travel on one side of its guide")
    return sorted(feasible, key=lambda linkage: steepest_rod_angle(linkage, travel))


def steepest_rod_angle(linkage: CrankLinkage, travel: float) -> float:
    """Return the largest angle of the rod with the guide over a travel [rad]."""
    return float(linkage.evaluate(np.linspace(0, travel, 101))["rod_angle"].max())


def _in_one_sense(linkage: CrankLinkage, travel: float, rotation: float) -> bool:
    """The squared closure has roots too at which the crank would have to cross its guide."""
    return abs(linkage.rotation(travel) - rotation) < 1e-9
