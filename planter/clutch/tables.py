"""Console tables of the clutch's shape and engagement."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from planter.clutch.results import ContactEngagement, EnergyBalance, ModalEngagement
from planter.files import units
from planter.terminal.console import Console

if TYPE_CHECKING:
    from planter.clutch.results import ClutchGeometry, FastestSwitching, InequalityResult, PolygonFit, Sizing


def print_geometry(console: Console, result: ClutchGeometry) -> None:
    """Print polygon, rotor, teeth, travel, linkage and inequalities, derived and as printed."""
    print(f"{result.clutch}: R = {result.R_mm:.6g} mm, a = {result.a_mm:.6g} mm, b = {result.b_mm:.6g} mm\n")
    oval, print_rotor, printed = result.ellipse, result.rotor, result.printed
    teeth = zip(result.tooth.table().items(), printed.tooth.table().values(), strict=True)
    rows = [
        ("A1", result.A1, printed.A1),
        ("A2", result.A2, printed.A2),
        ("semi-major axis / R", oval.semi_axes_over_R[0], printed.semi_axes_over_R[0]),
        ("semi-minor axis / R", oval.semi_axes_over_R[1], printed.semi_axes_over_R[1]),
        ("radius where the path meets the side / R", oval.tangency_radius_over_R, printed.tangency_radius_over_R),
        ("mismatch of the third pair of sides / R", print_rotor.mismatch_over_R, printed.mismatch_over_R),
        ("smallest hexagon, side to side / R", print_rotor.smallest_hexagon_over_R, None),
        ("limit of the fillet / R", print_rotor.fillet_limit_over_R, printed.fillet_limit_over_R),
        *((f"tooth: {key}", value, by_print) for (key, value), by_print in teeth),
    ]
    console.table("Polygon in the hexagon, teeth", ("", "derived", "printed"), rows)
    travel = ((t.axial_angle_deg, t.exact_mm, t.printed_mm) for t in result.travel)
    console.table("Travel", ("axial angle / deg", "derived / mm", "printed / mm"), travel)
    crank = ((r.axial_angle_deg, r.rod_mm, r.crank_rotation_deg, r.link_lift_deg) for r in result.linkage)
    head = ("axial angle / deg", "rod / mm", "crank rotation / deg", "lift of the link / deg")
    console.table("Linkage, for the printed travel", head, crank)
    print_conditions(console, result.conditions)
    for warning in result.warnings:
        print(f"warning: {warning}")


def print_conditions(console: Console, inequalities: Sequence[InequalityResult]) -> None:
    """Print inequalities with their margins."""
    rows = ((c.condition, "holds" if c.holds else "fails", c.margin, c.unit) for c in inequalities)
    console.table("Inequalities", ("", "", "margin", "unit"), rows)


def print_design(console: Console, result: Sizing) -> None:
    """Print sizes, linkage and inequalities of a sized clutch."""
    sizes = result.sizes.table() | result.linkage.table()
    rows = ((key, value, units.unit(key)) for key, value in sizes.items())
    console.table(f"{result.clutch}, sized", ("", "value", "unit"), rows)
    print_conditions(console, result.conditions)
    print(f"Binding: {'; '.join(result.binds)}.")
    print(f"Next: {result.tightest}.")


def print_optimum(console: Console, result: FastestSwitching) -> None:
    """Print start, optimum and its active constraints."""
    start, best = result.start_travel_time_s, result.travel_time_s
    start_values = result.start_design.table()
    rows = [(key, start_values[key], value, units.unit(key)) for key, value in result.design.table().items()]
    console.table("Linkage", ("", "file", "optimum", "unit"), [*rows, ("travel time", start, best, "s")])
    for limit in result.start_violates:
        print(f"the clutch of the file violates a limit: {limit}")
    proof = result.certificate
    active = ((a.name, a.multiplier) for a in proof.active)
    console.table("Active constraints", ("", "multiplier"), active)
    print(
        f"KKT residual {proof.kkt_residual:.2g}; {proof.agreeing_starts} of {proof.starts} starts agree, "
        f"spread {proof.spread:.2g}"
    )


def print_rotor(console: Console, result: PolygonFit) -> None:
    """Print the summary of a pair of polygons."""
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
    heading = f"Paths while vertices 0 and {slides.vertices_apart} slide on sides 0 and {slides.sides_apart}"
    console.table(heading, ("vertex", "centre / R", "semi-axes / R", "axis / deg"), paths)
    harmonics = ((h.order, h.amplitude_over_R, "yes" if h.rotor else "no") for h in result.harmonics)
    console.table("Harmonics of the support function", ("order", "amplitude / R", "a rotor's"), harmonics)


_LOADS = {
    "N0_N": "load at the start / N",
    "N_max_N": "largest load / N",
    "t_max_s": "its time / s",
    "t_loss_s": "contact is lost at / s",
}
_RUN = {
    "N_max_N": "largest load at engagement / N",
    "N_single_max_N": "largest on one tooth or jaw / N",
    "N_end_N": "load when engaged / N",
    "impacts": "impacts",
    "slips": "slips",
    "first_slip_s": "first slip / s",
    "engaged_s": "output at input speed after / s",
    "cut_off_s": "output at rest after / s",
    "cut_off_N_max_N": "largest load at cut-off / N",
}


def print_engagement(console: Console, result: ModalEngagement | ContactEngagement) -> None:
    """Print the loads and energy of an engagement by either model."""
    if isinstance(result, ModalEngagement):
        _modal(console, result)
    else:
        _contact(console, result)


def _modal(console: Console, result: ModalEngagement) -> None:
    mode = result.modal
    print(f"shape {mode.shape}: K = {mode.K_coefficient:.6g} E I / l^3, M = {mode.mass_coefficient:.6g} m2\n")
    rows = ((text, getattr(result, key), getattr(result.printed, key)) for key, text in _LOADS.items())
    console.table("Tooth and shaft in contact", ("", "derived", "as printed"), rows)
    _energy(console, result.energy)
    varied = ((row.input, row.factor, row.N_max_ratio) for row in result.sensitivity)
    console.table("Largest load over that above", ("input", "times", "ratio"), varied)


def _contact(console: Console, result: ContactEngagement) -> None:
    reuleaux, dog = result.reuleaux, result.dog
    rows = ((text, getattr(reuleaux, key), getattr(dog, key)) for key, text in _RUN.items())
    console.table("Engagement and cut-off", ("", "Reuleaux", "dog"), rows)
    print("Times count from the start of the link's motion.\n")
    _energy(console, result.energy)
    nominal = ("as given", 1.0, result.N_max_ratio, reuleaux.N_max_N, dog.N_max_N)
    loads = ("N_max_ratio", "reuleaux_N_max_N", "dog_N_max_N")
    varied = [(row.input, row.factor, *(getattr(row, key) for key in loads)) for row in result.sensitivity]
    header = ("largest load / N", "dog clutch's / N")
    console.table("Ratio of the clutches", ("input", "times", "ratio", *header), [nominal, *varied])
    teeth = result.teeth
    print(f"Body in the middle: teeth and shaft overlap by {teeth.coaxial_overlap_mm:.3g} mm or more at any angle.")
    print(f"Root circle that lets teeth pass the corners: {teeth.root_least_mm:.5g} mm at least.\n")
    phases = ((row.phase_deg, *(getattr(row, key) for key in loads)) for row in result.phases)
    console.table("By the moment of switching", ("input at / deg", "ratio", *header), phases)


def _energy(console: Console, energy: EnergyBalance) -> None:
    rows = ((key.removesuffix("_J"), value) for key, value in energy.table().items())
    console.table("Energy", ("", "J"), rows)
