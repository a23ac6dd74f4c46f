"""Engagement as the paper treats it, (8)-(12): tooth and shaft end move together in one mode of the
beam.

(M + m1) y'' + K y = F_M with y(0) = 0 and y'(0) = v0, the speed difference times the turning
radius; the load on the tooth is N = F_M - m1 y''. The printed formulas are the same with the mass
of the whole overhang, m2, in place of M + m1, whatever the shape, in the frequency and in the
acceleration by F_M: their load at the start may be a pull.
"""

from __future__ import annotations

from collections.abc import Callable

from planter.errors import InputError
from planter.kernels.formulas import load
from planter.papers.clutch.file import ClutchFile
from planter.papers.clutch.results import (
    BeamMode,
    EnergyBalance,
    LoadSensitivity,
    ModalEngagement,
    OneModeLoads,
)

Si = Callable[[str], float]
"""The value at a path such as `shaft.fillet_mm`, in SI units and radians."""
Engagement = dict[str, float]
"""Shaft, its mode in a shape of height 1 at the contact, and the body that strikes it, by the names
of the derivation, in SI units.
"""

SHAPES = {
    "quarter-sine": "sin(pi x / 2l), the paper's (9) and (10)",
    "clamped-cosine": "1 - cos(pi x / 2l)",
    "clamped-static": "deflection of a clamped beam under a load at its end",
    "clamped-mode": "first eigenshape of the clamped-free beam",
}
"""Shapes to choose from, by name; the first is the paper's."""
PAPERS = "quarter-sine"
MODEL, PRINTED = "clutch_beam", "clutch_beam_printed"
"""The generated formulas, derived and as the paper prints them."""
FACTORS = (10**-0.5, 10**0.5)
"""An undisclosed input is varied over a factor of 10 round its value."""


def build_engagement(si: Si, shape: str = PAPERS) -> Engagement:
    """Return the engagement of a clutch file in a named shape of its shaft.

    The driving force is the load over the turning radius, and the output is at rest. Raises
    InputError for an unknown shape.
    """
    if shape not in SHAPES:
        raise InputError(f"--shape = {shape}: must be one of {', '.join(SHAPES)}")
    radius = si("engagement.contact_radius_mm")
    values = {
        "flats": si("shaft.flat_to_flat_mm"),
        "E": si("shaft.modulus_GPa"),
        "rho": si("shaft.density_kg_m3"),
        "l": si("shaft.overhang_mm"),
        "m1": si("engagement.body_kg"),
        "F_M": si("engagement.load_Nm") / radius,
        "Delta_omega": si("engagement.input_speed_rpm"),
        "r1": radius,
    }
    return values | load(MODEL).pick(shape.replace("-", "_"), values)


def find_extremes(engagement: Engagement, model: str = MODEL) -> dict[str, float]:
    """Return frequency, acceleration by the driving force, load at the start and largest load, and
    their times, derived or as printed.
    """
    return load(model).pick("extremes", engagement)


def evaluate_motion(engagement: Engagement, t: float) -> dict[str, float]:
    """Return deflection `y_max` [m], `rate` [m/s] and load `N` [N] at a time [s]."""
    return load(MODEL).pick("motion", {**engagement, **find_extremes(engagement), "t": t})


def compute_energy(engagement: Engagement) -> EnergyBalance:
    """Return the work of the driving force until the loss of contact, or for a period, with its
    balance [J].

    As in the paper, the shaft end takes the body's speed at the start without loss of energy.
    """
    extremes = find_extremes(engagement)
    end = find_loss_time(engagement, extremes) or extremes["period"]
    balance = load(MODEL).pick("energy", engagement | evaluate_motion(engagement, end))
    work, stored = balance["given"], balance["kept"]
    return EnergyBalance(input_J=work, stored_J=stored, lost_J=0.0, imbalance_J=work - stored)


def find_loss_time(engagement: Engagement, extremes: dict[str, float]) -> float | None:
    """Return the time at which the load first falls to zero and contact ends [s], or None if it
    never does.
    """
    return None if engagement["F_M"] > extremes["swing"] else extremes["t_loss"]


def compute_sensitivity(engagement: Engagement) -> list[LoadSensitivity]:
    """Return the largest load over the nominal one, for a factor of 10 in each input."""
    inputs = {"stiffness": "K_1", "mass": "m1", "speed": "Delta_omega", "driving force": "F_M"}
    nominal = find_extremes(engagement)["N_max"]
    rows = []
    for label, name in inputs.items():
        for factor in FACTORS:
            varied = find_extremes(engagement | {name: factor * engagement[name]})
            rows.append(LoadSensitivity(label, factor, varied["N_max"] / nominal))
    return rows


def _to_loads(engagement: Engagement, model: str) -> OneModeLoads:
    extremes = find_extremes(engagement, model)
    return OneModeLoads(
        N0_N=extremes["N_0"],
        N_max_N=extremes["N_max"],
        t_max_s=extremes["t_max"],
        t_loss_s=find_loss_time(engagement, extremes),
    )


def evaluate_engagement(clutch: ClutchFile, shape: str = PAPERS) -> ModalEngagement:
    """Return the result of `engage --mode modal`; `printed` has the values of the paper's
    formulas.
    """
    engagement = build_engagement(clutch.si, shape)
    return ModalEngagement(
        clutch=clutch.name,
        mode="modal",
        **vars(_to_loads(engagement, MODEL)),
        modal=BeamMode(
            K_coefficient=engagement["stiffness_coefficient"],
            mass_coefficient=engagement["mass_coefficient"],
            shape=shape,
            frequency_rad_s=find_extremes(engagement)["B1"],
            mass_kg=engagement["M_1"],
            stiffness_N_m=engagement["K_1"],
        ),
        printed=_to_loads(engagement, PRINTED),
        energy=compute_energy(engagement),
        sensitivity=compute_sensitivity(engagement),
    )
