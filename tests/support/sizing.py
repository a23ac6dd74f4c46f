"""Curves of a wanted size in any family, to draw tests from: mean radius, relative swing of the
ratio, deformation.

The mean radius is that over the polar angle; the relative swing (largest - least) / (largest +
least) of the ratio is the same whichever gear drives. Neither depends on the deformation, because
both segments run through the same radii.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from planter.gears.geometry import families
from planter.gears.geometry.stage import (
    FIRST_TERMS,
    MAX_TERMS,
    SERIES_TOLERANCE,
    Stage,
    StageCandidate,
    converge_series,
)
from planter.kernels import Array, Kernel

NODES = 256
"""Midpoints of half a turn in a mean over it, which is spectrally accurate for an even curve."""
EXACT = 1e-15
"""Difference of a relative swing that is none [-]."""


@dataclass(frozen=True)
class Size:
    """Mean radius [m], relative swing of the ratio [-] and deformation coefficient [-] of a pitch
    curve.

    `shape` holds the numbers that some families have beside these, in the order of their sidecar;
    nothing means zeros.
    """

    mean_radius: float
    swing: float
    deformation: float = 1.0
    shape: tuple[float, ...] = ()


class Sizing:
    """Both ways between sizes and a family's parameters (p,), in SI and with the deformation last.

    >>> Sizing("ellipse").parameters(Size(mean_radius=0.04, swing=0.8, deformation=1.2)).round(12).tolist()
    [0.046188021535, 0.5, 1.2]
    """

    def __init__(self, family: str) -> None:
        self.family, self.sidecar = family, families.load_sidecar(family)
        self._names = tuple(entry["shown"] for entry in self.sidecar["parameters"])
        self._lengths = np.array([entry["unit"] == "m" for entry in self.sidecar["parameters"]])

    def size(self, parameters: Array) -> Size:
        """The size of a curve, without its shape.

        Raises GeometryError where the series of its rotation does not converge.
        """
        curve_parameters = np.asarray(parameters, dtype=float)
        stage = converge_series(
            Stage(self.family, self._names),
            [StageCandidate(curve_parameters, lambda name: f"{self.family}.{name}")],
        )
        mean, swing = _Described(stage)(curve_parameters)
        return Size(mean, swing, float(curve_parameters[-1]))

    def parameters(self, size: Size) -> Array:
        """The curve of a size: in closed form where the family has one, else solved; ValueError
        where none is found.
        """
        terms = FIRST_TERMS if self.sidecar["series"] else 0
        while terms <= MAX_TERMS:
            stage = Stage(self.family, self._names, terms)
            described = _Described(stage)
            solution = self._solved(described, size)
            if stage.tail(solution) < SERIES_TOLERANCE:
                mean, _ = described(solution)
                return np.where(self._lengths, solution * size.mean_radius / mean, solution)
            terms += terms // 2
        raise self._not_found(size)

    def _solved(self, described: _Described, size: Size) -> Array:
        """Parameters at unit size with the relative swing that is asked for."""
        from scipy.optimize import brentq

        def excess(x: float) -> float:
            return described(self._at(x, size))[1] - size.swing

        start, other = excess(size.swing), size.swing
        if abs(start) < EXACT:
            return self._at(size.swing, size)
        while excess(other) * start > 0:
            other = other / 2 if start > 0 else (1 + other) / 2
            if not EXACT < other < 1 - EXACT:
                raise self._not_found(size)
        return self._at(brentq(excess, *sorted((size.swing, other)), xtol=1e-16, rtol=1e-15), size)

    def _at(self, x: float, size: Size) -> Array:
        """Parameters at unit size, where x is close to the relative swing and grows with it."""
        shape = size.shape or (0.0,) * len(self.sidecar["shapes"])
        relative_size = self._relative(swing=x, shape=shape)
        return np.array([*(value[0, 0] for value in relative_size.values()), size.deformation])

    @cached_property
    def _relative(self) -> Kernel:
        return Kernel(families.load_functions(self.family).relative())

    def _not_found(self, size: Size) -> ValueError:
        return ValueError(
            f"no {self.sidecar['title']} of the relative swing {size.swing:g} was found"
        )


class _Described:
    """Mean radius [m] and relative swing [-] of a stage's curves, in numbers."""

    def __init__(self, stage: Stage) -> None:
        self._prologue, self._kernel = stage.prologue, Kernel(describe(stage))

    def __call__(self, parameters: Array) -> tuple[float, float]:
        ratios = self._kernel(
            parameters=parameters, hoisted=self._prologue(parameters=parameters)["hoisted"]
        )
        return float(ratios["mean_radius"][0, 0]), float(ratios["swing"][0, 0])


def describe(stage: Stage) -> ca.Function:
    """(parameters, hoisted) -> (mean_radius [m], swing [-]): the size as a function, to be had with
    its derivatives.

    The extremes of the ratio are those at u = 0 and pi, where the families have them, or at a node
    between.
    """
    contact = stage.contact.function
    parameters, hoisted = (
        ca.MX.sym(name, contact.size1_in(name)) for name in ("parameters", "hoisted")
    )
    t = np.pi * np.array([0, *(np.arange(NODES) + 0.5), NODES]) / NODES
    values = contact(t=ca.DM(t).T, parameters=ca.vertcat(parameters[:-1], 1), hoisted=hoisted)
    largest, smallest = ca.mmax(values["ratio"]), ca.mmin(values["ratio"])
    mean = ca.sum2(values["r"][1:-1]) / NODES
    return ca.Function(
        "describe",
        [parameters, hoisted],
        [mean, (largest - smallest) / (largest + smallest)],
        ["parameters", "hoisted"],
        ["mean_radius", "swing"],
    )
