"""Sizes of a clutch for a shaft, a space and a travel, with every inequality and its margin."""

from __future__ import annotations

import math
from collections.abc import Iterator

from planter.clutch.file import ClutchFile
from planter.clutch.geometry import CrankLinkage, find_linkages, steepest_rod_angle
from planter.clutch.model import build_condition, collect_values, evaluate_conditions, load_model
from planter.clutch.optimise import ASSUMES
from planter.clutch.results.shape import InequalityResult, Rods, Sizes, Sizing
from planter.errors import ComputationError

BINDS = 1e-9
"""Share of its value below which a margin counts as none."""


def size_clutch(clutch: ClutchFile) -> Sizing:
    """Return the smallest clutch for the file's shaft, travel and space, with the linkage that moves its sleeve.

    Fillet, teeth and hexagon get their smallest sizes, the taper the angle that the travel requires; lengths of crank,
    distance, gears and body stay as in the file. `feasible` says whether every inequality holds, `binds` which ones
    hold with equality and `violated` which do not, the worst first.

    Raises ComputationError if no hexagon or no rod exists.
    """
    values = compute_sizes(clutch)
    linkage, rotation = _linkage(clutch, values)
    rows = [
        *evaluate_conditions(values),
        *_space(clutch, values),
        *_limits(clutch, values, linkage),
    ]
    violated = sorted((c for c in rows if not c.holds), key=lambda c: c.share)
    return Sizing(
        clutch=clutch.name,
        feasible=not violated,
        binds=[c.condition for c in rows if abs(c.share) <= BINDS],
        violated=[c.condition for c in violated],
        tightest=min((c for c in rows if abs(c.share) > BINDS), key=lambda c: c.share).condition,
        sizes=_to_sizes(values),
        linkage=Rods(
            crank_mm=linkage.crank * 1e3,
            rod_mm=linkage.rod * 1e3,
            distance_mm=linkage.distance * 1e3,
            crank_rotation_deg=math.degrees(rotation),
            rod_angle_deg=math.degrees(steepest_rod_angle(linkage, values["c"])),
        ),
        conditions=rows,
        assumes=list(ASSUMES[1:]),
    )


def compute_sizes(clutch: ClutchFile) -> dict[str, float]:
    """Return the clutch's numbers in SI with fillet, teeth, hexagon, taper and body at their smallest sizes."""
    values = collect_values(clutch) | {"c": clutch.si("wanted_travel_mm")}
    wall = clutch.si("wall_mm")
    values["r"] = load_model().at("fillet", flats=values["flats"])["r"]
    teeth = load_model().at("teeth", flats=values["flats"], r=values["r"])
    values |= {"b1": teeth["b1"], "b2": teeth["b2"], "xi": teeth["xi"]}
    values["a"] = load_model().at("body", b2=values["b2"], wall=wall, d=values["d"], c=values["c"])["a"]
    if values["a"] <= 0:
        raise ComputationError(
            f"no hexagon is large enough: over a body of {values['d'] * 1e3:.4g} mm a taper for a travel of "
            f"{values['c'] * 1e3:.4g} mm takes off more than there is; the body must be shorter or the travel longer"
        )
    angle = load_model().at("angle", a=values["a"], c=values["c"])
    values |= {"b": angle["b"], "phi": angle["phi"], "R2": values["b2"] + wall}
    values["R1"] = load_model().at("taper", R2=values["R2"], d=values["d"], phi=values["phi"])["R1"]
    values["R"] = load_model().at("polygon", a=values["a"])["R"]
    return values


def _linkage(clutch: ClutchFile, values: dict[str, float]) -> tuple[CrankLinkage, float]:
    """Return the linkage for the travel, and the crank rotation [rad] from the lift of the link."""
    lift = clutch.si("lift_limit_deg")
    rotation = load_model().at("gears", alpha=lift, k=values["k"], gamma=values["gamma"])["theta_AR"]
    return find_linkages(values["l_AB"], values["l_AC"], values["c"], rotation)[0], rotation


def _space(clutch: ClutchFile, values: dict[str, float]) -> Iterator[InequalityResult]:
    """Yield the inequalities of the space that the file provides."""
    for subject, key, used in (
        ("corners of the hexagonal hole within the space", "space_radius_mm", values["a"]),
        ("outline of the body within the space", "space_radius_mm", values["R1"]),
        ("body and way of the sleeve within the space", "space_length_mm", values["d"] + values["c"]),
    ):
        room = clutch.si(key)
        yield build_condition(subject, f"wanted.{key}", "m", room - used, room)


def _limits(clutch: ClutchFile, values: dict[str, float], linkage: CrankLinkage) -> Iterator[InequalityResult]:
    """Yield the inequalities of forces, gears and rod by the limits of the file."""
    sleeve = {name: values[name] for name in ("a", "phi", "mu", "F1", "F2")}
    ends = (0.0, values["c"])
    tooth = max(
        load_model().at("push", shift=s, crank=linkage.packed, F1=values["F1"], r_A=values["r_A"])["tooth_force"]
        for s in ends
    )
    limits = clutch.limits
    for subject, key, unit, limit, used in (
        (
            "normal force of body and sleeve",
            "normal_force_N",
            "N",
            limits.normal_force_N,
            load_model().at("travel", **sleeve)["F_N"],
        ),
        ("tooth force of crank gear and rack", "tooth_force_N", "N", limits.tooth_force_N, tooth),
        (
            "angle of the rod",
            "rod_angle_deg",
            "rad",
            clutch.si("limits.rod_angle_deg"),
            steepest_rod_angle(linkage, values["c"]),
        ),
        ("length of the linkage", "length_mm", "m", clutch.si("limits.length_mm"), linkage.distance + values["c"]),
    ):
        yield build_condition(subject, f"limits.{key}", unit, limit - used, limit)
    min_radius = clutch.si("rack_least_mm")
    yield build_condition("radius of the rack", "limits.rack_least_mm", "m", values["r_D"] - min_radius, min_radius)
    teeth = 2 * values["r_A"] / values["m"]
    yield build_condition("teeth of the crank gear", "limits.teeth_least", "1", teeth - limits.teeth_least, teeth)


def _to_sizes(values: dict[str, float]) -> Sizes:
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


def build_refusal(sizing: Sizing) -> ComputationError:
    """Return the error of an infeasible design: the worst inequality and its margin."""
    worst = next(c for c in sizing.conditions if c.condition == sizing.violated[0])
    more = len(sizing.violated) - 1
    tail = f" (and {more} more)" if more else ""
    by = f"{-worst.margin:.4g} {worst.unit}"
    return ComputationError(f"no clutch fits: {worst.condition} fails by {by} ({worst.source}){tail}")
