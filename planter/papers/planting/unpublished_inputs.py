"""Inputs that a paper does not publish: their bounds, the support force as their function, their
fit to its figures.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from importlib.resources import files
from typing import Any

import casadi as ca
import numpy as np
import scipy

from planter.engine.solvers.sampled_cycle import sample_angles
from planter.files import units
from planter.kernels import Array, Kernel
from planter.papers.planting.model import Device
from planter.text_files import parse_toml

START, END = "cam.{}_delta_deg[0]", "cam.{}_delta_deg[1]"
MASS, CENTROID = "mass.planet_kg", ("centroid.planet_xy_mm[0]", "centroid.planet_xy_mm[1]")
INERTIA = "inertia.J7_about_B1_kg_m2"
DEG = units.unit_factor("_deg")


@cache
def load_calibration_data() -> dict[str, Any]:
    """Return the assumed bounds, the cam events that the paper gives, and its figures of the
    force.
    """
    name = "calibration.toml"
    return parse_toml(
        files("planter.papers.planting").joinpath(name).read_text(encoding="utf-8"), name
    )


@dataclass(frozen=True)
class CalibrationInputs:
    """Paths in the machine file, with bounds (n,) in SI.

    A path that comes `after` another one has bounds for its distance from that. The planet body's
    moment of inertia about its pin follows from its mass and centroid with a constant centroidal
    one [kg m2], so that it stays a body.
    """

    paths: tuple[str, ...]
    lower: Array
    upper: Array
    centroidal_inertia: float
    after: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def wide(cls, device: Device) -> CalibrationInputs:
        """Return the assumed bounds alone."""
        bounds = load_calibration_data()["bounds"]
        factors = np.array([units.unit_factor(path) for path in bounds])
        low, high = np.array(list(bounds.values()), dtype=float).T
        si = device.machine.si
        centroidal = si(INERTIA) - si(MASS) * sum(si(path) ** 2 for path in CENTROID)
        return cls(tuple(bounds), low * factors, high * factors, centroidal)

    @classmethod
    def with_events(cls, device: Device) -> CalibrationInputs:
        """Return the assumed bounds, with the cam's flanks where the paper has the nozzles open and
        close.
        """
        inputs, events = cls.wide(device), load_calibration_data()["events"]
        low, high = inputs.lower.copy(), inputs.upper.copy()
        for flank, angle in compute_flank_angles(device).items():
            ends = compute_cam_angles(
                device, angle + events["within_deg"] * DEG * np.array([-1.0, 1.0])
            )
            start, end = (inputs.paths.index(path.format(flank)) for path in (START, END))
            low[start], high[start] = ends
            low[end], high[end] = np.multiply(events["flank_deg"], DEG)
        return replace(
            inputs,
            lower=low,
            upper=high,
            after={END.format(f): START.format(f) for f in ("rise", "fall")},
        )

    def __len__(self) -> int:
        return len(self.paths)

    def find_constants(self, device: Device) -> list[int]:
        """Return the indices of the inputs, and of the moment of inertia, in a device's constants,
        (n + 1,).
        """
        paths = [entry["shown"] for entry in device.sidecar["vectors"]["machine"]]
        return [paths.index(path) for path in (*self.paths, INERTIA)]

    def values(self, z: Array) -> Array:
        """Return the values in SI of a point in the unit box, (n + 1,): the inputs, then the moment
        of inertia.
        """
        inputs = self._inputs(z)
        mass, x, y = inputs[self._body]
        return np.append(inputs, self.centroidal_inertia + mass * (x**2 + y**2))

    def slopes(self, z: Array) -> Array:
        """Return the derivatives of the values in the point, (n + 1, n)."""
        mass, x, y = self._inputs(z)[self._body]
        inertia = np.array([x**2 + y**2, 2 * mass * x, 2 * mass * y])
        slopes = self._sum_matrix * (self.upper - self.lower)
        return np.vstack([slopes, inertia @ slopes[self._body]])

    def _inputs(self, z: Array) -> Array:
        values: Array = self._sum_matrix @ (self.lower + z * (self.upper - self.lower))
        return values

    @cached_property
    def _body(self) -> list[int]:
        return [self.paths.index(path) for path in (MASS, *CENTROID)]

    def point(self, values: Array) -> Array:
        """Return the point of values of the inputs in SI, clipped to the unit box, (n,)."""
        parts = np.linalg.solve(self._sum_matrix, values)
        return np.clip((parts - self.lower) / (self.upper - self.lower), 0, 1)

    def table(self, z: Array) -> list[dict[str, Any]]:
        """Return the values with their bounds, in display units; a dependent value is its own
        bound.
        """
        values = self.values(z)
        starts = (self._sum_matrix - np.eye(len(self))) @ values[:-1]
        ends = (np.append(starts + bound, values[-1]) for bound in (self.lower, self.upper))
        rows = zip((*self.paths, INERTIA), values, *ends, strict=True)
        return [
            {
                "name": path,
                "value": float(value / units.unit_factor(path)),
                "unit": units.display_unit(path) or "1",
                "lower": float(low / units.unit_factor(path)),
                "upper": float(high / units.unit_factor(path)),
                "origin": "calibrated",
            }
            for path, value, low, high in rows
        ]

    @cached_property
    def _sum_matrix(self) -> Array:
        """Matrix (n, n) that adds to a distance the value of the path that it comes after."""
        matrix = np.eye(len(self.paths))
        for path, before in self.after.items():
            matrix[self.paths.index(path), self.paths.index(before)] = 1.0
        return matrix


def compute_flank_angles(device: Device) -> dict[str, float]:
    """Return the carrier angle of side 1 [rad] at which each flank begins, by the events that the
    paper gives.

    Side 2 is half a revolution behind. The nozzle that is higher at the carrier angle zero is the
    upper one. Raises ValueError if the events of the two sides are not half a revolution apart.
    """
    columns = device.columns(device.design, np.zeros(1))
    upper = int(columns["tip_y_2_mm"][0] > columns["tip_y_mm"][0])
    flanks: dict[str, set[float]] = defaultdict(set)
    for event in load_calibration_data()["events"]["seen"]:
        side = upper if event["nozzle"] == "upper" else 1 - upper
        flanks[event["flank"]].add((event["carrier_deg"] - 180 * side) % 360)
    if any(len(angles) > 1 for angles in flanks.values()):
        raise ValueError("the events of the two nozzles are not half a turn apart")
    return {flank: angles.pop() * DEG for flank, angles in flanks.items()}


def compute_cam_angles(device: Device, phi: Array) -> Array:
    """Return the cam's angle delta at carrier angles of side 1 [rad], in [0, 2 pi)."""
    turned = device.columns(device.design, phi)["phi72_deg"]
    angles: Array = np.mod(-turned * DEG, 2 * np.pi)
    return angles


