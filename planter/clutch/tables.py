"""Results of the clutch's shape as tables that a person likes to read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planter.files import units
from planter.terminal.console import Console

if TYPE_CHECKING:
    from planter.clutch.results.rotor import Fit
    from planter.clutch.results.shape import Condition, FastestSwitching, Geometry, Sizing


def geometry(console: Console, result: Geometry) -> None:
    """Polygon, rotor, teeth, travel, linkage and inequalities, beside the print."""
    print(f"{result.clutch}: R = {result.R_mm:.6g} mm, a = {result.a_mm:.6g} mm, b = {result.b_mm:.6g} mm\n")
    oval, rotor, printed = result.ellipse, result.rotor, result.printed
    teeth = zip(result.tooth.table().items(), printed.tooth.table().values(), strict=True)
    rows = [
        ("A1", result.A1, printed.A1),
        ("A2", result.A2, printed.A2),
        ("semi-major axis / R", oval.semi_axes_over_R[0], printed.semi_axes_over_R[0]),
        ("semi-minor axis / R", oval.semi_axes_over_R[1], printed.semi_axes_over_R[1]),
        ("radius where the path meets the side / R", oval.tangency_radius_over_R, printed.tangency_radius_over_R),
        ("mismatch of the third pair of sides / R", rotor.mismatch_over_R, printed.mismatch_over_R),
        ("smallest hexagon, side to side / R", rotor.smallest_hexagon_over_R, None),
        ("limit of the fillet / R", rotor.fillet_limit_over_R, printed.fillet_limit_over_R),
        *((f"tooth: {key}", value, by_print) for (key, value), by_print in teeth),
    ]
    console.table("Polygon in the hexagon, teeth", ("", "derived", "printed"), rows)
    travel = ((t.axial_angle_deg, t.exact_mm, t.printed_mm) for t in result.travel)
    console.table("Travel", ("axial angle / deg", "derived / mm", "printed / mm"), travel)
    crank = ((r.axial_angle_deg, r.rod_mm, r.crank_rotation_deg, r.link_lift_deg) for r in result.linkage)
    head = ("axial angle / deg", "rod / mm", "crank rotation / deg", "lift of the link / deg")
    console.table("Linkage, for the printed travel", head, crank)
    conditions(console, result.conditions)
    for warning in result.warnings:
        print(f"warning: {warning}")


def conditions(console: Console, found: Sequence[Condition]) -> None:
    """Inequalities with their margins."""
    rows = ((c.condition, "holds" if c.holds else "fails", c.margin, c.unit) for c in found)
    console.table("Inequalities", ("", "", "margin", "unit"), rows)


def design(console: Console, result: Sizing) -> None:
    """Sizes, linkage and inequalities of a sized clutch."""
    sizes = result.sizes.table() | result.linkage.table()
    rows = ((key, value, units.unit(key)) for key, value in sizes.items())
    console.table(f"{result.clutch}, sized", ("", "value", "unit"), rows)
    conditions(console, result.conditions)
    print(f"Binding: {'; '.join(result.binds)}.")
    print(f"Next: {result.tightest}.")


def optimisation(console: Console, result: FastestSwitching) -> None:
    """Start, optimum and what holds it."""
    start, best = result.start_travel_time_s, result.travel_time_s
    own = result.start_design.table()
    rows = [(key, own[key], value, units.unit(key)) for key, value in result.design.table().items()]
    console.table("Linkage", ("", "file", "optimum", "unit"), [*rows, ("travel time", start, best, "s")])
    for what in result.start_violates:
        print(f"the file's own clutch breaks a limit: {what}")
    proof = result.certificate
    held = ((a.name, a.multiplier) for a in proof.active)
    console.table("What holds the optimum", ("", "multiplier"), held)
    print(
        f"KKT residual {proof.kkt_residual:.2g}; {proof.agreeing_starts} of {proof.starts} starts agree, "
        f"spread {proof.spread:.2g}"
    )


def rotor(console: Console, result: Fit) -> None:
    """A pair of polygons in general."""
    title = f"Reuleaux polygon of {result.vertices} vertices in a regular one of {result.sides} sides"
    oval = result.ellipse.table() if result.ellipse else {}
    rows = [
        ("rotor", "yes" if result.exact else "no"),
        ("smallest_over_R", result.smallest_over_R),
        ("mismatch_over_R", result.mismatch_over_R),
        ("fillet_limit_over_R", result.fillet_limit_over_R),
    ]
    rows += [
        (key, ", ".join(f"{v:.6g}" for v in value) if isinstance(value, list) else value) for key, value in oval.items()
    ]
    console.table(title, ("", "value"), rows)
    slides = result.slides
    paths = (
        (p.vertex, *(f"{a:.6g}, {b:.6g}" for a, b in (p.centre_over_R, p.semi_axes_over_R)), p.axis_deg)
        for p in slides.paths
    )
    what = f"Paths while vertices 0 and {slides.vertices_apart} slide on sides 0 and {slides.sides_apart}"
    console.table(what, ("vertex", "centre / R", "semi-axes / R", "axis / deg"), paths)
    harmonics = ((h.order, h.amplitude_over_R, "yes" if h.rotor else "no") for h in result.harmonics)
    console.table("Harmonics of the support function", ("order", "amplitude / R", "a rotor's"), harmonics)
