"""The two-stage non-circular planetary gear train of an angle curve: split, closure, pitch curves,
path of the tip.

The first driver is fixed to the frame, the first follower and the second driver are one body in the
middle of the carrier, the arm is fixed to the second follower. Ratios and radii are those of the
derivation (sun2019, step 5): i = 1/slope, i1 = x_s sqrt(i), i2 = sqrt(i)/x_s, r1 = a/(1 + i1), r2 =
a - r1, r3 = a/(1 + i2), r4 = a - r3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planter.errors import ComputationError, GeometryError
from planter.kernels import Array
from planter.numerics import piecewise
from planter.numerics.arrays import TURN, to_degrees
from planter.papers.mapping import model
from planter.papers.mapping.curve import AngleCurve
from planter.papers.mapping.dyads import Dyad, distinct, solve_dyads
from planter.papers.mapping.file import PoseFile
from planter.papers.mapping.nearest import find_misses
from planter.papers.mapping.results import Missed, TrainFound, TrainWarning
from planter.papers.mapping.synthesis import choose_dyad, describe_slopes, to_four

GEARS = ("driver 1", "follower 1", "driver 2", "follower 2")
RADII = ("r1", "r2", "r3", "r4")
_PANEL = TURN / 90
"""Longest panel of a quadrature; panels end at the points of the curve."""
_NODES, _FEWER = 16, 12
_CONVEX = 1e-9
"""Share of the largest curvature that a convex curve may fall below zero by rounding."""


@dataclass(frozen=True)
class Train:
    """A train for a curve and a centre distance [m], equal in both stages.

    Raises ComputationError where the slope of the curve reaches zero: a gear would stand still or
    turn back.
    """

    curve: AngleCurve
    distance: float

    def __post_init__(self) -> None:
        lowest = self.curve.extremes[0]
        if lowest.value <= 0:
            at, worst = np.degrees(self.curve.find_zero_slope()), np.degrees(lowest.place)
            raise ComputationError(
                f"the slope of the angle curve reaches zero at carrier angle {at:.6g} deg, where "
                f"the gears would stand still and turn back (least slope {lowest.value:.6g} at "
                f"{worst:.6g} deg): it must stay positive"
            )

    @cached_property
    def x_s(self) -> float:
        """Split parameter that closes the first stage: the mean of 1/sqrt(i) over a turn."""
        return float(self._cumulated(_NODES, lambda slope: np.sqrt(slope))[1][-1]) / TURN

    def _cumulated(self, nodes: int, of_slope: Callable[[Array], Array]) -> tuple[Array, Array]:
        """Carrier angles (m,) of the ends of the panels and the integral of a function of the slope
        up to them.
        """
        angles, weights = piecewise.gauss_panels(self._panels, nodes)
        values = of_slope(self.curve.slopes(angles.ravel())[0]).reshape(angles.shape)
        return self._panels, np.append(0.0, np.cumsum((values * weights).sum(axis=1)))

    def panels(self) -> tuple[Array, Array]:
        """Return the carrier angles (m,) [rad] and the weights of the quadrature over a turn."""
        angles, weights = piecewise.gauss_panels(self._panels, _NODES)
        return angles.ravel(), weights.ravel()

    @cached_property
    def _panels(self) -> Array:
        """Ends of panels on each of which the curve is one cubic; about the least slope they grow
        with the distance.
        """
        knots = self.curve.carrier
        dense = knots[0] + TURN * np.arange(round(TURN / _PANEL)) / round(TURN / _PANEL)
        low = self.curve.extremes[0].place
        graded = _PANEL * 0.5 ** np.arange(24)
        inside = np.concatenate([knots, dense, low - graded, low + graded])
        inside = inside[(inside >= knots[0]) & (inside <= knots[-1])]
        ends = np.unique(inside)
        return ends[np.append(True, np.diff(ends) > 1e-12)]

    def gears(self, theta: Array) -> dict[str, Array]:
        """Ratios i, i1, i2, pitch radii r1 to r4 [m] and rates dpsi1 to dpsi4 of the polar angles
        (n,).
        """
        return model.gears(self.curve.slopes(theta)[0], self.x_s, self.distance)

    @cached_property
    def closure_errors(self) -> tuple[float, float]:
        """Rotation of the followers in a turn of their drivers, less a turn [rad], by a separate
        quadrature.

        The first follower turns through the mesh of stage 1; the second by the product of both
        ratios.
        """
        first = self._turned(_FEWER, "dpsi2")[1][-1]
        second = self._turned(_FEWER, "dpsi4")[1][-1]
        return float(first - TURN), float(second - TURN)

    def _turned(self, nodes: int, rate: str) -> tuple[Array, Array]:
        return self._cumulated(
            nodes, lambda slope: model.gears(slope, self.x_s, self.distance)[rate]
        )

    def polar_angles(self) -> tuple[Array, Array]:
        """Carrier angles (m,) along the turn, and the polar angles of the four gears' contacts (4,
        m) [rad].
        """
        theta, middle = self._turned(_NODES, "dpsi2")
        last = self._turned(_NODES, "dpsi4")[1]
        return theta, np.array([theta - theta[0], middle, middle, last])

    @cached_property
    def radius_range(self) -> tuple[Array, Array]:
        """Least and largest pitch radius (4,) [m]: radii go with the slope, so they have their
        extremes with it.
        """
        slopes = np.array([extreme.value for extreme in self.curve.extremes])
        radii = np.array([model.gears(slopes, self.x_s, self.distance)[name] for name in RADII])
        return radii.min(axis=1), radii.max(axis=1)

    @cached_property
    def curvatures(self) -> tuple[Array, Array]:
        """Carrier angles (m,) [rad] and curvatures (4, m) [1/m], on both sides of the points of the
        curve.
        """
        knots = self.curve.carrier
        shares = np.linspace(0, 1, 41)
        theta = (knots[:-1, None] + np.diff(knots)[:, None] * shares).ravel()
        slope, first, _ = self.curve.slopes(theta)
        # The third derivative of a cubic is one value between two points, which at its right end
        # belongs to the next.
        second = np.repeat(self.curve.slopes(knots[:-1])[2], len(shares))
        return theta, model.curvature(slope, first, second, self.x_s, self.distance)

    @property
    def convex(self) -> list[bool]:
        """Whether each pitch curve is convex."""
        kappa = self.curvatures[1]
        return [bool(k.min() >= -_CONVEX * np.abs(k).max()) for k in kappa]

    @property
    def least_curvature_radius(self) -> Array:
        """Smallest radius of curvature (4,) [m] where a pitch curve is convex."""
        return np.asarray(1 / self.curvatures[1].max(axis=1))

    def concave(self, gear: int) -> list[tuple[float, float]]:
        """Ranges of the carrier angle [rad] in which a pitch curve (0 to 3) is concave at the
        contact.
        """
        theta, kappa = self.curvatures[0], self.curvatures[1][gear]
        hollow = np.concatenate([[False], kappa < -_CONVEX * np.abs(kappa).max(), [False]])
        edges = np.flatnonzero(np.diff(hollow.astype(int)))
        return [
            (float(theta[a]), float(theta[b - 1]))
            for a, b in zip(edges[::2], edges[1::2], strict=True)
        ]

    def bend(self, crank: float) -> float:
        """Angle at the middle hinge [rad].

        Raises GeometryError where the hinges of the carrier form no triangle.
        """
        if crank > 2 * self.distance:
            raise GeometryError(
                f"the length of the carrier, {crank * 1e3:.6g} mm, is too large: it must be at "
                f"most twice the centre distance, {2e3 * self.distance:.6g} mm"
            )
        return model.bend(crank, self.distance)

    def motion(self, dyad: Dyad) -> dict[str, Array]:
        """A turn of the arm as the gears drive it: `theta`, `phi` (m,) [rad], `places` of tip and
        hinge (4, m) [m].

        The arm turns against the carrier with the second follower, by the product of both ratios.
        """
        theta, psi = self.polar_angles()
        phi = self.curve.relative[0] + self.curve.sense * psi[3] + theta
        return {"theta": theta, "phi": phi, "places": model.arm(theta, phi, dyad.vector)}


MOST_RATIO = 3.0
"""Ratio of a stage, or its reciprocal, from which on it is told: a pitch radius is a quarter of the
distance.
"""
DEDENDUM, ADDENDUM = 1.25, 1.0
"""Depth of the roots below a pitch curve, and height of the tips above it, in modules."""
LEAST_MODULE = 1e-3
"""Module [m] below which what limits it is told."""
_MM = 1e3


def warnings(train: Train) -> list[TrainWarning]:
    """Return all warnings of a train."""
    return [*_sense(train), *_ratios(train), *_sharp(train), *_hollow(train)]


def largest_module(train: Train) -> float:
    """The largest module [m] at which no curve of roots or tips has a cusp."""
    return float(min(min(_rooms(train, gear)) for gear in range(len(GEARS))))


def _rooms(train: Train, gear: int) -> tuple[float, float]:
    """Largest modules [m] of a gear: by its roots where the pitch curve is convex, by its tips
    where it is hollow.
    """
    kappa = train.curvatures[1][gear]
    sharpest, hollowest = float(kappa.max()), float(-kappa.min())
    return 1 / (DEDENDUM * sharpest), 1 / (ADDENDUM * hollowest) if hollowest > 0 else np.inf


def _sense(train: Train) -> Iterator[TrainWarning]:
    if train.curve.sense > 0:
        yield TrainWarning(
            "sense",
            None,
            "the arm gains on the carrier: two external meshes turn it the other way, so that one "
            "mesh needs an idler",
        )


def _ratios(train: Train) -> Iterator[TrainWarning]:
    """Ratios that leave one gear of a stage a small pitch radius."""
    for extreme in train.curve.extremes:
        at = train.gears(np.array([extreme.place]))
        stages = [float(at[name][0]) for name in ("i1", "i2")]
        if max(*stages, *(1 / stage for stage in stages)) >= MOST_RATIO:
            radii = {gear: float(at[f"r{k}"][0]) for k, gear in enumerate(GEARS, 1)}
            gear = min(radii, key=lambda gear: radii[gear])
            yield _warning(
                "ratio",
                extreme.place,
                f"the total ratio is {float(at['i'][0]):.4g} (stages {stages[0]:.4g} and "
                f"{stages[1]:.4g})",
                f": the pitch radius of {gear} is only {radii[gear] * _MM:.4g} mm of "
                f"{train.distance * _MM:.4g} mm",
            )


def _sharp(train: Train) -> Iterator[TrainWarning]:
    """Pitch curves so sharp that the roots of ordinary teeth meet."""
    theta, kappa = train.curvatures
    for gear, name in enumerate(GEARS):
        module = _rooms(train, gear)[0]
        if module < LEAST_MODULE:
            worst = int(np.argmax(kappa[gear]))
            yield _warning(
                "cusp",
                float(theta[worst]),
                f"the pitch curve of {name} is nearly a cusp, of a radius of "
                f"{_MM / kappa[gear][worst]:.4g} mm",
                f": the roots of teeth meet there from a module of {module * _MM:.3g} mm on",
            )


def _hollow(train: Train) -> Iterator[TrainWarning]:
    """Pitch curves that are not convex, which a rack or hob cannot cut."""
    theta, kappa = train.curvatures
    for gear, name in enumerate(GEARS):
        if not train.convex[gear]:
            worst = int(np.argmin(kappa[gear]))
            ranges = ", ".join(
                f"{to_degrees(a):.4g} to {to_degrees(b):.4g}" for a, b in train.concave(gear)
            )
            module = _rooms(train, gear)[1]
            limit = f"; the tips of teeth meet there from a module of {module * _MM:.3g} mm on"
            yield _warning(
                "hollow pitch curve",
                float(theta[worst]),
                f"the pitch curve of {name} is hollow, of a radius of "
                f"{_MM / -kappa[gear][worst]:.4g} mm (all in all from {ranges} deg)",
                f": a rack or hob cannot cut it there{limit if module < LEAST_MODULE else ''}",
            )


def _warning(name: str, angle: float, cause: str, consequence: str) -> TrainWarning:
    return TrainWarning(
        name,
        to_degrees(angle),
        f"at carrier angle {to_degrees(angle):.5g} deg {cause}{consequence}",
    )


@dataclass(frozen=True)
class Training:
    """A train with its carrier dyad and poses, or None; `result` is what the command returns."""

    train: Train
    crank: float | None
    dyad: Dyad | None
    poses: Array | None
    result: TrainFound


def build_training(
    curve: AngleCurve,
    distance: float,
    crank: float | None = None,
    file: PoseFile | None = None,
    carrier: int = 1,
) -> Training:
    """Return the train of a curve for a centre distance and an optional carrier length [m], with
    its misses at poses.

    Raises ComputationError if the slope of the curve reaches zero, InputError if the carrier does
    not fit.
    """
    dyad = None if file is None else _carrier(file, carrier)
    if crank is None and dyad is not None:
        crank = dyad.radius
    train = Train(curve, distance)
    bend = None if crank is None else train.bend(crank)
    poses = None if file is None else file.poses
    missed = [] if dyad is None or poses is None else find_misses(dyad, poses, curve)
    return Training(train, crank, dyad, poses, _result(train, bend, missed))


def _carrier(file: PoseFile, number: int) -> Dyad:
    """The dyad that a file names for its carrier, or a real one of its poses, counted by radius."""
    if file.carrier_dyad is not None and number == 1:
        return file.carrier_dyad
    dyads = solve_dyads(file.poses).dyads if len(distinct(file.poses)) > 1 else []
    return choose_dyad(dyads, number)


def _result(train: Train, bend: float | None, missed: list[Missed]) -> TrainFound:
    lowest, largest = train.curve.extremes
    smallest, biggest = train.radius_range
    return TrainFound(
        x_s=train.x_s,
        x_s_under_root=train.x_s**2,
        **describe_slopes(train.curve),
        ratio_min=1 / largest.value,
        ratio_max=1 / lowest.value,
        closure_error_rad=train.closure_errors,
        carrier_bend_deg=None if bend is None else math.degrees(bend),
        convex=train.convex,
        concave_deg=[
            [(math.degrees(a), math.degrees(b)) for a, b in train.concave(k)] for k in range(4)
        ],
        radius_min_mm=to_four(smallest),
        radius_max_mm=to_four(biggest),
        curvature_radius_min_mm=to_four(train.least_curvature_radius),
        module_max_mm=largest_module(train) * 1e3,
        poses=missed,
        warnings=warnings(train),
    )


def polar_curves(train: Train, samples: int = 361) -> tuple[Array, Array]:
    """Polar angles (4, m) [rad] and radii (4, m) [m] of the pitch curves, at the train's own
    carrier angles.
    """
    theta, psi = train.polar_angles()
    step = max(len(theta) // samples, 1)
    chosen = np.unique(np.append(np.arange(0, len(theta), step), len(theta) - 1))
    gears = train.gears(theta[chosen])
    return psi[:, chosen], np.array([gears[name] for name in ("r1", "r2", "r3", "r4")])
