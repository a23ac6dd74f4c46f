"""Inputs fitted to figures of the force: from many starts, then as near to the machine's own values as it goes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares, minimize

from planter.kernels import Array
from planter.planting.undisclosed.attainable import MARGIN, UNIT
from planter.planting.undisclosed.force import Curve, Force

Figures = Mapping[str, float]
MET = 0.01
"""A target is met where none of its figures is missed by more than this share."""
CLOSE = 1e-12
"""Relative change at which a fit ends: figures that can be met are met to rounding of the model."""
MOST_EVALUATIONS = 200
SPARSE = 4
"""Every so many samples the contact is a rule of its own on the way to the machine's values."""
FIRM = 10.0
"""Weight of the contact, of which a hundred newtons count as one, beside shares of the figures."""


@dataclass(frozen=True)
class Fit:
    """A point z of the unit box with what the force is there, beside the figures that were wanted."""

    force: Force
    z: Array
    wanted: Figures

    @cached_property
    def curve(self) -> Curve:
        return self.force(self.z)

    @property
    def misses(self) -> dict[str, float]:
        """Relative misses by figure."""
        return dict(zip(self.wanted, _misses(self.curve, self.wanted).tolist(), strict=True))

    @property
    def worst(self) -> float:
        return max(map(abs, self.misses.values()))

    @property
    def met(self) -> bool:
        return self.worst <= MET

    @property
    def pushes(self) -> bool:
        """Whether the cam only pushes the roller, over the whole turn."""
        return bool(self.curve.push.min() >= 0)

    @property
    def distance(self) -> float:
        """Root of the mean square of the distances from the machine's own values, in widths of the bounds."""
        return float(np.sqrt(np.mean((self.z - self.force.own()) ** 2)))

    @property
    def rank(self) -> tuple[bool, bool, float]:
        """Smaller is better: met, with a cam that pushes, near to the machine's own values or to the figures."""
        return not self.met, not self.pushes, self.distance if self.met else self.worst


def searched(force: Force, wanted: Figures, pushing: bool, starts: Iterable[Array], weights: Array) -> Iterator[Fit]:
    """Least squares of the weighted misses, and of the cam's pull if it must push, from each start."""

    def residuals(z: Array) -> Array:
        curve = force(z)
        pulled = FIRM * np.maximum(MARGIN - curve.push, 0) / UNIT if pushing else np.empty(0)
        return np.append(weights * _misses(curve, wanted), pulled)

    def slopes(z: Array) -> Array:
        curve = force(z)
        own = weights[:, None] * _slopes(curve, wanted)
        if not pushing:
            return own
        pulled = -FIRM * np.where((curve.push < MARGIN)[:, None], curve.push_slopes, 0) / UNIT
        return np.vstack([own, pulled])

    exact = {"ftol": CLOSE, "xtol": CLOSE, "gtol": CLOSE}
    for z in starts:
        inside = np.clip(z, 1e-6, 1 - 1e-6)
        found = least_squares(residuals, inside, slopes, bounds=(0, 1), max_nfev=MOST_EVALUATIONS, **exact)
        yield Fit(force, found.x, wanted)


def nearest(fit: Fit, pushing: bool) -> Fit:
    """The fit as near to the machine's own values as a search from it comes; itself where that loses the target."""
    force, own = fit.force, fit.force.own()
    rules = [
        {"type": "eq", "fun": lambda z: _misses(force(z), fit.wanted), "jac": lambda z: _slopes(force(z), fit.wanted)}
    ]
    if pushing:
        rules.append({"type": "ineq", "fun": lambda z: (force(z).push[::SPARSE] - MARGIN) / UNIT,
                      "jac": lambda z: force(z).push_slopes[::SPARSE] / UNIT})  # fmt: skip
    found = minimize(lambda z: ((z - own) @ (z - own), 2 * (z - own)), fit.z, jac=True, method="SLSQP",
                     bounds=[(0.0, 1.0)] * len(own), constraints=rules, options={"maxiter": 100})  # fmt: skip
    closer = Fit(force, np.clip(found.x, 0, 1), fit.wanted)
    return min(fit, closer, key=lambda one: one.rank)


def settled(fit: Fit, threshold: float = 1e-6) -> int:
    """How many combinations of the inputs the figures settle: singular values above this share of the largest."""
    values = np.linalg.svd(_slopes(fit.curve, fit.wanted), compute_uv=False)
    return int((values > threshold * values[0]).sum())


def _misses(curve: Curve, wanted: Figures) -> Array:
    found = curve.figures()
    return np.array([found[key] / value - 1 for key, value in wanted.items()])


def _slopes(curve: Curve, wanted: Figures) -> Array:
    slopes = dict(zip(curve.figures(), curve.figure_slopes(), strict=True))
    return np.array([slopes[key] / value for key, value in wanted.items()])