CONTACT = "F_E"
PUSH_MARGIN = 0.5
"""Least force of cam on roller that a search aims at [N], so that its penalties end on the safe
side of zero.
"""
SEARCH_UNIT = 100.0
"""Unit of the force in a search [N]."""
FIGURES = ("max_N", "min_N", "variance_N2")


@dataclass(frozen=True)
class CalibrationForceCurve:
    """Support force [N] (n,) over its period, cam's force on the roller [N] (m,) over a turn,
    Jacobians in z.
    """

    force: Array
    push: Array
    slopes: Array
    push_slopes: Array

    @property
    def range(self) -> float:
        return float(np.ptp(self.force))

    @property
    def variance(self) -> float:
        return float(self.force.var())

    @property
    def variance_slopes(self) -> Array:
        slopes: Array = 2 / len(self.force) * (self.force - self.force.mean()) @ self.slopes
        return slopes

    def figures(self) -> dict[str, float]:
        """Return extremes and variance by name."""
        values = float(self.force.max()), float(self.force.min()), self.variance
        return dict(zip(FIGURES, values, strict=True))

    def figure_slopes(self) -> Array:
        """Return the Jacobian of the figures in z, (3, n): an extreme's is that of its sample."""
        return np.array(
            [
                self.slopes[self.force.argmax()],
                self.slopes[self.force.argmin()],
                self.variance_slopes,
            ]
        )


