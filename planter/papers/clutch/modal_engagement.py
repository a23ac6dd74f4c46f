"""Engagement as the paper treats it, (8)-(12): tooth and shaft end move together in one mode of the
beam.

(M + m1) y'' + K y = F_M with y(0) = 0 and y'(0) = v0, the speed difference times the turning
radius; the load on the tooth is N = F_M - m1 y''. The printed formulas are the same with the mass
of the whole overhang, m2, in place of M + m1, whatever the shape, in the frequency and in the
acceleration by F_M: their load at the start may be a pull.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

from planter.errors import InputError
from planter.kernels import formulas
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

SHAPES = {
    "quarter-sine": "sin(pi x / 2l), the paper's (9) and (10)",
    "clamped-cosine": "1 - cos(pi x / 2l)",
    "clamped-static": "deflection of a clamped beam under a load at its end",
    "clamped-mode": "first eigenshape of the clamped-free beam",
}
"""Shapes to choose from, by name; the first is the paper's."""
PAPERS = "quarter-sine"


@dataclass(frozen=True)
class Beam:
    """A shaft in a shape of height 1 at the contact: modal mass [kg] and stiffness [N/m], and those
    of the whole.

    `mass_coefficient` is modal mass over the mass of the overhang, `stiffness_coefficient` modal
    stiffness over E I / l^3; `overhang` [kg], `modulus` E [N/m2], `second_moment` I [m4], `length`
    l [m].
    """

    shape: str
    mass_coefficient: float
    stiffness_coefficient: float
    mass: float
    stiffness: float
    overhang: float
    modulus: float
    second_moment: float
    length: float


def build_beam(si: Si, shape: str = PAPERS) -> Beam:
    """Return the output shaft of a clutch file in a named shape.

    Raises InputError for an unknown shape.
    """
    if shape not in SHAPES:
        raise InputError(f"--shape = {shape}: must be one of {', '.join(SHAPES)}")
    flats, modulus, density, length = (
        si(f"shaft.{key}")
        for key in ("flat_to_flat_mm", "modulus_GPa", "density_kg_m3", "overhang_mm")
    )
    bending = formulas.load("clutch_beam").at(
        shape.replace("-", "_"), beam=[flats, modulus, density, length]
    )
    return Beam(
        shape,
        bending["mass_coefficient"],
        bending["stiffness_coefficient"],
        bending["M_1"],
        bending["K_1"],
        bending["m2"],
        modulus,
        bending["I"],
        length,
    )


FACTORS = (10**-0.5, 10**0.5)
"""An undisclosed input is varied over a factor of 10 round its value."""


@dataclass(frozen=True)
class StrikingBody:
    """A body that strikes the shaft: mass [kg], driving force [N], speed difference [rad/s],
    turning radius [m].
    """

    body: float
    force: float
    speed: float
    radius: float

    @property
    def packed(self) -> list[float]:
        return [self.body, self.force, self.speed, self.radius]

    @property
    def start(self) -> float:
        """Speed of tooth and shaft end at the start [m/s]."""
        return formulas.load("clutch_beam").at("start", struck=self.packed)["v_0"]


@dataclass(frozen=True)
class Modal:
    """Tooth and shaft end in contact: what strikes, and the shaft it strikes."""

    struck: StrikingBody
    beam: Beam

    @cached_property
    def extremes(self) -> dict[str, float]:
        """Frequency, acceleration by the driving force, load at the start and largest load, their
        times.
        """
        mode = {"M_1": self.beam.mass, "K_1": self.beam.stiffness}
        return formulas.load("clutch_beam").at("extremes", **mode, struck=self.struck.packed)

    @property
    def largest(self) -> float:
        """Largest load [N]."""
        return self.extremes["N_max"]

    def at(self, t: float) -> dict[str, float]:
        """Return deflection `y_max` [m], `rate` [m/s] and load `N` [N] at a time [s]."""
        rates = {"B1": self.extremes["B1"], "B2": self.extremes["B2"]}
        return formulas.load("clutch_beam").at("motion", t=t, **rates, struck=self.struck.packed)

    def energy(self) -> EnergyBalance:
        """Return the work of the driving force until the loss of contact, or for a period, with
        balance [J].

        As in the paper, the shaft end takes the body's speed at the start without loss of energy.
        """
        last = self.at(loss_time(self.struck, self.extremes) or self.extremes["period"])
        at = {
            "y_max": last["y_max"],
            "rate": last["rate"],
            "M_1": self.beam.mass,
            "K_1": self.beam.stiffness,
        }
        balance = formulas.load("clutch_beam").at("energy", **at, struck=self.struck.packed)
        work, stored = balance["given"], balance["kept"]
        return EnergyBalance(input_J=work, stored_J=stored, lost_J=0.0, imbalance_J=work - stored)


