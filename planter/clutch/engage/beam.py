"""The overhanging output shaft as a beam that bends in one assumed shape."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from planter.errors import InputError
from planter.kernels import formulas

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
    """A shaft in a shape of height 1 at the contact: modal mass [kg] and stiffness [N/m], and those of the whole.

    `mass_coefficient` is modal mass over the mass of the overhang, `stiffness_coefficient` modal stiffness over
    E I / l^3; `overhang` [kg], `modulus` E [N/m2], `second_moment` I [m4], `length` l [m].
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


def beam(si: Si, shape: str = PAPERS) -> Beam:
    """The output shaft of a clutch file in a shape of that name. Raises InputError for an unknown name."""
    if shape not in SHAPES:
        raise InputError(f"--shape = {shape} is not allowed: it must be one of {', '.join(SHAPES)}")
    flats, modulus, density, length = (
        si(f"shaft.{key}") for key in ("flat_to_flat_mm", "modulus_GPa", "density_kg_m3", "overhang_mm")
    )
    found = formulas.load("clutch_beam").at(shape.replace("-", "_"), beam=[flats, modulus, density, length])
    return Beam(
        shape,
        found["mass_coefficient"],
        found["stiffness_coefficient"],
        found["M_1"],
        found["K_1"],
        found["m2"],
        modulus,
        found["I"],
        length,
    )