class CalibrationForce:
    """The force over a machine's own samples, at points z (n,) of the unit box of some inputs."""

    def __init__(self, device: Device, inputs: CalibrationInputs) -> None:
        self.device, self.inputs = device, inputs
        self._constants = inputs.find_constants(device)
        self._kernel = self._build_kernel()
        self._kernel.compile()
        offsets, curves = device.force.offsets, device.prologue(device.design).h[: self._curves]
        phi = sample_angles(device.machine.objective.samples, device.force.period)
        self._count = len(offsets)
        self._fixed = {
            "phi": np.add.outer(offsets, phi).reshape(1, -1),
            "x": device.design,
            "curves": curves,
        }

    def _build_kernel(self) -> Kernel:
        functions = self.device.functions
        side = [entry["name"] for entry in self.device.sidecar["vectors"]["side"]]
        d, q = ca.vertcat(functions.x, functions.c), ca.SX(0, 1)
        share = self.device.force.response.values_function(functions.phi, d, functions.h, q)
        outputs = [share, functions.side(functions.phi)[side.index(CONTACT)]]
        values, inputs = functions.of_data(outputs)
        self._curves = inputs[-1].numel()
        forces = ca.vertcat(*values)
        slopes = ca.densify(ca.jacobian(forces, functions.c[self._constants]))
        names = ["phi", "x", "c", "curves"]
        return Kernel(
            ca.Function(
                "inputs", inputs, ca.cse([forces, ca.vec(slopes)]), names, ["forces", "slopes"]
            ),
            ["phi"],
        )

    def __call__(self, z: Array) -> CalibrationForceCurve:
        constants = self.device.constants.copy()
        constants[self._constants] = self.inputs.values(z)
        values = self._kernel(c=constants, **self._fixed)
        jacobian = values["slopes"].reshape(len(self._constants), 2, -1).transpose(
            1, 2, 0
        ) @ self.inputs.slopes(z)
        force = values["forces"][0].reshape(self._count, -1).sum(axis=0)
        slopes = jacobian[0].reshape(self._count, len(force), -1).sum(axis=0)
        return CalibrationForceCurve(force, values["forces"][1], slopes, jacobian[1])

    @property
    def way(self) -> str:
        """Backend that evaluates the force."""
        return self._kernel.way

    def file_point(self) -> Array:
        """Return the point of the machine file's values, clipped to the bounds."""
        return self.inputs.point(self.device.constants[self._constants[:-1]])


Figures = Mapping[str, float]
MET = 0.01
"""A target is met where none of its figures is missed by more than this share."""
CLOSE = 1e-12
"""Relative change at which a fit ends: figures that can be met are met to rounding of the model."""
MOST_EVALUATIONS = 200
CONTACT_STRIDE = 4
"""Every so many samples the contact is a constraint in the search for the nearest fit."""
CONTACT_WEIGHT = 10.0
"""Weight of the contact, of which a hundred newtons count as one, beside shares of the figures."""


