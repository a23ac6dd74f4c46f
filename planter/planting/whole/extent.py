"""How long pitch curves can be within the bounds of a design, and so how many teeth they permit."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from planter.errors import InputError
from planter.gear_geometry.stage import PitchLength
from planter.kernels import Array
from planter.optimise.box import Box
from planter.optimise.problem import Problem
from planter.optimise.smooth import Smooth
from planter.optimise.starts import descents_from
from planter.planting.whole.lengths import Lengths

SAME = 1e-9
"""Share of a length by which rounding may put it outside its range."""


@dataclass(frozen=True)
class Extent:
    """Least and largest length of a stage's pitch curve within the bounds [m]; the arc that a tooth takes [m]."""

    stage: int
    least: float
    most: float
    pitch: float

    @property
    def teeth(self) -> range:
        """The whole numbers of teeth that are permitted."""
        least, most = self.least * (1 - SAME) / self.pitch, self.most * (1 + SAME) / self.pitch
        return range(math.ceil(least), math.floor(most) + 1)

    def nearest(self, length: float) -> int:
        """The permitted number of teeth that is nearest to a length [m]."""
        return min(self.teeth, key=lambda z: abs(z * self.pitch - length))

    def check(self, teeth: int | None) -> None:
        """Raise InputError unless so many teeth are permitted, or any whole number where it is None."""
        module = f"{1e3 * self.pitch / np.pi:.6g} mm"
        if teeth is None and not self.teeth:
            below = math.floor(self.least / self.pitch)
            told = " and ".join(self._module(z) for z in (below, below + 1))
            raise InputError(f"whole teeth of {module} are not allowed on stage {self.stage + 1}: {self}; {told}")
        if teeth is not None and teeth not in self.teeth:
            told = self._module(teeth)
            raise InputError(f"{teeth} teeth of {module} are not allowed on stage {self.stage + 1}: {self}; {told}")

    def _module(self, teeth: int) -> str:
        """Which modules the bounds permit with so many teeth."""
        low, high = (1e3 * length / (np.pi * teeth) for length in (self.least, self.most))
        return f"{teeth} teeth take a module of {low:.6g} to {high:.6g} mm"

    def __str__(self) -> str:
        return (
            f"within the bounds the pitch curve of stage {self.stage + 1} is {self.least * 1e3:.6g} to "
            f"{self.most * 1e3:.6g} mm long, {self.least / self.pitch:.5g} to {self.most / self.pitch:.5g} of them"
        )


def extents(lengths: Lengths) -> list[Extent]:
    """Of every stage that has whole teeth."""
    device, wanted = lengths.device, lengths.wanted
    found = []
    for k, length, at in zip(wanted.stages, lengths.lengths, lengths.places, strict=True):
        least, most = (_extreme(length, device.lower[at], device.upper[at], sign) for sign in (1, -1))
        found.append(Extent(k, least, most, wanted.pitch(k)))
    return found


class _Signed:
    """A length or its negative, as a `Function`."""

    def __init__(self, length: PitchLength, sign: int) -> None:
        self.length, self.sign = length, sign

    def value(self, x: Array) -> float:
        return self.sign * self.length.at(x).value

    def gradient(self, x: Array) -> Array:
        return self.sign * self.length.at(x).gradient

    def hessian(self, x: Array) -> Array:
        return self.sign * self.length.at(x).hessian


def _extreme(length: PitchLength, lower: Array, upper: Array, sign: int) -> float:
    """The least length in a box (sign +1), or the largest (-1): descents from its middle and from its best corner."""
    signed = _Signed(length, sign)
    names = tuple(str(k) for k in range(len(lower)))
    middle = (lower + upper) / 2
    problem = Problem(Smooth(signed, len(lower), length.at(middle).value), Box.shares(names, lower, upper, middle))
    corners = (np.array(corner, dtype=float) for corner in itertools.product((0, 1), repeat=len(lower)))
    best = min(corners, key=lambda u: signed.value(problem.design(u)))
    ends = [best, *(minimum.u for minimum in descents_from(problem, [problem.start, best]))]
    return sign * min(signed.value(problem.design(u)) for u in ends)
