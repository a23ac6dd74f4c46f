"""Crank slider and gears of the clutch's control: what a linkage does, and which one gives a wanted travel."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from planter.clutch.model import model
from planter.errors import ComputationError, GeometryError
from planter.kernels import Array


@dataclass(frozen=True)
class Linkage:
    """Lengths of crank and rod, and the distance of the crank's axis from the sleeve's pin when engaged [m]."""

    crank: float
    rod: float
    distance: float

    @property
    def packed(self) -> list[float]:
        return [self.crank, self.rod, self.distance]

    def closes(self, shift: float = 0.0) -> bool:
        """Whether crank and rod meet while the sleeve is off its engaged place by a shift [m]."""
        pin = self.distance + shift
        return abs(self.crank - self.rod) < pin < self.crank + self.rod

    def makes(self, travel: float) -> bool:
        """Whether crank and rod meet from end to end of a travel [m]."""
        return self.closes() and self.closes(travel)

    def check(self, travel: float, where: str) -> None:
        """Raise GeometryError, naming where the rod stands, unless the linkage makes the travel [m]."""
        if not self.makes(travel):
            low = max(abs(self.crank - self.distance), self.distance + travel - self.crank) * 1e3
            high = (self.crank + self.distance) * 1e3
            over = f"over the travel of {travel * 1e3:.4g} mm"
            wanted = f"it must be between {low:.6g} and {high:.6g}, where crank and rod meet {over}"
            allowed = wanted if low < high else f"no rod reaches {over}, the crank must be longer"
            raise GeometryError(f"{where} = {self.rod * 1e3:g} is not allowed: {allowed}")

    def rotation(self, travel: float) -> float:
        """Rotation of the crank relative to the link [rad] while the sleeve makes a travel [m]: (7)."""
        return model().at("limit", crank=self.packed, c=travel, r_A=1.0, m=1.0)["theta_Amax"]

    def along(self, shift: Array) -> dict[str, Array]:
        """Crank angle, crank pin, rod angle and lever at shifts of the sleeve (n,) [m, rad]."""
        return model()("slider", shift=shift, crank=self.packed)


def rods(crank: float, distance: float, travel: float, rotation: float) -> list[Linkage]:
    """The linkages whose crank makes a travel [m] of the sleeve in a rotation [rad], smaller rod angle first.

    Raises ComputationError where this crank cannot.
    """
    found = model().at("rod", l_AB=crank, l_AC=distance, c=travel, theta_Amax=rotation)
    if found["share"] > 1:
        raise ComputationError(
            f"a crank of {crank * 1e3:.4g} mm makes at most {travel / found['share'] * 1e3:.4g} mm in "
            f"{np.degrees(rotation):.4g} deg, the travel is {travel * 1e3:.4g} mm: it must be longer or turn further"
        )
    base = Linkage(crank, 0.0, distance)
    both = [replace(base, rod=found[name]) for name in ("l_BC_1", "l_BC_2")]
    whole = [one for one in both if one.makes(travel) and _in_one_sense(one, travel, rotation)]
    if not whole:
        raise ComputationError("no rod lets the crank make the travel on one side of its guide")
    return sorted(whole, key=lambda one: steepest(one, travel))


def steepest(linkage: Linkage, travel: float) -> float:
    """Largest angle of the rod with the guide over a travel [rad]."""
    return float(linkage.along(np.linspace(0, travel, 101))["rod_angle"].max())


def _in_one_sense(linkage: Linkage, travel: float, rotation: float) -> bool:
    """The squared closure has roots too at which the crank would have to cross its guide."""
    return abs(linkage.rotation(travel) - rotation) < 1e-9