@dataclass(frozen=True)
class ForceFit:
    """A point z of the unit box with the force there, and the target figures."""

    force: CalibrationForce
    z: Array
    target: Figures

    @cached_property
    def curve(self) -> CalibrationForceCurve:
        return self.force(self.z)

    @property
    def misses(self) -> dict[str, float]:
        """Relative deviations from the target by figure."""
        return dict(zip(self.target, _misses(self.curve, self.target).tolist(), strict=True))

    @property
    def worst(self) -> float:
        return max(map(abs, self.misses.values()))

    @property
    def met(self) -> bool:
        return self.worst <= MET

    @property
    def pushes(self) -> bool:
        """Whether the cam only pushes the roller, over the whole cycle."""
        return bool(self.curve.push.min() >= 0)

    @property
    def distance(self) -> float:
        """Root of the mean square of the distances from the machine's values in the file, in widths
        of the bounds.
        """
        return float(np.sqrt(np.mean((self.z - self.force.file_point()) ** 2)))

    @property
    def rank(self) -> tuple[bool, bool, float]:
        """Smaller is better: met, with a cam that pushes, near to the file's values or to the
        target.
        """
        return not self.met, not self.pushes, self.distance if self.met else self.worst


def fit_from_starts(
    force: CalibrationForce, target: Figures, pushing: bool, starts: Iterable[Array], weights: Array
) -> Iterator[ForceFit]:
    """Yield fits by least squares of the weighted misses, and of the cam's pull if it must push,
    from each start.
    """

    def residuals(z: Array) -> Array:
        curve = force(z)
        pull = (
            CONTACT_WEIGHT * np.maximum(PUSH_MARGIN - curve.push, 0) / SEARCH_UNIT
            if pushing
            else np.empty(0)
        )
        return np.append(weights * _misses(curve, target), pull)

    def slopes(z: Array) -> Array:
        curve = force(z)
        rows = weights[:, None] * _slopes(curve, target)
        if not pushing:
            return rows
        pull = (
            -CONTACT_WEIGHT
            * np.where((curve.push < PUSH_MARGIN)[:, None], curve.push_slopes, 0)
            / SEARCH_UNIT
        )
        return np.vstack([rows, pull])

    exact = {"ftol": CLOSE, "xtol": CLOSE, "gtol": CLOSE}
    for z in starts:
        inside = np.clip(z, 1e-6, 1 - 1e-6)
        solution = scipy.optimize.least_squares(
            residuals, inside, slopes, bounds=(0, 1), max_nfev=MOST_EVALUATIONS, **exact
        )
        yield ForceFit(force, solution.x, target)


def fit_nearest(fit: ForceFit, pushing: bool) -> ForceFit:
    """Return the fit nearest to the file's values that a search from a fit reaches; that one if the
    target is lost.
    """
    force, target, reference = fit.force, fit.target, fit.force.file_point()
    constraints = [
        {
            "type": "eq",
            "fun": lambda z: _misses(force(z), target),
            "jac": lambda z: _slopes(force(z), target),
        }
    ]
    if pushing:
        stride = slice(None, None, CONTACT_STRIDE)
        constraints.append(
            {
                "type": "ineq",
                "fun": lambda z: (force(z).push[stride] - PUSH_MARGIN) / SEARCH_UNIT,
                "jac": lambda z: force(z).push_slopes[stride] / SEARCH_UNIT,
            }
        )
    solution = scipy.optimize.minimize(
        lambda z: ((z - reference) @ (z - reference), 2 * (z - reference)),
        fit.z,
        jac=True,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * len(reference),
        constraints=constraints,
        options={"maxiter": 100},
    )
    closer = ForceFit(force, np.clip(solution.x, 0, 1), target)
    return min(fit, closer, key=lambda candidate: candidate.rank)


def count_determined(fit: ForceFit, threshold: float = 1e-6) -> int:
    """Return how many combinations of the inputs the figures determine.

    These are the singular values of their Jacobian above a share `threshold` of the largest.
    """
    values = np.linalg.svd(_slopes(fit.curve, fit.target), compute_uv=False)
    return int((values > threshold * values[0]).sum())


def _misses(curve: CalibrationForceCurve, target: Figures) -> Array:
    figures = curve.figures()
    return np.array([figures[key] / value - 1 for key, value in target.items()])


def _slopes(curve: CalibrationForceCurve, target: Figures) -> Array:
    slopes = dict(zip(curve.figures(), curve.figure_slopes(), strict=True))
    return np.array([slopes[key] / value for key, value in target.items()])
