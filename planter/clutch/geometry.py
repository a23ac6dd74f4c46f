"""Geometry of a clutch: polygon in the hexagon, teeth, travel, linkage, and what the print says of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from planter.clutch.file import Clutch
from planter.clutch.linkage import Linkage
from planter.clutch.model import MODELS, Model, conditions, given, model
from planter.clutch.results.shape import AsPrinted, Crank, Geometry, Tooth, Travel, Turning, VertexPath
from planter.clutch.rotor import Rotor
from planter.errors import GeometryError

VERTICES, SIDES = 5, 6


def geometry(clutch: Clutch) -> Geometry:
    """Everything about a clutch's shape as one result; `warnings` says which rods do not make the printed travel."""
    values = given(clutch)
    linkage = list(_linkage(clutch, values))
    sizes = model().at("polygon", a=values["a"])
    return Geometry(
        clutch=clutch.name,
        R_mm=sizes["R"] * 1e3,
        a_mm=values["a"] * 1e3,
        b_mm=sizes["b"] * 1e3,
        A1=sizes["A1"],
        A2=sizes["A2"],
        ellipse=_ellipse(sizes),
        rotor=_rotor(values["a"]),
        tooth=_tooth(values, "exact"),
        travel=_travel(clutch, values),
        linkage=[row for row, _ in linkage],
        conditions=conditions(values),
        warnings=[warning for _, warning in linkage if warning],
        printed=_printed(values),
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


def _rotor(side: float) -> Turning:
    found, R = model().at("rotor", a=side), model().at("polygon", a=side)["R"]
    fillet = model().at("fillet", flats=R)["r"]
    return Turning(
        mismatch_over_R=found["miss"] / R,
        smallest_hexagon_over_R=found["free"] / R,
        fillet_limit_over_R=fillet / R,
        harmonics=Rotor(VERTICES, SIDES).harmonics(6),
    )


def _tooth(values: dict[str, float], name: Model) -> Tooth:
    found = model(name).at("teeth", flats=values["flats"], r=values["r"])
    return Tooth(b1_min_mm=found["b1"] * 1e3, b2_min_mm=found["b2"] * 1e3, xi_deg=math.degrees(found["xi"]))


def travel(values: dict[str, float], angle: float, name: Model = "exact") -> float:
    """Least travel of the sleeve [m] at an axial angle [rad]: (4)."""
    at = {key: values[key] for key in ("a", "mu", "F1", "F2")}
    return model(name).at("travel", phi=angle, **at)["c_min"]


def _travel(clutch: Clutch, values: dict[str, float]) -> list[Travel]:
    return [
        Travel(
            axial_angle_deg=angle,
            printed_mm=travel(values, math.radians(angle), "printed") * 1e3,
            exact_mm=travel(values, math.radians(angle), "exact") * 1e3,
        )
        for angle in clutch.levels.axial_angles_deg
    ]


def _linkage(clutch: Clutch, values: dict[str, float]) -> Iterator[tuple[Crank, str | None]]:
    """Rotation of the crank for the printed travel, with the rod that belongs to it; else why it does not get there."""
    for index, (angle, rod) in enumerate(zip(clutch.levels.axial_angles_deg, clutch.levels.rods_mm, strict=True)):
        way = travel(values, math.radians(angle), "printed")
        linkage = Linkage(values["l_AB"], rod * 1e-3, values["l_AC"])
        unreached = Crank(angle, None, rod, None, None, None)
        try:
            linkage.check(way, f"{clutch.source}: levels.rods_mm[{index}]")
        except GeometryError as error:
            yield unreached, error.message
        else:
            yield _turned(unreached, linkage, way, values), None


def control_motion(clutch: Clutch, values: dict[str, float]) -> dict[str, float] | None:
    """Return how crank and link turn while the own linkage makes the sleeve's own travel; None if the rod cannot.

    Keys: `rotation` of the crank, `lift` of the link, `alpha_max`, its inclination then [rad], and the teeth `n`.
    """
    linkage = Linkage(*(clutch.si(f"linkage.{key}_mm") for key in ("crank", "rod", "distance")))
    way = clutch.si("sleeve.travel_mm")
    if not linkage.makes(way):
        return None
    limit = model().at("limit", crank=linkage.packed, c=way, r_A=values["r_A"], m=values["m"])
    return {"rotation": limit["theta_Amax"], "n": limit["n"], **_drive(values, limit["theta_Amax"])}


def _drive(values: dict[str, float], rotation: float) -> dict[str, float]:
    """The link, for a rotation of the crank [rad]."""
    span = values["r_A"] + values["r_D"]
    return model().at("drive", k=values["k"], span=span, gamma=values["gamma"], theta_Amax=rotation)


def _turned(unreached: Crank, linkage: Linkage, way: float, values: dict[str, float]) -> Crank:
    rotation = linkage.rotation(way)
    teeth, printed = (
        model(name).at("limit", crank=linkage.packed, c=way, r_A=values["r_A"], m=values["m"])["n"] for name in MODELS
    )
    return replace(
        unreached,
        crank_rotation_deg=math.degrees(rotation),
        link_lift_deg=math.degrees(_drive(values, rotation)["lift"]),
        teeth=teeth,
        printed_teeth=printed,
    )


def _printed(values: dict[str, float]) -> AsPrinted:
    """The same as the paper prints it, where it does."""
    sizes = model("printed").at("polygon", a=values["a"])
    R = sizes["R"]
    return AsPrinted(
        A1=sizes["A1"],
        A2=sizes["A2"],
        semi_axes_over_R=(sizes["s_1"] / R, sizes["s_2"] / R),
        tangency_radius_over_R=sizes["rho_C"] / R,
        mismatch_over_R=model("printed").at("path", theta=math.pi / 2, a=values["a"])["e_3"] / R,
        fillet_limit_over_R=model("printed").at("fillet", flats=R)["r"] / R,
        tooth=_tooth(values, "printed"),
        conditions=conditions(values, "printed"),
    )
