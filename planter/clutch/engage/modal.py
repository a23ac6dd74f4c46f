"""Engagement as the paper treats it, (8)-(12): tooth and shaft end move together in one mode of the beam.

(M + m1) y'' + K y = F_M with y(0) = 0 and y'(0) = v0, the speed difference times the turning radius; the load on the
tooth is N = F_M - m1 y''. The printed formulas are the same with the mass of the whole overhang, m2, in place of
M + m1, whatever the shape, in the frequency and in the acceleration by F_M: their load at the start may be a pull.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from planter.clutch.engage.beam import PAPERS, Beam, Si, beam
from planter.clutch.file import Clutch
from planter.clutch.results.engagement import Energy, ModalEngagement, Mode, OneModeLoads, Varied
from planter.kernels import formulas

FACTORS = (10**-0.5, 10**0.5)
"""An undisclosed input is varied over a factor of 10 round its value."""


@dataclass(frozen=True)
class Struck:
    """What strikes the shaft: mass [kg], driving force [N], speed difference [rad/s], turning radius [m]."""

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

    struck: Struck
    beam: Beam

    @cached_property
    def extremes(self) -> dict[str, float]:
        """Frequency, acceleration by the driving force, load at the start and largest load, their times."""
        given = {"M_1": self.beam.mass, "K_1": self.beam.stiffness}
        return formulas.load("clutch_beam").at("extremes", **given, struck=self.struck.packed)

    @property
    def largest(self) -> float:
        """Largest load [N]."""
        return self.extremes["N_max"]

    def at(self, t: float) -> dict[str, float]:
        """Deflection `y_max` [m], `rate` [m/s] and load `N` [N] at a time [s]."""
        rates = {"B1": self.extremes["B1"], "B2": self.extremes["B2"]}
        return formulas.load("clutch_beam").at("motion", t=t, **rates, struck=self.struck.packed)

    def energy(self) -> Energy:
        """Work of the driving force from the start until contact is lost, or for a period, and where it went [J].

        The start itself is the paper's: the shaft end takes the body's speed from nowhere.
        """
        last = self.at(lost_at(self.struck, self.extremes) or self.extremes["period"])
        at = {"y_max": last["y_max"], "rate": last["rate"], "M_1": self.beam.mass, "K_1": self.beam.stiffness}
        found = formulas.load("clutch_beam").at("energy", **at, struck=self.struck.packed)
        given, kept = found["given"], found["kept"]
        return Energy(input_J=given, stored_J=kept, lost_J=0.0, imbalance_J=given - kept)


def lost_at(struck: Struck, extremes: dict[str, float]) -> float | None:
    """Time at which the load first falls to zero and contact ends [s]; None where it never does."""
    return None if struck.force > extremes["swing"] else extremes["t_loss"]


def modal(si: Si, shape: str = PAPERS) -> Modal:
    """The engagement of a clutch file; the driving force is the load over the turning radius, the output at rest.

    Raises InputError for an unknown shape.
    """
    radius = si("engagement.contact_radius_mm")
    struck = Struck(
        si("engagement.body_kg"), si("engagement.load_Nm") / radius, si("engagement.input_speed_rpm"), radius
    )
    return Modal(struck, beam(si, shape))


def printed(found: Modal) -> dict[str, float]:
    """Extremes of the load with frequency and acceleration as the paper prints them."""
    shaft = found.beam
    given = {"E": shaft.modulus, "I": shaft.second_moment, "l": shaft.length, "m2": shaft.overhang}
    return formulas.load("clutch_beam_printed").at("extremes", **given, struck=found.struck.packed)


def _shown(struck: Struck, extremes: dict[str, float]) -> OneModeLoads:
    return OneModeLoads(
        N0_N=extremes["N_0"], N_max_N=extremes["N_max"], t_max_s=extremes["t_max"], t_loss_s=lost_at(struck, extremes)
    )


def sensitivity(found: Modal) -> list[Varied]:
    """Largest load over that of the given inputs, for a factor of 10 in each."""

    def varied(name: str, factor: float) -> Modal:
        if name == "stiffness":
            return replace(found, beam=replace(found.beam, stiffness=factor * found.beam.stiffness))
        return replace(found, struck=replace(found.struck, **{name: factor * getattr(found.struck, name)}))

    inputs = {"stiffness": "stiffness", "mass": "body", "speed": "speed", "driving force": "force"}
    return [
        Varied(shown, factor, varied(name, factor).largest / found.largest)
        for shown, name in inputs.items()
        for factor in FACTORS
    ]


def result(clutch: Clutch, shape: str = PAPERS) -> ModalEngagement:
    """What `engage --mode modal` reports; `printed` is the same by the paper's own formulas."""
    found = modal(clutch.si, shape)
    return ModalEngagement(
        clutch=clutch.name,
        mode="modal",
        **vars(_shown(found.struck, found.extremes)),
        modal=Mode(
            K_coefficient=found.beam.stiffness_coefficient,
            mass_coefficient=found.beam.mass_coefficient,
            shape=found.beam.shape,
            frequency_rad_s=found.extremes["B1"],
            mass_kg=found.beam.mass,
            stiffness_N_m=found.beam.stiffness,
        ),
        printed=_shown(found.struck, printed(found)),
        energy=found.energy(),
        sensitivity=sensitivity(found),
    )
