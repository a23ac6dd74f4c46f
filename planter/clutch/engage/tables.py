"""Results of an engagement as tables."""

from __future__ import annotations

from planter.clutch.results.engagement import ContactEngagement, Energy, ModalEngagement
from planter.terminal.console import Console

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


def show(console: Console, result: ModalEngagement | ContactEngagement) -> None:
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
    given = ("as given", 1.0, result.N_max_ratio, reuleaux.N_max_N, dog.N_max_N)
    loads = ("N_max_ratio", "reuleaux_N_max_N", "dog_N_max_N")
    varied = [(row.input, row.factor, *(getattr(row, key) for key in loads)) for row in result.sensitivity]
    header = ("largest load / N", "dog clutch's / N")
    console.table("Ratio of the clutches", ("input", "times", "ratio", *header), [given, *varied])
    teeth = result.teeth
    print(f"Body in the middle: teeth and shaft overlap by {teeth.coaxial_overlap_mm:.3g} mm or more at any angle.")
    print(f"Root circle that lets teeth pass the corners: {teeth.root_least_mm:.5g} mm at least.\n")
    phases = ((row.phase_deg, *(getattr(row, key) for key in loads)) for row in result.phases)
    console.table("By the moment of switching", ("input at / deg", "ratio", *header), phases)


def _energy(console: Console, energy: Energy) -> None:
    rows = ((key.removesuffix("_J"), value) for key, value in energy.table().items())
    console.table("Energy", ("", "J"), rows)
