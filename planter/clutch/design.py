"""Sizes of a clutch for a shaft, a space and a travel: least sizes first, then every inequality and which one binds."""

from __future__ import annotations

import math
from collections.abc import Iterator

from planter.clutch.file import Clutch
from planter.clutch.linkage import Linkage, rods, steepest
from planter.clutch.model import condition, conditions, given, model
from planter.clutch.results.shape import Condition, Rods, Sizes, Sizing
from planter.clutch.switching import ASSUMES
from planter.errors import ComputationError

BINDS = 1e-9
"""Share of its value below which a margin counts as none."""


def design(clutch: Clutch) -> Sizing:
    """The smallest clutch for the file's shaft, wanted travel and space, with the linkage that moves its sleeve.

    Fillet, teeth and hexagon get their least sizes, the taper the angle that the travel asks for; lengths of crank,
    distance, gears and body stay as in the file. `feasible` says whether every inequality holds, `binds` which ones
    hold with equality and `violated` which do not, the worst first.

    Raises ComputationError where no hexagon or no rod exists.
    """
    values = sized(clutch)
    linkage, rotation = _linkage(clutch, values)
    found = [
        *conditions(values),
        *_space(clutch, values),
        *_limits(clutch, values, linkage),
    ]
    violated = sorted((c for c in found if not c.holds), key=lambda c: c.share)
    return Sizing(
        clutch=clutch.name,
        feasible=not violated,
        binds=[c.condition for c in found if abs(c.share) <= BINDS],
        violated=[c.condition for c in violated],
        tightest=min((c for c in found if abs(c.share) > BINDS), key=lambda c: c.share).condition,
        sizes=_shown(values),
        linkage=Rods(
            crank_mm=linkage.crank * 1e3,
            rod_mm=linkage.rod * 1e3,
            distance_mm=linkage.distance * 1e3,
            crank_rotation_deg=math.degrees(rotation),
            rod_angle_deg=math.degrees(steepest(linkage, values["c"])),
        ),
        conditions=found,
        assumes=list(ASSUMES[1:]),
    )


def sized(clutch: Clutch) -> dict[str, float]:
    """The clutch's numbers in SI with fillet, teeth, hexagon, taper and body at their least sizes."""
    values = given(clutch) | {"c": clutch.si("wanted_travel_mm")}
    wall = clutch.si("wall_mm")
    values["r"] = model().at("fillet", flats=values["flats"])["r"]
    teeth = model().at("teeth", flats=values["flats"], r=values["r"])
    values |= {"b1": teeth["b1"], "b2": teeth["b2"], "xi": teeth["xi"]}
    values["a"] = model().at("body", b2=values["b2"], wall=wall, d=values["d"], c=values["c"])["a"]
    if values["a"] <= 0:
        raise ComputationError(
            f"no hexagon is large enough: over a body of {values['d'] * 1e3:.4g} mm a taper for a travel of "
            f"{values['c'] * 1e3:.4g} mm takes off more than there is; the body must be shorter or the travel longer"
        )
    angle = model().at("angle", a=values["a"], c=values["c"])
    values |= {"b": angle["b"], "phi": angle["phi"], "R2": values["b2"] + wall}
    values["R1"] = model().at("taper", R2=values["R2"], d=values["d"], phi=values["phi"])["R1"]
    values["R"] = model().at("polygon", a=values["a"])["R"]
    return values


def _linkage(clutch: Clutch, values: dict[str, float]) -> tuple[Linkage, float]:
    """The linkage for the travel in the rotation that the lift of the link gives."""
    lift = clutch.si("lift_limit_deg")
    rotation = model().at("gears", alpha=lift, k=values["k"], gamma=values["gamma"])["theta_AR"]
    return rods(values["l_AB"], values["l_AC"], values["c"], rotation)[0], rotation


def _space(clutch: Clutch, values: dict[str, float]) -> Iterator[Condition]:
    """The room that the file gives."""
    for what, key, used in (
        ("corners of the hexagonal hole within the space", "space_radius_mm", values["a"]),
        ("outline of the body within the space", "space_radius_mm", values["R1"]),
        ("body and way of the sleeve within the space", "space_length_mm", values["d"] + values["c"]),
    ):
        room = clutch.si(key)
        yield condition(what, f"wanted.{key}", "m", room - used, room)


def _limits(clutch: Clutch, values: dict[str, float], linkage: Linkage) -> Iterator[Condition]:
    """What the limits of the file ask of forces, gears and rod."""
    at = {name: values[name] for name in ("a", "phi", "mu", "F1", "F2")}
    ends = (0.0, values["c"])
    tooth = max(
        model().at("push", shift=s, crank=linkage.packed, F1=values["F1"], r_A=values["r_A"])["tooth_force"]
        for s in ends
    )
    limits = clutch.limits
    for what, key, unit, limit, used in (
        (
            "normal force of body and sleeve",
            "normal_force_N",
            "N",
            limits.normal_force_N,
            model().at("travel", **at)["F_N"],
        ),
        ("tooth force of crank gear and rack", "tooth_force_N", "N", limits.tooth_force_N, tooth),
        ("angle of the rod", "rod_angle_deg", "rad", clutch.si("limits.rod_angle_deg"), steepest(linkage, values["c"])),
        ("length of the linkage", "length_mm", "m", clutch.si("limits.length_mm"), linkage.distance + values["c"]),
    ):
        yield condition(what, f"limits.{key}", unit, limit - used, limit)
    least = clutch.si("rack_least_mm")
    yield condition("radius of the rack", "limits.rack_least_mm", "m", values["r_D"] - least, least)
    teeth = 2 * values["r_A"] / values["m"]
    yield condition("teeth of the crank gear", "limits.teeth_least", "1", teeth - limits.teeth_least, teeth)


def _shown(values: dict[str, float]) -> Sizes:
    return Sizes(
        fillet_mm=values["r"] * 1e3,
        tip_mm=values["b1"] * 1e3,
        root_mm=values["b2"] * 1e3,
        hexagon_side_mm=values["a"] * 1e3,
        width_mm=values["R"] * 1e3,
        outline_mm=values["b"] * 1e3,
        left_radius_mm=values["R1"] * 1e3,
        right_radius_mm=values["R2"] * 1e3,
        length_mm=values["d"] * 1e3,
        travel_mm=values["c"] * 1e3,
        face_angle_deg=math.degrees(values["xi"]),
        axial_angle_deg=math.degrees(values["phi"]),
    )


def refusal(found: Sizing) -> ComputationError:
    """The error of a design that does not fit: which inequality fails by how much."""
    worst = next(c for c in found.conditions if c.condition == found.violated[0])
    others = len(found.violated) - 1
    tail = f" (and {others} more)" if others else ""
    by = f"{-worst.margin:.4g} {worst.unit}"
    return ComputationError(f"no clutch fits: {worst.condition} fails by {by} ({worst.source}){tail}")