def loss_time(struck: StrikingBody, extremes: dict[str, float]) -> float | None:
    """Return the time at which the load first falls to zero and contact ends [s], or None if it
    never does.
    """
    return None if struck.force > extremes["swing"] else extremes["t_loss"]


def build_engagement(si: Si, shape: str = PAPERS) -> Modal:
    """Return the engagement of a clutch file; driving force: load over turning radius; output at
    rest.

    Raises InputError for an unknown shape.
    """
    radius = si("engagement.contact_radius_mm")
    struck = StrikingBody(
        si("engagement.body_kg"),
        si("engagement.load_Nm") / radius,
        si("engagement.input_speed_rpm"),
        radius,
    )
    return Modal(struck, build_beam(si, shape))


def printed_extremes(engagement: Modal) -> dict[str, float]:
    """Return the extremes of the load with frequency and acceleration as the paper prints them."""
    shaft = engagement.beam
    shaft_values = {
        "E": shaft.modulus,
        "I": shaft.second_moment,
        "l": shaft.length,
        "m2": shaft.overhang,
    }
    return formulas.load("clutch_beam_printed").at(
        "extremes", **shaft_values, struck=engagement.struck.packed
    )


def _to_loads(struck: StrikingBody, extremes: dict[str, float]) -> OneModeLoads:
    return OneModeLoads(
        N0_N=extremes["N_0"],
        N_max_N=extremes["N_max"],
        t_max_s=extremes["t_max"],
        t_loss_s=loss_time(struck, extremes),
    )


def compute_sensitivity(engagement: Modal) -> list[LoadSensitivity]:
    """Return the largest load over the nominal one, for a factor of 10 in each input."""

    def vary(name: str, factor: float) -> Modal:
        if name == "stiffness":
            return replace(
                engagement,
                beam=replace(engagement.beam, stiffness=factor * engagement.beam.stiffness),
            )
        return replace(
            engagement,
            struck=replace(engagement.struck, **{name: factor * getattr(engagement.struck, name)}),
        )

    inputs = {"stiffness": "stiffness", "mass": "body", "speed": "speed", "driving force": "force"}
    return [
        LoadSensitivity(label, factor, vary(name, factor).largest / engagement.largest)
        for label, name in inputs.items()
        for factor in FACTORS
    ]


def evaluate_engagement(clutch: ClutchFile, shape: str = PAPERS) -> ModalEngagement:
    """Return the result of `engage --mode modal`; `printed` has the values of the paper's
    formulas.
    """
    engagement = build_engagement(clutch.si, shape)
    return ModalEngagement(
        clutch=clutch.name,
        mode="modal",
        **vars(_to_loads(engagement.struck, engagement.extremes)),
        modal=BeamMode(
            K_coefficient=engagement.beam.stiffness_coefficient,
            mass_coefficient=engagement.beam.mass_coefficient,
            shape=engagement.beam.shape,
            frequency_rad_s=engagement.extremes["B1"],
            mass_kg=engagement.beam.mass,
            stiffness_N_m=engagement.beam.stiffness,
        ),
        printed=_to_loads(engagement.struck, printed_extremes(engagement)),
        energy=engagement.energy(),
        sensitivity=compute_sensitivity(engagement),
    )
